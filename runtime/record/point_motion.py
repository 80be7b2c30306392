"""How a point of the mechanism moves along a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from .frozen import freeze, restore
from .record import Record


@dataclass(frozen=True, eq=False)
class PointMotion:
    """At times t (n,) the `position` (m), `velocity` (m/s) and `acceleration` (m/s²) of the point `name`, (n, 2) each.

    Of one time t () and (2,). Accelerations are not numbers where the run knows none.
    """

    name: str
    t: FloatArray
    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray

    def __post_init__(self) -> None:
        freeze(self, "t", "position", "velocity")
        self.acceleration.flags.writeable = False

    def __setstate__(self, state: dict[str, object]) -> None:
        restore(self, state)


def point_motion(run: Record, name: str, t: ArrayLike | None) -> PointMotion:
    """That of the point at the times t, or at all rows of the run, those before impacts as before them."""
    if t is None:
        times, (q, u) = run.t, (run.q, run.u)
        u_dot = _at_rows(run)
    else:
        q, u = run.at(t)
        times = np.array(t, dtype=run.t.dtype)
        u_dot = run.accelerations(t)
    model = run.model
    acceleration = np.full((*np.shape(u_dot)[:-1], 2), np.nan, dtype=run.t.dtype)
    known = np.isfinite(u_dot).all(axis=-1)
    if np.any(known):
        acceleration[known] = model.point_acceleration(name, q[known], u[known], u_dot=u_dot[known])
    return PointMotion(name, times, model.point(name, q), model.point_velocity(name, q, u), acceleration)


def _at_rows(run: Record) -> FloatArray:
    """Accelerations (nt, nu) at the rows: at the first of two of the same time, before an impact, with what was held
    until then; not numbers at the last one of a run that stopped early, where there may be none."""
    if run.motion is None:
        raise ValueError("this run knows no accelerations: it was not made by simulate")
    times, count = run.t.copy(), len(run.t) if run.success else len(run.t) - 1
    before = np.flatnonzero(run.t[:-1] == run.t[1:])
    times[before] = np.nextafter(times[before], -np.inf, dtype=times.dtype)
    found = np.full_like(run.u, np.nan)
    if count:
        found[:count] = run.motion(times[:count], run.q[:count], run.u[:count]).u_dot
    return found
