"""Outputs of a run by name, and what they move by with the state."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..faults import Faults
from ..model.derivatives import SOLVED
from ..model.forces import Held
from ..model.inputs import Values
from ..model.model import Model
from ..model.numbers import read_numbers, told
from ..model.places import places_of

Function = Callable[[float, FloatArray, FloatArray], tuple[ArrayLike, ArrayLike, ArrayLike]]
"""From t, q (n,) and u (n,) values (k,) or a number, and their derivatives (k, n) by q and by u."""

Output = str | Function

WHOLE = ("q", "u")
TIMES = "impact_times"


def read_outputs(outputs: object) -> list[Output]:
    """The argument ``outputs``, one or several, as a list. Raises ``TypeError`` for what are neither names nor
    functions."""
    if isinstance(outputs, str) or callable(outputs):
        return [outputs]
    several = isinstance(outputs, Iterable) and not isinstance(outputs, bytes)
    several = several and not (isinstance(outputs, np.ndarray) and outputs.ndim == 0)
    given: list[Any] = list(outputs) if several else [None]  # type: ignore[call-overload]
    if not all(isinstance(one, str) or callable(one) for one in given):
        raise TypeError(f"outputs: found {told(outputs)}, expected names of outputs or functions, as a list")
    return given


def check_outputs(model: Model, outputs: Sequence[Output]) -> None:
    """Raise ``ValueError`` for outputs that are none, have no derivatives, or the same name as others, by which they
    are told, with all that is wrong."""
    faults, names = Faults(), [label(one) for one in outputs]
    for name in dict.fromkeys(name for name in names if names.count(name) > 1):
        faults.add(f"outputs: found {name} {names.count(name)} times, expected names that differ")
    named = [one for one in outputs if not callable(one) and one not in (*WHOLE, TIMES)]
    places = places_of(model) if named else {}
    for one in named:
        if one not in places:
            near = ", ".join(list(places)[:12])
            faults.add(
                f"outputs: found {one!r}, expected q, u, impact_times, a function, or one of {near}"
                f"{', …' if len(places) > 12 else ''}; of others there are no derivatives"
            )
    faults.stop_if_any()


def label(output: Output) -> str:
    """The name of an output."""
    return output if isinstance(output, str) else getattr(output, "__name__", "function")


def moves(
    model: Model,
    arguments: Sequence[str],
    output: Output,
    t: float,
    state: tuple[FloatArray, FloatArray],
    whole: FloatArray,
    held: Held,
    inputs: Values | None,
) -> FloatArray:
    """What an output moves by at one time, (columns,) or (k, columns), where state and ``arguments`` move by ``whole``
    (D, columns)."""
    q, u = state
    n = len(q)
    S = whole[: 2 * n]
    if output == "q":
        return S[:n]
    if output == "u":
        return S[n:]
    if callable(output):
        return _of_function(output, t, q, u, S)
    of, index = places_of(model)[str(output)]
    if of in ("q", "u"):
        return np.asarray(S[:n][index] if of == "q" else S[n:][index])
    if of in SOLVED and held:
        raise ValueError(
            f"outputs: found {output} at t = {t:.9g} s, where contacts are held, expected a time in flight: forces "
            "have derivatives there alone"
        )
    by: dict[str, Any] = {"q": S[:n], "u": S[n:]} | dict(zip(arguments, whole[2 * n :], strict=True))
    found = model.derivatives(of, q, u, t, inputs, by, () if model.contacts else None)
    return np.asarray(found[index])


def _of_function(function: Function, t: float, q: FloatArray, u: FloatArray, S: FloatArray) -> FloatArray:
    n, name = len(q), label(function)
    value, by_q, by_u = _asked(function, t, q, u)
    for part, argument in ((by_q, "q"), (by_u, "u")):
        if part.shape != (*value.shape, n):
            raise ValueError(
                f"outputs: {name}: found derivatives by {argument} of shape {part.shape}, expected {(*value.shape, n)}"
            )
    return np.asarray(by_q @ S[:n] + by_u @ S[n:])


def _asked(function: Function, t: float, q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """What a function says: its values, and what they move by with q and u."""
    found = function(t, q.copy(), u.copy())
    if not isinstance(found, tuple) or len(found) != 3:
        raise ValueError(
            f"outputs: {label(function)}: found {type(found).__name__}, expected a tuple of values and of their "
            "derivatives by q and by u"
        )
    value, by_q, by_u = (np.asarray(read_numbers(part, f"outputs: {label(function)}"), dtype=float) for part in found)
    return value, by_q, by_u


def value_of(function: Function, t: float, q: FloatArray, u: FloatArray) -> FloatArray:
    """The values of a function. Raises ``ValueError`` for one that does not say them with their derivatives."""
    return _asked(function, t, q, u)[0]


def values(
    model: Model, output: Output, t: float, state: tuple[FloatArray, FloatArray], named: Mapping[str, FloatArray]
) -> FloatArray:
    """The value of an output at one time; ``named`` are those of names."""
    if output in WHOLE:
        return np.asarray(state[WHOLE.index(str(output))])
    if callable(output):
        return value_of(output, t, *state)
    of, index = places_of(model)[str(output)]
    if of in WHOLE:
        return np.asarray(state[WHOLE.index(of)][index])
    return np.asarray(named[str(output)])
