"""Effects that events switch: what they do, times a gate that is 1 while they act and 0 while they are off."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from ..mechanism.joints import PointRef
from ..mechanism.links import Parameter
from .gaps import Accelerations, Gap, Positions, Velocities
from .motion import Couple, Force, Motion
from .terms_of_effects import Let, Terms, Told
from .vectors import Vector, Wrench, scale, symbol

APART = 2**20
"""The gap (m, rad) of a contact that is off. It stays so: nothing comes near it."""


def gated(effects: Sequence[Terms], gates: Sequence[Parameter | None]) -> tuple[Terms, ...]:
    """The effects, those with a gate in ``gates`` behind it."""
    if not gates:
        return tuple(effects)
    return tuple(Gated(effect, gate) if gate else effect for effect, gate in zip(effects, gates, strict=True))


@dataclass(frozen=True)
class Gated:
    """An effect behind its gate. While that is 0 there are no loads and nothing that loads tell, kinks are on the side
    where they are not positive, and contacts are ``APART``."""

    effect: Terms
    gate: Parameter

    @property
    def on(self) -> sp.Expr:
        return symbol(self.gate)

    @property
    def _off(self) -> str:
        """The name of what is 0 while it is on, and 1 while it is off: a sum with 1 and the gate would cost digits."""
        return f"off_{self.gate.symbol}"

    @property
    def title(self) -> str:
        return self.effect.title

    def parameters(self) -> tuple[Parameter, ...]:
        return (*self.effect.parameters(), self.gate)

    def field(self) -> Vector:
        return scale(self.on, self.effect.field())

    def inputs(self) -> tuple[str, ...]:
        return self.effect.inputs()

    def sides(self) -> tuple[str, ...]:
        return self.effect.sides()

    def switching(self, motion: Motion) -> Sequence[sp.Expr]:
        values = self.effect.switching(motion)
        return [self.on * value - motion.once(self._off, lambda: 1 - self.on) for value in values]

    def latches(self) -> tuple[tuple[str, str], ...]:
        return self.effect.latches()

    def latching(self, motion: Motion) -> Sequence[sp.Expr]:
        return self.effect.latching(motion)

    def reaches(self, motion: Motion) -> Sequence[Vector]:
        return self.effect.reaches(motion)

    def loads(self, motion: Motion) -> Sequence[Force | Couple]:
        return [
            Force(load.point, scale(self.on, load.vector))
            if isinstance(load, Force)
            else Couple(load.link, self.on * load.moment)
            for load in self.effect.loads(motion)
        ]

    def potential(self, motion: Motion) -> sp.Expr:
        return self.on * self.effect.potential(motion)

    def drives(self, motion: Motion) -> Sequence[tuple[int, sp.Expr]]:
        return self.effect.drives(motion)

    def power(self, motion: Motion) -> sp.Expr:
        return self.on * self.effect.power(motion)

    def outputs(self, motion: Motion) -> Sequence[Told]:
        return [(name, unit, self.on * value, *link) for name, unit, value, *link in self.effect.outputs(motion)]

    def gaps(self, let: Let) -> tuple[Gap, ...]:
        gaps = self.effect.gaps(let)
        apart = let(f"apart_{self.gate.symbol}", APART * (1 - self.on)) if gaps else sp.S.Zero
        return tuple(GatedGap(gap, self.on, apart) for gap in gaps)


@dataclass(frozen=True)
class GatedGap:
    """The ``gap`` of a contact while its effect is ``on``; ``apart`` is 0 then, and ``APART`` while it is off."""

    gap: Gap
    on: sp.Expr
    apart: sp.Expr

    @property
    def name(self) -> str:
        return self.gap.name

    @property
    def ground(self) -> str:
        return self.gap.ground

    @property
    def restitution(self) -> sp.Expr:
        return self.gap.restitution

    @property
    def friction(self) -> sp.Expr:
        return self.gap.friction

    @property
    def angular(self) -> bool:
        return self.gap.angular

    @property
    def slides(self) -> bool:
        return self.gap.slides

    def points(self) -> tuple[PointRef, ...]:
        return self.gap.points()

    def value(self, at: Positions) -> sp.Expr:
        return self.on * self.gap.value(at) + self.apart

    def closing(self, at: Velocities) -> sp.Expr:
        return self.on * self.gap.closing(at)

    def bias(self, at: Accelerations) -> sp.Expr:
        return self.on * self.gap.bias(at)

    def slip(self, at: Accelerations) -> sp.Expr:
        return self.gap.slip(at)

    def slip_bias(self, at: Accelerations) -> sp.Expr:
        return self.gap.slip_bias(at)

    def push(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        return self.gap.push(at, impulse)

    def drag(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        return self.gap.drag(at, impulse)
