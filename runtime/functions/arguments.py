"""The vector that a run is a function of: starts, parameters and inputs, one behind the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..faults import Faults
from ..model.inputs import Given, read_values
from ..model.model import Model
from ..model.numbers import read_numbers
from ..sensitivity.moving import STARTS, moving_of

STATES = (*STARTS, "q", "u")
"""Names of which there are as many entries as coordinates."""


@dataclass(frozen=True, eq=False)
class Arguments:
    """The entries ``columns`` of a vector x (p,), which ``names`` have, ``sizes`` of each, and what x is unless it is
    changed, ``start``; no entry is below ``lowest`` nor above ``highest``."""

    names: tuple[str, ...]
    sizes: tuple[int, ...]
    columns: tuple[str, ...]
    start: FloatArray
    lowest: FloatArray
    highest: FloatArray

    def read(self, x: ArrayLike, what: str = "x") -> FloatArray:
        """A vector of these, its own copy; a number where there is one entry.

        Raises ``ValueError`` for what is no row of as many finite numbers.
        """
        found = np.array(read_numbers(x, what), dtype=float)
        if found.ndim == 0 and len(self.columns) == 1:
            found = found[None]
        if found.shape != self.start.shape:
            raise ValueError(f"{what}: found shape {found.shape}, expected {self.start.shape}: {self._listed()}")
        if not np.all(np.isfinite(found)):
            wrong = ", ".join(c for c, value in zip(self.columns, found, strict=True) if not np.isfinite(value))
            raise ValueError(f"{what}: found what is no finite number for {wrong}, expected finite numbers")
        return found

    def parts(self, x: FloatArray) -> dict[str, FloatArray | float]:
        """What each of the names is: arrays (n,) of coordinates and rates, numbers of others."""
        ends = np.cumsum(self.sizes)[:-1]
        parts = zip(self.names, np.split(x, ends), strict=True)
        return {name: part if name in STATES else float(part[0]) for name, part in parts}

    def told(self, x: FloatArray) -> str:
        """A vector for a sentence."""
        return ", ".join(f"{column} = {value:.9g}" for column, value in zip(self.columns, x, strict=True))

    def _listed(self) -> str:
        return ", ".join(self.columns[:12]) + (", …" if len(self.columns) > 12 else "")


def arguments_of(
    model: Model, wrt: Sequence[str] | str, start: tuple[ArrayLike | None, ArrayLike | None], inputs: Given
) -> Arguments:
    """The vector of the names ``wrt``; what it is unless it is changed is in the model, in the ``start`` (q0, u0) and
    in ``inputs``.

    Raises ``TypeError`` or ``ValueError`` for names that runs have no derivatives by, with all that are wrong.
    """
    if isinstance(wrt, Mapping) or not (isinstance(wrt, str) or all(isinstance(name, str) for name in wrt)):
        raise TypeError(f"wrt: found {wrt!r}, expected names: q0, u0, parameters by their paths, or inputs")
    names = (wrt,) if isinstance(wrt, str) else tuple(wrt)
    faults = Faults()
    for name in dict.fromkeys(name for name in names if names.count(name) > 1):
        faults.add(f"wrt: found {name} {names.count(name)} times, expected each name once")
    moving, values, n = None, np.zeros(0), len(model.q_names)
    with faults.collecting():
        moving = moving_of(model, names)
    given = [_start(model, k, one, faults) for k, one in enumerate(start)]
    with faults.collecting():
        values = constants_of(model, inputs)
    faults.stop_if_any()
    assert moving is not None
    known: dict[str, Any] = dict(zip(STARTS, given, strict=True))
    known |= dict(zip(model.inputs, values, strict=True)) | dict(model.parameters)
    sizes = tuple(n if name in STARTS else 1 for name in names)
    open_ = (-np.inf, np.inf)
    domains = [domain_of(model, name) if name in model.parameters else open_ for name in names]
    lowest, highest = (np.repeat([one[k] for one in domains], sizes) for k in (0, 1))
    first = np.concatenate([np.atleast_1d(np.asarray(known[name], dtype=float)) for name in names])
    return Arguments(names, sizes, moving.columns, first, lowest, highest)


def _start(model: Model, k: int, given: ArrayLike | None, faults: Faults) -> FloatArray:
    """The scene's unless one is given."""
    own = np.asarray(model.start()[k], dtype=float)
    if given is None:
        return own
    with faults.collecting():
        found = read_numbers(given, STARTS[k])
        if found.shape != own.shape:
            raise ValueError(f"{STARTS[k]}: found shape {found.shape}, expected {own.shape}, one start")
        return np.asarray(found, dtype=float)
    return own


def domain_of(model: Model, path: str) -> tuple[float, float]:
    """The least and the largest value of a parameter; the least may be one that it has to be above."""
    domain = next(one["domain"] for one in model.data["parameters"] if one["path"] == path)
    least = [domain[key] for key in ("minimum", "above") if domain[key] is not None]
    return max(least, default=-np.inf), np.inf if domain["maximum"] is None else domain["maximum"]


def constants_of(model: Model, inputs: Given) -> FloatArray:
    """The constant values of all inputs. Raises ``ValueError`` for a controller or a table over time."""
    if callable(inputs) or (isinstance(inputs, Mapping) and "t" in inputs):
        what = "a controller" if callable(inputs) else "a table over time"
        raise ValueError(f"inputs: found {what}, expected constants: runs under {what} have no derivatives")
    return read_values(model.inputs, inputs)
