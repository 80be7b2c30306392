"""Inverse dynamics and momenta of a mechanism: the torques at joints that give a wanted motion, loops held shut.

A torque at a joint acts on the joint's second link, and its opposite on the first; both count as generalized forces
B τ beside the loads that are in the model. With closure rows A (rows, nu) and Z an orthonormal basis of the motions
A Z = 0, the equations M u̇ + h = Aᵀλ + B τ reduce to Zᵀ(M u̇ + h) = Zᵀ B τ (theory, sections 4 and 8).
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..model.drives import drive_columns, drive_rows
from ..model.inputs import Values
from ..model.integrators import integral_rows
from ..model.model import Model, check_model
from ..model.numbers import read_names, read_numbers, told
from ..precision import need_doubles
from .contacts import CLOSED, DEEPEST, Contacts, inside

RANK = 1e-9
"""Singular values below this part of the largest do not count."""
PRODUCED = 1e-8
"""Torques that leave a larger part of the wanted generalized force do not produce the motion."""
FOLLOWED = 1e-6
"""Accelerations that open a loop, or velocities and accelerations that close a closed gap, by less than this part of
the motion's own are rounding; so is what is taken from Coulomb's limits by less than this part of the forces."""


def momentum(model: Model, q: ArrayLike, u: ArrayLike) -> FloatArray:
    """Generalized momenta M u (nu,), the derivatives of the kinetic energy by u; a batch gives (b, nu).

    Where the mechanism floats, the first two are its linear momentum (kg m/s), and the sum of the others is its angular
    momentum (kg m²/s) about the origin of the root's frame.
    """
    check_model(model)
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
    contact_forces: ArrayLike | None = None,
) -> FloatArray:
    """Torques (joints,) in N m at the named joints that give the motion ``u_dot``; a batch gives (b, joints).

    They act on each joint's second link against its first, beside the loads of the model. More joints than degrees of
    freedom share the work with the least sum of squares. At a driven joint that is named the torque stands for its
    drive; drives of others take what ``u_dot`` asks of them. Effects that ``[start] off`` names are absent.

    The forces of contacts are not given by the motion: they are those of ``contact_forces`` (contacts, 2), normal force
    and friction of each in the order of the model's ``contacts``, in N (of stops in N m), a batch (b, contacts, 2), and
    without it zero; a warning names contacts that are closed then. Raises ``ValueError`` when a state is behind a
    surface, when the motion opens a loop or goes into a surface that it touches, for contact forces that such contacts
    cannot have, and when no torques at these joints produce ``u_dot``, saying how much is missing.
    """
    check_model(model)
    need_doubles(model.precision, model.name, "inverse dynamics")
    if not isinstance(joints, str):
        joints = read_names(joints, "joints", "joints")
    drives = drive_columns(model, joints)
    states, single = model._state(q, u)
    wanted, _ = model._batch(u_dot, "u_dot", len(model.u_names))
    if len(wanted) != len(states[0]):
        raise ValueError(f"u_dot: found {len(wanted)} rows, expected {len(states[0])}, one per state")
    if read_numbers(t, "t").ndim or not np.isfinite(read_numbers(t, "t")):
        raise ValueError(f"t: found {told(t)}, expected a finite number")
    opening = _closure_accelerations(model, *states, wanted)
    with model.given(inputs):
        forces = model.kernels.inverse_dynamics(*states, t, wanted)
    forces = forces - _contact_loads(model, *states, wanted, contact_forces, single)
    found = []
    for index, (one_q, force, miss) in enumerate(zip(states[0], forces, opening, strict=True)):
        scale = 1.0 + float(np.max(np.abs(wanted[index]))) * model.length
        if np.max(np.abs(miss), initial=0.0) > FOLLOWED * scale:
            raise ValueError(
                f"u_dot: state {index} opens a loop at {np.max(np.abs(miss)):.3g} m/s², expected accelerations that "
                "keep every loop closed"
            )
        found.append(_torques(model, one_q, force, drives, joints))
    return found[0] if single else np.array(found)


def _contact_loads(
    model: Model, q: FloatArray, u: FloatArray, u_dot: FloatArray, given: ArrayLike | None, single: bool
) -> FloatArray:
    """Generalized forces (b, nu) of the contacts in a motion that they allow."""
    count = len(model.contacts)
    shape = (count, 2) if single else (len(q), count, 2)
    found = np.zeros(shape) if given is None else np.array(read_numbers(given, "contact_forces"))
    if found.shape != shape or not np.all(np.isfinite(found)):
        raise ValueError(f"contact_forces: found shape {found.shape}, expected finite numbers {shape}")
    for contact in model.off_contacts:
        if np.any(found[..., model.contacts.index(contact), :]):
            point, ground = contact
            raise ValueError(f"contact_forces: found some at {point} on {ground}, which is off, expected zero there")
    contacts, loads, warned = Contacts(model), np.zeros_like(q), False
    if not count:
        return loads
    for index, forces in enumerate(found.reshape(len(q), count, 2)):
        if depth := inside(model, q[index], DEEPEST):
            raise ValueError(f"q: state {index} has {depth}, expected a state outside all surfaces")
        state = q[index : index + 1], u[index : index + 1], u_dot[index : index + 1]
        _check_touching(model, contacts, index, *state)
        _check_forces(model, contacts, index, q[index], forces)
        if given is None and not warned:
            warned = _warn_closed(model, contacts, index, *state[:2])
        loads[index] = contacts.generalized(q[index], forces)
    return loads


def _warn_closed(model: Model, contacts: Contacts, index: int, q: FloatArray, u: FloatArray) -> bool:
    """Say which contacts stay closed, whose forces are taken as zero; whether there are any."""
    rates = model.kernels.of_state("gap_rates", q, u)[0] / contacts.sizes
    staying = (contacts.depths(q[0]) >= -CLOSED) & (rates <= FOLLOWED * max(float(np.max(np.abs(u))), 1.0))
    closed = [model.contacts[k] for k in np.flatnonzero(staying)]
    if closed:
        names = ", ".join(f"{point} on {ground}" for point, ground in closed)
        warnings.warn(
            f"{model.name}: state {index} has closed contacts ({names}), whose forces the motion does not give; they "
            "are taken as zero, give contact_forces",
            stacklevel=4,
        )
    return bool(closed)


def _check_touching(
    model: Model, contacts: Contacts, index: int, q: FloatArray, u: FloatArray, u_dot: FloatArray
) -> None:
    """A motion from contacts that are closed does not lead into their surfaces."""
    closed = contacts.depths(q[0]) >= -CLOSED
    speed, change = (float(np.max(np.abs(x), initial=0.0)) for x in (u, u_dot))
    rates = model.kernels.of_state("gap_rates", q, u)[0] / contacts.sizes
    bias = model.kernels.of_state("gap_bias", q, u)[0]
    accelerations = (model.kernels.of_state("gap_rates", q, u_dot)[0] + bias) / contacts.sizes
    coming = closed & (rates < -FOLLOWED * max(speed, 1.0))
    pressed = closed & (np.abs(rates) <= FOLLOWED * max(speed, 1.0))
    pressed &= accelerations < -FOLLOWED * max(change, speed**2, 1.0)
    for which, what, values, per in ((coming, "u", rates, "s"), (pressed, "u_dot", accelerations, "s²")):
        if np.any(which):
            worst = int(np.argmin(np.where(which, values, 0.0)))
            point, ground = model.contacts[worst]
            unit = "rad" if ground in model.stops else "m"
            raise ValueError(
                f"{what}: state {index} drives {point} into {ground} at {-values[worst] * contacts.sizes[worst]:.3g} "
                f"{unit}/{per}, expected a motion along the surface or off it"
            )


def _check_forces(model: Model, contacts: Contacts, index: int, q: FloatArray, forces: FloatArray) -> None:
    """Forces are of closed contacts, push, and are within Coulomb's limits."""
    apart = contacts.depths(q) < -CLOSED
    size = FOLLOWED * float(np.max(np.abs(forces), initial=0.0))
    beyond = np.abs(forces[:, 1]) > contacts.friction * forces[:, 0] + size
    for contact in np.flatnonzero(np.any(forces != 0.0, axis=1)):
        point, ground = model.contacts[contact]
        normal, friction = forces[contact]
        wrong = "its gap is open" if apart[contact] else "it can only push" if normal < -size else ""
        if not wrong and beyond[contact]:
            wrong = f"its friction is at most {contacts.friction[contact] * normal:.6g} N"
        if wrong:
            raise ValueError(
                f"contact_forces: state {index} has {normal:.6g} and {friction:.6g} at {point} on {ground}; {wrong}"
            )


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


def free_motions(
    model: Model, q: FloatArray, released: Sequence[str] = (), contacts: FloatArray | None = None
) -> FloatArray:
    """Orthonormal basis Z (nu, freedoms) of the velocities that hold loops shut, driven joints and integrals still.

    Drives of joints that are ``released`` do not count. ``contacts`` (k, nu), in m, are rows of contacts that hold too.
    """
    held = [drive["joint"] not in released for drive in model.data["drives"]]
    parts = [model.jacobian(q), drive_rows(model)[held] * model.length, integral_rows(model) * model.length]
    rows = np.vstack(parts if contacts is None else [*parts, contacts])
    if not rows.size:
        return np.eye(len(model.u_names))
    _, values, right = np.linalg.svd(rows)
    rank = int(np.sum(values > RANK * max(values[0], model.length)))
    return np.asarray(right[rank:].T, dtype=float)


def _closure_accelerations(model: Model, q: FloatArray, u: FloatArray, u_dot: FloatArray) -> FloatArray:
    """A u̇ + (dA/dt) u, (b, rows): how fast the loops would open."""
    bias = model.kernels.of_state("closure_bias", q, u)
    return np.asarray(np.einsum("bij,bj->bi", model.jacobian(q), u_dot) + bias, dtype=float)
