"""Where a branch of periodic motions folds or changes its stability, and the functions that are zero there.

Test functions are those of Y. A. Kuznetsov, Elements of Applied Bifurcation Theory, 2004, section 10.2.3, with the
product over pairs of multipliers for the Neimark-Sacker bifurcation (docs/theory.md, eq. 12.3).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import combinations
from typing import Literal

import numpy as np

from ..arrays import ComplexArray
from .corrector import Corrector, Missed, Point
from .orbit import Orbit

Kind = Literal["fold", "flip", "Neimark-Sacker", "branch point", "grazing"]

FLAT = 1e-7
"""A test function below this on both sides of an interval does not change its sign there but stays zero to rounding, as
where energy is kept."""

ROUNDS = 40
"""Points that are looked at to find a zero; ten are enough."""

NARROW = 4e-15
"""An interval of this part of a step is as small as places are known."""


@dataclass(frozen=True, eq=False)
class Bifurcation:
    """What happens on a branch at a ``value`` of its parameter: there the branch folds, two branches of periodic
    motions meeting (multiplier 1); period doubling, a "flip" (multiplier -1); "Neimark-Sacker", where a pair of complex
    multipliers crosses the unit circle; a "branch point", where another branch of the same period crosses (multiplier 1
    too); or "grazing", where a ``contact`` closes with speed zero.

    ``orbit`` is the periodic motion there; of grazing the nearest one before it, the value being extrapolated, to about
    ``error``. ``place`` (points) is where it lies among the points of the branch.
    """

    kind: Kind
    parameter: str
    value: float
    orbit: Orbit = field(repr=False)
    place: float = field(repr=False)
    contact: tuple[str, str] | None = None
    error: float = field(default=0.0, repr=False)


def tests(point: Point) -> dict[Kind, float]:
    """Functions that are zero at each kind of point."""
    multipliers = point.orbit.multipliers
    return {
        "fold": float(point.tangent[-1]),
        "branch point": float(np.prod(multipliers - 1.0).real),
        "flip": float(np.prod(multipliers + 1.0).real),
        "Neimark-Sacker": float(np.prod([a * b - 1.0 for a, b in combinations(multipliers, 2)] or [1.0]).real),
    }


def passed(corrector: Corrector, one: Point, other: Point) -> list[tuple[Kind, Point, float]]:
    """What lies between two neighbouring points of a branch, with the part of the way there, in order."""
    found = list[tuple[Kind, Point, float]]()
    before, after = tests(one), tests(other)
    for kind, value in before.items():
        if value * after[kind] >= 0.0 or max(abs(value), abs(after[kind])) <= FLAT:
            continue
        if kind == "branch point" and any(known == "fold" for known, *_ in found):
            continue  # the multiplier 1 is that of the fold
        point, part = _zero(corrector, one, other, kind)
        if kind != "Neimark-Sacker" or _complex_pair(point.orbit.multipliers):
            found.append((kind, point, part))
    return sorted(found, key=lambda what: what[2])


def _complex_pair(multipliers: ComplexArray) -> bool:
    """Whether the two multipliers whose product is nearest to 1 are no real numbers."""
    pair = min(combinations(multipliers, 2), key=lambda two: abs(two[0] * two[1] - 1.0))
    return bool(all(abs(one.imag) > FLAT for one in pair))


def _zero(corrector: Corrector, one: Point, other: Point, kind: Kind) -> tuple[Point, float]:
    """Where a test function is zero between two points, by regula falsi with Illinois' halving along the chord."""
    chord = other.place - one.place
    low, high = (0.0, tests(one)[kind]), (1.0, tests(other)[kind])
    best, part, side = min(((one, 0.0), (other, 1.0)), key=lambda two: abs(tests(two[0])[kind])), 0.0, 0
    nearest = abs(tests(best[0])[kind])
    point, part = best
    for _ in range(ROUNDS):
        at = (low[0] * high[1] - high[0] * low[1]) / (high[1] - low[1])
        if not low[0] < at < high[0]:
            break
        try:
            found = corrector.point(one.place + at * chord, chord / np.linalg.norm(chord), one, exactly=True)
        except Missed:
            break
        value = tests(found)[kind]
        if abs(value) < nearest:
            nearest, point, part = abs(value), found, at
        if value == 0.0 or high[0] - low[0] <= NARROW:
            break
        if (value > 0.0) == (low[1] > 0.0):
            stays = abs(at - low[0]) <= NARROW
            low, high, side = (at, value), (high[0], high[1] / 2.0 if side < 0 else high[1]), -1
        else:
            stays = abs(at - high[0]) <= NARROW
            low, high, side = (low[0], low[1] / 2.0 if side > 0 else low[1]), (at, value), 1
        if stays:
            break
    return point, part
