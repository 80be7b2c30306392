"""What models cost in time, measured in turn: a round takes every model once, so that what else the machine does at
that moment falls on all of them, and only figures of the same round are subtracted."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray
from ..model.model import Model
from ..run import Run
from ..simulate import simulate

BATCH = 2e-4
"""Seconds of one batch of evaluations: long beside the clock, short beside what disturbs it."""
STATES = 64
"""States of a run that evaluations cycle through."""
FEWEST, MOST = 3, 40
"""Rounds of runs, whatever they take."""


@dataclass(frozen=True)
class Price:
    """A cost without and with something: the least of all rounds; the median of what it adds, round by round, and the
    half of the middle half of those differences."""

    without: float
    with_: float
    added: float
    spread: float


def price(without: FloatArray, with_: FloatArray) -> Price:
    """The price from two rows of measurements of the same rounds, (rounds,) each, in their unit."""
    low, middle, high = np.percentile(with_ - without, [25, 50, 75])
    return Price(float(without.min()), float(with_.min()), float(middle), float(high - low) / 2)


def sample(run: Run) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times (b,), q (b, nq) and u (b, nu) of up to :data:`STATES` rows of a run, evenly spread."""
    rows = np.unique(np.linspace(0, run.t.size - 1, STATES).astype(int))
    t, q, u = (np.ascontiguousarray(array[rows], dtype=float) for array in (run.t, run.q, run.u))
    return t, q, u


def evaluation_times(models: Sequence[Model], run: Run, rounds: int = 200) -> FloatArray:
    """Seconds of one acceleration kernel of each model at the states of ``run``, (models, rounds).

    The coordinates of the models are among those of the run; their inputs are zero.
    """
    t, q, u = sample(run)
    calls, states = [], []
    for model in models:
        own = _columns(run.model.q_names, model.q_names), _columns(run.model.u_names, model.u_names)
        states.append((np.ascontiguousarray(q[:, own[0]]), np.ascontiguousarray(u[:, own[1]])))
        count = len(t)
        while _batch(model, t, *states[-1], count) < BATCH:
            count *= 2
        calls.append(count)
    tried = list(zip(models, states, calls, strict=True))
    rows = [[_batch(m, t, *state, n) / n for m, state, n in tried] for _ in range(rounds)]
    return np.array(rows).T


def _columns(names: Sequence[str], wanted: Sequence[str]) -> list[int]:
    return [names.index(name) for name in wanted]


def _batch(model: Model, t: FloatArray, q: FloatArray, u: FloatArray, calls: int) -> float:
    """Seconds of ``calls`` evaluations, compiled and without the GIL."""
    start = time.perf_counter()
    model.kernels.repeat_acceleration(t, q, u, calls)
    return time.perf_counter() - start


def run_times(models: Sequence[Model], budget: float = 2.0) -> tuple[tuple[Run, ...], FloatArray]:
    """The run of each model as its scene asks for it, and the seconds of each, (models, rounds).

    A figure is that of the whole call of ``simulate``. ``budget`` (s) is about what all rounds together may take.
    """
    first = [_timed(model) for model in models]
    rounds = int(np.clip(budget / sum(seconds for _, seconds in first), FEWEST, MOST))
    rows = [[_timed(model)[1] for model in models] for _ in range(rounds)]
    return tuple(run for run, _ in first), np.array(rows).T


def _timed(model: Model) -> tuple[Run, float]:
    start = time.perf_counter()
    run = simulate(model)
    return run, time.perf_counter() - start
