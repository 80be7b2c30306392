"""Some runs of a plan, made here or by a worker elsewhere, as columns."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..ensemble.ensemble import ensemble
from ..ensemble.table import INTERRUPTED, REFUSED
from ..model.model import Model
from .plan import Plan
from .source import Source, build_here, model_of
from .starts import start_names, starts_of


class Chunk(NamedTuple):
    """Runs one after the other from the number ``first`` on: what varies, ``numbers`` (runs,) by name, and what is
    asked of them."""

    first: int
    numbers: Mapping[str, FloatArray]
    observe: tuple[str, ...]
    at: tuple[float, ...] | None
    run: Mapping[str, Any]

    @property
    def last(self) -> int:
        """The number of the run behind them."""
        return self.first + len(next(iter(self.numbers.values())))


def chunk_of(plan: Plan, first: int, last: int) -> Chunk:
    """The runs ``first`` to ``last`` of a plan."""
    return Chunk(first, plan.rows(first, last), plan.observe, plan.at, plan.run)


def make_chunk(model: Model, chunk: Chunk, threads: int | None = None) -> dict[str, Any]:
    """The runs of a chunk: columns of the table by name, each (runs, ...); ``reason`` is a list of sentences.

    The same whatever runs are made beside them. Raises ``KeyboardInterrupt`` at Ctrl-C."""
    numbers, starts = chunk.numbers, start_names(model)
    params = {name: values for name, values in numbers.items() if name not in starts}
    wanted = {name: values for name, values in numbers.items() if name in starts}
    q, u, faults = starts_of(model, params, wanted)
    made = ensemble(model, params, q, u, observe=chunk.observe, at=chunk.at, threads=threads, **chunk.run)
    reason = list(made.reason)
    for run, why in faults.items():
        assert made.status[run] == REFUSED
        reason[run] = f"start: {why}"
    assert INTERRUPTED not in made.status
    columns = {
        "run": np.arange(chunk.first, chunk.last),
        **numbers,
        "status": made.status,
        "reason": reason,
        "t": made.t,
    }
    observed = {name: values for name, values in made.columns.items() if name != "impacts"}  # which is always there
    return columns | {"steps": made.steps, "impacts": made.impacts} | observed


def make_elsewhere(source: Source, chunk: Chunk, threads: int) -> tuple[dict[str, Any], float, dict[str, Any]]:
    """Columns of a chunk, the seconds that its runs took, in the process of a worker, and what built the model there.

    Raises :class:`~.source.NoModelError` where the model cannot be loaded there."""
    model = model_of(source)
    began = time.perf_counter()
    return make_chunk(model, chunk, threads), time.perf_counter() - began, build_here(source)
