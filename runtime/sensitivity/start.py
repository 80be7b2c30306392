"""What the start of a run moves by: by the implicit function theorem (docs/theory.md, eq. 11.10)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..model.model import Model
from ..model.start import kept_places, kept_rates, scene_start
from ..model.tolerances import start_miss
from .local import Local, at_one
from .moving import Moving

SHUT = 1e-9
"""A start given by hand that is open by more than this, in lengths of the mechanism, is moved by projection by so much
that its metric changes on the way: of what is below, the change of the metric is as much of the derivative."""


def start_moves(
    model: Model, moving: Moving, q: FloatArray, u: FloatArray, given: tuple[FloatArray, FloatArray] | None
) -> FloatArray:
    """What the start (q, u) of a run moves by, (2 n, columns).

    ``given`` are coordinates and rates as they were before they were put onto the closure, or None where the start is
    the scene's, which moves with the parameters as ``Model.start`` does.

    Raises ``ValueError`` for a start that was given far from closed.
    """
    if given is None and _moves_itself(moving) and moving.along.any() and kept_rates(model):
        # what the scene gives stays with other parameters, not where the start is moved by itself
        by_itself, by_arguments = _apart(moving)
        return start_moves(model, by_itself, q, u, None) + start_moves(model, by_arguments, q, u, None)
    at = at_one(model, moving, 0.0, q)
    n = len(q)
    scene = given is None
    q_given, u_given = given if given is not None else scene_start(model)
    if not scene and float(np.max(np.abs(q - q_given), initial=0.0)) > SHUT * max(1.0, model.length):
        raise ValueError(
            f"q0: found a start that is open by {float(np.max(np.abs(model.closure(q_given)), initial=0.0)):.3g} m, "
            "expected one whose loops are shut, by which the run can be derived; take it from model.project or "
            "model.assemble"
        )
    free, fixed = _parted(moving)
    drives = at.drive_rows
    toward_q, toward_u = free[:n], free[n : 2 * n]
    if len(drives):  # driven joints are where they are to be, if that is given, and as fast
        placed = drives[_placed(model)]
        toward_q = toward_q - np.linalg.pinv(placed) @ (placed @ toward_q)
        toward_u = toward_u + np.linalg.pinv(drives) @ (_speeds_move(at) - drives @ toward_u)
    closure = at.closure_moves()
    by_q = closure[:, :n]
    # directions in q0, and parameters of a start that was given: projected in the metric of the mass
    wanted = -(by_q @ toward_q + (0.0 if scene else closure[:, 2 * n :] @ fixed))
    q_moves = toward_q + at.response(np.zeros((n, wanted.shape[1])), wanted)
    if scene and len(fixed):
        q_moves = q_moves + _assembled(at, q_given, closure) @ fixed
    whole = np.vstack([q_moves, np.zeros_like(q_moves), fixed])
    kept = kept_rates(model) if scene and not _moves_itself(moving) and _as_given(model, u, u_given) else []
    u_moves = _rates(at, u, u_given, whole, toward_u, scene, kept)
    return np.vstack([q_moves, u_moves])


def _parted(moving: Moving) -> tuple[FloatArray, FloatArray]:
    """What q0 and u0 move by, (2 n, columns), and the arguments (arguments, columns)."""
    return np.vstack([moving.q0, moving.u0]), moving.along


def _moves_itself(moving: Moving) -> bool:
    return bool(moving.q0.any() or moving.u0.any())


def _apart(moving: Moving) -> tuple[Moving, Moving]:
    """Directions of the start alone, and of the arguments alone: all that moves moves by both."""
    none = np.zeros_like(moving.q0)
    return replace(moving, along=np.zeros_like(moving.along)), replace(moving, q0=none, u0=none)


def _as_given(model: Model, x: FloatArray, given: FloatArray) -> bool:
    """Whether the rates that the scene gives are those of the start."""
    kept = kept_rates(model)
    near = start_miss(model.core.REAL, model.length)
    return bool(np.all(np.abs(x - given)[kept] <= near * (1.0 + np.abs(given[kept]))))


def _assembled(at: Local, q_given: FloatArray, closure: FloatArray) -> FloatArray:
    """What the configuration (n, arguments) nearest to that of the scene moves by with the parameters.

    It has T'T (q - q_given) + R' nu = 0 and is closed, R being the rows of the closure, of the driven joints whose
    places are given, and of the coordinates that stay: the derivative of both solves the same system with what they
    miss by.
    """
    model, n, rows = at.model, len(at.q), len(at.model.rows)
    T = model.displacements()
    W = T.T @ T
    placed = _placed(model)
    kept = kept_places(model)
    if np.max(np.abs(at.q - q_given)[kept], initial=0.0) > start_miss(model.core.REAL, model.length):
        kept = []  # the loops are not closed so
    R = np.vstack([at.closure_rows, at.drive_rows[placed], np.eye(n)[kept]])
    if not len(R):
        return np.zeros((n, closure.shape[1] - 2 * n))
    pull = -W @ (at.q - q_given)
    nu = np.asarray(np.linalg.lstsq(R.T, pull, rcond=1e-12)[0], dtype=float)
    # jump: A' lambda - M 0, by q and the arguments
    turned = at.tangent("jump", n + rows, np.zeros(n), ("q", "k"), multipliers=nu[:rows])[:n]
    system = np.block([[W + turned[:, :n], R.T], [R, np.zeros((len(R), len(R)))]])
    right = -np.vstack([turned[:, 2 * n :], closure[:, 2 * n :], np.zeros((len(R) - rows, closure.shape[1] - 2 * n))])
    return np.asarray(np.linalg.lstsq(system, right, rcond=1e-13)[0][:n])


def _placed(model: Model) -> NDArray[np.bool_]:
    """Which drives say where their joint is at the start; the others take it on from anywhere."""
    return np.array([drive["position"] is not None for drive in model.data["drives"]], dtype=bool)


def _rates(
    at: Local,
    u: FloatArray,
    u_given: FloatArray,
    whole: FloatArray,
    toward: FloatArray,
    scene: bool,
    kept: Sequence[int],
) -> FloatArray:
    """What the rates (n, columns) of a start move by: as little off the given ones as shuts the loops, with driven
    joints as fast as they are to be, and the rates of the coordinates ``kept`` as they are."""
    model, n, rows = at.model, len(at.q), len(at.model.rows)
    turned = at.closure_rates_move(u)
    bent = turned[:, :n] @ whole[:n] + turned[:, 2 * n :] @ whole[2 * n :]
    if scene and (model.data["drives"] or kept):
        R = np.vstack([at.drive_rows, np.eye(n)[list(kept)], at.closure_rows])
        y = np.asarray(np.linalg.lstsq(R.T, u - u_given, rcond=1e-12)[0], dtype=float)
        held = at.tangent("jump", n + rows, np.zeros(n), ("q", "k"), multipliers=y[len(R) - rows :])[:n]
        pulled = held @ whole
        speeds = np.vstack([_speeds_move(at), np.zeros((len(kept), whole.shape[1]))])
        wanted = np.vstack([speeds, -bent]) - R @ (pulled + toward)
        return np.asarray(toward + pulled + np.linalg.pinv(R, rcond=1e-12) @ wanted)
    jump = np.ascontiguousarray(u - u_given)
    held = np.zeros((n, whole.shape[1]))
    if jump.any():  # else no impulse has put it onto the closure
        _, Lambda, _ = model.kernels.impulse(at.q[None], np.zeros((1, n)), np.append(at.closure_rows @ jump, 0.0)[None])
        held = at.tangent("jump", n + rows, jump, ("q", "k"), multipliers=Lambda[0])[:n] @ whole
    return np.asarray(toward + at.response(held, -bent - at.closure_rows @ toward))


def _speeds_move(at: Local) -> FloatArray:
    """What the speeds of driven joints at the start move by, (drives, columns), with parameters that are speeds."""
    speeds = [drive["speed"] for drive in at.model.data["drives"]]
    found = np.zeros((len(speeds), len(at.moving.columns)))
    for row, speed in enumerate(speeds):
        if speed in at.moving.arguments:
            found[row] = at.moving.along[at.moving.arguments.index(speed)]
    return found
