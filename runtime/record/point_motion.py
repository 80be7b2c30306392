"""How a point of the mechanism moves along a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from .frozen import freeze, restore
from .motion_at_rows import motion_at_rows
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
        u_dot = motion_at_rows(run).u_dot
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
