"""How named points move: Jacobian, velocity, and acceleration that follows from given accelerations.

A place is a sum of arms, each turned by one absolute angle, and of lengths along lines that one angle turns (theory,
eq. 2.3 and 2.5). So the derivative of a column of the Jacobian by the angle that turns it is the column turned by a
right angle, and by any other coordinate zero, but for a length's column, which its line's angle turns:
``J̇ u = Σ ω² (J_ω)^⊥ + 2 Σ ω ṡ (J_s)^⊥``, the centripetal and Coriolis' part of eq. 2.4 and 2.6.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from .geometry import Geometry
from .numbers import read_name

GROUND = -1


def point_jacobian(model: Geometry, name: str, q: ArrayLike) -> FloatArray:
    """Derivatives J (2, nu) of the point's velocity by u. A batch gives (b, 2, nu)."""
    states, single = model._batch(q, "q", len(model.q_names))
    found = jacobian_at(model, link_of(model, name), model.point(name, states), states)
    return np.ascontiguousarray(found[0] if single else found)


def jacobian_at(model: Geometry, link: int, places: FloatArray, q: FloatArray) -> FloatArray:
    """That (b, 2, nu) of points fixed in the link that are at ``places`` (b, 2) at configurations q (b, nq).

    Velocities are linear in u: columns are those at unit u. The link moves with its frame's origin and turns about it.
    """
    count, nu = len(q), len(model.u_names)
    if link == GROUND:
        return np.zeros((count, 2, nu), dtype=model.core.REAL)
    units = np.tile(np.eye(nu, dtype=model.core.REAL), (count, 1))
    moving = model.kernels.of_state("velocities", np.repeat(q, nu, axis=0), units)
    moving = moving.reshape(count, nu, len(model.links), 3)[:, :, link].transpose(0, 2, 1)
    arms = places - model.poses(q)[:, link, :2]
    return np.asarray(moving[:, :2] + turned(arms)[:, :, None] * moving[:, 2:])


def point_velocity(model: Geometry, name: str, q: ArrayLike, u: ArrayLike) -> FloatArray:
    """Velocity J u of the point (m/s), (2,) or (b, 2)."""
    (states, rates), single = model._state(q, u)
    found = np.einsum("bij,bj->bi", point_jacobian(model, name, states), rates)
    return np.asarray(found[0] if single else found)


def point_acceleration(model: Geometry, name: str, q: ArrayLike, u: ArrayLike, u_dot: ArrayLike) -> FloatArray:
    """Acceleration J u̇ + J̇ u of the point (m/s²), (2,) or (b, 2), where ``u_dot`` are those of the mechanism."""
    (states, rates), single = model._state(q, u)
    changes, _ = model._batch(u_dot, "u_dot", len(model.u_names))
    if len(changes) != len(states):
        raise ValueError(f"u_dot: found {len(changes)} rows, expected {len(states)}, one per state")
    jacobian = point_jacobian(model, name, states)
    found = np.einsum("bij,bj->bi", jacobian, changes) + bias(model, jacobian, rates)
    return np.asarray(found[0] if single else found)


def bias(model: Geometry, jacobian: FloatArray, u: FloatArray) -> FloatArray:
    """J̇ u (b, 2) of a point with this ``jacobian`` (b, 2, nu) at rates u (b, nu)."""
    coordinates = [(kind, of) for kind, of in model.data["coordinates"]]
    weights = np.zeros_like(u)
    for column, (kind, of) in enumerate(coordinates):
        if kind == "angle":
            weights[:, column] = u[:, column] ** 2
        elif kind == "slide":
            first = model.data["lines"][of]["links"][0]
            if first != GROUND and (leader := model.data["leaders"][first]) != GROUND:
                weights[:, column] = 2.0 * u[:, coordinates.index(("angle", leader))] * u[:, column]
    return turned(np.einsum("bij,bj->bi", jacobian, weights))


def link_of(model: Geometry, name: str) -> int:
    """The number of the link in which ``model.point`` has this point fixed; −1 for the ground."""
    name = read_name(name, "name", "a joint or of a point")
    name = model.data["welded_points"].get(name, name)
    if name in model.joints:
        first, second = model.data["between"][model.joints.index(name)]
        return int(second if name in model.data["lines"] else first)
    link = name.partition(".")[0]
    return model.links.index(link) if link in model.links else GROUND


def turned(v: FloatArray) -> FloatArray:
    """Vectors (..., 2) turned by a right angle."""
    return np.stack([-v[..., 1], v[..., 0]], axis=-1)
