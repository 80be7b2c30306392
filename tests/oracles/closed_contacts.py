"""Which rigid motions of closed contacts with Coulomb friction there are: every combination of modes is tried.

A contact opens ("o"), sticks ("s"), or slides forward ("+") or backward ("-"). For each combination the forces follow
from dense linear algebra, and it is consistent when no force pulls, none is beyond its limit, no gap closes, and what
begins to slide does so against its friction. The matrices are put together from the model's kernels by a null space,
not by its elimination.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np

from .maximal import Array


@dataclass(frozen=True)
class Motion:
    """One consistent combination: modes, forces and accelerations of normals, then of tangents."""

    modes: str
    forces: Array
    accelerations: Array


def rows(model: Any, q: Array, u: Array) -> tuple[Array, Array]:
    """W and b of all contacts, normals and then tangents: accelerations = W forces + b."""
    kernels, n = model.kernels, u.size
    many, unit, state = np.repeat(q[None], n, axis=0), np.eye(n), (q[None], u[None])
    mass = kernels.of_state("momentum", many, unit).T
    both = np.vstack([kernels.of_state("gap_rates", many, unit).T, kernels.of_state("slips", many, unit).T])
    bias = np.append(kernels.of_state("gap_bias", *state), kernels.of_state("slip_bias", *state))
    closure = model.jacobian(q)
    _, values, directions = np.linalg.svd(closure)
    free = directions[int(np.sum(values > 1e-9 * np.max(values, initial=0.0))) :].T
    fixed = -np.linalg.pinv(closure, rcond=1e-9) @ kernels.of_state("closure_bias", *state)[0]
    load = kernels.inverse_dynamics(*state, 0.0, np.zeros((1, n)))[0] + mass @ fixed
    reduced = np.linalg.inv(free.T @ mass @ free)
    moved = both @ free
    return moved @ reduced @ moved.T, both @ (fixed - free @ reduced @ free.T @ load) + bias


def of_modes(W: Array, b: Array, mu: float, modes: str) -> Motion | None:
    """Forces of least norm in these modes, or ``None`` where there are none."""
    n = len(modes)
    unit, needed, columns = np.eye(2 * n), [], []
    for i, mode in enumerate(modes):
        if mode == "o":
            continue
        sign = {"+": 1.0, "-": -1.0, "s": 0.0}[mode]
        columns.append(unit[i] - sign * mu * unit[n + i])
        needed.append(i)
        if mode == "s":
            columns.append(unit[n + i])
            needed.append(n + i)
    if not needed:
        return Motion(modes, np.zeros(2 * n), b.copy())
    span = np.array(columns).T
    forces = span @ np.linalg.lstsq(W[needed] @ span, -b[needed], rcond=1e-11)[0]
    found = W @ forces + b
    return Motion(modes, forces, found) if np.max(np.abs(found[needed])) <= 1e-8 * np.max(np.abs(b)) else None


def consistent(W: Array, mu: float, slides: Array, motion: Motion, tolerance: float) -> bool:
    """Whether it is one that rigid bodies may have; ``slides`` has the sign of each contact's sliding, or 0."""
    n = len(motion.modes)
    push, drag = (motion.forces[k * n : (k + 1) * n] * np.diag(W)[:n] for k in (0, 1))
    opens, begins = motion.accelerations[:n], motion.accelerations[n:]
    for i, mode in enumerate(motion.modes):
        if mode == "o":
            right = opens[i] >= -tolerance
        else:
            right = push[i] >= -tolerance and abs(drag[i]) <= mu * push[i] + tolerance
            sign = {"+": 1.0, "-": -1.0, "s": 0.0}[mode]
            right &= slides[i] == sign if slides[i] else sign * begins[i] >= -tolerance
        if not right:
            return False
    return True


def motions(W: Array, b: Array, mu: float, slides: Array) -> list[Motion]:
    """All consistent combinations."""
    choices = ["o" + ({1.0: "+", -1.0: "-"}.get(float(s), "s+-")) for s in slides]
    found = (of_modes(W, b, mu, "".join(modes)) for modes in itertools.product(*choices))
    tolerance = 1e-9 * float(np.max(np.abs(b)))
    return [motion for motion in found if motion and consistent(W, mu, slides, motion, tolerance)]
