"""Kinds of gaps: a disc above a half-plane (of radius zero: a point), and a joint before its stop.

A gap asks :class:`Positions`, :class:`Velocities` or :class:`Accelerations` where things are and how they move, and
answers with expressions; what its impulses do it says as wrenches on links (theory, sections 5.1 and 5.8). To add a
kind, write a class with the methods of :class:`Gap`, as the discs and edges of links in ``touching.py``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import sympy as sp

from ..mechanism.joints import PointRef
from .vectors import Vector, Wrench, dot, perp, scale


class Positions(Protocol):
    """Where the mechanism is."""

    def position(self, ref: PointRef) -> Vector:
        """Position of a point (m)."""
        ...

    def angle(self, link: int) -> sp.Expr:
        """Angle of a link's frame (rad); zero for the ground."""
        ...

    def distance(self, start: PointRef, end: PointRef) -> Vector:
        """The vector from one point to another (m)."""
        ...

    def joint_position(self, joint: int) -> sp.Expr:
        """Angle of a joint that turns (rad), or how far one that slides is along its line (m)."""
        ...

    def let(self, name: str, expression: sp.Expr) -> sp.Expr:
        """A name for what is used more than once."""
        ...

    def let_vector(self, name: str, vector: Vector) -> Vector:
        """Names for both entries."""
        ...

    def once(self, name: str, make: Callable[[], sp.Expr]) -> sp.Expr:
        """A name for what ``make`` says, which is asked at most once."""
        ...


class Velocities(Positions, Protocol):
    """Where the mechanism is, and how fast it moves."""

    def velocity(self, ref: PointRef) -> Vector:
        """Velocity of a point (m/s)."""
        ...

    def rate(self, link: int) -> sp.Expr:
        """Angular velocity of a link (rad/s); zero for the ground."""
        ...

    def approach(self, start: PointRef, end: PointRef) -> Vector:
        """The rate of the vector from one point to another (m/s)."""
        ...

    def joint_speed(self, joint: int) -> sp.Expr:
        """Its rate (rad/s, m/s)."""
        ...


class Accelerations(Velocities, Protocol):
    """All that gaps ask: how points accelerate by the velocities alone, too."""

    def arm(self, ref: PointRef) -> Vector:
        """From the inboard point of the point's link to the point (m)."""
        ...

    def centripetal(self, ref: PointRef) -> Vector:
        """Acceleration of a point with u̇ = 0 (m/s²)."""
        ...

    def bend(self, start: PointRef, end: PointRef) -> Vector:
        """The second rate of that vector with u̇ = 0 (m/s²)."""
        ...

    def joint_bias(self, joint: int) -> sp.Expr:
        """The second rate of a joint's position with u̇ = 0 (rad/s², m/s²)."""
        ...

    def along_joint(self, joint: int, impulse: sp.Expr) -> dict[int, Wrench]:
        """What an impulse that moves a joint's second link on, a couple or along its line, does to both links."""
        ...


class Gap(Protocol):
    """Something that must not become negative, as a function of the configuration.

    ``name`` and ``ground`` say what touches what; gaps, rates and impulses are in m, m/s and N s or, where ``angular``,
    in rad, rad/s and N m s.
    """

    @property
    def name(self) -> str: ...

    @property
    def ground(self) -> str: ...

    @property
    def restitution(self) -> sp.Expr: ...

    @property
    def friction(self) -> sp.Expr: ...

    @property
    def angular(self) -> bool: ...

    @property
    def slides(self) -> bool:
        """Whether it ends the line of a joint that slides."""
        ...

    def points(self) -> tuple[PointRef, ...]:
        """Points to which arms are needed."""
        ...

    def value(self, at: Positions) -> sp.Expr:
        """The gap, positive outside."""
        ...

    def closing(self, at: Velocities) -> sp.Expr:
        """Its row of N u: the gap's rate."""
        ...

    def bias(self, at: Accelerations) -> sp.Expr:
        """Its row of Ṅ u: the gap's second derivative with u̇ = 0."""
        ...

    def slip(self, at: Accelerations) -> sp.Expr:
        """Its row of T u: how fast it slides (m/s)."""
        ...

    def slip_bias(self, at: Accelerations) -> sp.Expr:
        """Its row of Ṫ u (m/s²)."""
        ...

    def push(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        """What a normal impulse does to links: impulse, and its moment about the link's inboard point."""
        ...

    def drag(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        """What a tangential impulse does, likewise."""
        ...


@dataclass(frozen=True)
class PlaneGap:
    """A disc of ``radius`` about a point, above a half-plane: gap = normal·x − offset − radius (eq. 5.1 and 5.10)."""

    name: str
    point: PointRef
    ground: str
    normal: Vector
    offset: sp.Expr
    restitution: sp.Expr
    friction: sp.Expr = sp.S.Zero
    radius: sp.Expr = sp.S.Zero
    angular = False
    slides = False

    @property
    def tangent(self) -> Vector:
        """The direction of sliding: the normal turned by a right angle, clockwise."""
        return (self.normal[1], -self.normal[0])

    def points(self) -> tuple[PointRef, ...]:
        return (self.point,)

    def value(self, at: Positions) -> sp.Expr:
        return dot(self.normal, at.position(self.point)) - self.offset - self.radius

    def closing(self, at: Velocities) -> sp.Expr:
        return dot(self.normal, at.velocity(self.point))

    def bias(self, at: Accelerations) -> sp.Expr:
        return dot(self.normal, at.centripetal(self.point))

    def slip(self, at: Accelerations) -> sp.Expr:
        """Of the material point that touches, eq. 5.11."""
        return dot(self.tangent, at.velocity(self.point)) + self.radius * at.rate(self.point.link)

    def slip_bias(self, at: Accelerations) -> sp.Expr:
        return dot(self.tangent, at.centripetal(self.point))

    def push(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        return self._at_centre(at, scale(impulse, self.normal), sp.S.Zero)

    def drag(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        return self._at_centre(at, scale(impulse, self.tangent), self.radius * impulse)

    def _at_centre(self, at: Accelerations, impulse: Vector, moment: sp.Expr) -> dict[int, Wrench]:
        """An impulse through the disc's centre, and a moment."""
        return {self.point.link: (impulse, dot(perp(at.arm(self.point)), impulse) + moment)}


@dataclass(frozen=True)
class JointGap:
    """A joint before its stop at ``limit``, eq. 5.12: its angle (rad), second link against first, or where it
    ``slides`` its way along its line (m).

    The gap is sign (position − limit): sign is 1 for a lowest position and −1 for a highest one. ``joint`` is the
    joint's number, ``ends`` are its points.
    """

    name: str
    ground: str
    joint: int
    slides: bool
    ends: tuple[PointRef, PointRef]
    sign: int
    limit: sp.Expr
    restitution: sp.Expr
    friction: sp.Expr = sp.S.Zero

    @property
    def angular(self) -> bool:
        return not self.slides

    def points(self) -> tuple[PointRef, ...]:
        return self.ends if self.slides else ()

    def value(self, at: Positions) -> sp.Expr:
        return self.sign * (at.joint_position(self.joint) - self.limit)

    def closing(self, at: Velocities) -> sp.Expr:
        return self.sign * at.joint_speed(self.joint)

    def bias(self, at: Accelerations) -> sp.Expr:
        return self.sign * at.joint_bias(self.joint)

    def slip(self, at: Accelerations) -> sp.Expr:
        """Zero: a stop has no friction."""
        return sp.S.Zero

    def slip_bias(self, at: Accelerations) -> sp.Expr:
        return sp.S.Zero

    def push(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        """On the second link, its opposite on the first."""
        return at.along_joint(self.joint, self.sign * impulse)

    def drag(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        return {}
