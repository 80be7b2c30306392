"""Where a branch of periodic motions grazes: approached from the side on which it is smooth, and extrapolated.

States and parameter are smooth functions of the least gap on one side of grazing, and of the closing speed on the
other, though the map there has a root in it (A. B. Nordmark, Journal of Sound and Vibration 145, 1991).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from .corrector import Corrector, Missed, Point
from .grazing import Nearness

NEARER = 0.35
"""The next point is so much nearer to grazing."""

SOON = 3.0
"""Grazing is a reason for a failed step where it is expected within so many of it."""

NEAR, LEAST = 0.1, 1e-6
"""Extrapolated is from points nearer than this part of the first, at the most to where roundings of the closing speed
are felt."""

ORDER = 6
"""Points that are extrapolated from."""

SURE = 1e-5
"""Extrapolated values of two orders agree to this part of the range."""


class Grazing(NamedTuple):
    """Where a ``contact`` grazes, to about ``error``, and the ``points`` on the way there."""

    contact: tuple[str, str]
    value: float
    error: float
    points: list[Point]


def approach(corrector: Corrector, points: Sequence[Point], step: float) -> Grazing | None:
    """Grazing within about a ``step`` beyond the last of the points of a branch, if that is what ends it."""
    if len(points) < 2:
        return None
    which = _candidate(points[-2], points[-1], step)
    if which is None:
        return None
    found = list(points[-2:])
    while found[-1].near[which].size > LEAST:
        following = _nearer(corrector, found, which)
        if following is None:
            break
        found.append(following)
    sizes = np.array([point.near[which].size for point in found])
    if len(found) < 5 or sizes[-1] > NEAR * sizes[1]:
        return None
    count = min(ORDER, len(found))
    values = [_extrapolated(sizes[-k:], np.array([p.value for p in found[-k:]]), 0.0) for k in (count - 1, count)]
    error = abs(float(values[1] - values[0]))
    if error > SURE * corrector.unit:
        return None
    return Grazing(found[-1].near[which].contact, float(values[1]), error, found[2:])


def _candidate(before: Point, last: Point, step: float) -> int | None:
    """What comes to zero first, within some steps; places compare in the same segments alone."""
    ends, others = ([one.section for one in point.orbit.chain.maps] for point in (before, last))
    if ends != others:
        return None
    if [_name(one) for one in before.near] != [_name(one) for one in last.near]:
        return None
    apart = float(np.linalg.norm(last.place - before.place))
    ways = {}
    for k, (earlier, later) in enumerate(zip(before.near, last.near, strict=True)):
        if later.size < earlier.size:
            ways[k] = later.size * apart / (earlier.size - later.size)
    first = min(ways, key=lambda k: ways[k], default=None)
    return first if first is not None and ways[first] <= SOON * step else None


def _name(one: Nearness) -> tuple[object, ...]:
    return one.contact, one.strikes


def _nearer(corrector: Corrector, found: Sequence[Point], which: int) -> Point | None:
    """The next point, nearer to grazing."""
    last, some = found[-1], found[-3:]
    sizes = np.array([point.near[which].size for point in some])
    for part in (NEARER, 0.6, 0.8):
        guess = _extrapolated(sizes, np.array([point.place for point in some]), part * sizes[-1])
        try:
            point = corrector.point(guess, last.tangent, last, exactly=True)
        except Missed:
            continue
        same = point.pattern == last.pattern and [*map(_name, point.near)] == [*map(_name, last.near)]
        if same and point.near[which].size < 0.95 * sizes[-1]:
            return point
    return None


def _extrapolated(sizes: FloatArray, values: FloatArray, size: float) -> FloatArray:
    """The polynomial through values (k, ...) at ``sizes`` (k,), there, by E. H. Neville's scheme."""
    table = [np.asarray(value, dtype=float) for value in values]
    for order in range(1, len(table)):
        table = [
            ((size - sizes[k]) * table[k + 1] - (size - sizes[k + order]) * table[k]) / (sizes[k + order] - sizes[k])
            for k in range(len(table) - 1)
        ]
    return table[0]
