"""The mass matrix, and the motions that a mechanism has at a configuration."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..precision import need_doubles
from .compiled import Compiled
from .integrators import integral_rows

EASY = 0.3
"""The next motion is that of the first coordinate that is at least this part as easy to move as the easiest: so equal
ones are taken in their order, whatever their rounding."""


def mass_matrix(model: Compiled, q: ArrayLike) -> FloatArray:
    """M (nu, nu), symmetric: columns are momenta M u (theory, eq. 7.2) at unit u. A batch gives (b, nu, nu)."""
    states, single = model._batch(q, "q", len(model.q_names))
    count, nu = len(states), len(model.u_names)
    units = np.tile(np.eye(nu, dtype=model.core.REAL), (count, 1))
    found = model.kernels.of_state("momentum", np.repeat(states, nu, axis=0), units).reshape(count, nu, nu)
    found = (found + found.transpose(0, 2, 1)) / 2
    return found[0] if single else found


def motions(model: Compiled, q: ArrayLike) -> FloatArray:
    """A basis Z (nu, dof) of the velocities that keep loops shut, driven joints and integrals still, with ZᵀMZ = 1.

    The core says which rows count (theory, section 8). Its basis Z₀ becomes Z₀ K, with K Kᵀ = (Z₀ᵀ M Z₀)⁻¹: then Z Zᵀ
    has the velocities that an impulse at each coordinate gives. Column by column, the coordinate is taken that those
    columns already there leave easiest to move; the column is the motion that an impulse there gives while coordinates
    of the columns before stand still, with half a joule of kinetic energy.
    """
    need_doubles(model.precision, model.name, "motions")
    states, single = model._batch(q, "q", len(model.q_names))
    if not single:
        raise ValueError(
            f"q: found shape {states.shape}, expected ({len(model.q_names)},): configurations may differ in how many "
            "motions they have; ask for each"
        )
    free = model.kernels.motions(np.ascontiguousarray(states[0])).T
    if len(held := integral_rows(model)):
        free = free @ np.linalg.svd(held @ free)[2][len(held) :].T  # nothing else moves with an integral
        free[np.any(held, axis=0)] = 0.0
    if not free.shape[1]:
        return np.array(free)
    root = np.linalg.cholesky(free.T @ mass_matrix(model, states[0]) @ free)
    found = np.linalg.solve(root, free.T).T
    lengths = np.array([kind != "angle" for kind, _ in model.data["coordinates"]])
    return _by_coordinates(found, np.where(lengths, 1.0 / model.length, 1.0))


def _by_coordinates(basis: FloatArray, weights: FloatArray) -> FloatArray:
    """The ``basis`` (nu, k) turned so that each column has a coordinate, with a positive entry, at which all later
    columns have zeros; ``weights`` (nu,) make coordinates comparable."""
    columns, taken = basis.copy(), np.zeros(len(basis), dtype=bool)
    for k in range(basis.shape[1]):
        ease = np.where(taken, 0.0, np.linalg.norm(columns[:, k:], axis=1) * weights)
        chosen = int(np.argmax(ease >= EASY * ease.max()))
        row = columns[chosen, k:]
        _reflect_onto_first(columns[:, k:], row / np.linalg.norm(row))
        columns[chosen, k + 1 :] = 0.0
        taken[chosen] = True
    return columns


def _reflect_onto_first(columns: FloatArray, direction: FloatArray) -> None:
    """Turn ``columns`` (n, k), in place, by a reflection after which rows along ``direction`` (k,) have all in the
    first column, with its sign."""
    mirror = direction.copy()
    mirror[0] += 1.0 if mirror[0] >= 0.0 else -1.0
    columns -= np.outer(columns @ mirror, 2.0 * mirror / (mirror @ mirror))
    if direction[0] >= 0.0:
        columns[:, 0] *= -1.0
