"""Compliant touch: a disc on one link that presses on a disc, or an edge, of another, both giving way a little."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect_base.compliance import Compliance, ComplianceTable, Hertz, Pressed, read_compliance
from ..effect_base.effect import Complain, Effect, Entry, Rim, Surroundings
from ..effect_base.pair import Pair, PairTable, read_pair
from ..mechanism.links import Parameter
from ..mechanism.mechanism import Mechanism

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Couple, Force, Motion
    from ..derive.terms_of_effects import Told
    from ..derive.touching import TouchGap


class CompliantTouchTable(PairTable, ComplianceTable):
    """One ``[[compliant_touch]]``."""


@dataclass(frozen=True)
class CompliantTouch(Effect):
    """Presses the two of a ``pair`` that are inside each other apart by a ``law``, and resists their slip.

    Hertz's law takes an edge as flat.
    """

    index: int
    name: str
    pair: Pair
    law: Compliance

    def parameters(self) -> tuple[Parameter, ...]:
        return (*self.pair.parameters(), *self.law.parameters())

    def describe(self, mechanism: Mechanism) -> str:
        return f"{self.pair.title}, {super().describe(mechanism)}"

    def sides(self) -> tuple[str, ...]:
        """Those of the law; of an edge also whether the disc is past its ends, where the surface's curvature jumps."""
        ends = tuple(f"{self._label}_past_{end}" for end in ("start", "end")) if self.pair.ends else ()
        return (*self.law.sides([self._label]), *ends)

    def switching(self, motion: Motion) -> Sequence[Expr]:
        gap, values = self._gap(motion), self.law.switching(motion, self._pressed(motion))
        if gap.edge is None:
            return values
        return (*values, -gap.place(motion), gap.place(motion) - gap.edge.length)

    def latches(self) -> tuple[tuple[str, str], ...]:
        return self.law.latches([self._label])

    def latching(self, motion: Motion) -> Sequence[Expr]:
        return self.law.latching(motion, self._pressed(motion))

    def loads(self, motion: Motion) -> Sequence[Force | Couple]:
        """The force on the disc's centre, the opposite on the other's point, and what moves them there."""
        from sympy import S

        from ..derive.motion import Couple, Force
        from ..derive.vectors import add, dot, perp, scale

        gap, pressed = self._gap(motion), self._pressed(motion)
        meeting = gap.meet(motion)
        push, drag = self.law.push(motion, pressed), self.law.drag(motion, pressed)
        given = add(scale(push, meeting.normal), scale(drag, meeting.tangent))
        force = motion.let_vector(f"force_{self._label}", given)
        back = scale(S.NegativeOne, force)
        return (
            Force(gap.disc, force),
            Couple(gap.disc.link, gap.radius * drag),
            Force(gap.other, back),
            Couple(gap.other.link, dot(perp(gap.nearest(motion).foot), back) + gap.thickness * drag),
        )

    def potential(self, motion: Motion) -> Expr:
        return self.law.stored(motion, self._pressed(motion))

    def power(self, motion: Motion) -> Expr:
        return self.law.spent(motion, self._pressed(motion))

    def outputs(self, motion: Motion) -> Sequence[Told]:
        """How deep it is, negative where the bodies are apart, its normal force and friction."""
        depth, *forces = self.law.outputs(motion, self._pressed(motion), "")
        return depth, *((asked, unit, value, self.pair.disc.start.link) for asked, unit, value, *_ in forces)

    def rims(self) -> tuple[Rim, ...]:
        return self.pair.rims()

    @property
    def _label(self) -> str:
        return f"compliant_touch_{self.index}"

    def _gap(self, motion: Motion) -> TouchGap:
        return self.pair.gap(motion.let, self.name, self._label, motion.value(None), motion.value(None))

    def _pressed(self, motion: Motion) -> Pressed:
        gap, label = self._gap(motion), self._label
        curved = [gap.radius] if self.pair.ends else [gap.radius, gap.thickness]
        return Pressed(
            label,
            motion.let(f"depth_{label}", -gap.value(motion)),
            motion.let(f"approach_{label}", -gap.closing(motion)),
            motion.let(f"slip_{label}", gap.slip(motion)) if self.law.friction else motion.value(None),
            sum((1 / radius for radius in curved if radius != 0), motion.value(None)),
        )


def build(table: CompliantTouchTable, index: int, around: Surroundings, complain: Complain) -> CompliantTouch | None:
    """The record of a table, or ``None`` after having complained."""
    name = table.name or f"compliant_touch_{index}"
    pair = read_pair(table, name, f"rct_{index}", around.mechanism, complain)
    law = read_compliance(table, name, f"compliant_touch_{index}", complain)
    if pair is None or law is None:
        return None
    if isinstance(law.elastic, Hertz) and not (pair.disc.radius and (pair.ends or pair.other.radius)):
        message = "found young with a disc of radius 0, expected radii, because Hertz's law is one of round bodies"
        complain(("young",), f"{message}; give both discs one, or write load in its place")
        return None
    return CompliantTouch(index, name, pair, law)


ENTRY = Entry("compliant_touch", True, CompliantTouchTable, build, {})
