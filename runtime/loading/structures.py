"""The models of all that a mechanism comes to where joints let go and take hold."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..model.model import Model
from .load import load_model


def structures_of(model: Model) -> tuple[Model, ...]:
    """The model of the start, and those of all other structures, with the values of its parameters.

    Raises ``FileNotFoundError`` or ``ImportError`` where the package of one is missing, or of another scene.
    """
    return (model, *(_beside(model, said) for said in model.data["switching"]["structures"][1:]))


def _beside(model: Model, said: Mapping[str, Any]) -> Model:
    """The model that lies beside another, with the values of its parameters."""
    folder = model.folder
    if folder is None:
        raise FileNotFoundError(f"{model.name}: found a model without a package, expected one beside those it becomes")
    declared = {one["path"]: one["value"] for one in model.data["parameters"]}
    changed = {path: value for path, value in model.parameters.items() if value != declared[path]}
    other = load_model(folder.parent / said["package"])
    if other.data["hash"] != said["hash"]:
        raise ImportError(
            f"{other.folder}: found another model ({other.name}) than {said['model']}, which {model.name} becomes; "
            "generate it there again"
        )
    own = {path: value for path, value in changed.items() if path in other.parameters}
    return other.with_parameters(own) if own else other.as_it_is()
