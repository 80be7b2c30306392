"""Many runs by one call of ``simulate`` for each: where there are controllers in Python, events, joints that let go, or
impulses are observed, which the core alone does not do."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import count as counting
from typing import Any

import numpy as np

from ..arrays import BoolArray, FloatArray
from ..faults import sentence
from ..model.model import Model
from ..record.outputs import values_of
from ..run import Run
from ..simulate import simulate
from ..simulation.threads import share
from .numbers import Numbers, outside
from .observed import EXTREMES, Observed
from .table import DONE, INTERRUPTED, REFUSED, STOPPED, Ensemble
from .units import units_of_columns

SIZE = 1024
"""Runs at a time."""


class SingleRuns:
    """Makes runs of one model, part by part."""

    def __init__(self, model: Model, observed: Observed, options: dict[str, Any]) -> None:
        self.model, self.observed, self.options = model, observed, options
        self.units = units_of_columns(model, observed.columns)
        self.width = len(model.q_names)

    def size(self, numbers: Numbers) -> int:
        """How many runs are made at a time."""
        return SIZE

    def make(self, numbers: Numbers, threads: int, told: Callable[[int], None] | None) -> tuple[Ensemble, bool]:
        """The table of these runs; whether Ctrl-C let them come to their ends."""
        rows: list[_Row | None] = [None] * numbers.count
        waiting, ended, wrong = counting(), list[bool](), outside(self.model, numbers)

        def stop_here(t: float) -> None:
            if ended:
                raise KeyboardInterrupt

        def work() -> None:
            while not ended and (run := next(waiting)) < numbers.count:
                rows[run] = self._row(numbers, run, stop_here, bool(wrong[run]))

        def tell() -> None:
            assert told is not None
            told(sum(row is not None for row in rows))

        whole = share(work, min(threads, numbers.count), lambda: ended.append(True), tell if told else None)
        return self._table(
            numbers, [row or _Row(INTERRUPTED, "not begun: all runs were to stop") for row in rows]
        ), whole

    def left(self, numbers: Numbers) -> Ensemble:
        """The table of runs that are not begun."""
        return self._table(numbers, [NOT_BEGUN] * numbers.count)

    def _row(self, numbers: Numbers, run: int, stop_here: Callable[[float], None], wrong: bool) -> _Row:
        q, u = numbers.start_of(run)
        inputs = numbers.inputs
        if isinstance(inputs, np.ndarray):
            inputs = inputs[run if len(inputs) > 1 else 0]
        try:
            model = self.model.with_parameters(numbers.params_of(run)) if numbers.params else self.model
            made = simulate(model, q, u, inputs=inputs, progress=stop_here, keep_interrupted=True, **self.options)
        except (ValueError, KeyError, TypeError) as error:
            if not isinstance(error, ValueError) and not wrong:
                raise
            return _Row(REFUSED, sentence(error))
        if made.success:
            return _Row(DONE, "", *_sizes(made), self._observe(made))
        status = INTERRUPTED if made.message.endswith("interrupted") else STOPPED
        return _Row(status, made.message, *_sizes(made), self._observe(made))

    def _observe(self, run: Run) -> dict[str, FloatArray]:
        observed, found = self.observed, dict[str, FloatArray]()
        at = observed.at
        reached = np.zeros(0, dtype=bool) if at is None else at <= run.t[-1]
        times = run.t[-1:] if at is None else at[reached]
        values = values_of(run, observed.outputs, times) if observed.outputs and times.size else {}
        for column in observed.columns:
            name, kind = column.name, column.kind
            if kind in ("q", "u"):
                found[name] = run.q[-1] if kind == "q" else run.u[-1]
            elif kind == "impacts":
                found[name] = np.array(float(len(run.impacts)))
            elif kind == "impact_times":
                instants = np.array([impact.t for impact in run.impacts], dtype=float)
                found[name] = filled(instants, column.count)
            elif kind in EXTREMES:
                rows = values if at is not None else values_of(run, [column.output])
                found[name] = column.extremes(rows.get(column.output, np.full(1, np.nan))[None])[0]
            else:
                found[name] = values[name][0] if at is None else placed(values.get(name), reached)
        return found

    def _table(self, numbers: Numbers, rows: list[_Row]) -> Ensemble:
        observed, number = self.observed, self.model.core.REAL
        columns = dict[str, FloatArray]()
        for column in observed.columns:
            name, kind = column.name, column.kind
            wide = (self.width,) if kind in ("q", "u") else ()
            if kind == "impact_times":
                wide = (column.count,)
            elif kind == "output" and observed.at is not None:
                wide = (len(observed.at),)
            empty = np.full(wide, np.nan, dtype=number)
            columns[name] = np.array([row.values.get(name, empty) for row in rows], dtype=number)
        return Ensemble(
            np.array([row.status for row in rows], dtype="<U11"),
            tuple(row.reason for row in rows),
            np.array([row.t for row in rows], dtype=number),
            np.array([row.steps for row in rows], dtype=np.int64),
            np.array([row.impacts for row in rows], dtype=np.int64),
            columns,
            self.units,
            numbers.params,
            observed.at,
        )


@dataclass(frozen=True)
class _Row:
    status: str
    reason: str
    t: float = 0.0
    steps: int = 0
    impacts: int = 0
    values: dict[str, FloatArray] = field(default_factory=dict)


NOT_BEGUN = _Row(INTERRUPTED, "not begun: all runs were to stop")


def _sizes(run: Run) -> tuple[float, int, int]:
    return run.t[-1].item(), run.t.size - 1, len(run.impacts)


def filled(values: FloatArray, size: int) -> FloatArray:
    """The first ``size`` numbers, and no numbers behind them where there are fewer."""
    found = np.full(size, np.nan, dtype=values.dtype)
    found[: min(size, len(values))] = values[:size]
    return found


def placed(values: FloatArray | None, where: BoolArray) -> FloatArray:
    """The values where they are known, and no numbers elsewhere."""
    found = np.full(len(where), np.nan, dtype=float if values is None else values.dtype)
    if values is not None:
        found[where] = values
    return found
