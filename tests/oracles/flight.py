"""Free motion of a system by SciPy's DOP853 on the dense maximal-coordinate accelerations, without any projection."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.integrate import solve_ivp

from .maximal import Array, System, accelerate


def fly(system: System, poses: Array, velocities: Array, times: Array, rtol: float = 1e-13) -> tuple[Array, Array]:
    """Frame poses and velocities, (times, links, 3) each, from the first of ``times`` on."""
    double = replace(system, dtype=np.float64)
    shape = poses.shape

    def slope(_: float, y: Array) -> Array:
        pose, velocity = y.reshape(2, *shape)
        return np.concatenate([velocity.ravel(), accelerate(double, pose, velocity).frames.ravel()])

    start = np.concatenate([poses.ravel(), velocities.ravel()]).astype(float)
    span = (float(times[0]), float(times[-1]))
    found = solve_ivp(slope, span, start, method="DOP853", rtol=rtol, atol=rtol, t_eval=times)
    states = found.y.T.reshape(len(times), 2, *shape)
    return states[:, 0], states[:, 1]
