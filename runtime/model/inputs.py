"""Inputs of a model as people give them: values by name or in order, a function of the state, a table over time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from .numbers import read_numbers

if TYPE_CHECKING:
    from .._core import Supply

Values = Mapping[str, float] | Sequence[float] | FloatArray | float
"""Values of the inputs: by name (those left out are zero), in the order of ``Model.inputs``, or the one there is."""

Controller = Callable[[float, FloatArray, FloatArray], Values]
"""Values of the inputs from (t, q, u)."""

Given = Values | Mapping[str, ArrayLike] | Controller | None
"""Inputs of a run: constants, a table with rows over ``"t"``, or a controller; ``None`` for zeros."""


def read_values(names: tuple[str, ...], given: object, what: str = "inputs") -> FloatArray:
    """One number per input. Raises ``ValueError`` for unknown names, a wrong count, and what is no finite number."""
    if given is None:
        return np.zeros(len(names))
    if not names:
        raise ValueError(f"{what}: found {given!r}, expected None; the model has no inputs")
    if isinstance(given, Mapping):
        _check_names(names, given, what)
        return np.array([_number(given.get(name, 0.0), f"{what}: {name}") for name in names])
    if np.ndim(given) == 0 and len(names) == 1:  # type: ignore[arg-type]
        return np.array([_number(given, f"{what}: {names[0]}")])
    found = _array(given, what)
    if found.shape != (len(names),):
        raise ValueError(f"{what}: found shape {found.shape}, expected ({len(names)},): {', '.join(names)}")
    return found


def supply_of(names: tuple[str, ...], given: object, supply: type[Supply]) -> tuple[Supply | None, FloatArray]:
    """Where a run's inputs come from, as a ``supply`` of the model's core, and the times at which they have kinks."""
    none = np.zeros(0)
    if not names:
        read_values(names, given)
        return None, none
    if callable(given):

        def ask(t: float, q: FloatArray, u: FloatArray) -> FloatArray:
            found = given(t, q, u)
            if found is None:
                raise ValueError(f"inputs at t = {t:.12g}: found None, expected values of {', '.join(names)}")
            return read_values(names, found, f"inputs at t = {t:.12g}")

        return supply(ask), none
    if isinstance(given, Mapping) and "t" in given:
        t, rows = table_of(names, given)
        return supply(None, t, rows), t
    return supply(None, np.zeros(1), read_values(names, given)[None]), none


def table_of(names: tuple[str, ...], given: Mapping[str, Any]) -> tuple[FloatArray, FloatArray]:
    """Times (rows,), and values (rows, inputs) of all inputs. Raises ``ValueError`` for what is no table."""
    _check_names(("t", *names), given, "inputs")
    t = _array(given["t"], "inputs: t")
    if t.ndim != 1 or not t.size or np.any(np.diff(t) <= 0.0):
        raise ValueError("inputs: t: found no row of times that grow, expected at least one time, each after the last")
    rows = np.zeros((t.size, len(names)))
    for index, name in enumerate(names):
        if name in given:
            column = _array(given[name], f"inputs: {name}")
            if column.shape != t.shape:
                raise ValueError(f"inputs: {name}: found shape {column.shape}, expected {t.shape}, a value for each t")
            rows[:, index] = column
    return t, rows


def _check_names(names: tuple[str, ...], given: Mapping[str, Any], what: str) -> None:
    for name in given:
        if name not in names:
            raise ValueError(f"{what}: found {name!r}, expected one of {', '.join(names)}")


def _number(value: object, what: str) -> float:
    found = _array(value, what)
    if found.shape != ():
        raise ValueError(f"{what}: found shape {found.shape}, expected a number")
    return float(found)


def _array(value: object, what: str) -> FloatArray:
    found = read_numbers(value, what)
    if not np.all(np.isfinite(found)):
        raise ValueError(f"{what}: found {found[~np.isfinite(found)].flat[0]}, expected finite numbers")
    return found
