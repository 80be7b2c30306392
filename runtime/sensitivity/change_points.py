"""Change points that a run has passed, at which motions part from which there is no derivative.

There closure rows A lose rank: with y^T A = 0, two branches of the motion cross. What changes the closure by c with
y^T c other than zero parts them: the motion goes on from one to the other, or turns back, and how it goes on is no
smooth function of that (docs/theory.md, section 11.5).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import FloatArray
from ..model.model import Model
from ..record.record import Record
from .local import Places, at_one
from .moving import Moving
from .steps import Steps

KNOWN = 1e-6
"""Where rows lose rank is found by the squares of their singular values, which are known to rounding of the largest:
they themselves to its root, and some of these by which steps towards the least end."""

INDEPENDENT = 1e-9
"""Rows are independent, somewhere on the way, with a least singular value above this part of the largest."""

DIPS = 0.8
"""Three squares of a singular value lie on a parabola whose least value is below this part of that in the middle where
rows may lose rank between them. Where they are those of a line it is zero; of sines 1 rad apart 0.71 at most."""

LOOKS = 40
"""Steps towards the least singular value: it takes ten or so, by halving at the worst thirty."""

UNMOVED = 1e-9
"""A column leaves a change point where it is if it changes the closure there by less than this part of what moves."""


def refuse_parted(run: Record, model: Model, moving: Moving, steps: Steps) -> None:
    """Raise ``ValueError`` where a run, of which these are all ``steps``, passes a change point from which a column
    parts the branches."""
    if not moving.arguments or not model.rows or not len(steps.t):
        return
    looked, q = _on_the_way(steps)
    states = moving.states
    moves = Places(model, moving, looked, q).closure_moves()[:, :, states:] @ moving.along
    if not moves.any():
        return

    def singular(t: float) -> FloatArray:
        return np.asarray(_singular_values(model, run.at(t)[0][None])[0])

    values = _singular_values(model, q)
    rank = int(np.max(np.count_nonzero(values > INDEPENDENT * values[:, :1], axis=1)))
    if not rank:
        return
    for t in losses(looked, values, rank, singular):
        at = at_one(model, moving, t, run.at(t)[0])
        left, sizes, _ = np.linalg.svd(at.closure_rows * model.coordinate_units)
        freed = left[:, np.count_nonzero(sizes > KNOWN * sizes[0]) :].T
        change = at.closure_moves()[:, states:] @ moving.along
        opened = np.max(np.abs(freed @ change), axis=0)
        size = np.max(np.abs(change), axis=0)
        if np.any(opened > UNMOVED * size):
            column = moving.columns[int(np.argmax(opened - UNMOVED * size))]
            raise ValueError(
                f"{model.name}: found a change point at t = {t:.9g} s, at which loops can go on in two ways, and "
                f"{column}, which parts them; there is no derivative by it from there on: end the run before"
            )


def _on_the_way(steps: Steps) -> tuple[FloatArray, FloatArray]:
    """Times (b,) that grow and coordinates (b, n) there: the ends of all steps, and between them what these tell. A
    step of a rounding of its time has no middle."""
    h = steps.h[:, None]
    middle = (steps.q + steps.q1) / 2.0 + h / 8.0 * (steps.u - steps.u1)  # the cubic of Hermite
    t = np.stack([steps.t, steps.t + steps.h / 2.0], axis=1).ravel()
    q = np.stack([steps.q, middle], axis=1).reshape(len(t), -1)
    times, first = np.unique(np.append(t, steps.t[-1] + steps.h[-1]), return_index=True)
    return times, np.concatenate([q, steps.q1[-1:]])[first]


def _singular_values(model: Model, q: FloatArray) -> FloatArray:
    """Those of the closure rows at q (b, n), from the largest on, (b, rows)."""
    rows = np.asarray(model.jacobian(q)) * model.coordinate_units
    return np.asarray(np.linalg.svd(rows, compute_uv=False))


def losses(times: FloatArray, values: FloatArray, rank: int, singular: Callable[[float], FloatArray]) -> list[float]:
    """The times at which the singular value that is number ``rank`` vanishes, of ``values`` (b, rows) at ``times``."""
    squares, largest = values[:, rank - 1] ** 2, values[:, 0].max()
    found = []
    for k in range(len(times)):
        around = slice(max(k - 1, 0), k + 2)
        if squares[k] > squares[around].min() or (k and squares[k] == squares[k - 1]):
            continue
        if squares[k] <= (KNOWN * largest) ** 2:
            found.append(float(times[k]))
        elif 0 < k < len(times) - 1 and _least(times[around], squares[around])[1] < DIPS * squares[k]:
            t, square = _towards(times[around], squares[around], rank, singular)
            if square <= (KNOWN * largest) ** 2:
                found.append(t)
    return found


def _least(t: FloatArray, y: FloatArray) -> tuple[float, float]:
    """Where the parabola through three points is least, and how large it is there."""
    first, second = (y[1] - y[0]) / (t[1] - t[0]), (y[2] - y[1]) / (t[2] - t[1])
    bend = (second - first) / (t[2] - t[0])
    slope = first + bend * (t[1] - t[0])  # at t[1]
    if bend <= 0.0:
        return float(t[1]), float(y[1])
    return float(t[1] - 0.5 * slope / bend), float(y[1] - 0.25 * slope**2 / bend)


def _towards(t: FloatArray, y: FloatArray, rank: int, singular: Callable[[float], FloatArray]) -> tuple[float, float]:
    """Where the square of a singular value is least between three times, the second value being less than the others,
    by parabolas, and by halving the longer side where these do not lead there; its value there."""
    t, y = t.copy(), y.copy()
    for look in range(LOOKS):
        new = _least(t, y)[0]
        near = 1e-9 * (t[2] - t[0])
        if look % 3 == 2 or not t[0] + near < new < t[2] - near:
            new = float(t[0] + t[1] if t[1] - t[0] > t[2] - t[1] else t[1] + t[2]) / 2.0
        if abs(new - t[1]) <= 4.0 * np.finfo(float).eps * abs(t[1]):
            break
        square = float(singular(new)[rank - 1] ** 2)
        side = 0 if new < t[1] else 2
        if square < y[1]:
            t[2 - side], y[2 - side] = t[1], y[1]
            t[1], y[1] = new, square
        else:
            t[side], y[side] = new, square
    return float(t[1]), float(y[1])
