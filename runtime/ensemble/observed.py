"""What is to be observed of every run, as it is asked for: outputs by name, their extremes, impacts, the last state."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..faults import Faults
from ..model.model import Model
from ..model.numbers import read_names, read_numbers
from ..record.outputs import unknown

EXTREME = re.compile(r"^(min|max)\((.+)\)$")
IMPACT_TIMES = re.compile(r"^impact_times\((\d+)\)$")
MOST_IMPACT_TIMES = 1_000_000
"""Times of impacts that may be kept of every run."""


@dataclass(frozen=True)
class Column:
    """What is observed by the name ``name``, taken apart.

    ``kind`` is ``output``, ``min`` or ``max`` of one, ``impact_times``, ``impacts``, ``q`` or ``u``; ``output`` is the
    name of that output, ``count`` how many times of impacts are kept."""

    name: str
    kind: str
    output: str = ""
    count: int = 0

    def extremes(self, values: FloatArray) -> FloatArray:
        """Of ``max(NAME)`` or ``min(NAME)`` the extreme (b,) over times (b, m) that are numbers."""
        which = np.fmax if self.kind == "max" else np.fmin
        return np.asarray(which.reduce(values, axis=1))


EXTREMES = ("min", "max")
WHOLE = ("q", "u", "impacts")
"""Names that are kinds of their own."""


def column_of(name: str) -> Column:
    """A name taken apart; whether there is such an output is not asked."""
    if times := IMPACT_TIMES.match(name):
        return Column(name, "impact_times", count=int(times[1]))
    if extreme := EXTREME.match(name):
        return Column(name, extreme[1], extreme[2])
    return Column(name, name) if name in WHOLE else Column(name, "output", name)


@dataclass(frozen=True)
class Observed:
    """``columns`` in the order in which they are asked for.

    ``at`` (m,) are the times (s) at which outputs are read, that of the end of each run where it is None."""

    columns: tuple[Column, ...]
    at: FloatArray | None

    @property
    def names(self) -> tuple[str, ...]:
        """As they are asked for."""
        return tuple(column.name for column in self.columns)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Outputs that are observed, or whose extremes are, each once."""
        return tuple(dict.fromkeys(column.output for column in self.columns if column.output))

    @property
    def impact_times(self) -> int:
        """How many times of impacts are kept at most."""
        return max((column.count for column in self.columns), default=0)


def read_observed(model: Model, observe: Sequence[str], at: ArrayLike | None, until: float) -> Observed:
    """Raises ``ValueError`` with all names that are none, and for times outside of the runs."""
    faults = Faults()
    names = tuple(read_names(observe, "observe", "outputs"))
    if len(set(names)) != len(names):
        faults.add(f"observe: found {', '.join(names)}, expected each name once")
    columns = tuple(column_of(name) for name in names)
    for column in columns:
        if column.kind == "impact_times" and not 0 < column.count <= MOST_IMPACT_TIMES:
            faults.add(f"observe: found {column.name!r}, expected a number of times from 1 to {MOST_IMPACT_TIMES}")
        for wrong in unknown(model, [column.output]) if column.output else ():
            faults.add(f"observe: {wrong}; q, u, impacts, impact_times(16), max(NAME) and min(NAME) are others")
    with faults.collecting():
        times_read = None if at is None else _times(model, at, until)
    faults.stop_if_any()
    return Observed(columns, times_read)


def _times(model: Model, at: ArrayLike, until: float) -> FloatArray:
    t = np.atleast_1d(np.array(read_numbers(at, "at", model.core.REAL)))
    if t.ndim != 1 or not t.size or not np.all((t >= 0.0) & (t <= until)):
        wrong = t[~((t >= 0.0) & (t <= until))]
        found = f"{wrong.flat[0]:g} s" if wrong.size else f"shape {t.shape}"
        raise ValueError(f"at: found {found}, expected a row of times from 0 to {until:g} s, the end of the runs")
    return t
