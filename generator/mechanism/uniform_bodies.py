"""Mass, mass centre and inertia of uniform bodies: rods, polygons, discs, points, and several of them together.

Sums over coordinates are exact, of numbers as they are written (0.2 is a fifth), and rounded once at their end: what is
symmetric has its mass centre on the axis, to the last digit, and results do not depend on the machine.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from .totals import total


@dataclass(frozen=True)
class Mass:
    """What a body weighs: mass (kg), mass centre (m, complex), inertia about the mass centre (kg m²)."""

    mass: float
    com: complex
    inertia: float


def together(parts: Sequence[Mass]) -> Mass:
    """Several bodies as one, by the parallel axis theorem (Steiner). Without any mass, the first one's centre."""
    if len(parts) == 1:
        return parts[0]
    mass = total(part.mass for part in parts)
    com = total(part.mass * part.com for part in parts) / mass if mass else parts[0].com
    inertia = total(part.inertia + part.mass * abs(part.com - com) ** 2 for part in parts)
    return Mass(mass, complex(com), inertia)


def rod(mass: float, start: complex, end: complex, width: float = 0.0) -> Mass:
    """A uniform rod between two places (m), or a bar that is ``width`` (m) wide and ends there: m (l² + w²)/12."""
    (x, y), (x2, y2) = _exact([start, end])
    square = (x2 - x) ** 2 + (y2 - y) ** 2 + _as_written(width) ** 2
    centre = complex(float((x + x2) / 2), float((y + y2) / 2))
    return Mass(mass, centre, float(_as_written(mass) * square / 12))


def disc(mass: float, centre: complex, radius: float, inner_radius: float = 0.0) -> Mass:
    """A uniform disc, or a ring, about ``centre``, radii in m: m (R² + r²)/2."""
    square = _as_written(radius) ** 2 + _as_written(inner_radius) ** 2
    return Mass(mass, centre, float(_as_written(mass) * square / 2))


def point(mass: float, place: complex) -> Mass:
    """A mass in one place (m): it has no inertia of its own."""
    return Mass(mass, place, 0.0)


def polygon_area(corners: Sequence[complex]) -> float:
    """The area (m²) inside a polygon that does not cross itself, its corners in order round it, either way."""
    try:
        return float(abs(sum(_crosses(_exact(corners)), Fraction(0))) / 2)
    except OverflowError:
        return math.inf


def polygon(mass: float, corners: Sequence[complex]) -> Mass:
    """A uniform plate with these corners (m), in order round it, either way.

    With c_i = x_i y_{i+1} − x_{i+1} y_i the area is A = Σ c_i / 2, its centre Σ c_i (p_i + p_{i+1}) / (6 A), and its
    moment about the origin Σ c_i (p_i·p_i + p_i·p_{i+1} + p_{i+1}·p_{i+1}) / 12: C. Steger, On the calculation of
    arbitrary moments of polygons, TU München, FGBV-96-05, 1996. The corners must have an area, and edges may not cross.
    """
    points = _exact(corners)
    crosses = _crosses(points)
    twice = sum(crosses, Fraction(0))
    pairs = [*pairwise([*points, points[0]])]
    x, y = (
        sum(c * (a[axis] + b[axis]) for c, (a, b) in zip(crosses, pairs, strict=True)) / (3 * twice) for axis in (0, 1)
    )
    second = sum(
        c * sum(a[axis] * a[axis] + a[axis] * b[axis] + b[axis] * b[axis] for axis in (0, 1))
        for c, (a, b) in zip(crosses, pairs, strict=True)
    )
    per_mass = second / (6 * twice) - x * x - y * y
    return Mass(mass, complex(float(x), float(y)), float(_as_written(mass) * per_mass))


def crossing_edges(corners: Sequence[complex], closed: bool = True) -> tuple[int, int] | None:
    """The first two edges of a polygon, or of an open line, that cross, touch or overlap, by the numbers of the corners
    at which they begin; twice the same edge where that has no length; ``None`` where none do. Decided exactly."""
    exact = _exact(corners)
    scale = math.lcm(*(part.denominator for point in exact for part in point))
    points = [(int(x * scale), int(y * scale)) for x, y in exact]
    count = len(points)
    edges = [*pairwise([*points, points[0]] if closed else points)]
    boxes = [tuple(sorted(pair) for pair in zip(*edge, strict=True)) for edge in edges]
    if point_edges := [i for i, (a, b) in enumerate(edges) if a == b]:
        return point_edges[0], point_edges[0]
    for i, (a, b) in enumerate(edges):
        for j in range(i + 1, len(edges)):
            if all(one[0] <= other[1] and other[0] <= one[1] for one, other in zip(boxes[i], boxes[j], strict=True)):
                c, d = edges[j]
                beside = j == i + 1 or (closed and i == 0 and j == count - 1)
                if _overlap(a, b, c, d) if beside else _meet(a, b, c, d):
                    return i, j
    return None


def in_line(corners: Sequence[complex]) -> bool:
    """Whether all corners lie on one line. Decided exactly."""
    (x, y), *others = _exact(corners)
    steps = [(one - x, other - y) for one, other in others]
    dx, dy = max(steps, key=lambda step: step[0] ** 2 + step[1] ** 2)
    return all(dx * one[1] == dy * one[0] for one in steps)


_Integers = tuple[int, int]


def _overlap(a: _Integers, b: _Integers, c: _Integers, d: _Integers) -> bool:
    """Whether edges with a common corner go back along each other."""
    if b == d or a == c:  # a triangle's edges, or a corner that three edges share
        a, b, c, d = (a, b, d, c) if b == d else (b, a, c, d)
    corner, one, other = (b, a, d) if b == c else (a, b, c)
    return _side(corner, one, other) == 0 and _inner(corner, one, other) > 0


def _meet(a: _Integers, b: _Integers, c: _Integers, d: _Integers) -> bool:
    """Whether two edges have a point in common."""
    sides = [_sign(_side(*three)) for three in ((a, b, c), (a, b, d), (c, d, a), (c, d, b))]
    if sides[0] * sides[1] < 0 and sides[2] * sides[3] < 0:
        return True
    ends = ((a, b, c), (a, b, d), (c, d, a), (c, d, b))
    return any(side == 0 and _inner(on, p, q) <= 0 for side, (p, q, on) in zip(sides, ends, strict=True))


def _side(a: _Integers, b: _Integers, c: _Integers) -> int:
    """Twice the area of a triangle, positive where its corners go round counter-clockwise."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _inner(corner: _Integers, one: _Integers, other: _Integers) -> int:
    return (one[0] - corner[0]) * (other[0] - corner[0]) + (one[1] - corner[1]) * (other[1] - corner[1])


def _sign(value: int) -> int:
    return (value > 0) - (value < 0)


def _exact(corners: Sequence[complex]) -> list[tuple[Fraction, Fraction]]:
    return [(_as_written(corner.real), _as_written(corner.imag)) for corner in corners]


def _as_written(number: float) -> Fraction:
    """The shortest decimal fraction that is read as this number."""
    return Fraction(repr(float(number)))


def _crosses(points: Sequence[tuple[Fraction, Fraction]]) -> list[Fraction]:
    return [a[0] * b[1] - b[0] * a[1] for a, b in pairwise([*points, points[0]])]
