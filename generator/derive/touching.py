"""Gaps between links: a disc of one before a disc, an edge or a piece of an outline of another (theory, section 5.9).

All are the distance of a centre from a point of the other link, less radii: from the centre of the other disc, or from
the nearest point of segments with round ends. Where that point is inside a segment the common normal turns with the
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
        return self._meet(at).distance - self.radius - self.thickness

    def closing(self, at: Velocities) -> sp.Expr:
        return at.let(f"closing_{self.label}", dot(self._meet(at).normal, self._drift(at)))

    def bias(self, at: Accelerations) -> sp.Expr:
        """Eq. 5.16: ν·a_cf − Ω (2 τ·v_cf + Ω D)."""
        meeting, turn = self._meet(at), self._turn(at)
        curved = turn * (2 * self._sideways(at) + turn * meeting.distance)
        return dot(meeting.normal, self._bend(at)) - curved

    def slip(self, at: Accelerations) -> sp.Expr:
        """Of the material points that touch, eq. 5.14."""
        rolling = self.radius * at.rate(self.disc.link) + self.thickness * at.rate(self.other.link)
        return self._sideways(at) + rolling

    def slip_bias(self, at: Accelerations) -> sp.Expr:
        """Eq. 5.16: τ·a_cf + Ω ν·v_cf."""
        return dot(self._meet(at).tangent, self._bend(at)) + self._turn(at) * self.closing(at)

    def push(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        """Along the common normal, through the disc's centre and the point of the other body that is nearest."""
        return self._opposite(at, scale(impulse, self._meet(at).normal), sp.S.Zero, sp.S.Zero)

    def drag(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        """Across it at the touching place, which is off the centre and off the nearest point by the radii."""
        along = scale(impulse, self._meet(at).tangent)
        return self._opposite(at, along, self.radius * impulse, self.thickness * impulse)

    def _opposite(self, at: Accelerations, impulse: Vector, moment: sp.Expr, turned: sp.Expr) -> dict[int, Wrench]:
        """An impulse on the disc's centre and its opposite on the nearest point, with a moment on each."""
        arms = (at.arm(self.disc), add(at.arm(self.other), self._meet(at).foot))
        back = scale(sp.S.NegativeOne, impulse)
        return {
            self.disc.link: (impulse, dot(perp(arms[0]), impulse) + moment),
            self.other.link: (back, dot(perp(arms[1]), back) + turned),
        }

    # -- geometry --------------------------------------------------------------------------------------------------

    def _meet(self, at: Positions) -> Meeting:
        """The nearest point of the other body, and the common normal."""
        name, foot, inside = self.label, ZERO, sp.S.Zero
        reach = at.let_vector(f"reach_{name}", at.distance(self.other, self.disc))
        if self.edge:
            length = self.edge.length
            along = at.let_vector(f"edge_{name}", scale(1 / length, at.distance(self.other, self.edge.end)))
            place = at.let(f"place_{name}", dot(along, reach))
            beyond = at.let(f"beyond_{name}", step(place - length))
            inside = at.let(f"inside_{name}", step(place) - beyond)
            foot = at.let_vector(f"foot_{name}", scale(inside * place + beyond * length, along))
            reach = at.let_vector(f"off_{name}", less(reach, foot))
        distance = at.let(f"apart_{name}", sp.sqrt(dot(reach, reach)))
        return Meeting(foot, distance, at.let_vector(f"normal_{name}", scale(1 / distance, reach)), inside)

    def _drift(self, at: Velocities) -> Vector:
        """v_cf: velocity of the centre against the material point of the other body that is nearest (m/s)."""
        swing = scale(-at.rate(self.other.link), perp(self._meet(at).foot))
        return at.let_vector(f"drift_{self.label}", add(at.approach(self.other, self.disc), swing))

    def _bend(self, at: Accelerations) -> Vector:
        """a_cf: acceleration of the centre against that point with u̇ = 0 (m/s²)."""
        inwards = scale(at.rate(self.other.link) ** 2, self._meet(at).foot)
        return at.let_vector(f"bend_{self.label}", add(at.bend(self.other, self.disc), inwards))

    def _sideways(self, at: Accelerations) -> sp.Expr:
        """τ·v_cf (m/s)."""
        return at.let(f"sideways_{self.label}", dot(self._meet(at).tangent, self._drift(at)))

    def _turn(self, at: Accelerations) -> sp.Expr:
        """Ω (rad/s), eq. 5.15: the normal turns with the edge where the disc is beside it, else with the line."""
        meeting = self._meet(at)
        line = -self._sideways(at) / meeting.distance
        rate = meeting.inside * at.rate(self.other.link) + (1 - meeting.inside) * line
        return at.let(f"turn_{self.label}", rate)


@dataclass(frozen=True)
class Side:
    """An edge of an outline between two points of a link, ``length`` (m) apart; ``label`` tells its names from those of
    other edges."""

    label: str
    start: PointRef
    end: PointRef
    length: sp.Expr


@dataclass(frozen=True)
class PieceGap(TouchGap):
    """A disc before a piece of an outline: ``sides`` in a row from ``other`` on, with one nearest point of the disc's
    centre, as a convex outline has one outside."""

    sides: tuple[Side, ...] = ()

    def points(self) -> tuple[PointRef, ...]:
        return (self.disc, self.other, *dict.fromkeys(side.end for side in self.sides))

    def _meet(self, at: Positions) -> Meeting:
        """Of the nearest points of all edges the nearest; where two are as near, it is their common corner."""
        name, foot, inside, square = self.label, ZERO, sp.S.Zero, sp.S.Zero
        reach = at.let_vector(f"reach_{name}", at.distance(self.other, self.disc))
        for k, side in enumerate(self.sides):
            one = f"{name}_{k}"
            start = at.let_vector(f"start_{side.label}", at.distance(self.other, side.start)) if k else ZERO
            along = at.let_vector(f"edge_{side.label}", scale(1 / side.length, at.distance(side.start, side.end)))
            place = at.let(f"place_{one}", dot(along, less(reach, start)))
            beyond = at.let(f"beyond_{one}", step(place - side.length))
            within = at.let(f"inside_{one}", step(place) - beyond)
            end = add(start, scale(within * place + beyond * side.length, along))
            end = at.let_vector(f"foot_{one}", end)
            off = less(reach, end)
            away = at.let(f"square_{one}", dot(off, off))
            if k:
                nearer = at.let(f"nearer_{one}", step(square - away))
                end = add(scale(1 - nearer, foot), scale(nearer, end))
                within, away = (1 - nearer) * inside + nearer * within, (1 - nearer) * square + nearer * away
            last = k == len(self.sides) - 1
            foot = at.let_vector(f"foot_{name}" if last else f"least_foot_{one}", end)
            inside = at.let(f"inside_{name}" if last else f"least_inside_{one}", within)
            square = away if last else at.let(f"least_square_{one}", away)
        reach = at.let_vector(f"off_{name}", less(reach, foot))
        distance = at.let(f"apart_{name}", sp.sqrt(dot(reach, reach)))
        return Meeting(foot, distance, at.let_vector(f"normal_{name}", scale(1 / distance, reach)), inside)
