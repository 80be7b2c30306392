"""Some runs of a plan, made here or by a worker elsewhere, as columns."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..ensemble.ensemble import ensemble
from ..ensemble.table import INTERRUPTED, REFUSED
from ..model.model import Model
from .plan import Plan
from .starts import start_names, starts_of


def make_chunk(model: Model, plan: Plan, first: int, last: int, threads: int | None = None) -> dict[str, Any]:
    """The runs ``first`` to ``last`` of a plan: columns of the table by name, each (last - first, ...); ``reason`` is a
    list of sentences.

    The same whatever runs are made beside them. Raises ``KeyboardInterrupt`` at Ctrl-C."""
    numbers, starts = plan.rows(first, last), start_names(model)
    params = {name: values for name, values in numbers.items() if name not in starts}
    wanted = {name: values for name, values in numbers.items() if name in starts}
    q, u, faults = starts_of(model, params, wanted)
    made = ensemble(model, params, q, u, observe=plan.observe, at=plan.at, threads=threads, **plan.run)
    reason = list(made.reason)
    for run, why in faults.items():
        assert made.status[run] == REFUSED
        reason[run] = f"start: {why}"
    assert INTERRUPTED not in made.status
    columns = {"run": np.arange(first, last), **numbers, "status": made.status, "reason": reason, "t": made.t}
    observed = {name: values for name, values in made.columns.items() if name != "impacts"}  # which is always there
    return columns | {"steps": made.steps, "impacts": made.impacts} | observed
