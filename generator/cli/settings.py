"""``--set PATH=VALUE``: values of parameters for one command."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from .refusal import Faults, fail, value_of

if TYPE_CHECKING:
    from ccgen.runtime import Model


def read_settings(given: Sequence[str]) -> dict[str, float]:
    """Values by the paths of parameters; exit code 2, and all that is wrong, where an option says none."""
    faults, found = Faults(), dict[str, float]()
    for text in given:
        path, sign, number = (part.strip() for part in text.partition("="))
        value = value_of(number)
        if not sign or not path or not isinstance(value, float):
            faults.add(f'--set: found "{text}", expected PATH=NUMBER in SI units, such as crank.mass=2')
        elif path in found:
            faults.add(f"--set {path}: found twice, expected once; leave one out")
        else:
            found[path] = value
    faults.stop_if_any()
    return found


def with_settings(model: Model, settings: Mapping[str, float]) -> Model:
    """The model with these values; exit code 2 where it has no such parameters, or they cannot be those."""
    if not settings:
        return model
    try:
        return model.with_parameters(settings)
    except (KeyError, ValueError) as error:
        fail("\n".join(f"--set {line}" for line in str(error).splitlines()))
