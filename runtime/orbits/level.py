"""Sections at which a coordinate passes a value, growing; angles are counted without whole turns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..run import Run

PARTS = 8
"""A step of a run is looked at in so many parts: a coordinate may pass a value and come back within it."""

HALVINGS = 80
"""Halvings of such a part, to rounding of the time."""

LEAVES = 1e-9
"""A run that begins this near to the value, in units of the coordinate, leaves it there and does not come to it."""


@dataclass(frozen=True)
class Level:
    """A ``coordinate`` by number and the ``value`` (rad or m) that it passes, in ``turns`` of 2 pi or at that alone."""

    coordinate: int
    value: float
    turns: bool


def level_times(run: Run, level: Level, unit: float) -> list[float]:
    """When the coordinate of this ``unit`` passes the value, growing, behind the start of a run."""
    found = list[float]()
    whole = 2.0 * np.pi if level.turns else np.inf
    for row in np.flatnonzero(np.diff(run.t) > 0.0).tolist():
        t = np.linspace(run.t[row], run.t[row + 1], PARTS + 1)
        inner = run.at(t[1:-1])[0][:, level.coordinate]
        x = np.array([run.q[row, level.coordinate], *inner, run.q[row + 1, level.coordinate]])
        for k in range(PARTS):
            target = level.value
            if level.turns:
                target += whole * np.floor((x[k + 1] - level.value) / whole)
            if x[k] < target <= x[k + 1]:
                begins = not found and t[k] == run.t[0] and target - x[k] <= LEAVES * unit
                if not begins:
                    found.append(_passed(run, level.coordinate, target, float(t[k]), float(t[k + 1])))
    return found


def _passed(run: Run, coordinate: int, target: float, low: float, high: float) -> float:
    for _ in range(HALVINGS):
        middle = (low + high) / 2.0
        if not low < middle < high:
            break
        if float(run.at(middle)[0][coordinate]) < target:
            low = middle
        else:
            high = middle
    return high
