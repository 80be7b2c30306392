"""What follows from a state: accelerations and forces, and the velocities after an impact."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..faults import Faults
from ..precision import finite
from .compiled import Compiled
from .failed_impact import failed_impact
from .forces import Contacts, flight_of, in_flight, motion_of, near_limits
from .inputs import Values, read_values
from .numbers import read_numbers

KNOWN = 1e-9
"""Accelerations and jumps that are known less well than this, relative to the largest, come with a warning."""

CALLER = 4
"""Levels from a warning here up to the line that calls a method of the model."""


def at_states(
    model: Compiled, q: ArrayLike, u: ArrayLike, t: ArrayLike, inputs: Values | None, contacts: Contacts, what: str
) -> FloatArray:
    """One field of ``Motion``, of one state or a batch, under ``inputs`` and with what ``contacts`` push."""
    try:
        states, single = model._state(q, u)
        times = read_times(t, len(states[0]))
        under = model.given(inputs)
    except ValueError:
        _refuse_all(model, q, u, t, inputs)
        raise
    with under:
        if in_flight(model, states[0], contacts) and not near_limits(model, states[0]).any():
            found, inexact = flight_of(model, *states, times, what), model.kernels.inexact
        else:
            motion, inexact = motion_of(model, *states, times, contacts, reactions=what == "reactions")
            found = getattr(motion, what)
    _warn_inexact(model, "accelerations", inexact)
    return found[0] if single else found


def impact(
    model: Compiled,
    q: ArrayLike,
    u: ArrayLike,
    contacts: Sequence[tuple[str, str]],
    restitution: ArrayLike | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Velocities u⁺ (nu,) and normal impulses (k,) when ``contacts`` strike together, of one state or a batch.

    Raises ``ValueError`` for unknown or repeated contacts, and where the model's law has no impulses for them, would
    add energy, or masses differ so much that rounding hides what contacts can do.
    """
    chosen = model._contacts(contacts)
    if len(set(chosen)) != len(chosen) or not chosen:
        raise ValueError(f"found contacts {list(contacts)}, expected at least one and each once")
    own = [model.parameters[f"{model.contacts[c][1].partition('.')[0]}.restitution"] for c in chosen]
    e = read_numbers(own if restitution is None else restitution, "restitution", model.core.REAL)
    if e.shape not in ((), (len(chosen),)) or not np.all((e >= 0.0) & (e <= 1.0)):
        raise ValueError(f"found restitution {e}, expected a number from 0 to 1, or {len(chosen)} of them")
    e = np.ascontiguousarray(np.broadcast_to(e, (len(chosen),)))
    (q2, u2), single = model._state(q, u)
    results = []
    for one_q, one_u in zip(q2, u2, strict=True):
        u_plus, impulses, outcome = model.kernels.impact(one_q, one_u, np.array(chosen, dtype=np.int32), e)
        if outcome != "done":
            struck = " and ".join("{} on {}".format(*contact) for contact in contacts)
            reason = failed_impact(outcome, struck, model.data["law"])
            raise ValueError(f"{model.name}: no impact can be computed here ({outcome.replace('_', ' ')}): {reason}")
        _warn_inexact(model, "jumps", model.kernels.inexact)
        results.append((u_plus, impulses[: len(chosen)]))
    if single:
        return results[0]
    return np.array([r[0] for r in results]), np.array([r[1] for r in results])


def _refuse_all(model: Compiled, q: ArrayLike, u: ArrayLike, t: ArrayLike, inputs: Values | None) -> None:
    """Raise with all that is wrong with these, one of which is."""
    faults, count = Faults(), 0
    with faults.collecting():
        count = len(model._state(q, u)[0][0])
    with faults.collecting():
        read_times(t, count or read_numbers(t, "t").size)
    with faults.collecting():
        read_values(model.inputs, inputs)
    faults.stop_if_any()


def read_times(t: ArrayLike, count: int) -> float | FloatArray:
    """One time for all ``count`` states, or each one's own."""
    times = read_numbers(t, "t")
    if times.shape not in ((), (count,)) or not finite(times):
        raise ValueError(f"t: found {t!r}, expected a finite number, or one for each of {count} states")
    return times if times.ndim else float(times)


def _warn_inexact(model: Compiled, what: str, inexact: float) -> None:
    if inexact > KNOWN:
        warnings.warn(
            f"{model.name}: masses differ so much that {what} are known to {inexact:.0e} of the "
            "largest only; make light links that carry heavy ones heavier, or leave them out",
            stacklevel=CALLER,
        )
