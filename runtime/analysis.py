"""Inverse dynamics and momenta of a mechanism: the torques at joints that give a wanted motion, loops held shut.

A torque at a joint acts on the joint's second link, and its opposite on the first; both count as generalized forces
B τ beside the loads that are in the model. With closure rows A (rows, nu) and Z an orthonormal basis of the motions
A Z = 0, the equations M u̇ + h = Aᵀλ + B τ reduce to Zᵀ(M u̇ + h) = Zᵀ B τ (theory, sections 4 and 8).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from .drives import drive_columns, drive_rows
from .frames import FloatArray
from .inputs import Values
from .model import Model
from .precision import need_doubles

RANK = 1e-9
"""Singular values below this part of the largest do not count."""
PRODUCED = 1e-8
"""Torques that leave a larger part of the wanted generalized force do not produce the motion."""


def momentum(model: Model, q: ArrayLike, u: ArrayLike) -> FloatArray:
    """Generalized momenta M u (nu,), the derivatives of the kinetic energy by u; a batch gives (b, nu).

    Where the mechanism floats, the first two are its linear momentum (kg m/s), and the sum of the others is its angular
    momentum (kg m²/s) about the origin of the root's frame.
    """
    states, single = model._state(q, u)
    found = model.kernels.of_state("momentum", *states)
    return found[0].copy() if single else found.copy()


def inverse_dynamics(
    model: Model,
    q: ArrayLike,
    u: ArrayLike,
    u_dot: ArrayLike,
    joints: Sequence[str],
    t: float = 0.0,
    inputs: Values | None = None,
) -> FloatArray:
    """Torques (joints,) in N m at the named joints that give the motion ``u_dot``; a batch gives (b, joints).

    They act on each joint's second link against its first, beside the loads of the model. More joints than degrees of
    freedom share the work with the least sum of squares. At a driven joint that is named the torque stands for its
    drive; drives of others take what ``u_dot`` asks of them. Raises ``ValueError`` when ``u_dot`` opens a loop, or when
    no torques at these joints produce it, saying how much is missing.
    """
    need_doubles(model.precision, model.name, "inverse dynamics")
    drives = drive_columns(model, joints)
    states, single = model._state(q, u)
    wanted, _ = model._batch(u_dot, "u_dot", len(model.u_names))
    if len(wanted) != len(states[0]):
        raise ValueError(f"u_dot: found {len(wanted)} rows, expected {len(states[0])}, one per state")
    if not np.isfinite(t):
        raise ValueError(f"t: found {t}, expected a finite number")
    opening = _closure_accelerations(model, *states, wanted)
    with model.given(inputs):
        forces = model.kernels.inverse_dynamics(*states, t, wanted)
    found = []
    for index, (one_q, force, miss) in enumerate(zip(states[0], forces, opening, strict=True)):
        scale = 1.0 + float(np.max(np.abs(wanted[index]))) * model.length
        if np.max(np.abs(miss), initial=0.0) > 1e-6 * scale:
            raise ValueError(
                f"u_dot: state {index} opens a loop at {np.max(np.abs(miss)):.3g} m/s², expected accelerations that "
                "keep every loop closed"
            )
        found.append(_torques(model, one_q, force, drives, joints))
    return found[0] if single else np.array(found)


def _torques(model: Model, q: FloatArray, force: FloatArray, drives: FloatArray, joints: Sequence[str]) -> FloatArray:
    """Least torques that leave nothing of ``force`` along the motions that the loops allow."""
    motions = free_motions(model, q, joints)
    wanted, reach = motions.T @ force, motions.T @ drives
    torques = np.linalg.lstsq(reach, wanted, rcond=RANK)[0]
    missing = float(np.linalg.norm(wanted - reach @ torques))
    if missing > PRODUCED * max(float(np.linalg.norm(force)), 1e-300):
        raise ValueError(
            f"torques at {', '.join(joints)} cannot give this motion: a generalized force of {missing:.3g} N m is left "
            f"of {np.linalg.norm(wanted):.3g}; name more joints ({motions.shape[1]} degrees of freedom)"
        )
    return np.asarray(torques, dtype=float)


def free_motions(model: Model, q: FloatArray, released: Sequence[str] = ()) -> FloatArray:
    """Orthonormal basis Z (nu, freedoms) of the velocities that hold the loops shut and driven joints still.

    Drives of joints that are ``released`` do not count.
    """
    held = [drive["joint"] not in released for drive in model.data["drives"]]
    rows = np.vstack([model.jacobian(q), drive_rows(model)[held] * model.length])
    if not rows.size:
        return np.eye(len(model.u_names))
    _, values, right = np.linalg.svd(rows)
    rank = int(np.sum(values > RANK * max(values[0], model.length)))
    return np.asarray(right[rank:].T, dtype=float)


def _closure_accelerations(model: Model, q: FloatArray, u: FloatArray, u_dot: FloatArray) -> FloatArray:
    """A u̇ + (dA/dt) u, (b, rows): how fast the loops would open."""
    bias = model.kernels.of_state("closure_bias", q, u)
    return np.asarray(np.einsum("bij,bj->bi", model.jacobian(q), u_dot) + bias, dtype=float)
