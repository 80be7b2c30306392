"""Steps that take few differences on: each by sweeps, with no matrix of the step (docs/theory.md, eq. 11.7).

A matrix takes an elimination for each step, whatever there are of columns; sweeps take as many products with the
derivatives at the nodes for each column.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .._core import Carried
from ..arrays import FloatArray
from ..model.forces import Held
from ..model.model import Model
from .moving import Moving
from .passing import Check, Instant, Part, Passed
from .shutting import Shutting
from .steps import Steps, along_nodes, gauss, linear

FEW = 1.5
"""Columns by coordinates: with so many, sweeps in vectors of four numbers take half of the time of elimination for 8
coordinates, and four fifths for 14; with twice as many columns as coordinates they take as long for 14."""

ROOM = 2**23
"""Numbers at most that the derivatives along the steps of a run may be; they are all in memory at one time."""


@dataclass(frozen=True)
class Sweeps:
    """Steps side by side, with the accelerations ``W`` (k, s, n) at their nodes and what puts their ends back."""

    model: Model
    moving: Moving
    held: Held
    steps: Steps
    W: FloatArray
    shutting: Shutting | None
    carried: Carried


@dataclass(frozen=True)
class Swept:
    """One of them: a part of a run, which lets every column pass."""

    sweeps: Sweeps
    number: int
    checks: ClassVar[tuple[Check, ...]] = ()
    passed: ClassVar[Passed | None] = None
    instant: ClassVar[Instant | None] = None

    @property
    def matrix(self) -> FloatArray:
        """What it makes of differences of the state and the arguments, (2 n, D), by elimination."""
        one, which = self.sweeps, slice(self.number, self.number + 1)
        found = linear(one.model, one.moving, one.held, one.steps.some(which), one.W[which])
        return np.asarray((one.shutting.some(which).behind(found) if one.shutting is not None else found)[0])

    def stretch(self, parts: Sequence[Part | Swept]) -> Sequence[Part | Swept]:
        """Those of the ``parts``, which begin with this one, that are steps of the same sweeps one after the other, and
        the instants between them that let every column pass."""
        number, last = self.number, 0
        for k, part in enumerate(parts):
            if isinstance(part, Swept):
                if part.sweeps is not self.sweeps or part.number != number:
                    break
                number, last = number + 1, k + 1
            elif part.checks or part.passed is None:
                break
        return parts[:last]

    def through(self, whole: FloatArray, parts: Sequence[Part | Swept] = ()) -> tuple[FloatArray, FloatArray]:
        """Differences (2 n, columns) behind a stretch of ``parts`` from this one on, or behind this one alone, of those
        (D, columns) before it; and those before each instant on it, (instants, D, columns)."""
        instants = [k for k, part in enumerate(parts) if isinstance(part, Part)]
        before = np.array([k - i for i, k in enumerate(instants)], dtype=np.intp)  # steps until there
        jumps = np.array([parts[k].matrix for k in instants]).reshape(-1, self.sweeps.moving.states, len(whole))
        seen, count = np.empty((len(instants), *whole.shape)), max(len(parts), 1) - len(instants)
        found = self.sweeps.carried.through(self.number, whole, count, before, jumps, seen)
        if found is not None:
            return found, seen
        if len(parts) <= 1:  # sweeps do not contract
            return np.asarray(self.matrix @ whole), seen
        whole, states, passed = whole.copy(), self.sweeps.moving.states, 0
        for part in parts:
            if isinstance(part, Part):
                seen[passed], passed = whole, passed + 1
                whole[:states] = part.through(whole)
            else:
                whole[:states] = part.through(whole)[0]
        return whole[:states], seen


def swept(
    model: Model, moving: Moving, held: Held, steps: Steps, W: FloatArray, shutting: Shutting | None
) -> Sequence[Swept]:
    """Steps with accelerations ``W`` (k, s, n) at their nodes, behind each of which differences are put back by
    ``shutting``."""
    g, J = gauss(), along_nodes(model, moving, held, steps, W)
    carried = Carried(steps.h, (g.c, g.b, g.twice_b, g.A, g.twice), J, shutting.back if shutting is not None else ())
    every = Sweeps(model, moving, held, steps, W, shutting, carried)
    return [Swept(every, number) for number in range(len(steps.t))]


def few(columns: int, steps: int, moving: Moving) -> bool:
    """Whether so many columns are few enough to sweep through the steps of a run."""
    n, D = moving.states // 2, len(moving.directions.columns)
    return columns <= FEW * n and steps * len(gauss().c) * n * D <= ROOM
