"""Gaps between links: a disc of one before a disc, an edge or a piece of an outline of another (theory, section 5.9).

All are the distance of a centre from a point of the other link, less radii: from the centre of the other disc, or from
the nearest point of segments with round ends. Where that point is inside a segment the common normal turns with the
edge, else with the line between two points; all else is one set of formulas. What a disc inside a round hole or a slot
has in common with this, :class:`Pair`, is here too; the rest is in ``containing.py``.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ..equations.step import step
from ..mechanism.joints import PointRef
from .gaps import Accelerations, Positions, Velocities
from .vectors import ZERO, Vector, Wrench, add, dot, less, perp, scale

NEARER = sp.Rational(1, 2**36)
"""An edge is taken to be nearer than a corner if its squared distance is not more by this part.

Past a corner an edge is nearer by the square of the way along it alone, which rounding hides: the two would take turns
there. This is more than the rounding of squared distances, 2 ε width/radius, of polygons up to 3·10⁴ disc radii wide.
Only corners nearer to each other than 4·10⁻⁶ radii could be mistaken for what is between them, by 10⁻¹¹ radii."""


@dataclass(frozen=True)
class Edge:
    """A straight edge from a point of a link to its point ``end``, ``length`` (m) away."""

    end: PointRef
    length: sp.Expr


@dataclass(frozen=True)
class Nearest:
    """The point of the other body that is nearest to a disc's centre: all vectors in fixed axes.

    It is ``foot`` away from the other body's point, and the centre is ``off`` away from it. ``inside`` is 1 where it
    lies inside an edge, whose direction is ``along``, else 0.
    """

    foot: Vector
    off: Vector
    inside: sp.Expr
    along: Vector


@dataclass(frozen=True, kw_only=True)
class Pair:
    """A disc of ``radius`` about ``disc``, and another body about ``other``: round about that point, or about an edge
    from there.

    ``thickness`` is how far the surface of the other body is from there (m), negative where the disc is inside it.
    ``label`` tells the names of its quantities from those of others.
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
    slides = False

    def points(self) -> tuple[PointRef, ...]:
        return (self.disc, self.other, *((self.edge.end,) if self.edge else ()))

    def nearest(self, at: Positions) -> Nearest:
        """The nearest point of the other body."""
        name, foot, inside, along = self.label, ZERO, sp.S.Zero, ZERO
        off = self._reach(at)
        if self.edge:
            length, along, place = self.edge.length, self._direction(at, self.edge), self.place(at)
            beyond = at.let(f"beyond_{name}", step(place - length))
            inside = at.let(f"inside_{name}", step(place) - beyond)
            foot = at.let_vector(f"foot_{name}", scale(inside * place + beyond * length, along))
            off = at.let_vector(f"off_{name}", less(off, foot))
        return Nearest(foot, off, inside, along)

    def place(self, at: Positions) -> sp.Expr:
        """How far along the edge the disc's centre is (m), which lies beside it between 0 and its length."""
        assert self.edge is not None
        return at.let(f"place_{self.label}", dot(self._direction(at, self.edge), self._reach(at)))

    def _reach(self, at: Positions) -> Vector:
        """From the other body's point to the disc's centre (m)."""
        return at.let_vector(f"reach_{self.label}", at.distance(self.other, self.disc))

    def _direction(self, at: Positions, edge: Edge) -> Vector:
        """The direction of an edge."""
        return at.let_vector(f"edge_{self.label}", scale(1 / edge.length, at.distance(self.other, edge.end)))

    def _drift(self, at: Velocities) -> Vector:
        """v_cf: velocity of the centre against the material point of the other body that is nearest (m/s)."""
        swing = scale(-at.rate(self.other.link), perp(self.nearest(at).foot))
        return at.let_vector(f"drift_{self.label}", add(at.approach(self.other, self.disc), swing))

    def _bend(self, at: Accelerations) -> Vector:
        """a_cf: acceleration of the centre against that point with u̇ = 0 (m/s²)."""
        inwards = scale(at.rate(self.other.link) ** 2, self.nearest(at).foot)
        return at.let_vector(f"bend_{self.label}", add(at.bend(self.other, self.disc), inwards))

    def _rolling(self, at: Velocities) -> sp.Expr:
        """How fast the surfaces move against each other because both bodies turn (m/s), eq. 5.14."""
        return self.radius * at.rate(self.disc.link) + self.thickness * at.rate(self.other.link)

    def _across(self, at: Accelerations, impulse: sp.Expr, tangent: Vector) -> dict[int, Wrench]:
        """An impulse across the normal at the touching place, which is off the centre and off the nearest point."""
        return self._opposite(at, scale(impulse, tangent), self.radius * impulse, self.thickness * impulse)

    def _opposite(
        self, at: Accelerations, impulse: Vector, moment: sp.Expr = sp.S.Zero, turned: sp.Expr = sp.S.Zero
    ) -> dict[int, Wrench]:
        """An impulse on the disc's centre and its opposite on the nearest point, with a moment on each."""
        arms = (at.arm(self.disc), add(at.arm(self.other), self.nearest(at).foot))
        back = scale(sp.S.NegativeOne, impulse)
        return {
            self.disc.link: (impulse, dot(perp(arms[0]), impulse) + moment),
            self.other.link: (back, dot(perp(arms[1]), back) + turned),
        }


@dataclass(frozen=True)
class Meeting:
    """Where a disc and another body are nearest: all vectors in fixed axes.

    ``normal`` points from the other body to the disc, whose centre is ``distance`` (m) from the nearest point. That is
    inside an edge where ``inside`` is 1, not 0.
    """

    distance: sp.Expr
    normal: Vector
    inside: sp.Expr

    @property
    def tangent(self) -> Vector:
        """The direction of sliding: the normal turned by a right angle, clockwise."""
        return (self.normal[1], -self.normal[0])


@dataclass(frozen=True, kw_only=True)
class TouchGap(Pair):
    """A disc before another disc, or before an edge. ``thickness`` is the other disc's radius, or half of what the edge
    is thick (m)."""

    def value(self, at: Positions) -> sp.Expr:
        """Eq. 5.13."""
        return self.meet(at).distance - self.radius - self.thickness

    def closing(self, at: Velocities) -> sp.Expr:
        return at.let(f"closing_{self.label}", dot(self.meet(at).normal, self._drift(at)))

    def bias(self, at: Accelerations) -> sp.Expr:
        """Eq. 5.16: ν·a_cf − Ω (2 τ·v_cf + Ω D)."""
        meeting, turn = self.meet(at), self._turn(at)
        curved = turn * (2 * self._sideways(at) + turn * meeting.distance)
        return dot(meeting.normal, self._bend(at)) - curved

    def slip(self, at: Velocities) -> sp.Expr:
        """Of the material points that touch, eq. 5.14."""
        return self._sideways(at) + self._rolling(at)

    def slip_bias(self, at: Accelerations) -> sp.Expr:
        """Eq. 5.16: τ·a_cf + Ω ν·v_cf."""
        return dot(self.meet(at).tangent, self._bend(at)) + self._turn(at) * self.closing(at)

    def push(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        """Along the common normal, through the disc's centre and the point of the other body that is nearest."""
        return self._opposite(at, scale(impulse, self.meet(at).normal))

    def drag(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        return self._across(at, impulse, self.meet(at).tangent)

    # -- geometry --------------------------------------------------------------------------------------------------

    def meet(self, at: Positions) -> Meeting:
        """The distance to the nearest point of the other body, and the common normal."""
        nearest = self.nearest(at)
        distance = at.let(f"apart_{self.label}", sp.sqrt(dot(nearest.off, nearest.off)))
        normal = at.let_vector(f"normal_{self.label}", scale(1 / distance, nearest.off))
        return Meeting(distance, normal, nearest.inside)

    def _sideways(self, at: Velocities) -> sp.Expr:
        """τ·v_cf (m/s)."""
        return at.let(f"sideways_{self.label}", dot(self.meet(at).tangent, self._drift(at)))

    def _turn(self, at: Accelerations) -> sp.Expr:
        """Ω (rad/s), eq. 5.15: the normal turns with the edge where the disc is beside it, else with the line."""
        meeting = self.meet(at)
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
class Polygon:
    """All edges of a polygon in order round it, and the label of the disc's centre that is outside of it or inside."""

    label: str
    sides: tuple[Side, ...]


@dataclass(frozen=True, kw_only=True)
class PieceGap(TouchGap):
    """A disc before a piece of an outline: ``sides`` in a row, with one nearest point of the disc's centre, as a convex
    outline has one outside. Inside of a ``polygon`` the distance is negative."""

    sides: tuple[Side, ...]
    polygon: Polygon | None = None

    def points(self) -> tuple[PointRef, ...]:
        sides = self.polygon.sides if self.polygon else self.sides
        return (self.disc, *dict.fromkeys((self.other, *(end for side in sides for end in (side.start, side.end)))))

    def meet(self, at: Positions) -> Meeting:
        """Inside of a polygon the normal still points outwards (section 5.9)."""
        if self.polygon is None:
            return super().meet(at)
        nearest = self.nearest(at)
        distance = sp.sqrt(dot(nearest.off, nearest.off))
        distance = at.let(f"apart_{self.label}", self._outside(at, self.polygon) * distance)
        normal = at.let_vector(f"normal_{self.label}", scale(1 / distance, nearest.off))
        return Meeting(distance, normal, nearest.inside)

    def nearest(self, at: Positions) -> Nearest:
        """Of the nearest points of all edges the nearest; where two are as near, it is their common corner."""
        name, foot, inside, square = self.label, ZERO, sp.S.Zero, sp.S.Zero
        reach = self._reach(at)
        for k, side in enumerate(self.sides):
            one = f"{name}_{k}"
            start, along = self._start(at, side), self._along(at, side)
            place = at.let(f"place_{one}", dot(along, less(reach, start)))
            beyond = at.let(f"beyond_{one}", step(place - side.length))
            within = at.let(f"inside_{one}", step(place) - beyond)
            end = add(start, scale(within * place + beyond * side.length, along))
            end = at.let_vector(f"foot_{one}", end)
            off = less(reach, end)
            away = at.let(f"square_{one}", dot(off, off) * (1 - NEARER * within))
            if k:
                nearer = at.let(f"nearer_{one}", step(square - away))
                end = add(scale(1 - nearer, foot), scale(nearer, end))
                within, away = (1 - nearer) * inside + nearer * within, (1 - nearer) * square + nearer * away
            last = k == len(self.sides) - 1
            foot = at.let_vector(f"foot_{name}" if last else f"least_foot_{one}", end)
            inside = at.let(f"inside_{name}" if last else f"least_inside_{one}", within)
            square = away if last else at.let(f"least_square_{one}", away)
        return Nearest(foot, at.let_vector(f"off_{name}", less(reach, foot)), inside, ZERO)

    def _outside(self, at: Positions, polygon: Polygon) -> sp.Expr:
        """1 outside of the polygon, −1 inside (section 5.9)."""
        return at.once(f"outside_{polygon.label}", lambda: 1 - 2 * self._winding(at, polygon) ** 2)

    def _winding(self, at: Positions, polygon: Polygon) -> sp.Expr:
        """The polygon's winding number about the centre."""
        reach, turns = self._reach(at), []
        above = [step(reach[1] - self._start(at, side)[1]) for side in polygon.sides]
        above = [at.let(f"above_{polygon.label}_{k}", one) for k, one in enumerate(above)]
        for k, side in enumerate(polygon.sides):
            left = step(dot(perp(self._along(at, side)), less(reach, self._start(at, side))))
            left = at.let(f"left_{polygon.label}_{k}", left - sp.Rational(1, 2))
            turns.append((above[k] - above[(k + 1) % len(above)]) ** 2 * left)
        return at.let(f"winding_{polygon.label}", sp.Add(*turns))

    def _reach(self, at: Positions) -> Vector:
        """Pieces of a polygon share it."""
        label = self.polygon.label if self.polygon else self.label
        return at.let_vector(f"reach_{label}", at.distance(self.other, self.disc))

    def _start(self, at: Positions, side: Side) -> Vector:
        """From the other body's point to an edge's start (m)."""
        if side.start == self.other:
            return ZERO
        return at.let_vector(f"start_{side.label}", at.distance(self.other, side.start))

    def _along(self, at: Positions, side: Side) -> Vector:
        """The direction of an edge."""
        return at.let_vector(f"edge_{side.label}", scale(1 / side.length, at.distance(side.start, side.end)))
