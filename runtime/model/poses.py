"""States read off poses and velocities of the links."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from .geometry import Geometry
from .numbers import read_numbers
from .tolerances import joint_miss


def read_off(model: Geometry, poses: FloatArray) -> FloatArray:
    """Coordinates (nq,) of links at ``poses`` (links, 3)."""
    lines = model.lines
    found = [lines.coordinate(kind, of, poses) for kind, of in model.data["coordinates"]]
    return np.array(found, dtype=model.core.REAL)


def read_rates(model: Geometry, poses: FloatArray, velocities: FloatArray) -> FloatArray:
    """Quasi-velocities (nu,) of links at ``poses`` that move with ``velocities``, both (links, 3)."""
    lines = model.lines
    found = [lines.rate(kind, of, poses, velocities) for kind, of in model.data["coordinates"]]
    return np.array(found, dtype=model.core.REAL)


def read_states(model: Geometry, poses: ArrayLike, velocities: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """State (q, u) of links at ``poses`` that move with ``velocities``, both (links, 3), or of a batch of them.

    Nothing is projected.

    Raises ``ValueError`` when joints miss by more than 1e-6 of the mechanism's length, or their velocities by
    more than that per second.
    """
    if np.ndim(poses) == 3 and np.shape(poses) == np.shape(velocities):
        states = [_read_state(model, *one) for one in zip(np.asarray(poses), np.asarray(velocities), strict=True)]
        return np.array([q for q, _ in states]), np.array([u for _, u in states])
    return _read_state(model, poses, velocities)


def _read_state(model: Geometry, poses: ArrayLike, velocities: ArrayLike) -> tuple[FloatArray, FloatArray]:
    given = _rows(model, poses, "poses"), _rows(model, velocities, "velocities")
    q, u = read_off(model, given[0]), read_rates(model, *given)
    places, moving = model.poses(q) - given[0], model.velocities(q, u) - given[1]
    places[:, 2] = np.remainder(places[:, 2] + np.pi, 2.0 * np.pi) - np.pi
    opening = model.kernels.of_state("closure_rate", q[None], u[None])
    allowed = joint_miss(model.core.REAL, model.length)
    misses = (("poses", "m", places, model.closure(q)), ("velocities", "m/s", moving, opening))
    for what, unit, difference, closure in misses:
        parts = (difference[:, :2], difference[:, 2] * model.length, closure)
        miss = max(float(np.max(np.abs(part), initial=0.0)) for part in parts)
        if miss > allowed:
            raise ValueError(f"{what}: joints miss by {miss:.3g} {unit}, expected at most {allowed:g} {unit}")
    return q, u


def _rows(model: Geometry, rows: ArrayLike, what: str) -> FloatArray:
    found = np.array(read_numbers(rows, what, model.core.REAL))
    if found.shape != (len(model.links), 3) or not np.all(np.isfinite(found)):
        raise ValueError(f"{what}: found shape {found.shape}, expected finite numbers ({len(model.links)}, 3)")
    return found
