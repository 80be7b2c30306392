"""Derivatives of runs by differences of runs in wide numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ccgen.runtime import simulate

from ..oracles.maximal import WIDE, Array
from .derivative_checks import difference

STEP = 2.0**-18
"""Of the differences: their error falls with its sixth power, and what rounding leaves, 1e-18 of a run, is divided by
it."""

FOURTH = 1e-8
"""What differences of the fourth order may miss, in parts: those of the sixth then miss about its power of 3/2."""

RTOL = 1e-13
"""Of runs whose derivatives are looked at: these are then known to as much."""


def along(
    wide: Any, model: Any, wrt: Mapping[str, Array], until: float, q0: Array | None = None, u0: Array | None = None
) -> Array:
    """By what the end (q, u) of a run and the times of its impacts change, (2 n + impacts, columns), along
    directions."""
    counts = {np.shape(value)[-1] for value in wrt.values()}

    def end(column: int, h: float) -> Array:
        moved = {name: WIDE(h) * np.asarray(value)[..., column] for name, value in wrt.items()}
        values = {name: model.parameters[name] + step for name, step in moved.items() if name not in ("q0", "u0")}
        start = [None if one is None else np.asarray(one, dtype=WIDE) for one in (q0, u0)]
        for k, name in enumerate(("q0", "u0")):
            if name in moved:
                own = model.start()[k] if start[k] is None else start[k]
                start[k] = np.asarray(own, dtype=WIDE) + moved[name]
        run = simulate(wide.with_parameters(values), *start, until=until, rtol=1e-18)
        assert run.success
        return np.concatenate([run.q[-1], run.u[-1], np.array([impact.t for impact in run.impacts], dtype=WIDE)])

    columns = [_settled(one_column(end, k)) for k in range(counts.pop())]
    return np.asarray(np.array(columns).T, dtype=float)


def _settled(end: Callable[[float], Array]) -> Array:
    """The derivative at zero, by steps short enough for how much an end changes: with them errors of the fourth order
    are so small that those of the sixth are not seen. Of steps that are never so short, the best."""
    best, off = np.array([]), np.inf
    for step in (STEP, STEP / 8, STEP / 64, STEP / 512):
        ends: dict[float, Array] = {}
        found = difference(lambda h, ends=ends: ends.setdefault(h, end(h)), step)
        near, far = ((ends[h] - ends[-h]) / (2 * WIDE(h)) for h in (step, 2 * step))
        missed = float(np.max(np.abs(found - (4 * near - far) / 3)) / max(1e-9, np.max(np.abs(found))))
        if missed < off:
            best, off = found, missed
        if off <= FOURTH:
            break
    return best


def one_column(end: Callable[[int, float], Array], column: int) -> Callable[[float], Array]:
    return lambda h: end(column, h)


def unit_directions(names: Sequence[str]) -> dict[str, Array]:
    """Parameters one by one."""
    return {name: np.eye(len(names))[k] for k, name in enumerate(names)}


def relative(found: Array, wanted: Array) -> float:
    """The largest difference, of each column in parts of its largest number, or of one where that may be rounding."""
    size = np.max(np.abs(wanted), axis=0)
    return float(np.max(np.max(np.abs(found - wanted), axis=0) / np.where(size > 1e-9, size, 1.0)))
