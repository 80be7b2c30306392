"""Units of the columns of a sweep's table."""

from __future__ import annotations

from ..ensemble.observed import column_of
from ..ensemble.units import units_of_columns
from ..model.model import Model
from .plan import Plan
from .starts import AT_START, start_names
from .written import UNITS


def units_of_table(model: Model, plan: Plan) -> dict[str, str]:
    """The unit of each column that has one, by name; "SI" of parameters, whose kind the model does not know."""
    starts = start_names(model)
    varied = {name: _of_start(name) if name in starts else "SI" for name in plan.names}
    observed = units_of_columns(model, [column_of(name) for name in plan.observe])
    return {**varied, "t": "s", "steps": "1", "impacts": "1", **observed}


def _of_start(name: str) -> str:
    """The unit of a coordinate of the start, or of its rate."""
    return UNITS[name.removesuffix(AT_START).rpartition(".")[2]]
