"""Directions as scenes write them, brought to length 1."""

from __future__ import annotations

import math
from collections.abc import Sequence


def unit(given: Sequence[float]) -> tuple[float, float] | None:
    """The direction [x, y] at length 1, however short or long it is written; ``None`` where both are zero.

    The larger entry is brought between 1/2 and 1 first, by a power of two, which costs no digits.
    """
    x, y = given
    largest = max(abs(x), abs(y))
    if not 0.0 < largest < math.inf:
        return None
    scale = -math.frexp(largest)[1]
    x, y = math.ldexp(x, scale), math.ldexp(y, scale)
    length = math.hypot(x, y)
    return x / length, y / length
