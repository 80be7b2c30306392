"""Whether what comes back goes on as it did: forces that change with time, and coordinates that need not come back.

A state that comes back is that of a periodic motion only where the forces on it are what they were. Newton's method
compares states alone.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from .orbit import Orbit
from .section import SOMETIMES, Map, accelerations_at, acting_by_time, depends_on_time, looked_at
from .tolerance import tolerance_of

FORCES = 1e-9
"""Forces agree where they differ by less than this part of what they change by, however small the tolerance is."""

ROUNDED = 1e-10
"""And by less than this part of what they are."""

GROWN = 1e-14
"""Rounding of a state, in units of the mechanism, which two periods of an unstable orbit let grow."""


def check_time(a_map: Map) -> None:
    """Raise ``ValueError`` where a time as section is no period of what drives the model: with a state that is
    relabelled, one after which forces are those of the relabelled state."""
    model, time = a_map.model, a_map.section
    if not isinstance(time, float):
        return
    _check_events(a_map, time)
    if not depends_on_time(model):
        return
    n, units = len(model.q_names), a_map.units[len(model.q_names) :]
    A, b = (np.eye(2 * n), np.zeros(2 * n)) if a_map.relabel is None else a_map.relabel
    instants = time * np.array([0.0, *SOMETIMES])
    apart, changes, size = 0.0, 0.0, 0.0
    for q, u in looked_at(model):
        other = A @ np.concatenate([q, u]) + b
        found = np.array([accelerations_at(model, q, u, t) for t in instants])
        wanted = np.hstack([np.tile(u, (len(found), 1)), found]) @ A[n:].T
        later = np.array([accelerations_at(model, other[:n], other[n:], t + time) for t in instants])
        apart = max(apart, float(np.max(np.abs(later - wanted) / units)))
        changes = max(changes, float(np.max(np.ptp(found, axis=0) / units)))
        size = max(size, float(np.max(np.abs(found) / units)))
    allowed = max(tolerance_of(a_map), FORCES)
    if apart > allowed * changes + ROUNDED * size:
        behind = "" if a_map.relabel is None else ", relabelled as the state"
        raise ValueError(
            f"section: found {time:.15g} s, after which forces are not what they were{behind}: they differ by "
            f"{apart / (changes or size):.2g} of what they change by; expected a period of what drives the model, to "
            "all its digits"
        )


def _check_events(a_map: Map, time: float) -> None:
    """Raise ``ValueError`` where events that do something by the time would come at another phase a ``time`` (s)
    later."""
    model = a_map.model
    names = [one["name"] for one in acting_by_time(model)]
    numbers = [number for number, one in enumerate(model.data.get("events", ())) if one["name"] in names]
    instants = time * np.array([0.0, *SOMETIMES])
    for q, u in looked_at(model) if names else ():
        states = np.tile(q, (len(instants), 1)), np.tile(u, (len(instants), 1))
        now, later = (model.kernels.indicators(t, *states) for t in (instants, instants + time))
        apart = (np.max(np.abs(later[0] - now[0]), axis=0) - FORCES * np.max(now[2], axis=0))[numbers]
        if a_map.relabel is not None or np.any(apart > 0.0):
            name = names[int(np.argmax(apart))]
            raise ValueError(
                f"section: found {time:.15g} s, after which {name}, an event that does something by the time, is not "
                "what it was, expected a period of it; without a state that is relabelled"
            )


def check_advance(orbit: Orbit) -> None:
    """Raise ``ValueError`` where a motion depends on coordinates that need not come back: from where they have got to
    it does not come back again."""
    a_map = orbit.return_map
    names = ", ".join(a_map.model.q_of[k] for k in a_map.free)
    grown = float(np.linalg.norm(orbit.matrix)) ** 2 * max(orbit.missed, GROWN)
    tolerance = tolerance_of(a_map)
    if not names or grown > tolerance:  # nothing can be told of what leaves so fast
        return
    try:
        missed = _missed_again(a_map, orbit.q, orbit.u, orbit.period)
        said = f"misses by {missed:.2g} of its size a period later"
    except ValueError as error:
        missed, said = np.inf, f"does not come back a period later: {error}"
    if missed > tolerance:
        raise ValueError(
            f"{a_map.model.name}: found a motion that comes back but for {names}, and {said}; expected coordinates "
            "that nothing depends on; let them come back too"
        )


def _missed_again(a_map: Map, q: FloatArray, u: FloatArray, period: float) -> float:
    """By how much the second of two periods misses what is compared, in units of the mechanism."""
    once = a_map.after(q, u, period)
    twice = a_map.doubled().after(q, u, 2.0 * period) if a_map.relabel is None else a_map.after(*once, period)
    apart = (np.concatenate(twice) - np.concatenate(once)) / a_map.units
    return float(np.max(np.abs(apart[a_map.compared]), initial=0.0))
