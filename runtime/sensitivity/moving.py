"""What a run is derived by: starts, parameters and inputs, and the directions that are asked for in them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..faults import Faults
from ..model.directions import Directions, directions_of
from ..model.model import Model
from ..model.numbers import read_names, read_numbers
from ..model.thresholds import characteristic_time

Wrt = str | Sequence[str] | Mapping[str, ArrayLike]
"""What a run is derived by: names, each with all its entries one by one, or directions in them by name."""

NAMED = "q0, u0, parameters by their paths, or inputs"
STARTS = ("q0", "u0")


@dataclass(frozen=True)
class Moving:
    """Directions, a column for each of the ``columns``, which names them.

    ``q0`` (nq, columns) and ``u0`` (nu, columns) are what the start moves by before it is put onto the closure;
    ``arguments`` are names of parameters and inputs, and ``along`` (arguments, columns) what these move by.
    ``directions`` are those in q, then u, then each of the arguments, one by one.
    """

    columns: tuple[str, ...]
    q0: FloatArray
    u0: FloatArray
    arguments: tuple[str, ...]
    along: FloatArray
    directions: Directions

    @property
    def states(self) -> int:
        """Directions in q and u."""
        return 2 * len(self.q0)

    def whole(self, q: FloatArray, u: FloatArray) -> FloatArray:
        """What the ``directions`` are combined with, (2 n + arguments, columns), where q and u move by these."""
        return np.vstack([q, u, self.along])


def moving_of(model: Model, wrt: Wrt) -> Moving:
    """The directions that ``wrt`` asks for, in its order.

    Raises ``ValueError``, or ``KeyError`` for names that the model has not, with all that is wrong with them.
    """
    n = len(model.q_names)
    listed = [wrt] if isinstance(wrt, str) else wrt if isinstance(wrt, Mapping) else read_names(wrt, "wrt", NAMED)
    given = wrt if isinstance(wrt, Mapping) else dict.fromkeys(listed)
    if not given:
        raise ValueError("wrt: found nothing, expected names: q0, u0, parameters by their paths, or inputs")
    faults, arguments = Faults(), tuple(name for name in given if name not in STARTS)
    if not isinstance(wrt, Mapping):
        again = [name for name, times in Counter(listed).items() if times > 1]
        for name in again:
            faults.add(f"wrt: found {name!r} more than once, expected each name once")
    directions = None
    with faults.collecting():
        directions = directions_of(model, ("q", "u", *arguments))
    for name in arguments:
        with faults.collecting():
            _check_argument(model, name)
    sizes = {name: n if name in STARTS else 1 for name in given}
    if isinstance(wrt, Mapping):
        parts = {}
        for name, value in wrt.items():
            with faults.collecting():
                parts[name] = _directions(name, value, sizes[name])
        counts = {name: part.shape[1] for name, part in parts.items()}
        if len(set(counts.values())) > 1:
            faults.add(f"wrt: found {counts} directions, expected as many of each")
        faults.stop_if_any()
        columns = tuple(f"direction {k}" for k in range(next(iter(counts.values()))))
    else:
        faults.stop_if_any()
        labels = [(name, entry) for name in given for entry in range(sizes[name])]
        columns = tuple(f"{name}[{model.q_of[entry]}]" if name in STARTS else name for name, entry in labels)
        each, firsts = np.eye(len(labels)), np.cumsum([0, *sizes.values()])
        parts = {name: each[first : first + sizes[name]] for name, first in zip(given, firsts, strict=False)}
    none = np.zeros((n, len(columns)))
    along = np.vstack([parts[name] for name in arguments]) if arguments else np.zeros((0, len(columns)))
    assert directions is not None
    return Moving(columns, parts.get("q0", none), parts.get("u0", none), arguments, along, directions)


def _check_argument(model: Model, name: str) -> None:
    """It is none by which runs have no derivatives."""
    if name in ("q", "u", "t", "inputs"):
        raise ValueError(
            f"wrt: found {name!r}, expected q0 or u0, a parameter by its path, or one of the inputs "
            f"{', '.join(model.inputs) or '(there are none)'}"
        )
    if name in model.data["instants"]:
        raise ValueError(f"wrt: found {name}, a time at which a load jumps, expected a parameter that forces depend on")


def _directions(name: str, value: ArrayLike, size: int) -> FloatArray:
    found = read_numbers(value, f"wrt: {name}")
    found = found[None] if found.ndim == 1 and size == 1 else found
    if found.ndim != 2 or len(found) != size or not np.all(np.isfinite(found)):
        raise ValueError(f"wrt: {name}: found shape {found.shape}, expected finite numbers ({size}, directions)")
    return np.asarray(found, dtype=float)


def whole_of(model: Model, moving: Moving, row: FloatArray) -> FloatArray:
    """What a row (n,) of the coordinates makes of a change of the state by all of its size, where each column
    (columns,) is as large as changes what it is by all of that."""
    unit = model.coordinate_units
    values = np.array([abs(model.parameters[name]) if name in model.parameters else 1.0 for name in moving.arguments])
    values[values == 0.0] = 1.0
    parts = (
        moving.q0 / unit[:, None],
        characteristic_time(model) * moving.u0 / unit[:, None],
        moving.along / values[:, None],
    )
    columns = np.max([np.max(np.abs(part), axis=0, initial=0.0) for part in parts], axis=0)
    return np.asarray(float(np.abs(row) @ unit) * columns)
