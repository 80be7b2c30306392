"""Newton's method for periodic motions in any number of segments, with or without a free parameter (eq. 12.2, 12.5)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager
from typing import NamedTuple, Protocol

import numpy as np

from ..arrays import FloatArray
from .rank import least_change
from .section import Crossed
from .shooting import Chain, State
from .tolerance import LESS

Trial = Callable[[int, State, float], AbstractContextManager[None]]
"""Around the run from a state that a step led to, at a value of the parameter: to tell of it what is wrong there."""


class Found(NamedTuple):
    """What comes of the nodes that miss least, by how much they do, and the value of the parameter."""

    crossed: tuple[Crossed, ...]
    missed: float
    value: float


class Curve(Protocol):
    """A ``parameter`` that is free, in its ``unit``, and what tells where on the curve of motions one is looked for."""

    parameter: str
    unit: float

    def row(self, crossed: Sequence[Crossed], value: float) -> tuple[FloatArray, float]:
        """By what a place on the curve moves along all directions and the parameter, (m + 1,), and what it is off."""

    def changed(self, value: float, by: float) -> float:
        """The value of the parameter behind a step."""

    def leaves(self, crossed: Sequence[Crossed] | None, value: float) -> bool:
        """Whether a place is too far away to be of this curve; at first of the parameter alone."""


def newton(
    chain: Chain,
    nodes: Sequence[State],
    tolerance: float,
    most: int,
    trial: Trial,
    *,
    enough: float = 0.0,
    curve: Curve | None = None,
    value: float = 0.0,
    about: Sequence[float] | None = None,
) -> tuple[Found | None, int]:
    """The motion near ``nodes`` that misses least after ``most`` steps, and how many were made; None where the curve
    was left.

    It ends with what misses no more than ``enough``, or, within the ``tolerance``, where steps make that no less.
    ``about`` are the times that segments take.
    """
    best: Found | None = None
    parameter, unit = (curve.parameter, curve.unit) if curve else (None, 1.0)
    for step in range(most):
        crossed = list[Crossed]()
        times: Sequence[float | None] = about or [None] * len(nodes)
        for one, node, time in zip(chain.maps, nodes, times, strict=True):
            with trial(step, node, value):
                crossed.append(one.at(*node, parameter, time))
        rest, rows = chain.system(crossed, unit)
        missed = float(np.max(np.abs(rest), initial=0.0))
        if best is not None and best.missed <= tolerance and not missed < best.missed / LESS:
            return best, step
        if best is None or missed < best.missed:
            best = Found(tuple(crossed), missed, value)
        if missed <= enough:
            return best, step
        if curve and curve.leaves(crossed, value):
            return None, step
        change, value = _step(rest, rows, crossed, curve, value)
        if curve and curve.leaves(None, value):
            return None, step
        about = [one.time for one in crossed]
        changes = chain.changes(crossed, change, unit)
        chain, nodes = led(chain, parameter, value, crossed, changes, trial, step + 1)
    return best, most


def led(
    chain: Chain,
    parameter: str | None,
    value: float,
    crossed: Sequence[Crossed],
    changes: Iterable[FloatArray],
    trial: Trial,
    step: int,
) -> tuple[Chain, list[State]]:
    """The segments at a value of the parameter, and the nodes to which ``changes`` (2 n,) of those before lead in a
    step, with all shut that is kept there."""
    nodes = list[State]()
    for k, (here, by) in enumerate(zip(crossed, changes, strict=True)):
        n = len(here.q)
        with trial(step, (here.q + by[:n], here.u + by[n:]), value):
            if parameter is not None and not k:
                chain = chain.of(chain.map.model.with_parameters({parameter: value}))
            nodes.append(chain.maps[k].moved(here, by))
    return chain, nodes


def _step(
    rest: FloatArray, rows: FloatArray, crossed: Sequence[Crossed], curve: Curve | None, value: float
) -> tuple[FloatArray, float]:
    """Newton's step (m + 1,) of least size along the directions of all starts and the parameter, and its value behind
    it. Directions are of length 1: where all of a row is rounding of them, as of motions of any speed that have one
    period, no step is known."""
    if curve is None:
        return np.append(least_change(rows[:, :-1], -rest, 1.0), 0.0), value
    row, off = curve.row(crossed, value)
    step = least_change(np.vstack([rows, row]), -np.append(rest, off), 1.0)
    return step, curve.changed(value, float(step[-1]))
