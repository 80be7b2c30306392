"""Motion and forces of a mechanism with dependent joints, by a dense singular value decomposition."""

from __future__ import annotations

import numpy as np

from . import maximal
from .maximal import Array
from .mechanisms import Drawing


def least_squares(drawing: Drawing, poses: Array, velocities: Array) -> tuple[Array, Array]:
    """Angular accelerations and the forces of least norm on each pin's link ``b``, by a dense decomposition."""
    system = drawing.system
    angles, spins = poses[:, 2], velocities[:, 2]
    rows = maximal.jacobian(system, angles).astype(float)
    inertias = np.stack([system.mass, system.mass, system.inertia], axis=1).ravel().astype(float)
    force = np.zeros((system.size, 3))
    force[:, 1] = -system.mass * system.gravity
    bias = maximal._centripetal(system, angles.astype(np.longdouble), spins.astype(np.longdouble)).astype(float)
    root = 1 / np.sqrt(inertias)  # Gauss's principle: least constraint in the metric of the mass matrix
    free = force.ravel() / inertias
    left, values, right = np.linalg.svd(rows * root, full_matrices=False)
    rank = int(np.sum(values > 1e-9 * values[0]))
    needed = (left.T @ (bias - rows @ free))[:rank] / values[:rank]
    a = free + root * (right[:rank].T @ needed)
    multipliers = left[:, :rank] @ (needed / values[:rank])
    return a.reshape(-1, 3)[:, 2], multipliers.reshape(-1, 2)
