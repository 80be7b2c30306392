"""The consistent configuration nearest to a given one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .frames import FloatArray

PASSES = 200


def nearest_closed(
    closure: Callable[[FloatArray], FloatArray],
    jacobian: Callable[[FloatArray], FloatArray],
    displacements: FloatArray,
    start: FloatArray,
) -> FloatArray:
    """The q (n,) that minimises |T (q − start)| under closure(q) = 0, for the linear map ``displacements`` T (m, n).

    Each pass takes the nearest point to ``start`` on the closure linearised where the last pass ended (a least-norm
    problem, so dependent rows do no harm), shortened while that would open the loops further. A fixed point satisfies
    the conditions of the constrained minimum. Raises ``ValueError`` with the miss that remains when loops stay open.
    """
    root = np.linalg.cholesky(displacements.T @ displacements)
    q, miss = start.copy(), float(np.max(np.abs(closure(start))))
    rounding = rounding_of(jacobian(start), start)
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
