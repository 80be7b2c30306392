"""The nearest consistent configuration, in joint displacements, and the nearest state on the closure."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from .geometry import Geometry

PASSES = 200

RANK = 1e-12
"""Singular values of rows below this part of the largest are zero."""

STANDS = 1e-13
"""Steps (rad, m) as short as this are the rounding of coordinates about 1."""

POLISHES = 3
"""Corrections by what is left, each of which brings sixteen digits more."""

LONGEST = 0.3
"""No step of Newton's method moves a coordinate by more (rad, m): it is to stay on the branch on which it begins."""

DIFFERENCE = 1e-5
"""Of differences of rows (rad, m): near the cube root of rounding, at which central ones know ten digits."""

UNPROJECTED = {
    "not_closed": "it is too far from closed; assemble it first",
    "not_finite": "its closure is not a finite number; check the parameters",
}


def assemble(model: Geometry, q: ArrayLike) -> FloatArray:
    """The consistent configuration nearest to ``q`` (or to each of a batch); ``ValueError`` where none is found."""
    states, single = model._batch(q, "q", len(model.q_names))
    if not model.rows:
        return states[0].copy() if single else states.copy()
    found = np.array([nearest_closed(model.closure, model.jacobian, model.displacements(), one) for one in states])
    return found[0] if single else found


def project(model: Geometry, q: ArrayLike, u: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """The state on the closure nearest to (q, u), or to each of a batch. Raises ``ValueError`` where none is found."""
    states, single = model._state(q, u)
    new_q, new_u = put_onto_closure(model, *states, single=single)
    return (new_q[0], new_u[0]) if single else (new_q, new_u)


def put_onto_closure(model: Geometry, q: FloatArray, u: FloatArray, *, single: bool) -> tuple[FloatArray, FloatArray]:
    """The same of states (b, n) that are known to be numbers; ``single`` says whether a caller knows of one alone."""
    new_q, new_u, outcomes = model.kernels.project(q, u)
    for index, outcome in enumerate(outcomes):
        if outcome != "done":
            which = "the state" if single else f"state {index}"
            raise ValueError(f"{model.name}: {which} cannot be put onto the closure: {UNPROJECTED[outcome]}")
    return new_q, new_u


def nearest_closed(
    closure: Callable[[FloatArray], FloatArray],
    jacobian: Callable[[FloatArray], FloatArray],
    displacements: FloatArray,
    start: FloatArray,
    begin: FloatArray | None = None,
) -> FloatArray:
    """The q (n,) that minimises |T (q − start)| under closure(q) = 0, for the linear map ``displacements`` T (m, n).

    Each pass takes the nearest point to ``start`` on the closure linearised where the last pass ended (a least-norm
    problem, so dependent rows do no harm), shortened while that would open the loops further. A fixed point satisfies
    the conditions of the constrained minimum. Passes begin at ``start``, or at ``begin``. Raises ``ValueError`` with
    the miss that remains when loops stay open.
    """
    root = np.linalg.cholesky(displacements.T @ displacements)
    q = (start if begin is None else begin).copy()
    miss, rounding = float(np.max(np.abs(closure(q)))), rounding_of(jacobian(q), q)
    for _ in range(PASSES):
        a = np.asarray(jacobian(q), dtype=float)  # the last digits come from the passes, not from the solution
        scaled = np.linalg.solve(root, a.T).T
        wanted = a @ (q - start) - closure(q)
        step = np.linalg.lstsq(scaled, np.asarray(wanted, dtype=float), rcond=1e-12)[0]
        target = start + np.linalg.solve(root.T, step)
        part = 1.0
        while part > 1e-3 and np.max(np.abs(closure(q + part * (target - q)))) > max(2.0 * miss, rounding):
            part /= 2
        change = part * (target - q)
        q = q + change
        miss = float(np.max(np.abs(closure(q))))
        if miss <= rounding and np.max(np.abs(change)) <= 1e-13 * (1.0 + np.max(np.abs(q))):
            return q
    for _ in range(POLISHES):  # wide numbers have digits that no solution in doubles for all of the way has
        if miss <= rounding:
            return q
        a, gap = np.asarray(jacobian(q), dtype=float), closure(q)
        size = float(np.max(np.abs(gap))) or 1.0
        step = np.linalg.lstsq(np.linalg.solve(root, a.T).T, np.asarray(gap / size, dtype=float), rcond=1e-12)[0]
        q = q - size * np.linalg.solve(root.T, step)
        miss = float(np.max(np.abs(closure(q))))
    if miss <= rounding:
        return q
    raise ValueError(f"the loops cannot be closed from here: the cut joints still miss by {miss:.3g} m")


def least_weighted(
    misses: Callable[[FloatArray], FloatArray],
    rows: Callable[[FloatArray], FloatArray],
    weights: FloatArray,
    near: FloatArray,
    begin: FloatArray,
) -> FloatArray | None:
    """The q (n,) at which Σ w (q − near)² is least under misses(q) = 0, of those about ``begin``, or None where
    Newton's method on the conditions of the constrained minimum does not get to one.

    ``rows`` are derivatives of the misses, ``weights`` (n, n). How the rows turn is known by differences: that decides
    how fast the steps come in, not where they end.
    """
    q = begin.copy()
    for _ in range(PASSES):
        a, missed = np.asarray(rows(q), dtype=float), np.asarray(misses(q), dtype=float)
        pull = np.asarray(weights @ (near - q), dtype=float)
        curved = weights + _turned(rows, q, np.linalg.lstsq(a.T, pull, rcond=RANK)[0])
        _, sizes, axes = np.linalg.svd(a)
        free = axes[np.count_nonzero(sizes > RANK * sizes.max(initial=0.0)) :].T
        step = -np.linalg.lstsq(a, missed, rcond=RANK)[0]
        bent = free.T @ curved @ free
        step = step + free @ np.linalg.lstsq(bent, free.T @ (pull - curved @ step), rcond=RANK)[0]
        largest = float(np.max(np.abs(step)))
        if largest <= STANDS * (1.0 + float(np.max(np.abs(q)))) and float(np.max(np.abs(missed))) <= rounding_of(a, q):
            return q if not bent.size or np.linalg.eigvalsh(bent)[0] > 0.0 else None
        q = q + step * min(1.0, LONGEST / max(largest, 1e-300))
    return None


def _turned(rows: Callable[[FloatArray], FloatArray], q: FloatArray, multipliers: FloatArray) -> FloatArray:
    """Derivatives (n, n) of rows' multipliers by q, by central differences."""
    steps = DIFFERENCE * np.eye(len(q), dtype=q.dtype)
    found = [(rows(q + h).T @ multipliers - rows(q - h).T @ multipliers) / (2.0 * DIFFERENCE) for h in steps]
    return np.asarray(np.array(found, dtype=float).T)


def rounding_of(jacobian: FloatArray, q: FloatArray) -> float:
    """What the closure (m) of loops that are shut may miss by rounding.

    A row is a sum of terms no larger than its entries: each term loses some digits where it comes about, and as many as
    its angle has turns, since an angle's last digit moves the end of its arm; adding them up loses as many as the root
    of their number, of what all of them are together.
    """
    arms = np.abs(jacobian)
    digits = arms @ (16.0 + np.abs(q)) + np.sqrt(np.count_nonzero(arms, axis=1)) * arms.sum(axis=1)
    return float(np.finfo(q.dtype).eps) * max(64.0, float(np.max(digits)))
