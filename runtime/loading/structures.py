"""The models of all structures of a mechanism whose joints let go and take hold."""

from __future__ import annotations

from ..model.model import Model
from .load import load_model


def structures_of(model: Model) -> tuple[Model, ...]:
    """The model of the start, and those of all other structures, with the values of its parameters.

    Raises ``FileNotFoundError`` or ``ImportError`` where the package of one is missing, or of another scene.
    """
    folder = model.folder
    if folder is None:
        raise FileNotFoundError(f"{model.name}: found a model without a package, expected one beside those it becomes")
    declared = {one["path"]: one["value"] for one in model.data["parameters"]}
    changed = {path: value for path, value in model.parameters.items() if value != declared[path]}
    found = [model]
    for said in model.data["switching"]["structures"][1:]:
        other = load_model(folder.parent / said["package"])
        if other.data["hash"] != said["hash"]:
            raise ImportError(
                f"{other.folder}: found another model ({other.name}) than {said['model']}, which {model.name} becomes; "
                "generate it there again"
            )
        own = {path: value for path, value in changed.items() if path in other.parameters}
        found.append(other.with_parameters(own) if own else other.as_it_is())
    return tuple(found)
