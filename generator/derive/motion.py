"""What effects see of the moving mechanism: where points are, how they move, and angles between links.

Distances between two points are summed along the tree from the link where their ways meet, so the position of a
floating mechanism does not enter them and costs no digits.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import sympy as sp

from ..equations.names import slide_name, sliding_name
from ..equations.step import step
from ..mechanism.joints import Joint, PointRef
from ..mechanism.links import GROUND, INTEGRATES, Parameter
from .closure import Closure
from .displacement import Displacement, between
from .kinematics import Kinematics
from .vectors import NO_LOAD, ZERO, Vector, Wrench, add, dot, less, perp, scale, symbol

TIME = sp.Symbol("t")


@dataclass(frozen=True)
class Force:
    """A force (N, fixed axes) on a point of a link; on the ground it does nothing."""

    point: PointRef
    vector: Vector


@dataclass(frozen=True)
class Couple:
    """A moment (N m, counter-clockwise) on a link; on the ground it does nothing."""

    link: int
    moment: sp.Expr


class Stands(Protocol):
    """What the name of a law stands for in a motion."""

    def as_law(self, motion: Motion, held: bool) -> sp.Expr:
        """The value, on the sides of kinks that the run holds (``held``), or with its kinks."""
        ...


class Motion:
    """Positions, velocities and angles as expressions; :meth:`let` names what is used more than once."""

    def __init__(
        self,
        kinematics: Kinematics,
        closure: Closure,
        place: dict[int, Vector],
        velocity: dict[int, Vector],
        laws: Mapping[str, Stands] | None = None,
    ) -> None:
        self.kinematics, self.closure, self.place, self.velocity_of = kinematics, closure, place, velocity
        self.time, self.laws = TIME, laws or {}
        self._known: dict[tuple[str, bool], sp.Expr] = {}

    def let(self, name: str, expression: sp.Expr) -> sp.Expr:
        """A named quantity of an effect."""
        return self.kinematics.ledger.let(name, expression)

    def let_vector(self, name: str, vector: Vector) -> Vector:
        return self.kinematics.ledger.let_vector(name, vector)

    def once(self, name: str, make: Callable[[], sp.Expr]) -> sp.Expr:
        """A named quantity for what ``make`` says, which is asked at most once."""
        return self.kinematics.ledger.once(name, make)

    def value(self, parameter: Parameter | None) -> sp.Expr:
        """A parameter's symbol, zero for a structural zero."""
        return symbol(parameter)

    def input(self, name: str) -> sp.Expr:
        """The value of an input, given at run time."""
        return sp.Symbol(f"in_{name}")

    def law(self, name: str, held: bool = True) -> sp.Expr:
        """What a law's name stands for, on the sides of kinks that the run holds, or with its kinks."""
        if (name, held) not in self._known:
            self._known[name, held] = self.laws[name].as_law(self, held)
        return self._known[name, held]

    def side(self, name: str) -> sp.Expr:
        """1 where the switching function of a kink is positive, else 0."""
        return sp.Symbol(f"side_{name}")

    def latched(self, name: str) -> sp.Expr:
        """A value that an effect holds since the switching function of one of its kinks became positive."""
        return sp.Symbol(f"latched_{name}")

    def step(self, value: sp.Expr) -> sp.Expr:
        """1 where a value is positive, else 0: of a potential, what :meth:`side` is of loads."""
        return step(value)

    def joint(self, index: int) -> Joint:
        """A joint between the links that a scene names, whether a shaft is between them or not."""
        return self.kinematics.mechanism.as_named(index)

    def position(self, ref: PointRef) -> Vector:
        """Where a point is (m)."""
        base = ZERO if ref.link == GROUND else self.place[ref.link]
        return add(base, self.kinematics.arm_to(ref))

    def velocity(self, ref: PointRef) -> Vector:
        """How fast a point moves (m/s)."""
        if ref.link == GROUND:
            return ZERO
        return add(self.velocity_of[ref.link], self.kinematics.swing(ref.link, self.kinematics.arm_to(ref)))

    def distance(self, start: PointRef, end: PointRef) -> Vector:
        """The vector from one point to another (m)."""
        if self.kinematics.topology.floating and GROUND in (start.link, end.link):
            return add(self.position(end), scale(sp.S.NegativeOne, self.position(start)))
        return self._displacement(start, end).vector()

    def approach(self, start: PointRef, end: PointRef) -> Vector:
        """The rate of :meth:`distance` (m/s)."""
        if self.kinematics.topology.floating and GROUND in (start.link, end.link):
            return add(self.velocity(end), scale(sp.S.NegativeOne, self.velocity(start)))
        return self._displacement(start, end).rate()

    def angle(self, link: int) -> sp.Expr:
        """Angle of a link against the fixed axes (rad)."""
        return sp.S.Zero if link == GROUND else self.kinematics.state.angle(link)

    def rate(self, link: int) -> sp.Expr:
        """Angular velocity of a link (rad/s)."""
        return sp.S.Zero if link == GROUND else self.kinematics.state.rate(link)

    def joint_angle(self, joint: Joint) -> sp.Expr:
        """Angle of the second link against the first (rad)."""
        return self.angle(joint.second.link) - self.angle(joint.first.link)

    def joint_rate(self, joint: Joint) -> sp.Expr:
        """Rate of :meth:`joint_angle` (rad/s)."""
        return self.rate(joint.second.link) - self.rate(joint.first.link)

    def joint_position(self, index: int) -> sp.Expr:
        """Angle (rad) of a joint that turns; of one that slides, the length along its line (m)."""
        joint = self.joint(index)
        if not joint.slides:
            return self.joint_angle(joint)
        if index in self.closure.lines:
            line = self.closure.lines[index]
            return dot(line.along, line.distance)
        if self._is_apart(index):
            return dot(self.kinematics.line(index), self.distance(joint.first, joint.second))
        return sp.Symbol(slide_name(index))

    def joint_speed(self, index: int) -> sp.Expr:
        """Rate of :meth:`joint_position` (rad/s or m/s)."""
        joint = self.joint(index)
        if not joint.slides:
            return self.joint_rate(joint)
        if index in self.closure.lines:
            line = self.closure.lines[index]
            return dot(line.along, line.drift)
        if self._is_apart(index):
            carried = self.kinematics.swing(joint.first.link, self.distance(joint.first, joint.second))
            drift = less(self.approach(joint.first, joint.second), carried)
            return dot(self.kinematics.line(index), drift)
        return sp.Symbol(sliding_name(index))

    def _is_apart(self, index: int) -> bool:
        """Whether no coordinate is its place: it follows from others, or has a shaft."""
        shafts, name = self.kinematics.mechanism.shafts, self.kinematics.mechanism.joints[index].name
        return name in shafts or any(idle.joint == index for idle in self.kinematics.topology.implied)

    def joint_effort(self, index: int, effort: sp.Expr) -> list[Force | Couple]:
        """A torque (N m) on the joint's second link, or a force (N) along its line; the opposite on its first link."""
        joint = self.joint(index)
        if not joint.slides:
            return [Couple(joint.first.link, -effort), Couple(joint.second.link, effort)]
        push = scale(effort, self.kinematics.line(index))
        return [Force(joint.first, scale(sp.S.NegativeOne, push)), Force(joint.second, push)]

    def integral(self, name: str) -> sp.Expr:
        """An integral over time that an effect asks for."""
        return self.rate(self._integrator(name))

    def integrate(self, name: str, value: sp.Expr) -> Couple:
        """What makes ``value`` the rate of an integral."""
        return Couple(self._integrator(name), sp.Rational(INTEGRATES) * value)

    def _integrator(self, name: str) -> int:
        return next(one.link for one in self.kinematics.mechanism.integrators if one.name == name)

    def _displacement(self, start: PointRef, end: PointRef) -> Displacement:
        ends = [(ref.link, self.kinematics.arm_to(ref)) for ref in (start, end)]
        return between(self.kinematics, ends[0], ends[1])


def sum_per_link(loads: list[Force | Couple], kinematics: Kinematics) -> dict[int, Wrench]:
    """Force and moment about the inboard point for every link that is loaded."""
    result: dict[int, Wrench] = {}
    for load in loads:
        link = load.point.link if isinstance(load, Force) else load.link
        if link == GROUND:
            continue
        force, moment = result.get(link, NO_LOAD)
        if isinstance(load, Force):
            arm = kinematics.arm_to(load.point)
            result[link] = (add(force, load.vector), moment + dot(perp(arm), load.vector))
        else:
            result[link] = (force, moment + load.moment)
    return {
        link: (
            kinematics.ledger.let_vector(f"load_{link}", force),
            kinematics.ledger.let(f"moment_{link}", moment),
        )
        for link, (force, moment) in sorted(result.items())
    }
