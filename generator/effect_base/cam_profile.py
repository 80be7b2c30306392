"""The lift of a cam's follower over a turn of the cam: pieces with the laws that designers use, or expressions.

What is wrong with a profile as a shape is found here: pieces that do not meet, a cam that its roller would cut under, a
hollow that a straight face cannot reach.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from ..mechanism.links import Parameter
from .expression_of_time import Expression
from .laws_of_rise import LAWS, TURN, LawOfRise, exact

if TYPE_CHECKING:
    from collections.abc import Callable

    from sympy import Expr

    from ..derive.following import LiftPiece

SAMPLES = 1440
"""Places round a turn at which a profile is looked at."""
MEETS, BENDS = 1e-9, 1e-6
"""How far lifts of two pieces may be apart where they meet, and their slopes, both by the base radius: rounding."""


@dataclass(frozen=True)
class Height:
    """A lift (m) between pieces: a parameter, or a number where an expression ends there."""

    value: float
    parameter: Parameter | None = None

    def symbol(self) -> Expr:
        from ..derive.vectors import symbol

        return symbol(self.parameter) if self.parameter else exact(self.value)


@dataclass(frozen=True)
class Piece:
    """The lift from the angle ``start`` to ``end`` (rad): an expression, or from height to height by the ``part`` of a
    law, ``None`` of a dwell."""

    start: float
    end: float
    law: LawOfRise | Expression | None
    before: Height
    after: Height
    part: int = 0

    def lift(self, angle: float, order: int) -> float:
        """The lift, or its derivative by the angle up to the second (m)."""
        if isinstance(self.law, Expression):
            return self._functions[order](angle)
        flat = 0.0 if order else self.before.value
        if self.law is None:
            return flat
        part = LAWS[self.law][self.part]
        length = (self.end - self.start) / (part.end - part.start)
        rise = self.after.value - self.before.value
        return flat + rise * part.at((angle - self.start) / length, order) / length**order

    @cached_property
    def _functions(self) -> list[Callable[[float], float]]:
        import sympy as sp

        from ..derive.following import ANGLE

        law = self.expression()
        return [_told(sp.lambdify(ANGLE, sp.diff(law, ANGLE, order), "math")) for order in range(3)]

    def expression(self) -> Expr:
        """The lift as an expression of the angle."""
        import sympy as sp

        from ..derive.following import ANGLE
        from ..derive.motion import TIME

        if isinstance(self.law, Expression):
            return self.law.plain().xreplace({TIME: ANGLE})
        before = self.before.symbol()
        if self.law is None:
            return before
        part = LAWS[self.law][self.part]
        share = (ANGLE - exact(self.start)) / sp.Float((self.end - self.start) / (part.end - part.start))
        return before + (self.after.symbol() - before) * part.of(share)


@dataclass(frozen=True)
class CamProfile:
    """How far a follower is from the cam's centre, ``base`` plus ``radius`` of a roller plus the lift (m).

    ``radius`` is ``None`` before a straight face, and zero of a point. ``mounted`` is where on the cam's link its angle
    is zero (rad), from which it is counted clockwise where ``clockwise`` is true.
    """

    base: Parameter
    radius: Parameter | float | None
    pieces: tuple[Piece, ...]
    mounted: Parameter | None
    clockwise: bool

    @property
    def sense(self) -> int:
        return -1 if self.clockwise else 1

    def parameters(self) -> tuple[Parameter, ...]:
        heights = [height.parameter for piece in self.pieces for height in (piece.before, piece.after)]
        own = (self.base, self.radius if isinstance(self.radius, Parameter) else None, *heights, self.mounted)
        return tuple(dict.fromkeys(parameter for parameter in own if parameter))

    @property
    def size(self) -> float:
        """The roller's radius (m), 0 of a point and of a face."""
        return self.radius.value if isinstance(self.radius, Parameter) else 0.0

    def far(self, angle: float, order: int = 0) -> float:
        """How far from the cam's centre the roller's centre, or the face, is at an angle of the cam (m)."""
        turned = angle % TURN
        piece = next((piece for piece in self.pieces if turned < piece.end), self.pieces[-1])
        return self._far(piece, turned, order)

    def _far(self, piece: Piece, angle: float, order: int) -> float:
        return piece.lift(angle, order) + (0.0 if order else self.base.value + self.size)

    def seen_at(self, direction: complex, turned: float) -> float:
        """The cam's angle in a direction when its link is turned by ``turned`` (rad)."""
        mounted = self.mounted.value if self.mounted else 0.0
        return self.sense * (math.atan2(direction.imag, direction.real) - turned) - mounted

    def surface(self, count: int) -> tuple[tuple[float, float], ...]:
        """The cam's surface as a closed polygon about its centre, in the axes of its link (m)."""
        mounted = self.mounted.value if self.mounted else 0.0
        found = []
        for k in range(count + 1):
            angle = TURN * k / count
            far, slope = self.far(angle), self.far(angle, 1)
            place = complex(far, slope)
            if self.radius is not None:
                place = far - self.size * complex(far, -slope) / math.hypot(far, slope)
            place *= complex(math.cos(angle + mounted), math.sin(angle + mounted))
            found.append((place.real, self.sense * place.imag))
        return tuple(found)

    def lifts(self) -> tuple[LiftPiece, ...]:
        """The pieces as the equations have them."""
        from ..derive.following import LiftPiece

        return tuple(LiftPiece(piece.start, piece.end, piece.expression()) for piece in self.pieces)

    # -- what is wrong with it ---------------------------------------------------------------------------------------

    def fault(self) -> str:
        """What is wrong with the shape, what is expected and what to do; nothing if all is well."""
        return self._apart() or self._without_distance() or (self._cut() if self.radius is not None else self._hollow())

    def _apart(self) -> str:
        """Pieces meet with the same lift and the same slope; a turn's end meets its beginning."""
        scale = self.base.value
        for one, other in zip(self.pieces, (*self.pieces[1:], self.pieces[0]), strict=True):
            for order, most, what, unit in ((0, MEETS, "the lift", "m"), (1, BENDS, "the slope of the lift", "m/rad")):
                before, after = one.lift(one.end, order), other.lift(other.start, order)
                if not abs(after - before) <= most * scale:
                    told = f"{what} is {before:.9g} {unit} before {_degrees(one.end)} and {after:.9g} {unit} after it"
                    return f"{told}, expected a smooth closed profile; change one of them"
        return ""

    def _without_distance(self) -> str:
        least, at = min((self._far(piece, angle, 0), angle) for piece, angle in self._places())
        if least > self.size:
            return ""
        more = f", more than the roller's radius, {self.size:.6g} m" if self.size else ""
        return (
            f"the follower comes as near as {least:.6g} m to the cam's centre at {_degrees(at)}, expected a positive "
            f"distance{more}; make the base larger, or the lift less deep"
        )

    def _cut(self) -> str:
        """A roller's centre goes round bends that are wider than the roller, or the cam is cut under."""
        sharpest, at = max((self._bend(piece, angle), angle) for piece, angle in self._places())
        if sharpest * self.size < 1.0:
            return ""
        return (
            f"the way of the roller's centre bends with a radius of {1.0 / sharpest:.6g} m at {_degrees(at)}, expected "
            f"more than the roller's radius, {self.size:.6g} m, or the cam is cut under; make the base larger, the "
            "roller smaller or the rise longer"
        )

    def _bend(self, piece: Piece, angle: float) -> float:
        """The curvature (1/m) of the way of the roller's centre, positive where the cam is convex."""
        far, slope, curve = (self._far(piece, angle, order) for order in range(3))
        return (far**2 + 2.0 * slope**2 - far * curve) / math.hypot(far, slope) ** 3

    def _hollow(self) -> str:
        """A straight face touches at one place at a time: the cam's radius of curvature h + h'' is positive."""
        least, at = min(
            (self._far(piece, angle, 0) + self._far(piece, angle, 2), angle) for piece, angle in self._places()
        )
        if least > 0.0:
            return ""
        return (
            f"the cam's radius of curvature is {least:.6g} m at {_degrees(at)}, expected a positive one all round, "
            "because a straight face touches at one place at a time; make the base larger or the rise longer"
        )

    def _places(self) -> Iterator[tuple[Piece, float]]:
        """Places all round, the ends of every piece among them from both sides."""
        for piece in self.pieces:
            count = max(2, math.ceil(SAMPLES * (piece.end - piece.start) / TURN))
            yield from ((piece, piece.start + (piece.end - piece.start) * k / count) for k in range(count + 1))


def _told(function: Callable[[float], Any]) -> Callable[[float], float]:
    """The function, with ``nan`` where it has no value."""

    def told(angle: float) -> float:
        try:
            return float(function(angle))
        except (ArithmeticError, ValueError, TypeError):
            return math.nan

    return told


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.6g} deg"
