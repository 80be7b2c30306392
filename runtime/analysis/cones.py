"""Small problems on cones in NumPy: non-negative least squares, the point of a polyhedron that is nearest to the
origin, and how far a linear function goes on one.

The first two are those of C. L. Lawson, R. J. Hanson, Solving Least Squares Problems, 1974, chapter 23; the third is
the simplex method with Bland's rule, which cannot cycle (R. G. Bland, Mathematics of Operations Research 2, 1977).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray

BoolArray = NDArray[np.bool_]

ROUNDING = 1e-13
"""Gradients below this part of what is to be reached are rounding."""
DEPENDENT = 1e-10
"""Parts of unit columns across others, and shares in them, below this are rounding."""
PASSES = 30
"""Per column; far more than ever needed."""


def nonnegative(a: FloatArray, b: FloatArray) -> FloatArray:
    """The x (n,) >= 0 that minimises |a x − b| for a (m, n), b (m,); columns where it is positive are independent."""
    size = np.linalg.norm(a, axis=0)
    usable = size > 0.0
    unit = a / np.where(usable, size, 1.0)
    least = ROUNDING * float(np.linalg.norm(b))
    x, used = np.zeros(a.shape[1]), np.zeros(a.shape[1], dtype=bool)
    barred = ~usable
    for _ in range(PASSES * (len(x) + 1)):
        slope = np.where(used | barred, -math.inf, unit.T @ (b - unit @ x))
        enter = int(np.argmax(slope)) if len(x) else -1
        if enter < 0 or slope[enter] <= least:
            break
        used[enter] = True
        gone = _bring_down(unit, b, x, used, enter)
        barred = ~usable if not gone else barred | (np.arange(len(x)) == enter)
    return np.asarray(x / np.where(usable, size, 1.0), dtype=float)


def _bring_down(a: FloatArray, b: FloatArray, x: FloatArray, used: BoolArray, enter: int) -> bool:
    """Least squares over the columns in use, those that would become negative left out on the way, in place.

    Says whether the column that entered had to leave at once: then nothing is won by it, but by rounding.
    """
    while True:
        target = np.zeros(len(x))
        target[used] = np.linalg.lstsq(a[:, used], b, rcond=None)[0]
        if target[enter] <= 0.0 and x[enter] == 0.0:
            used[enter] = False
            return True
        falling = used & (target <= 0.0)
        if not np.any(falling):
            x[:] = target
            return False
        parts = x[falling] / (x[falling] - target[falling])
        x += float(np.min(parts)) * (target - x)
        used[np.flatnonzero(falling)[parts <= np.min(parts)]] = False
        x[~used] = 0.0


def least_distance(g: FloatArray, h: FloatArray) -> FloatArray | None:
    """The shortest x (n,) with g x >= h for g (m, n) and h (m,); ``None`` where there is none."""
    size = np.linalg.norm(g, axis=1)
    far = float(np.max(h / np.where(size > 0.0, size, 1.0), initial=0.0))
    if far <= 0.0:
        return np.zeros(g.shape[1])
    rows, wanted = g / np.where(size > 0.0, size, 1.0)[:, None], h / np.where(size > 0.0, size, 1.0) / far
    stacked = np.vstack([rows.T, wanted])
    shares = nonnegative(stacked, np.append(np.zeros(g.shape[1]), 1.0))
    if 1.0 - float(wanted @ shares) <= DEPENDENT:
        return None
    active = shares > 0.0
    return np.asarray(far * np.linalg.lstsq(rows[active], wanted[active], rcond=None)[0], dtype=float)


def farthest(a: FloatArray, x: FloatArray, c: FloatArray) -> tuple[float, FloatArray]:
    """The largest c·y over y >= 0 with a y = a x, and a y that has it, for a (m, n), c (n,).

    ``x`` (n,) >= 0 has independent columns where it is positive, as :func:`nonnegative` leaves it. Where there is no
    largest the value is infinite, and y is on the way there.
    """
    size = np.linalg.norm(a, axis=0)
    scale = np.where(size > 0.0, size, 1.0)
    left, values, _ = np.linalg.svd(a / scale, full_matrices=False)
    rows = left[:, values > DEPENDENT * max(values[0], 1.0)].T @ (a / scale) if values.size else np.zeros((0, len(x)))
    cost, y = c / scale, x * scale
    basis = _basis(rows, y)
    most = DEPENDENT * float(np.max(np.abs(cost), initial=0.0))
    for _ in range(PASSES * (len(y) + 1)):
        prices = np.linalg.solve(rows[:, basis].T, cost[basis])
        gain = cost - rows.T @ prices
        gain[basis] = 0.0
        entering = np.flatnonzero(gain > most)
        if not entering.size:
            break
        enter = int(entering[0])
        change = np.linalg.solve(rows[:, basis], rows[:, enter])
        falling = np.flatnonzero(change > DEPENDENT)
        if not falling.size:
            along = max(float(np.max(y)), 1.0)
            y[basis] -= along * change
            y[enter] += along
            return math.inf, np.maximum(y, 0.0) / scale
        parts = y[basis][falling] / change[falling]
        leave = min(falling[parts <= np.min(parts)], key=lambda k: basis[k])
        y[basis] = np.maximum(y[basis] - float(np.min(parts)) * change, 0.0)
        y[enter], y[basis[leave]] = float(np.min(parts)), 0.0
        basis[leave] = enter
    return float(cost @ y), y / scale


def _basis(rows: FloatArray, y: FloatArray) -> list[int]:
    """Columns of ``rows`` (rank, n) that span its range: those where ``y`` is positive, and others."""
    chosen: list[int] = []
    across = np.eye(len(rows))
    for k in [*np.flatnonzero(y > 0.0), *np.flatnonzero(y <= 0.0)]:
        part = across @ rows[:, k]
        length = float(np.linalg.norm(part))
        if len(chosen) < len(rows) and length > DEPENDENT:
            chosen.append(int(k))
            across = across - np.outer(part, part) / length**2
    return chosen
