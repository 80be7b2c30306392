"""Followers before a cam: a disc, or a point, before its profile, and a straight face (theory, section 5.16).

A cam is described by what its follower does: how far from the cam's centre the disc's centre, or the face, is where
they touch, as a function of the angle at which it is seen from the cam. For a disc these are polar coordinates of its
centre's way round the cam, for a face it is the support function of the profile. Both gaps are written with this
function and its derivatives; nothing is solved for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from ..equations.step import step
from ..mechanism.joints import PointRef
from .gaps import Accelerations, Positions, Velocities
from .vectors import Vector, Wrench, add, dot, perp, scale

ANGLE = sp.Symbol("angle")
"""The cam's own angle (rad) in the laws of lift."""

HIGHEST = 3
"""The highest derivative of a lift that a gap needs."""

PI = sp.Float(3.141592653589793)


@dataclass(frozen=True)
class LiftPiece:
    """The lift (m) from the angle ``start`` to ``end`` (rad) as an expression of :data:`ANGLE`."""

    start: float
    end: float
    law: sp.Expr

    @cached_property
    def laws(self) -> tuple[sp.Expr, ...]:
        """The law and its derivatives by the angle."""
        return tuple(sp.diff(self.law, ANGLE, order) if order else self.law for order in range(HIGHEST + 1))


@dataclass(frozen=True)
class Profile:
    """How far from the cam's centre its follower is: ``base`` (m) and a lift in ``pieces`` round one turn.

    Angles are counted from ``mounted`` (rad) in the cam's frame, counter-clockwise, or clockwise where ``sense`` is −1.
    """

    label: str
    base: sp.Expr
    pieces: tuple[LiftPiece, ...]
    mounted: sp.Expr
    sense: int

    def distance(self, at: Positions, cam: int, towards: Vector) -> tuple[sp.Expr, ...]:
        """The distance in the direction ``towards``, of length 1 in fixed axes, and its derivatives by the angle that
        this direction has in the frame of the link ``cam``, counter-clockwise (m)."""
        angle = self._angle(at, cam, towards)
        sums = [sp.S.Zero] * (HIGHEST + 1)
        for k, piece in enumerate(self.pieces):
            weight = self._within(at, angle, k)
            for order, law in enumerate(self._laws(at, angle, weight, k, piece)):
                sums[order] += weight * law
        signs = [self.sense**order for order in range(HIGHEST + 1)]
        sums[0] += self.base
        names = ("far", "slope", "curve", "third")
        return tuple(
            at.let(f"{name}_{self.label}", sign * value) for name, sign, value in zip(names, signs, sums, strict=True)
        )

    def zero(self, turned: sp.Expr, beyond: float = 0.0) -> Vector:
        """The direction of the cam's angle ``beyond`` (rad), zero unless given, where its link is ``turned``.

        The link's own sine and cosine are turned, so that no angle is added to one, whose sum SymPy would take apart.
        """
        axis = (sp.cos(turned), sp.sin(turned))
        for angle in (self.mounted, sp.Float(beyond) if beyond else sp.S.Zero):
            across = scale(self.sense * sp.sin(angle), perp(axis))
            axis = add(scale(sp.cos(angle), axis), across)
        return axis

    def _angle(self, at: Positions, cam: int, towards: Vector) -> sp.Expr:
        """The direction's angle on the cam, from 0 to one turn."""
        axis = at.let_vector(f"zero_{self.label}", self.zero(at.angle(cam)))
        along = at.let(f"along_{self.label}", dot(axis, towards))
        across = at.let(f"across_{self.label}", self.sense * dot(perp(axis), towards))
        behind = at.let(f"behind_{self.label}", step(-along))
        front = 1 - 2 * behind
        half = sp.atan(front * across / (1 + front * along))
        turned = at.let(f"turned_{self.label}", 2 * half + PI * behind)
        return at.let(f"angle_{self.label}", turned + 2 * PI * step(-turned))

    def _within(self, at: Positions, angle: sp.Expr, k: int) -> sp.Expr:
        """1 in piece ``k``, else 0."""
        weight = sp.S.One
        if k:
            weight = at.let(f"from_{self.label}_{k}", step(angle - sp.Float(self.pieces[k].start)))
        if k < len(self.pieces) - 1:
            weight -= at.let(f"from_{self.label}_{k + 1}", step(angle - sp.Float(self.pieces[k].end)))
        return weight

    def _laws(self, at: Positions, angle: sp.Expr, weight: sp.Expr, k: int, piece: LiftPiece) -> list[sp.Expr]:
        """The lift of a piece and its derivatives; outside of the piece those at its start, so that all are numbers."""
        own, label = angle, f"{self.label}_{k}"
        if len(self.pieces) > 1 and piece.law.has(ANGLE):
            start = sp.Float(piece.start)
            own = at.let(f"angle_{label}", start + weight * (angle - start))
        named = _Named(at.let, label)
        return [named.of(law.xreplace({ANGLE: own})) for law in piece.laws]


class _Named:
    """Gives each function, and each root, in some expressions a name of its own, in the order of their finding."""

    def __init__(self, let: Callable[[str, sp.Expr], sp.Expr], label: str) -> None:
        self.let, self.label = let, label
        self.names: dict[sp.Expr, sp.Expr] = {}

    def of(self, e: sp.Expr) -> sp.Expr:
        if not e.args:
            return e
        args = [self.of(arg) for arg in e.args]
        if isinstance(e, sp.Function):
            return self._name(e.func(*args))
        if e.is_Pow and e.exp.is_Rational and e.exp.q == 2:
            return self._name(sp.sqrt(args[0])) ** sp.Integer(e.exp.p)
        return e.func(*args)

    def _name(self, e: sp.Expr) -> sp.Expr:
        if e not in self.names:
            self.names[e] = self.let(f"part_{self.label}_{len(self.names)}", e)
        return self.names[e]


@dataclass(frozen=True, kw_only=True)
class RollerGap:
    """A disc of ``radius`` about ``disc`` before a cam about ``cam``; a point where the radius is zero.

    With ϱ the distance of both centres and p that of their touching, δ = w (ϱ − p), w = p/√(p² + p'²).
    """

    name: str
    ground: str
    label: str
    cam: PointRef
    disc: PointRef
    radius: sp.Expr
    profile: Profile
    restitution: sp.Expr
    friction: sp.Expr = sp.S.Zero
    angular = False
    slides = False

    def points(self) -> tuple[PointRef, ...]:
        return (self.cam, self.disc)

    def value(self, at: Positions) -> sp.Expr:
        """Eq. 5.28."""
        _, out, weight, (far, *_) = self._seen(at)
        return weight * (out - far)

    def closing(self, at: Velocities) -> sp.Expr:
        """Eq. 5.29: w ϱ̇ + g φ̇."""
        outwards, turning = self._moving(at)
        return at.let(f"closing_{self.label}", self._seen(at)[2] * outwards + self._lever(at) * turning)

    def bias(self, at: Accelerations) -> sp.Expr:
        """Eq. 5.30."""
        outwards, turning = self._moving(at)
        outwards_more, turning_more = self._bending(at)
        _, out, weight, (far, slope, curve, _) = self._seen(at)
        first, second = self._weight_rates(at)
        lever = second * (out - far) - 2 * first * slope - weight * curve
        total = weight * outwards_more + 2 * first * outwards * turning + lever * turning**2
        return total + self._lever(at) * turning_more

    def slip(self, at: Velocities) -> sp.Expr:
        """Of the material points that touch, eq. 5.31."""
        outwards, turning = self._moving(at)
        _, out, weight, _ = self._seen(at)
        rolling = self.radius * (at.rate(self.disc.link) - at.rate(self.cam.link))
        return rolling - weight * (out * turning + self._steep(at) * outwards)

    def slip_bias(self, at: Accelerations) -> sp.Expr:
        """Eq. 5.32."""
        outwards, turning = self._moving(at)
        outwards_more, turning_more = self._bending(at)
        _, out, weight, _ = self._seen(at)
        steep, steeper, (first, _) = self._steep(at), self._steeper(at), self._weight_rates(at)
        inner = outwards * turning + out * turning_more + steeper * turning * outwards + steep * outwards_more
        return -(first * turning * (out * turning + steep * outwards) + weight * inner)

    def push(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        """Through the place where they touch, where they do."""
        direction, out, weight, _ = self._seen(at)
        lever = self._lever(at)
        normal = at.let_vector(
            f"normal_{self.label}", add(scale(weight, direction), scale(lever / out, perp(direction)))
        )
        return self._opposite(at, scale(impulse, normal), sp.S.Zero, -lever * impulse)

    def drag(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        direction, out, weight, _ = self._seen(at)
        tangent = scale(-weight, add(perp(direction), scale(self._steep(at), direction)))
        tangent = at.let_vector(f"tangent_{self.label}", tangent)
        turned = (weight * out - self.radius) * impulse
        return self._opposite(at, scale(impulse, tangent), self.radius * impulse, turned)

    def _opposite(self, at: Accelerations, impulse: Vector, moment: sp.Expr, turned: sp.Expr) -> dict[int, Wrench]:
        """An impulse on the disc's centre and its opposite on the cam's, with a moment on each."""
        return opposite(at, (self.disc, self.cam), impulse, moment, turned)

    # -- geometry --------------------------------------------------------------------------------------------------

    def _seen(self, at: Positions) -> tuple[Vector, sp.Expr, sp.Expr, tuple[sp.Expr, ...]]:
        """The direction from the cam's centre to the disc's, their distance ϱ, w, and p with its derivatives."""
        reach = at.let_vector(f"reach_{self.label}", at.distance(self.cam, self.disc))
        out = at.let(f"out_{self.label}", sp.sqrt(dot(reach, reach)))
        direction = at.let_vector(f"towards_{self.label}", scale(1 / out, reach))
        far = self.profile.distance(at, self.cam.link, direction)
        weight = at.let(f"weight_{self.label}", far[0] / sp.sqrt(far[0] ** 2 + far[1] ** 2))
        return direction, out, weight, far

    def _steep(self, at: Positions) -> sp.Expr:
        """k = p'/p, the tangent of the pressure angle of a follower that moves straight from the centre."""
        far, slope, _, _ = self._seen(at)[3]
        return at.let(f"steep_{self.label}", slope / far)

    def _steeper(self, at: Positions) -> sp.Expr:
        """k'."""
        far, _, curve, _ = self._seen(at)[3]
        return at.let(f"steeper_{self.label}", curve / far - self._steep(at) ** 2)

    def _weight_rates(self, at: Positions) -> tuple[sp.Expr, sp.Expr]:
        """w' and w''."""
        weight, (far, _, curve, third) = self._seen(at)[2:]
        steep, steeper = self._steep(at), self._steeper(at)
        most = third / far - steep * curve / far - 2 * steep * steeper
        first = at.let(f"weight_rate_{self.label}", -steep * steeper * weight**3)
        second = -(steeper**2 + steep * most) * weight**3 - 3 * steep * steeper * weight**2 * first
        return first, at.let(f"weight_bias_{self.label}", second)

    def _lever(self, at: Positions) -> sp.Expr:
        """∂δ/∂φ = w' (ϱ − p) − w p' (m)."""
        _, out, weight, (far, slope, _, _) = self._seen(at)
        return at.let(f"lever_{self.label}", self._weight_rates(at)[0] * (out - far) - weight * slope)

    def _moving(self, at: Velocities) -> tuple[sp.Expr, sp.Expr]:
        """ϱ̇ and φ̇: how fast the distance grows (m/s), and how fast its direction turns on the cam (rad/s)."""
        direction, out, _, _ = self._seen(at)
        drift = at.let_vector(f"drift_{self.label}", at.approach(self.cam, self.disc))
        outwards = at.let(f"outwards_{self.label}", dot(direction, drift))
        swing = at.let(f"swing_{self.label}", dot(perp(direction), drift) / out)
        return outwards, at.let(f"turning_{self.label}", swing - at.rate(self.cam.link))

    def _bending(self, at: Accelerations) -> tuple[sp.Expr, sp.Expr]:
        """ϱ̈ and φ̈ with u̇ = 0."""
        direction, out, _, _ = self._seen(at)
        outwards, turning = self._moving(at)
        swing = turning + at.rate(self.cam.link)
        bend = at.let_vector(f"bend_{self.label}", at.bend(self.cam, self.disc))
        return (
            at.let(f"outwards_bias_{self.label}", dot(direction, bend) + out * swing**2),
            at.let(f"turning_bias_{self.label}", (dot(perp(direction), bend) - 2 * outwards * swing) / out),
        )


@dataclass(frozen=True, kw_only=True)
class FaceGap:
    """A straight face through the points ``start`` and ``end`` of a link, ``length`` (m) apart, before a cam about
    ``cam``: δ = D − h, where D is the distance of the face from the cam's centre and h the support function.

    Both sides of the face are solid, and the cam is on the side on which its centre is.
    """

    name: str
    ground: str
    label: str
    cam: PointRef
    start: PointRef
    end: PointRef
    length: sp.Expr
    profile: Profile
    restitution: sp.Expr
    friction: sp.Expr = sp.S.Zero
    angular = False
    slides = False

    def points(self) -> tuple[PointRef, ...]:
        return (self.cam, self.start, self.end)

    def value(self, at: Positions) -> sp.Expr:
        """Eq. 5.33."""
        _, out, (far, *_) = self._seen(at)
        return out - far

    def closing(self, at: Velocities) -> sp.Expr:
        """Eq. 5.34."""
        normal, _, (_, slope, *_) = self._seen(at)
        drift, turning = self._moving(at)
        swung = at.rate(self.start.link) * self._aside(at)
        return at.let(f"closing_{self.label}", dot(normal, drift) + swung - slope * turning)

    def bias(self, at: Accelerations) -> sp.Expr:
        """Eq. 5.34."""
        normal, out, (_, _, curve, _) = self._seen(at)
        drift, turning = self._moving(at)
        rate, bend = at.rate(self.start.link), self._bend(at)
        return dot(normal, bend) + 2 * rate * dot(perp(normal), drift) - rate**2 * out - curve * turning**2

    def slip(self, at: Velocities) -> sp.Expr:
        """Of the material points that touch, eq. 5.35."""
        normal, _, (far, *_) = self._seen(at)
        drift, _ = self._moving(at)
        return at.rate(self.cam.link) * far - dot(perp(normal), drift)

    def slip_bias(self, at: Accelerations) -> sp.Expr:
        """Eq. 5.35."""
        normal, _, (_, slope, *_) = self._seen(at)
        drift, turning = self._moving(at)
        turned = at.rate(self.start.link) * dot(normal, drift) - dot(perp(normal), self._bend(at))
        return turned + at.rate(self.cam.link) * slope * turning

    def push(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        """Through the place where they touch, off the foot of the cam's centre by h'."""
        normal, _, (_, slope, *_) = self._seen(at)
        turned = (self._aside(at) - slope) * impulse
        return opposite(at, (self.start, self.cam), scale(impulse, normal), turned, slope * impulse)

    def drag(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        normal, _, (far, *_) = self._seen(at)
        tangent = scale(sp.S.NegativeOne, perp(normal))
        return opposite(at, (self.start, self.cam), scale(impulse, tangent), sp.S.Zero, far * impulse)

    # -- geometry --------------------------------------------------------------------------------------------------

    def _seen(self, at: Positions) -> tuple[Vector, sp.Expr, tuple[sp.Expr, ...]]:
        """The face's normal, away from the cam, its distance D, and h with its derivatives."""
        reach = at.let_vector(f"reach_{self.label}", at.distance(self.cam, self.start))
        face = at.let_vector(f"face_{self.label}", scale(1 / self.length, at.distance(self.start, self.end)))
        height = at.let(f"height_{self.label}", dot(perp(face), reach))
        side = at.let(f"beside_{self.label}", 2 * step(height) - 1)
        normal = at.let_vector(f"normal_{self.label}", scale(side, perp(face)))
        out = at.let(f"out_{self.label}", side * height)
        return normal, out, self.profile.distance(at, self.cam.link, normal)

    def _aside(self, at: Positions) -> sp.Expr:
        """n⊥·(x_A − x_C): how far the face's first point is beside the foot of the cam's centre (m)."""
        normal, *_ = self._seen(at)
        reach = at.let_vector(f"reach_{self.label}", at.distance(self.cam, self.start))
        return at.let(f"aside_{self.label}", dot(perp(normal), reach))

    def _moving(self, at: Velocities) -> tuple[Vector, sp.Expr]:
        """Velocity of the face's first point against the cam's centre, and how fast the normal turns on the cam."""
        drift = at.let_vector(f"drift_{self.label}", at.approach(self.cam, self.start))
        return drift, at.let(f"turning_{self.label}", at.rate(self.start.link) - at.rate(self.cam.link))

    def _bend(self, at: Accelerations) -> Vector:
        return at.let_vector(f"bend_{self.label}", at.bend(self.cam, self.start))


def opposite(
    at: Accelerations, points: tuple[PointRef, PointRef], impulse: Vector, moment: sp.Expr, turned: sp.Expr
) -> dict[int, Wrench]:
    """An impulse on the first point and its opposite on the second, with a moment on each of their links."""
    first, second = points
    back = scale(sp.S.NegativeOne, impulse)
    return {
        first.link: (impulse, dot(perp(at.arm(first)), impulse) + moment),
        second.link: (back, dot(perp(at.arm(second)), back) + turned),
    }
