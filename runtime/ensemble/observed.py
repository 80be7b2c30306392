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
from ..model.numbers import read_numbers
from ..record.outputs import outputs_of, unknown

EXTREME = re.compile(r"^(min|max)\((.+)\)$")
IMPACT_TIMES = re.compile(r"^impact_times\((\d+)\)$")
MOST_IMPACT_TIMES = 1_000_000
"""Times of impacts that may be kept of every run."""


@dataclass(frozen=True)
class Observed:
    """``names`` as they are asked for; ``outputs`` are those of them, and of extremes, that are outputs.

    ``at`` (m,) are the times (s) at which they are read, that of the end of each run where it is None; ``impact_times``
    is how many times of impacts are kept."""

    names: tuple[str, ...]
    outputs: tuple[str, ...]
    at: FloatArray | None
    impact_times: int


def read_observed(model: Model, observe: Sequence[str], at: ArrayLike | None, until: float) -> Observed:
    """Raises ``ValueError`` with all names that are none, and for times outside of the runs."""
    faults = Faults()
    if isinstance(observe, str) or not all(isinstance(name, str) for name in observe):
        raise TypeError(f"observe: found {observe!r}, expected a list of names")
    names = tuple(observe)
    if len(set(names)) != len(names):
        faults.add(f"observe: found {', '.join(names)}, expected each name once")
    outputs, impact_times, known = [], 0, outputs_of(model)
    for name in names:
        extreme, times = EXTREME.match(name), IMPACT_TIMES.match(name)
        if times:
            impact_times = max(impact_times, int(times[1]))
            if not 0 < int(times[1]) <= MOST_IMPACT_TIMES:
                faults.add(f"observe: found {name!r}, expected a number of times from 1 to {MOST_IMPACT_TIMES}")
        elif name not in ("q", "u", "impacts"):
            output = extreme[2] if extreme else name
            if output in known:
                outputs.append(output)
            for wrong in unknown(model, [output]):
                faults.add(f"observe: {wrong}; q, u, impacts, impact_times(16), max(NAME) and min(NAME) are others")
    with faults.collecting():
        times_read = None if at is None else _times(model, at, until)
    faults.stop_if_any()
    return Observed(names, tuple(dict.fromkeys(outputs)), times_read, impact_times)


def _times(model: Model, at: ArrayLike, until: float) -> FloatArray:
    t = np.atleast_1d(np.array(read_numbers(at, "at", model.core.REAL)))
    if t.ndim != 1 or not t.size or not np.all((t >= 0.0) & (t <= until)):
        wrong = t[~((t >= 0.0) & (t <= until))]
        found = f"{wrong.flat[0]:g} s" if wrong.size else f"shape {t.shape}"
        raise ValueError(f"at: found {found}, expected a row of times from 0 to {until:g} s, the end of the runs")
    return t


def extremes(name: str, values: FloatArray) -> FloatArray:
    """Of ``max(NAME)`` or ``min(NAME)`` the extreme (b,) over times (b, m) that are numbers."""
    which = np.fmax if name.startswith("max") else np.fmin
    return np.asarray(which.reduce(values, axis=1))
