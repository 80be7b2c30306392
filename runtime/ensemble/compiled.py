"""Many runs by the core: nothing of Python is in a run, and nothing is kept of it but what is observed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..faults import sentence
from ..model.inputs import read_values, table_of
from ..model.kinks import kinks_until
from ..model.model import Model
from ..record.outputs import Output, named_outputs
from ..simulation.arguments import DEPTH, RATE_BUDGET, STEP_BUDGET, checked_start, stops_of
from ..simulation.ending import message_of
from ..simulation.one_run import Options
from ..simulation.threads import share
from .numbers import Numbers, prepare, rounding_sample
from .observed import EXTREMES, Observed
from .reduction import Reduction
from .singly import SingleRuns
from .stacked import Apart, Stack, WantsParameters, WantsRun, wants_forces, wants_parameters
from .table import DONE, INTERRUPTED, REFUSED, STOPPED, Ensemble
from .units import units_of_columns

MEMORY = 64e6
"""Bytes of what is observed that are worked on at a time, beside the table itself."""
UNSET = ("cannot_set", "opened", "inside", "too_far", "set_without_end")
"""Ends of runs in which an event has set what cannot be, of ensembles and programs in C alone."""
MOST = 65536
"""Runs at a time."""


def can(model: Model, numbers: Numbers, observed: Observed, until: float) -> bool:
    """Whether the core alone can make these runs."""
    if callable(numbers.inputs):
        return False
    set_by_events = {path for event in model.data.get("events", ()) for path in event["set"]}
    if model.folded and set_by_events:
        return False  # which says so
    if set_by_events & set(model.data["instants"]):
        return False
    if numbers.params and kinks_until(model, until):
        return False  # instants at which steps end are parameters
    if observed.at is None and any(column.kind in EXTREMES for column in observed.columns):
        return False
    try:
        for output in named_outputs(model, observed.outputs).values():
            wants_forces(model, output)
            if varies(model) and wants_parameters(model, output):
                return False
    except WantsRun:
        return False
    return True


def varies(model: Model) -> bool:
    """Whether events set parameters of a model, or switch effects, or joints let go or take hold."""
    return bool(model.joint_gates) or any(
        event["set"] or event["on"] or event["off"] for event in model.data.get("events", ())
    )


class CompiledRuns:
    """Makes runs of one model, part by part."""

    def __init__(
        self,
        model: Model,
        observed: Observed,
        options: Options,
        reduction: Reduction | None,
        asked: dict[str, Any],
    ) -> None:
        self.asked = asked
        self.model, self.observed, self.options, self.reduction = model, observed, options, reduction
        self.units = units_of_columns(model, observed.columns)
        self.outputs = named_outputs(model, observed.outputs)
        self.forces = any(wants_forces(model, output) for output in self.outputs.values())
        self.times = 0 if not self.outputs else 1 if observed.at is None else len(observed.at)

    def _apart(self, numbers: Numbers) -> bool:
        """Whether states have parameters of their own."""
        return bool(numbers.params) or varies(self.model)

    def size(self, numbers: Numbers) -> int:
        """How many runs are made at a time."""
        m, n = self.model, len(self.model.q_names)
        places = 6 * len(m.links) + 2 * len(m.points) + 2 * len(m.contacts) + 2 if self._apart(numbers) else 0
        forces = n + len(m.rows) + 1 + 2 * len(m.contacts) + 3 * len(m.joints) + len(m.told) if self.forces else 0
        state = self.times * (2 * n + places + forces + len(self.outputs))
        row = 8 * (2 * n + 8 + self.observed.impact_times + state + (len(m.parameters) if numbers.params else 0))
        return int(max(1, min(MOST, MEMORY // row)))

    def make(self, numbers: Numbers, threads: int, told: Callable[[int], None] | None) -> tuple[Ensemble, bool]:
        """The table of these runs; whether Ctrl-C let them come to their ends."""
        model, asked = self.model, self.options.settings
        ready = prepare(model, numbers)
        table = numbers.inputs
        constants = isinstance(table, np.ndarray)
        made = model.core.Ensemble(
            model.kernels,
            numbers.count,
            ready.q,
            ready.u,
            method=asked.method,
            until=asked.until,
            rtol=asked.rtol,
            atol=asked.atol,
            fixed_step=asked.step,
            step_budget=STEP_BUDGET,
            rate_budget=RATE_BUDGET,
            kept=asked.drift,
            on_gain=asked.on_gain,
            stops=stops_of(model, self.options.kinks, asked.until, asked.step),
            parameters=ready.parameters,
            scales=ready.scales,
            inputs=table if constants else np.zeros((1, len(model.inputs))) if model.inputs and table is None else None,
            table=table_of(model.inputs, table) if isinstance(table, Mapping) else None,
            projections=ready.projections,
            deepest=DEPTH,
            sample=rounding_sample(model) if numbers.params else None,
            at=self.observed.at if self.outputs else None,
            times=self.times,
            impact_times=self.observed.impact_times,
            places=bool(self.outputs) and self._apart(numbers),
            forces=self.forces,
            reduction=self.reduction and self.reduction.address,
            refused=ready.refused,
        )
        whole = share(made.work, min(threads, numbers.count), made.end, told and (lambda: told(made.done)))
        rows = self._table(numbers, made.answers)
        unset = np.isin(made.answers["outcome"], [model.core.OUTCOMES.index(name) for name in UNSET])
        alone = rows.status == STOPPED if model.data["drives"] or model.joint_gates else unset
        return self._as_alone(numbers, rows, np.flatnonzero(alone).tolist()), whole

    def _as_alone(self, numbers: Numbers, table: Ensemble, runs: Sequence[int]) -> Ensemble:
        """The table with ``runs`` that have stopped as they are alone: at a dead point of a drive, which is told by all
        of a run's rows, some are cut off, and what an event cannot set, or why a joint cannot take hold, is told in
        full. A reduction, which has read rows, is no number there."""
        singly, reasons = SingleRuns(self.model, self.observed, self.asked), list(table.reason)
        for run in runs:
            one, _ = singly.make(numbers.part(run, run + 1), 1, None)
            table.status[run], reasons[run] = one.status[0], one.reason[0]
            table.t[run], table.steps[run], table.impacts[run] = one.t[0], one.steps[0], one.impacts[0]
            for name, values in table.columns.items():
                values[run] = one.columns[name][0] if name in one.columns else np.nan
        return replace(table, reason=tuple(reasons))

    def _table(self, numbers: Numbers, found: Mapping[str, Any]) -> Ensemble:
        n = len(self.model.q_names)
        status, reasons = self._ends(numbers, found)
        end, columns = found["end"], dict[str, FloatArray]()
        read = self._read(numbers, found)
        for column in self.observed.columns:
            name, kind = column.name, column.kind
            if kind in ("q", "u"):
                columns[name] = end[:, :n].copy() if kind == "q" else end[:, n : 2 * n].copy()
            elif kind == "impacts":
                columns[name] = found["impacts"].astype(float)
            elif kind == "impact_times":
                columns[name] = found["impact_t"][:, : column.count].copy()
            else:
                values = read[column.output]
                if kind in EXTREMES:
                    values = column.extremes(values)
                elif self.observed.at is None:
                    values = values[:, 0]
                columns[name] = values
        if self.reduction is not None:
            columns[self.reduction.name] = found["reduction"]
        t = np.where(np.isnan(end[:, 2 * n]), 0.0, end[:, 2 * n])
        at = self.observed.at
        return Ensemble(status, reasons, t, found["steps"], found["impacts"], columns, self.units, numbers.params, at)

    def _ends(self, numbers: Numbers, found: Mapping[str, Any]) -> tuple[Any, tuple[str, ...]]:
        """How runs have ended, and of those that have not come to their end the sentence on it."""
        model, asked, n = self.model, self.options.settings, len(self.model.q_names)
        outcomes = model.core.OUTCOMES
        status, reasons = np.full(numbers.count, DONE, dtype="<U11"), [""] * numbers.count
        for run in np.flatnonzero(found["outcome"]).tolist():
            number = int(found["outcome"][run])
            if number == model.core.ROW_NOT_BEGUN:
                status[run], reasons[run] = INTERRUPTED, "not begun: all runs were to stop"
            elif number == model.core.ROW_REFUSED:
                status[run], reasons[run] = REFUSED, self._refusal(numbers, run)
            elif outcomes[number] == "interrupted":
                status[run], reasons[run] = (
                    INTERRUPTED,
                    f"stopped at t = {found['end'][run, 2 * n]:.12g} s: interrupted",
                )
            elif outcomes[number] in UNSET:
                status[run] = STOPPED  # one that is made alone says why
            else:
                other = model.with_parameters(numbers.params_of(run)) if numbers.params else model
                row = found["end"][run : run + 1]
                told = {
                    "t_end": float(np.nan_to_num(row[0, 2 * n])),
                    "outcome": outcomes[number],
                    "contact": int(found["contact"][run]),
                    "q": row[:, :n],
                    "u": row[:, n : 2 * n],
                }
                status[run] = STOPPED
                reasons[run] = message_of(other, asked.until, told, asked.step > 0.0)
        return status, tuple(reasons)

    def _refusal(self, numbers: Numbers, run: int) -> str:
        try:
            model = self.model.with_parameters(numbers.params_of(run)) if numbers.params else self.model
            checked_start(model, *numbers.start_of(run))
            rows = numbers.inputs
            if isinstance(rows, np.ndarray):
                read_values(model.inputs, rows[run if len(rows) > 1 else 0])
        except (ValueError, KeyError, TypeError) as error:
            return sentence(error)
        return "its start cannot be put onto the closure, or is inside a ground"

    # -- outputs by name ----------------------------------------------------------------------------------------------

    def _read(self, numbers: Numbers, found: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        """Values (count, times) of all outputs; not numbers where a run has no state."""
        if not self.outputs:
            return {}
        n, count = len(self.model.q_names), numbers.count
        known = np.flatnonzero(~np.isnan(found["state"][:, 0]))
        state = found["state"][known]
        ends = np.repeat(found["end"][:, 2 * n], self.times)
        t = (ends if self.observed.at is None else np.tile(self.observed.at, count))[known]
        forces = {key: found[key][known] for key in FORCES} if self.forces else None
        q, u = np.ascontiguousarray(state[:, :n]), np.ascontiguousarray(state[:, n:])
        values = {}
        for name, one in zip(self.outputs, self._values(numbers, found, known, (t, q, u), forces), strict=True):
            values[name] = np.full(count * self.times, np.nan, dtype=self.model.core.REAL)
            values[name][known] = one
            values[name] = values[name].reshape(count, self.times)
        return values

    def _values(
        self,
        numbers: Numbers,
        found: Mapping[str, FloatArray],
        known: Any,
        states: tuple[FloatArray, FloatArray, FloatArray],
        forces: Mapping[str, FloatArray] | None,
    ) -> Iterator[FloatArray]:
        """Values (n,) of each output at the states that are ``known``."""
        t, q, u = states
        stack: Stack
        if not self._apart(numbers):
            stack = Stack(self.model, t, q, u, forces)
        else:
            stack = Apart(self.model, t, q, u, {key: found[key][known] for key in PLACES}, forces)
        for output in self.outputs.values():
            try:
                yield np.asarray(output.of(stack))
            except WantsParameters:
                yield self._run_by_run(numbers, known // self.times, states, forces, output)

    def _run_by_run(
        self,
        numbers: Numbers,
        runs: Any,
        states: tuple[FloatArray, FloatArray, FloatArray],
        forces: Mapping[str, FloatArray] | None,
        output: Output,
    ) -> FloatArray:
        """The values of an output that each run's own parameters are needed for."""
        (t, q, u), values = states, np.empty(len(runs), dtype=self.model.core.REAL)
        for run in np.unique(runs).tolist():
            rows = np.flatnonzero(runs == run)
            other = self.model.with_parameters(numbers.params_of(run))
            own = {key: part[rows] for key, part in forces.items()} if forces is not None else None
            values[rows] = output.of(Stack(other, t[rows], q[rows], u[rows], own))
        return values


FORCES = ("u_dot", "multipliers", "push", "reaction", "told")
PLACES = ("pose", "velocity", "point", "energy", "gap", "gap_rate")
