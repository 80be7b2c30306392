"""The largest value of a function that is known at samples, refined between them."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ..arrays import FloatArray

GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
NARROW = 1e-8
"""Of the bracket that is left, in parts of the first and of where it lies: near a largest value of a smooth function
the values differ by the square of that, which is rounding."""
LEVEL = 1e-12
"""Samples that differ by less than this part of the largest differ by rounding."""


def largest(value: Callable[[float], float], places: FloatArray, samples: FloatArray) -> tuple[float, float]:
    """The largest value of ``value`` and where it is, ``samples`` (n,) being its values at the rising ``places`` (n,).

    Each sample that is not below its neighbours has a largest value between these; that is looked for by golden section
    (Kiefer, 1953), which needs no derivatives and so finds corners too, where it may be the largest of all. Peaks that
    lie between two samples altogether are not seen.
    """
    best = int(np.argmax(samples))
    rounding = LEVEL * float(np.max(np.abs(samples)))
    if np.ptp(samples) <= rounding:
        return float(samples[0]), float(places[0])
    found = float(samples[best]), float(places[best])
    for k in range(len(samples)):
        low, high = max(k - 1, 0), min(k + 1, len(samples) - 1)
        sides = float(samples[low]), float(samples[high])
        top = float(samples[k])
        if top < max(sides) or top + max(top - side for side in sides) < samples[best]:
            continue  # no crest, or one of which a parabola says that it stays below: it rises by an eighth of that
        crest = _crest(value, float(places[low]), float(places[high]))
        if crest[0] > found[0] + (rounding if found[1] == places[best] else 0.0):
            found = crest
    return found


def _crest(value: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """The largest value between two places, with one crest between them, and where it is."""
    narrow = NARROW * (high - low + abs(low) + abs(high))
    one, other = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_one, at_other = value(one), value(other)
    while high - low > narrow:
        if at_one >= at_other:
            high, other, at_other = other, one, at_one
            one = high - GOLDEN * (high - low)
            at_one = value(one)
        else:
            low, one, at_one = one, other, at_other
            other = low + GOLDEN * (high - low)
            at_other = value(other)
    return max((at_one, one), (at_other, other))
