"""Effects that come and go: what they do, times a gate that is 1 while they act and 0 while they are off.

Events switch effects; others act at joints that let go and take hold, and go with them.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

import sympy as sp

from ..mechanism.joints import PointRef
from ..mechanism.links import Parameter
from ..mechanism.mechanism import Mechanism
from ..mechanism.touching_points import touching_points
from .gaps import Accelerations, Gap, Positions, Velocities
from .motion import Couple, Force, Motion, Stands
from .terms_of_effects import Let, Terms, Told
from .vectors import Vector, Wrench, add, local, scale, symbol

APART = 2**20
"""The gap (m, rad) of a contact that is off, and the length (m) that is told of an effect. It stays so: nothing comes
near it."""


def gated(effects: Sequence[Terms], gates: Sequence[Parameter | None]) -> tuple[Terms, ...]:
    """The effects, those with a gate in ``gates`` behind it."""
    if not gates:
        return tuple(effects)
    return tuple(Gated(effect, gate) if gate else effect for effect, gate in zip(effects, gates, strict=True))


def at_joints(
    effects: Sequence[Terms], joints: Sequence[Collection[int]], everywhere: Sequence[bool], mechanism: Mechanism
) -> tuple[Terms, ...]:
    """The effects, each as it acts at its ``joints`` (their indices), of which some let go or take hold, or with all
    contacts that there are where it acts ``everywhere``."""
    if not mechanism.gates:
        return tuple(effects)
    found = list[Terms]()
    for effect, own, whole in zip(effects, joints, everywhere, strict=True):
        gates = {joint: gate for joint, gate in mechanism.gates_at.items() if joint in own}
        if len(own) == 1 and gates:
            found.append(AtJoint(effect, *gates.values()))
        elif gates:
            found.append(AtJoints(effect, gates))
        else:
            found.append(AtEnds(effect, mechanism) if whole else effect)
    return tuple(found)


@dataclass(frozen=True)
class Whiles:
    """When something is there: while one of ``whiles`` is so, each of gates and whether they are 1; no two at once."""

    whiles: tuple[tuple[tuple[Parameter, bool], ...], ...]

    @property
    def on(self) -> sp.Expr:
        """1 while it is there, and else 0."""
        terms = [sp.Mul(*(symbol(gate) if one else 1 - symbol(gate) for gate, one in each)) for each in self.whiles]
        return sp.expand(sp.Add(*terms))

    def apart(self, at: Positions) -> sp.Expr:
        """``APART`` while it is off, and else 0."""
        names = ["_".join(gate.symbol + ("" if one else "_open") for gate, one in each) for each in self.whiles]
        return at.once(f"apart_{'_or_'.join(names)}", lambda: APART * (1 - self.on))


class Seen:
    """A motion as what is not always there sees it: while it is off two points are never at one place, where what acts
    between them would have no direction, and no number times 0 would be none."""

    def __init__(self, motion: Positions, there: Whiles) -> None:
        self._motion, self._there = motion, there

    def __getattr__(self, name: str) -> Any:
        return getattr(self._motion, name)

    def distance(self, start: PointRef, end: PointRef) -> Vector:
        """The vector from one point to another (m)."""
        return add((self._there.apart(self._motion), sp.S.Zero), self._motion.distance(start, end))


@dataclass(frozen=True)
class Gated:
    """An effect behind its gate. While that is 0 there are no loads and nothing that loads tell, kinks are on the side
    where they are not positive, and contacts are ``APART``, as lengths are that it tells."""

    effect: Terms
    gate: Parameter

    @property
    def on(self) -> sp.Expr:
        return symbol(self.gate)

    @property
    def _there(self) -> Whiles:
        return Whiles((((self.gate, True),),))

    def _seen(self, motion: Motion) -> Motion:
        """The motion as the effect sees it."""
        return cast("Motion", Seen(motion, self._there))

    @property
    def title(self) -> str:
        return self.effect.title

    def parameters(self) -> tuple[Parameter, ...]:
        return (*self.effect.parameters(), self.gate)

    def field(self) -> Vector:
        return scale(self.on, self.effect.field())

    def inputs(self) -> tuple[str, ...]:
        return self.effect.inputs()

    def defines(self) -> Mapping[str, Stands]:
        return self.effect.defines()

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
            (name, unit, self.on * value + (self._there.apart(motion) if unit == "m" else 0), *link)
            for name, unit, value, *link in self.effect.outputs(self._seen(motion))
        ]

    def gaps(self, let: Let) -> tuple[Gap, ...]:
        return tuple(GatedGap(gap, self._there) for gap in self.effect.gaps(let))


@dataclass(frozen=True)
class AtJoint(Gated):
    """An effect at one joint, behind the gate of that, which is a parameter of the mechanism."""

    def parameters(self) -> tuple[Parameter, ...]:
        return self.effect.parameters()


@dataclass(frozen=True)
class AtEnds:
    """A ground that touches all that the ``mechanism`` has, some points only while some joints hold or are open."""

    effect: Terms
    mechanism: Mechanism

    def __getattr__(self, name: str) -> Any:
        return getattr(self.effect, name)

    def _seen(self, motion: Motion) -> Motion:
        """The motion as the effect sees it."""
        (plane,) = cast("Any", self.effect).planes()
        return cast("Motion", Sunk(motion, local(plane[2]), whiles_of_points(self.mechanism)))

    def switching(self, motion: Motion) -> Sequence[sp.Expr]:
        return self.effect.switching(self._seen(motion))

    def latching(self, motion: Motion) -> Sequence[sp.Expr]:
        return self.effect.latching(self._seen(motion))

    def loads(self, motion: Motion) -> Sequence[Force | Couple]:
        return self.effect.loads(self._seen(motion))

    def potential(self, motion: Motion) -> sp.Expr:
        return self.effect.potential(self._seen(motion))

    def power(self, motion: Motion) -> sp.Expr:
        return self.effect.power(self._seen(motion))

    def outputs(self, motion: Motion) -> Sequence[Told]:
        return self.effect.outputs(self._seen(motion))

    def gaps(self, let: Let) -> tuple[Gap, ...]:
        whiles = whiles_of_points(self.mechanism)
        found = list[Gap]()
        for gap in self.effect.gaps(let):
            there = whiles.get(gap.points()[0]) if gap.points() else None
            found.append(GatedGap(gap, there) if there else gap)
        return tuple(found)


def whiles_of_points(mechanism: Mechanism) -> dict[PointRef, Whiles]:
    """When the points of a mechanism touch that do not always do so."""
    gates = mechanism.gates_at
    found = dict[PointRef, Whiles]()
    for point in touching_points(mechanism):
        there = Whiles(tuple(tuple((gates[k], held) for k, held in sorted(each)) for each in point.whiles))
        if there.on != 1:
            found[point.ref] = there
    return found


class Sunk:
    """A motion in which points are far outside a plane with a ``normal`` while they do not touch it."""

    def __init__(self, motion: Motion, normal: Vector, whiles: Mapping[PointRef, Whiles]) -> None:
        self._motion, self._normal, self._whiles = motion, normal, whiles

    def __getattr__(self, name: str) -> Any:
        return getattr(self._motion, name)

    def position(self, ref: PointRef) -> Vector:
        """Position of a point (m)."""
        place, there = self._motion.position(ref), self._whiles.get(ref)
        return add(place, scale(there.apart(self._motion), self._normal)) if there else place


@dataclass(frozen=True)
class AtJoints:
    """Friction in several joints, some of which have ``gates``: it sees no speed where one is open."""

    effect: Terms
    gates: Mapping[int, Parameter]

    def __getattr__(self, name: str) -> Any:
        return getattr(self.effect, name)

    def _seen(self, motion: Motion) -> Motion:
        return cast("Motion", Slipping(motion, self.gates))

    def loads(self, motion: Motion) -> Sequence[Force | Couple]:
        return self.effect.loads(self._seen(motion))

    def power(self, motion: Motion) -> sp.Expr:
        return self.effect.power(self._seen(motion))

    def outputs(self, motion: Motion) -> Sequence[Told]:
        return self.effect.outputs(self._seen(motion))


class Slipping:
    """A motion in which joints with ``gates`` do not move while they are open."""

    def __init__(self, motion: Motion, gates: Mapping[int, Parameter]) -> None:
        self._motion, self._gates = motion, gates

    def __getattr__(self, name: str) -> Any:
        return getattr(self._motion, name)

    def joint_speed(self, joint: int) -> sp.Expr:
        """Rate of a joint's position (rad/s or m/s), 0 while it is open."""
        gate, speed = self._gates.get(joint), self._motion.joint_speed(joint)
        return symbol(gate) * speed if gate else speed


@dataclass(frozen=True)
class GatedGap:
    """The ``gap`` of a contact that is not always there."""

    gap: Gap
    there: Whiles

    @property
    def on(self) -> sp.Expr:
        return self.there.on

    def _seen(self, at: Positions) -> Accelerations:
        """Where the mechanism is, as the gap sees it."""
        return cast("Accelerations", Seen(at, self.there))

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
        return self.on * self.gap.value(self._seen(at)) + self.there.apart(at)

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


def whiles_of(gap: Gap) -> tuple[tuple[tuple[str, bool], ...], ...]:
    """While what a contact is there, one way of several: gates, by their paths, each with whether it is 1 or 0."""
    found: tuple[tuple[tuple[str, bool], ...], ...] = ((),)
    while isinstance(gap, GatedGap):
        these = [tuple((gate.path, one) for gate, one in each) for each in gap.there.whiles]
        found = tuple((*before, *these_) for before in found for these_ in these)
        gap = gap.gap
    return found
