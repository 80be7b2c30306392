"""Units of what is observed of many runs."""

from __future__ import annotations

from collections.abc import Iterable

from ..model.model import Model
from ..record.outputs import named_outputs
from ..record.tables import unit_of_coordinate
from .observed import Column


def units_of_columns(model: Model, columns: Iterable[Column]) -> dict[str, str]:
    """The unit of each column by its name: those of all entries of q and u, as "m, m, rad"; "1" for a number of
    impacts."""
    columns = tuple(columns)
    known = named_outputs(model, (column.output for column in columns if column.output))
    q, u = model.q_names, model.u_names
    fixed = {
        "impacts": "1",
        "impact_times": "s",
        "q": ", ".join(unit_of_coordinate(name) for name in q),
        "u": ", ".join(f"{unit_of_coordinate(name)}/s" for name in u),
    }
    return {column.name: known[column.output].unit if column.output else fixed[column.kind] for column in columns}
