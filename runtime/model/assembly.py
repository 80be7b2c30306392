"""The nearest consistent configuration, in joint displacements, and the nearest state on the closure."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from .geometry import Geometry

PASSES = 200

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
    if miss <= rounding:
        return q
    raise ValueError(f"the loops cannot be closed from here: the cut joints still miss by {miss:.3g} m")


def rounding_of(jacobian: FloatArray, q: FloatArray) -> float:
    """What the closure (m) of loops that are shut may miss by rounding.

    A row is a sum of terms no larger than its entries: each term loses some digits where it comes about, and as many as
    its angle has turns, since an angle's last digit moves the end of its arm; adding them up loses as many as the root
    of their number, of what all of them are together.
    """
    arms = np.abs(jacobian)
    digits = arms @ (16.0 + np.abs(q)) + np.sqrt(np.count_nonzero(arms, axis=1)) * arms.sum(axis=1)
    return float(np.finfo(q.dtype).eps) * max(64.0, float(np.max(digits)))
