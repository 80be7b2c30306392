"""Times at which what effects do has kinks: steps end there, so that methods keep their order."""

from __future__ import annotations

import math

from .geometry import Geometry

MOST = 1e6
"""Times that periodic rows may begin anew: steps end there, and runs have ten million of them at most."""


def kinks_until(model: Geometry, until: float) -> list[float]:
    """The times (s) of a model's own kinks, of those that come again and again as many as lie up to ``until``.

    Raises ``ValueError`` where these are more than a run can have steps."""
    found = [model.parameters[path] for path in model.data["instants"]]
    for first, period in model.data.get("kinks", []):
        if period and until / period > MOST:
            raise ValueError(
                f"{model.name}: found rows that begin anew every {period:g} s, {until / period:.3g} times up to "
                f"{until:g} s, expected at most {MOST:g} times; end the run earlier, or write another period"
            )
        again = range(math.ceil(-first / period), math.floor((until - first) / period) + 1) if period else (0,)
        found += [first + number * period for number in again]
    return found
