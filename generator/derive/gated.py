"""Effects that events switch: what they do, times a gate that is 1 while they act and 0 while they are off."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import sympy as sp

from ..mechanism.joints import PointRef
from ..mechanism.links import Parameter
from .gaps import Accelerations, Gap, Positions, Velocities
from .motion import Couple, Force, Motion
from .terms_of_effects import Let, Terms, Told
from .vectors import Vector, Wrench, add, scale, symbol

APART = 2**20
"""The gap (m, rad) of a contact that is off, and the length (m) that is told of an effect. It stays so: nothing comes
near it."""


def gated(effects: Sequence[Terms], gates: Sequence[Parameter | None]) -> tuple[Terms, ...]:
    """The effects, those with a gate in ``gates`` behind it."""
    if not gates:
        return tuple(effects)
    return tuple(Gated(effect, gate) if gate else effect for effect, gate in zip(effects, gates, strict=True))


def _apart(at: Positions, gate: Parameter) -> sp.Expr:
    """0 while a gate is on, ``APART`` while it is off."""
    return at.once(f"apart_{gate.symbol}", lambda: APART * (1 - symbol(gate)))


class Seen:
    """A motion as an effect behind a gate sees it: while that is off two points are never at one place, where what
    acts between them would have no direction, and no number times 0 would be none."""

    def __init__(self, motion: Positions, gate: Parameter) -> None:
        self._motion, self._gate = motion, gate

    def __getattr__(self, name: str) -> Any:
        return getattr(self._motion, name)

    def distance(self, start: PointRef, end: PointRef) -> Vector:
        """The vector from one point to another (m)."""
        return add((_apart(self._motion, self._gate), sp.S.Zero), self._motion.distance(start, end))


@dataclass(frozen=True)
class Gated:
    """An effect behind its gate. While that is 0 there are no loads and nothing that loads tell, kinks are on the side
    where they are not positive, and contacts are ``APART``, as lengths are that it tells."""

    effect: Terms
    gate: Parameter

    @property
    def on(self) -> sp.Expr:
        return symbol(self.gate)

    def _seen(self, motion: Motion) -> Motion:
        """The motion as the effect sees it."""
        return cast("Motion", Seen(motion, self.gate))

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
        off = motion.once(f"off_{self.gate.symbol}", lambda: 1 - self.on)  # a sum with 1 and the gate would cost digits
        return [self.on * value - off for value in self.effect.switching(self._seen(motion))]

    def latches(self) -> tuple[tuple[str, str], ...]:
        return self.effect.latches()

    def latching(self, motion: Motion) -> Sequence[sp.Expr]:
        return self.effect.latching(self._seen(motion))

    def reaches(self, motion: Motion) -> Sequence[Vector]:
        return self.effect.reaches(self._seen(motion))

    def loads(self, motion: Motion) -> Sequence[Force | Couple]:
        return [
            Force(load.point, scale(self.on, load.vector))
            if isinstance(load, Force)
            else Couple(load.link, self.on * load.moment)
            for load in self.effect.loads(self._seen(motion))
        ]

    def potential(self, motion: Motion) -> sp.Expr:
        return self.on * self.effect.potential(self._seen(motion))

    def drives(self, motion: Motion) -> Sequence[tuple[int, sp.Expr]]:
        return self.effect.drives(self._seen(motion))

    def power(self, motion: Motion) -> sp.Expr:
        return self.on * self.effect.power(self._seen(motion))

    def outputs(self, motion: Motion) -> Sequence[Told]:
        return [
            (name, unit, self.on * value + (_apart(motion, self.gate) if unit == "m" else 0), *link)
            for name, unit, value, *link in self.effect.outputs(self._seen(motion))
        ]

    def gaps(self, let: Let) -> tuple[Gap, ...]:
        return tuple(GatedGap(gap, self.gate) for gap in self.effect.gaps(let))


@dataclass(frozen=True)
class GatedGap:
    """The ``gap`` of a contact behind the gate of its effect."""

    gap: Gap
    gate: Parameter

    @property
    def on(self) -> sp.Expr:
        return symbol(self.gate)

    def _seen(self, at: Positions) -> Accelerations:
        """Where the mechanism is, as the gap sees it."""
        return cast("Accelerations", Seen(at, self.gate))

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
        return self.on * self.gap.value(self._seen(at)) + _apart(at, self.gate)

    def closing(self, at: Velocities) -> sp.Expr:
        return self.on * self.gap.closing(self._seen(at))

    def bias(self, at: Accelerations) -> sp.Expr:
        return self.on * self.gap.bias(self._seen(at))

    def slip(self, at: Accelerations) -> sp.Expr:
        return self.gap.slip(self._seen(at))

    def slip_bias(self, at: Accelerations) -> sp.Expr:
        return self.gap.slip_bias(self._seen(at))

    def push(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        return self.gap.push(self._seen(at), impulse)

    def drag(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        return self.gap.drag(self._seen(at), impulse)
