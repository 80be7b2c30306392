"""By how much a periodic motion may miss itself."""

from __future__ import annotations

from .section import Map

LESS = 4.0
"""Newton's method squares what is missed; where that becomes less by no more than this factor it is rounding."""

CLOSED = 1e4
"""A motion comes back where it misses by less than this many tolerances of the run: it is known to a hundred of them,
which a period of an unstable orbit may make a hundred times as many."""

KNOWN = 1e-3
"""The part of that to which points of a branch come back: Newton's method squares it in one step more."""


def tolerance_of(a_map: Map) -> float:
    """By how much a periodic motion may miss itself, in units of the mechanism."""
    rtol = a_map.options["rtol"]
    return CLOSED * float(a_map.model.data["run"]["rtol"] if rtol is None else rtol)
