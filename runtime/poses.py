"""States read off poses and velocities of the links."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from .frames import FloatArray

if TYPE_CHECKING:
    from .model import Model

JOINT_MISS = 1e-6
"""Poses whose joints miss by more than this (m) are not a state of the mechanism."""


ANGLE_KNOWN = 1e-6
"""Angles are states if they are known to this (rad): points at the mechanism's length are then known to JOINT_MISS."""


@cache
def largest_angle(kind: np.dtype[Any]) -> float:
    """Size (rad) beyond which no digits are left of where links point, in numbers of that type.

    The last place is larger than 1e-6 rad beyond 4.5e9 rad (in floats, which carry 7 digits: than 1e-3, beyond 1e4).
    """
    last = float(np.finfo(kind).eps)
    return max(ANGLE_KNOWN, 1e4 * last) / last


def check_angles(model: Model, q: FloatArray) -> None:
    """Coordinates q (b, nq) have no larger angle than that, else ``ValueError``."""
    angles = np.abs(q[:, model.angular])
    largest = largest_angle(model.core.REAL)
    if angles.size and angles.max() > largest:
        row, column = np.unravel_index(int(np.argmax(angles)), angles.shape)
        name, found = model.q_names[model.angular[column]], float(q[row, model.angular[column]])
        raise ValueError(
            f"q: found {name} = {found:.3g} rad, expected at most {largest:.2g} rad, beyond which no digits "
            "are left of where links point; leave out full turns"
        )


def joint_miss(model: Model) -> float:
    """The same for a model in its own numbers: floats miss by more than that already by rounding."""
    return max(JOINT_MISS, 1e3 * float(np.finfo(model.core.REAL).eps) * model.length)


def read_off(model: Model, poses: FloatArray) -> FloatArray:
    """Coordinates (nq,) of links at ``poses`` (links, 3)."""
    lines = model.lines
    found = [lines.coordinate(kind, of, poses) for kind, of in model.data["coordinates"]]
    return np.array(found, dtype=model.core.REAL)


def read_rates(model: Model, poses: FloatArray, velocities: FloatArray) -> FloatArray:
    """Quasi-velocities (nu,) of links at ``poses`` that move with ``velocities``, both (links, 3)."""
    lines = model.lines
    found = [lines.rate(kind, of, poses, velocities) for kind, of in model.data["coordinates"]]
    return np.array(found, dtype=model.core.REAL)


def read_state(model: Model, poses: ArrayLike, velocities: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """State (q, u) of links at ``poses`` that move with ``velocities``, both (links, 3), nothing projected.

    Raises ``ValueError`` when joints miss by more than 1e-6 m, or their velocities by more than 1e-6 m/s.
    """
    given = _rows(model, poses, "poses"), _rows(model, velocities, "velocities")
    q, u = read_off(model, given[0]), read_rates(model, *given)
    places, moving = model.poses(q) - given[0], model.velocities(q, u) - given[1]
    places[:, 2] = np.remainder(places[:, 2] + np.pi, 2.0 * np.pi) - np.pi
    opening = model.kernels.of_state("closure_rate", q[None], u[None])
    misses = (("poses", "m", places, model.closure(q)), ("velocities", "m/s", moving, opening))
    for what, unit, difference, closure in misses:
        parts = (difference[:, :2], difference[:, 2] * model.length, closure)
        miss = max(float(np.max(np.abs(part), initial=0.0)) for part in parts)
        if miss > joint_miss(model):
            raise ValueError(f"{what}: joints miss by {miss:.3g} {unit}, expected at most {joint_miss(model):g} {unit}")
    return q, u


def _rows(model: Model, rows: ArrayLike, what: str) -> FloatArray:
    found = np.array(rows, dtype=model.core.REAL)
    if found.shape != (len(model.links), 3) or not np.all(np.isfinite(found)):
        raise ValueError(f"{what}: found shape {found.shape}, expected finite numbers ({len(model.links)}, 3)")
    return found
