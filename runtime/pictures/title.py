"""What stands over a picture of a run: whose motion it is, and with which values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..record.record import Record

NAMED = 3
"""Values that a title names, the first, before it counts the others: as many as stand in a line."""


def title_of(run: Record, settings: Mapping[str, object] | None = None) -> str:
    """The model's name, and the ``settings`` that the run was asked for with, each value as it was written; those
    parameters that are other than the scene's where none are given. Of many the first three, and how many more."""
    values = dict(settings or _changed(run))
    texts = [f"{value:g}" if isinstance(value, float) else str(value) for value in values.values()]
    told = [f"{path} = {text}" for path, text in zip(values, texts, strict=True)]
    more = [f"and {len(told) - NAMED} more"] if len(told) > NAMED else []
    return ", ".join([run.model.name, *told[:NAMED], *more])


def _changed(run: Record) -> dict[str, float]:
    """The parameters with other values than in the scene; none of a model that says nothing of its parameters."""
    model: Any = run.model
    if not hasattr(model, "data"):
        return {}
    declared = {one["path"]: one["value"] for one in model.data["parameters"]}
    return {path: value for path, value in model.parameters.items() if value != declared.get(path, value)}
