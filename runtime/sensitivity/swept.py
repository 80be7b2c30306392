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
from .passing import Check, Instant, Passed
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

    def alike(self, parts: Sequence[object]) -> int:
        """How many of the ``parts`` that begin with this one are steps of the same sweeps, one after the other."""
        for k, part in enumerate(parts):
            if not (isinstance(part, Swept) and part.sweeps is self.sweeps and part.number == self.number + k):
                return k
        return len(parts)

    def through(self, whole: FloatArray, count: int = 1) -> FloatArray:
        """Differences (2 n, columns) behind ``count`` steps from this one on, of those (D, columns) before it."""
        found = self.sweeps.carried.through(self.number, whole, count)
        if found is not None:
            return found
        if count == 1:  # sweeps do not contract
            return np.asarray(self.matrix @ whole)
        whole, states = whole.copy(), self.sweeps.moving.states
        for number in range(self.number, self.number + count):
            whole[:states] = Swept(self.sweeps, number).through(whole)
        return whole[:states]


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
