"""Spring: a linear spring without mass between two points; a rope that only pulls, a buffer that only pushes, a
spring with play."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from ..effect_base.dead_zone import DeadZone
from ..effect_base.effect import Complain, Effect, Entry, Part, Surroundings
from ..effect_base.line import Line, find_line
from ..effect_base.table import Name, NotNegative, PointName, Positive, Table
from ..effect_base.written_numbers import Measured
from ..mechanism.links import NOT_NEGATIVE, Parameter

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Force, Motion
    from ..derive.terms_of_effects import Told
    from ..derive.vectors import Vector
    from ..mechanism.assembled import Assembled
    from ..mechanism.mechanism import Mechanism


Acts = Literal["both", "pull", "push"]


class SpringTable(Table):
    """One ``[[spring]]``."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    between: list[PointName] = Field(
        min_length=2, max_length=2, description='the two points it joins, ["link.point", "ground.point"]'
    )
    stiffness: Annotated[Positive, Measured("N/m")] = Field(description="the stiffness in N/m, a positive number")
    length: Annotated[NotNegative, Measured("m")] = Field(
        default=0.0, description="the length at rest in m, zero or a positive number"
    )
    acts: Acts = Field(
        default="both",
        description='"both" ways, "pull" only when it is longer than at rest, as a rope, or "push" only when it is '
        "shorter, as a buffer",
    )
    damping: Annotated[NotNegative, Measured("N s/m")] | None = Field(
        default=None,
        description='the damping in N s/m while it acts, zero or positive, with acts "pull" or "push" or play only',
    )
    play: Annotated[Positive, Measured("m")] | None = Field(
        default=None,
        description="the way in m in which it is free, half on either side of its length at rest, a positive number",
    )


@dataclass(frozen=True)
class OneWay:
    """A spring that acts only where ``sign`` times its elongation is positive: 1 as a rope, -1 as a buffer.

    There it has ``damping`` (N s/m) too; where that would turn its force round there is none.
    """

    sign: int
    damping: Parameter | None


@dataclass(frozen=True)
class Spring(Effect):
    """Pulls the ends of its line together with ``stiffness`` (N/m) times its elongation beyond ``length`` (m)."""

    name: str
    line: Line
    stiffness: Parameter
    length: Parameter | None
    one_way: OneWay | None = None
    zone: DeadZone | None = None

    def parameters(self) -> tuple[Parameter, ...]:
        damping = self.one_way.damping if self.one_way else self.zone.damping if self.zone else None
        return (self.stiffness, *(p for p in (self.length, damping, self.zone.play if self.zone else None) if p))

    def describe(self, mechanism: Mechanism) -> str:
        told = super().describe(mechanism)
        return told if self.one_way is None else f"{told}, {'pulls' if self.one_way.sign > 0 else 'pushes'} only"

    def sides(self) -> tuple[str, ...]:
        if self.zone:
            return self.zone.sides()
        if self.one_way is None:
            return ()
        return (self.line.label, *((self._loaded,) if self.one_way.damping else ()))

    def switching(self, motion: Motion) -> Sequence[Expr]:
        """Its elongation, and with damping its tension, both in the way in which it acts."""
        if self.zone:
            return self.zone.switching(motion, self._elongation(motion), self._lengthening(motion))
        if self.one_way is None:
            return ()
        values = (self._elongation(motion), *((self._tension(motion),) if self.one_way.damping else ()))
        return tuple(self.one_way.sign * value for value in values)

    def reaches(self, motion: Motion) -> Sequence[Vector]:
        """Its line, unless it has no length at rest, or is slack where its ends meet."""
        pulls = self.one_way is not None and self.one_way.sign > 0
        return () if self.length is None or pulls else (self.line.reach(motion),)

    def loads(self, motion: Motion) -> Sequence[Force]:
        """k (L − L₀) along the line; without a length at rest, k times the vector between the points."""
        tension = motion.value(self.stiffness)
        if self.zone:
            effort = self.zone.effort(motion, self._elongation(motion), self._lengthening(motion))
            tension = motion.let(f"tension_{self.line.label}", effort / self.line.length(motion))
        elif self.one_way and self.one_way.damping:
            tension = motion.let(f"tension_{self.line.label}", self._force(motion) / self.line.length(motion))
        elif self.length:
            slack = 1 - motion.value(self.length) / self.line.length(motion)
            acts = motion.side(self.line.label) if self.one_way else 1
            tension = motion.let(f"tension_{self.line.label}", acts * tension * slack)
        return self.line.pull(motion, tension)

    def potential(self, motion: Motion) -> Expr:
        """½ k (L − L₀)², where it acts."""
        stiffness = motion.value(self.stiffness)
        if self.length is None:
            return stiffness * self.line.square(motion) / 2
        if self.zone:
            return self.zone.potential(motion, self._elongation(motion))
        energy = stiffness * (self.line.length(motion) - motion.value(self.length)) ** 2 / 2
        return energy * motion.step(self.one_way.sign * self._elongation(motion)) if self.one_way else energy

    def power(self, motion: Motion) -> Expr:
        """What damping takes: the power of the force, less that of its part k (L − L₀), which has a potential."""
        import sympy as sp

        if self.zone:
            return self.zone.power(motion, self._elongation(motion), self._lengthening(motion))
        if self.one_way is None or self.one_way.damping is None:
            return sp.S.Zero
        elastic = motion.side(self.line.label) * motion.value(self.stiffness) * self._elongation(motion)
        return (elastic - self._force(motion)) * self._lengthening(motion)

    def outputs(self, motion: Motion) -> Sequence[Told]:
        """The distance of its ends, and the force that pulls them together."""
        return ("length", "m", self.line.length(motion)), ("force", "N", self._pull(motion))

    def _pull(self, motion: Motion) -> Expr:
        if self.zone:
            return self.zone.effort(motion, self._elongation(motion), self._lengthening(motion))
        if self.one_way and self.one_way.damping:
            return self._force(motion)
        acts = motion.side(self.line.label) if self.one_way else 1
        return acts * motion.value(self.stiffness) * self._elongation(motion)

    @property
    def _loaded(self) -> str:
        return f"{self.line.label}_loaded"

    def _elongation(self, motion: Motion) -> Expr:
        return self.line.length(motion) - motion.value(self.length)

    def _lengthening(self, motion: Motion) -> Expr:
        """dL/dt."""
        return self.line.stretching(motion) / self.line.length(motion)

    def _tension(self, motion: Motion) -> Expr:
        """k (L − L₀) + c dL/dt, whether it acts or not."""
        elastic = motion.value(self.stiffness) * self._elongation(motion)
        damping = self.one_way.damping if self.one_way else None
        return motion.let(f"strain_{self.line.label}", elastic + motion.value(damping) * self._lengthening(motion))

    def _force(self, motion: Motion) -> Expr:
        """The tension where it is longer (shorter) than at rest and pulls (pushes)."""
        return motion.side(self.line.label) * motion.side(self._loaded) * self._tension(motion)

    def parts(self, mechanism: Mechanism) -> tuple[Part, ...]:
        return (("spring", self.name, self.line.points, ()),)

    def check_start(self, start: Assembled) -> tuple[str, ...]:
        if self.length is None or not self.line.is_point(start):
            return ()
        return (
            f"the start has both ends of {self.name} at the same place, where a spring with a length at rest has no "
            "direction; change the start, or leave out the length",
        )


def build(table: SpringTable, index: int, around: Surroundings, complain: Complain) -> Spring | None:
    """The record of a table, or ``None`` after having complained."""
    label = f"spring_{index}"
    name = table.name or label
    line = find_line(label, table.between, around.mechanism, complain)
    if line is None:
        return None
    length = Parameter(f"{name}.length", f"L0_{label}", table.length, NOT_NEGATIVE) if table.length else None
    damping = (
        Parameter(f"{name}.damping", f"c_{label}", table.damping, NOT_NEGATIVE) if table.damping is not None else None
    )
    if table.acts != "both" and length is None:
        complain(("acts",), f'found "{table.acts}" without a length, expected a length at rest beside it; add length')
        return None
    stiffness = Parameter(f"{name}.stiffness", f"k_{label}", table.stiffness, NOT_NEGATIVE)
    if table.play is not None:
        if table.acts != "both":
            message = f'found it with acts = "{table.acts}", expected a spring that acts both ways'
            complain(("play",), f"{message}; remove it and change the length by half of it")
            return None
        if length is None:
            complain(("play",), "found without a length, expected a length at rest beside it; add length")
            return None
        zone = DeadZone(label, Parameter(f"{name}.play", f"p_{label}", table.play, NOT_NEGATIVE), stiffness, damping)
        return Spring(name, line, stiffness, length, zone=zone)
    if table.acts == "both" and damping:
        message = "found damping of a spring that acts both ways, expected a [[damper]] between the same points"
        complain(("damping",), f'{message}; write one, or acts = "pull" or "push"')
        return None
    one_way = None if table.acts == "both" else OneWay(1 if table.acts == "pull" else -1, damping)
    return Spring(name, line, stiffness, length, one_way)


ENTRY = Entry("spring", True, SpringTable, build, {})
