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
    rounding = 64 * float(np.finfo(start.dtype).eps) * max(1.0, float(np.max(np.abs(jacobian(start)))))
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
