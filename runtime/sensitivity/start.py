"""What the start of a run moves by: by the implicit function theorem (docs/theory.md, eq. 11.10)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..model.model import Model
from ..model.start import closed_anew, floats_by_another, going_anew, scene_start, shape_parameters
from .local import Local, at_one
from .moving import Moving

SHUT = 1e-9
"""A start given by hand that is open by more than this, in lengths of the mechanism, is moved by projection by so much
that its metric changes on the way: of what is below, the change of the metric is as much of the derivative."""

STEP = 1e-3
"""Of differences (rad, m) of where a link is: those of the fourth order miss its fourth power, 1e-12."""


def start_moves(
    model: Model, moving: Moving, q: FloatArray, u: FloatArray, given: tuple[FloatArray, FloatArray] | None
) -> FloatArray:
    """What the start (q, u) of a run moves by, (2 n, columns).

    ``given`` are coordinates and rates as they were before they were put onto the closure, or None where the start is
    the scene's, which moves with the parameters as ``Model.start`` does.

    Raises ``ValueError`` for a start that was given far from closed.
    """
    if given is None:
        # where the start is moved by itself it is given; what the parameters move is the scene's
        moves = np.zeros((2 * len(q), len(moving.columns)))
        if moving.along.any():
            moves = _scene_moves(model, moving, q, u)
        if _moves_itself(moving):
            moves = moves + start_moves(model, replace(moving, along=np.zeros_like(moving.along)), q, u, (q, u))
        return moves
    at = at_one(model, moving, 0.0, q)
    n = len(q)
    q_given, u_given = given
    if float(np.max(np.abs(q - q_given), initial=0.0)) > SHUT * max(1.0, model.length):
        raise ValueError(
            f"q0: found a start that is open by {float(np.max(np.abs(model.closure(q_given)), initial=0.0)):.3g} m, "
            "expected one whose loops are shut, by which the run can be derived; take it from model.project or "
            "model.assemble"
        )
    toward_q, toward_u, fixed = moving.q0, moving.u0, moving.along
    drives = at.drive_rows
    if len(drives):  # driven joints are where they are to be, if that is given, and as fast
        placed = drives[_placed(model)]
        toward_q = toward_q - np.linalg.pinv(placed) @ (placed @ toward_q)
        toward_u = toward_u + np.linalg.pinv(drives) @ (_speeds_move(at) - drives @ toward_u)
    closure = at.closure_moves()
    # directions in q0, and parameters: projected in the metric of the mass
    wanted = -(closure[:, :n] @ toward_q + closure[:, 2 * n :] @ fixed)
    q_moves = toward_q + at.response(np.zeros((n, wanted.shape[1])), wanted)
    whole = np.vstack([q_moves, np.zeros_like(q_moves), fixed])
    return np.vstack([q_moves, _projected_rates(at, u, u_given, whole, toward_u)])


def _moves_itself(moving: Moving) -> bool:
    return bool(moving.q0.any() or moving.u0.any())


def _scene_moves(model: Model, moving: Moving, q: FloatArray, u: FloatArray) -> FloatArray:
    """What the scene's start moves by with the parameters."""
    at, n = at_one(model, moving, 0.0, q), len(q)
    own_q, own_u = scene_start(model)
    none = np.zeros((n, len(moving.columns)))
    q_moves = _closed_moves(at, own_q) if model.rows or _placed(model).any() else none
    whole = np.vstack([q_moves, none, moving.along])
    u_moves = _going_moves(at, u, own_u, whole) if model.rows or model.data["drives"] else none
    return _first_link_moves(at, np.vstack([q_moves, u_moves]), u)


def _closed_moves(at: Local, own: FloatArray) -> FloatArray:
    """What a configuration (n, columns) moves by that is closed anew from the scene's ``own``.

    It has W (q - near) + R' nu = 0 and is closed, R being the rows of the closure, of the driven joints whose places
    are given, and of the coordinates that stay: the derivative of both solves the same system with what they miss by.
    """
    model, n, rows, closure = at.model, len(at.q), len(at.model.rows), at.closure_moves()
    closed = closed_anew(model, own)
    R = np.vstack([at.closure_rows, at.drive_rows[closed.placed], np.eye(n)[closed.kept]])
    nu = np.asarray(np.linalg.lstsq(R.T, closed.weights @ (closed.near - at.q), rcond=1e-12)[0], dtype=float)
    # jump: A' lambda - M 0, by q and the arguments
    turned = at.tangent("jump", n + rows, np.zeros(n), ("q", "k"), multipliers=nu[:rows])[:n]
    system = np.block([[closed.weights + turned[:, :n], R.T], [R, np.zeros((len(R), len(R)))]])
    right = -np.vstack([turned[:, 2 * n :], closure[:, 2 * n :], np.zeros((len(R) - rows, closure.shape[1] - 2 * n))])
    return np.asarray(np.linalg.lstsq(system, right, rcond=1e-13)[0][:n] @ at.moving.along)


def _going_moves(at: Local, u: FloatArray, own: FloatArray, whole: FloatArray) -> FloatArray:
    """What rates (n, columns) move by that are set going anew from the scene's ``own``, likewise, where configuration
    and arguments move by ``whole``."""
    model, n, rows = at.model, len(at.q), len(at.model.rows)
    going = going_anew(model, at.q, own)
    R = np.vstack([at.drive_rows, np.eye(n)[going.kept], at.closure_rows])
    y = np.asarray(np.linalg.lstsq(R.T, going.weights @ (going.near - u), rcond=1e-12)[0], dtype=float)
    pulled = at.tangent("jump", n + rows, np.zeros(n), ("q", "k"), multipliers=y[len(R) - rows :])[:n] @ whole
    system = np.block([[going.weights, R.T], [R, np.zeros((len(R), len(R)))]])
    kept = np.zeros((len(going.kept), whole.shape[1]))
    right = np.vstack([-pulled, _speeds_move(at), kept, -at.closure_rates_move(u) @ whole])
    return np.asarray(np.linalg.lstsq(system, right, rcond=1e-13)[0][:n])


def _first_link_moves(at: Local, moves: FloatArray, u: FloatArray) -> FloatArray:
    """The same (2 n, columns) of a start that floats with its first link where it was, whatever its root is: how that
    link's frame moves seen from the root is known by differences."""
    model, q = at.model, at.q
    if not floats_by_another(model):
        return moves
    n = len(q)
    root = [i for i, (kind, _) in enumerate(model.data["coordinates"]) if kind in ("x", "y")]
    shaped = [name for name in at.moving.arguments if name in shape_parameters(model)]
    moves = moves.copy()
    moves[[*root, *(n + i for i in root)]] = 0.0
    for column, change in enumerate(moves.T):
        by = dict(zip(at.moving.arguments, at.moving.along[:, column].tolist(), strict=True))

        def first(h: float, change: FloatArray = change, by: dict[str, float] = by) -> FloatArray:
            other = model.with_parameters({name: model.parameters[name] + h * by[name] for name in shaped})
            state = q + h * change[:n], u + h * change[n:]
            return np.append(other.poses(state[0])[0, :2], other.velocities(*state)[0, :2])

        h = STEP / max(1e-300, float(np.max(np.abs(change))), max((abs(by[name]) for name in shaped), default=0.0))
        near, far = ((first(k * h) - first(-k * h)) / (2.0 * k * h) for k in (1.0, 2.0))
        moves[[*root, *(n + i for i in root)], column] = -(4.0 * near - far) / 3.0
    return moves


def _placed(model: Model) -> NDArray[np.bool_]:
    """Which drives say where their joint is at the start; the others take it on from anywhere."""
    return np.array([drive["position"] is not None for drive in model.data["drives"]], dtype=bool)


def _projected_rates(
    at: Local, u: FloatArray, u_given: FloatArray, whole: FloatArray, toward: FloatArray
) -> FloatArray:
    """What the rates (n, columns) of a start that was given move by: as little off the given ones as shuts the loops,
    in the metric of the mass, driven joints held."""
    model, n, rows = at.model, len(at.q), len(at.model.rows)
    turned = at.closure_rates_move(u)
    bent = turned[:, :n] @ whole[:n] + turned[:, 2 * n :] @ whole[2 * n :]
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
