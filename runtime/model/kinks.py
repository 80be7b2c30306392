"""Times at which what effects do has kinks: steps end there, so that methods keep their order."""

from __future__ import annotations

import math

from .geometry import Geometry


def kinks_until(model: Geometry, until: float) -> list[float]:
    """The times (s) of a model's own kinks, of those that come again and again as many as lie up to ``until``."""
    found = [model.parameters[path] for path in model.data["instants"]]
    for first, period in model.data.get("kinks", []):
        again = range(math.ceil(-first / period), math.floor((until - first) / period) + 1) if period else (0,)
        found += [first + number * period for number in again]
    return found
