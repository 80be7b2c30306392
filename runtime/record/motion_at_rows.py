"""Accelerations and forces at the rows of a run."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from ..model.forces import Motion
from .record import Record


def motion_at_rows(run: Record) -> Motion:
    """Those at all rows: at the first of two of the same time, before an impact, with what was held until then; not
    numbers at the last one of a run that stopped early, where there may be none.

    Raises ``ValueError`` for a run that ``simulate`` has not made.
    """
    if run.motion is None:
        raise ValueError("this run knows no accelerations: it was not made by simulate")
    times, count = run.t.copy(), len(run.t) if run.success else len(run.t) - 1
    before = np.flatnonzero(run.t[:-1] == run.t[1:])
    times[before] = np.nextafter(times[before], -np.inf, dtype=times.dtype)
    if count == len(run.t):
        return run.motion(times, run.q, run.u)
    known = run.motion(times[:count], run.q[:count], run.u[:count])
    parts = (getattr(known, field.name) for field in fields(Motion))
    return Motion(*(np.concatenate([part, np.full_like(run.t, np.nan, shape=(1, *part.shape[1:]))]) for part in parts))
