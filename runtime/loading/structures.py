"""The models of all that a mechanism comes to: where joints let go and take hold, and where effects are on and off."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..model.model import Model
from .load import load_model


def structures_of(model: Model) -> tuple[Model, ...]:
    """The model of the start, and those of all other structures, with the values of its parameters.

    Raises ``FileNotFoundError`` or ``ImportError`` where the package of one is missing, or of another scene.
    """
    return (model, *(_beside(model, said) for said in model.data["switching"]["structures"][1:]))


def switched_of(model: Model) -> dict[frozenset[str], Model]:
    """The model of a mechanism with all its effects, and those without the effects that events switch, by those that
    are off, with the values of its parameters. Raises as :func:`structures_of` does.
    """
    others = model.data["switched"]["models"] if model.data.get("switched") else []
    found = {frozenset[str](): model.with_all_effects()}
    found |= {frozenset(said["off"]): _beside(model, said) for said in others}
    if odd := [one.name for one in found.values() if (one.q_names, one.rows) != (model.q_names, model.rows)]:
        raise ImportError(
            f"{odd[0]}: found other coordinates or loops than those of {model.name}, expected the same; generate both "
            "with one plan"
        )
    return found


def at_start(model: Model) -> Model:
    """The model of what acts where the scene starts: without the effects that ``[start] off`` names, with the values of
    the parameters and the start that ``model`` has; itself where nothing is off, and where it is that of a later time
    of a run. Raises as :func:`structures_of` does.
    """
    switched = model.data.get("switched")
    if not switched or not switched["off"]:
        return model
    said = next(one for one in switched["models"] if set(one["off"]) == set(switched["off"]))
    found = _beside(model, said)
    if (found.q_names, found.rows) != (model.q_names, model.rows):
        raise ImportError(
            f"{found.name}: found other coordinates or loops than those of {model.name}, expected the same; generate "
            "both with one plan"
        )
    begin = model._begin
    if begin is None:
        return found
    known = dict(zip(model.parameters, begin.values, strict=True))
    values = tuple(known.get(path, value) for path, value in found.parameters.items())
    return Model(found._descriptor, found.data, found._parameters, found.folder, begin._replace(values=values))


def of_all_contacts(whole: Model, model: Model, values: FloatArray) -> FloatArray:
    """What is said of each contact of a ``model``, (contacts, ...), as of all of the ``whole`` one's: zero of those
    that are off."""
    if model.contacts == whole.contacts:
        return values
    found = np.zeros((len(whole.contacts), *values.shape[1:]), dtype=values.dtype)
    found[own_contacts(whole, model)] = values
    return found


def own_contacts(whole: Model, model: Model) -> list[int]:
    """Which of the ``whole`` model's contacts those of a ``model`` are."""
    return [whole.contacts.index(contact) for contact in model.contacts]


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
