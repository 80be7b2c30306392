"""Gaps between links: a disc of one before a disc, or before an edge, of another (theory, section 5.9).

Both are the distance of a centre from a point of the other link, less radii: from the centre of the other disc, or from
the nearest point of a segment with round ends. Where that point is inside the segment the common normal turns with the
edge, else with the line between two points; all else is one set of formulas.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ..equations.step import step
from ..mechanism.joints import PointRef
from .gaps import Accelerations, Positions, Velocities
from .vectors import ZERO, Vector, Wrench, add, dot, less, perp, scale


@dataclass(frozen=True)
class Edge:
    """A straight edge from a point of a link to its point ``end``, ``length`` (m) away."""

    end: PointRef
    length: sp.Expr


@dataclass(frozen=True)
class Meeting:
    """Where a disc and another body are nearest: all vectors in fixed axes.

    ``normal`` points from the other body to the disc, whose centre is ``distance`` (m) from the nearest point; this is
    ``foot`` away from the other body's point. ``inside`` is 1 where it lies inside an edge, else 0.
    """

    foot: Vector
    distance: sp.Expr
    normal: Vector
    inside: sp.Expr

    @property
    def tangent(self) -> Vector:
        """The direction of sliding: the normal turned by a right angle, clockwise."""
        return (self.normal[1], -self.normal[0])


@dataclass(frozen=True)
class TouchGap:
    """A disc of ``radius`` about ``disc`` before another body about ``other``: a disc, or an edge from there.

    ``thickness`` is the other disc's radius, or half of what the edge is thick (m). ``label`` tells the names of its
    quantities from those of others.
    """

    name: str
    ground: str
    label: str
    disc: PointRef
    other: PointRef
    edge: Edge | None
    radius: sp.Expr
    thickness: sp.Expr
    restitution: sp.Expr
    friction: sp.Expr = sp.S.Zero
    angular = False

    def points(self) -> tuple[PointRef, ...]:
        return (self.disc, self.other, *((self.edge.end,) if self.edge else ()))

    def value(self, at: Positions) -> sp.Expr:
        """Eq. 5.13."""
        return self.meet(at).distance - self.radius - self.thickness

    def place(self, at: Positions) -> sp.Expr:
        """How far along the edge the disc's centre is (m), which lies beside it between 0 and its length."""
        assert self.edge is not None
        return at.let(f"place_{self.label}", dot(self._along(at, self.edge), self._reach(at)))

    def closing(self, at: Velocities) -> sp.Expr:
        return at.let(f"closing_{self.label}", dot(self.meet(at).normal, self._drift(at)))

    def bias(self, at: Accelerations) -> sp.Expr:
        """Eq. 5.16: ν·a_cf − Ω (2 τ·v_cf + Ω D)."""
        meeting, turn = self.meet(at), self._turn(at)
        curved = turn * (2 * self._sideways(at) + turn * meeting.distance)
        return dot(meeting.normal, self._bend(at)) - curved

    def slip(self, at: Velocities) -> sp.Expr:
        """Of the material points that touch, eq. 5.14."""
        rolling = self.radius * at.rate(self.disc.link) + self.thickness * at.rate(self.other.link)
        return self._sideways(at) + rolling

    def slip_bias(self, at: Accelerations) -> sp.Expr:
        """Eq. 5.16: τ·a_cf + Ω ν·v_cf."""
        return dot(self.meet(at).tangent, self._bend(at)) + self._turn(at) * self.closing(at)

    def push(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        """Along the common normal, through the disc's centre and the point of the other body that is nearest."""
        return self._opposite(at, scale(impulse, self.meet(at).normal), sp.S.Zero, sp.S.Zero)

    def drag(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        """Across it at the touching place, which is off the centre and off the nearest point by the radii."""
        along = scale(impulse, self.meet(at).tangent)
        return self._opposite(at, along, self.radius * impulse, self.thickness * impulse)

    def _opposite(self, at: Accelerations, impulse: Vector, moment: sp.Expr, turned: sp.Expr) -> dict[int, Wrench]:
        """An impulse on the disc's centre and its opposite on the nearest point, with a moment on each."""
        arms = (at.arm(self.disc), add(at.arm(self.other), self.meet(at).foot))
        back = scale(sp.S.NegativeOne, impulse)
        return {
            self.disc.link: (impulse, dot(perp(arms[0]), impulse) + moment),
            self.other.link: (back, dot(perp(arms[1]), back) + turned),
        }

    # -- geometry --------------------------------------------------------------------------------------------------

    def _reach(self, at: Positions) -> Vector:
        """From the other body's point to the disc's centre (m)."""
        return at.let_vector(f"reach_{self.label}", at.distance(self.other, self.disc))

    def _along(self, at: Positions, edge: Edge) -> Vector:
        """The direction of an edge."""
        return at.let_vector(f"edge_{self.label}", scale(1 / edge.length, at.distance(self.other, edge.end)))

    def meet(self, at: Positions) -> Meeting:
        """The nearest point of the other body, and the common normal."""
        name, foot, inside = self.label, ZERO, sp.S.Zero
        reach = self._reach(at)
        if self.edge:
            length, along = self.edge.length, self._along(at, self.edge)
            place = self.place(at)
            beyond = at.let(f"beyond_{name}", step(place - length))
            inside = at.let(f"inside_{name}", step(place) - beyond)
            foot = at.let_vector(f"foot_{name}", scale(inside * place + beyond * length, along))
            reach = at.let_vector(f"off_{name}", less(reach, foot))
        distance = at.let(f"apart_{name}", sp.sqrt(dot(reach, reach)))
        return Meeting(foot, distance, at.let_vector(f"normal_{name}", scale(1 / distance, reach)), inside)

    def _drift(self, at: Velocities) -> Vector:
        """v_cf: velocity of the centre against the material point of the other body that is nearest (m/s)."""
        swing = scale(-at.rate(self.other.link), perp(self.meet(at).foot))
        return at.let_vector(f"drift_{self.label}", add(at.approach(self.other, self.disc), swing))

    def _bend(self, at: Accelerations) -> Vector:
        """a_cf: acceleration of the centre against that point with u̇ = 0 (m/s²)."""
        inwards = scale(at.rate(self.other.link) ** 2, self.meet(at).foot)
        return at.let_vector(f"bend_{self.label}", add(at.bend(self.other, self.disc), inwards))

    def _sideways(self, at: Velocities) -> sp.Expr:
        """τ·v_cf (m/s)."""
        return at.let(f"sideways_{self.label}", dot(self.meet(at).tangent, self._drift(at)))

    def _turn(self, at: Accelerations) -> sp.Expr:
        """Ω (rad/s), eq. 5.15: the normal turns with the edge where the disc is beside it, else with the line."""
        meeting = self.meet(at)
        line = -self._sideways(at) / meeting.distance
        rate = meeting.inside * at.rate(self.other.link) + (1 - meeting.inside) * line
        return at.let(f"turn_{self.label}", rate)
