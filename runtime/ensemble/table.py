"""What is known of many runs: a row for each, in the order of their numbers, whatever happened."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..extras import needed

DONE, STOPPED, REFUSED, INTERRUPTED = "done", "stopped", "refused", "interrupted"
STATUSES = (DONE, STOPPED, REFUSED, INTERRUPTED)
"""How a run ended: at its end; before it, as ``reason`` says; not begun, since its numbers cannot be simulated; or not
made, or not to its end, since all were to stop."""


TOLD = ("run", "status", "reason", "t", "steps", "impacts")
"""Columns that every table has, in memory or on disk."""


@dataclass(frozen=True, eq=False)
class Ensemble:
    """A row for every run.

    ``status`` (b,) is one of :data:`STATUSES`, ``reason`` (b,) the sentence on it, empty where it is ``done``. ``t``
    (b,) is the time reached (s), ``steps`` (b,) how many rows its record had behind the first, ``impacts`` (b,) how
    many there were. ``columns`` are what was observed,
    by name: (b,) or (b, times); not a number where a run did not come so far. ``units`` are their units, "m, m, rad"
    of a column of q.
    ``params`` (b,) are the values of the parameters that vary.
    """

    status: NDArray[np.str_]
    reason: tuple[str, ...]
    t: FloatArray
    steps: NDArray[np.int64]
    impacts: NDArray[np.int64]
    columns: Mapping[str, FloatArray]
    units: Mapping[str, str] = field(default_factory=dict)
    params: Mapping[str, FloatArray] = field(default_factory=dict)
    at: FloatArray | None = None

    def __len__(self) -> int:
        return len(self.status)

    def __getitem__(self, name: str) -> FloatArray:
        """A column by name. Raises ``KeyError`` for one that was not observed."""
        if name not in self.columns:
            raise KeyError(f"{name}: found no such column, expected one of {', '.join(self.columns) or 'none'}")
        return self.columns[name]

    def __repr__(self) -> str:
        counts = ((status, int(np.count_nonzero(self.status == status))) for status in STATUSES)
        return f"<Ensemble of {len(self)} runs: {', '.join(f'{n} {status}' for status, n in counts if n) or 'none'}>"

    def rows(self) -> Iterator[tuple[str, FloatArray]]:
        """Flat columns: parameters, then what was observed, columns of several times as ``name[0]``, ``name[1]``."""
        yield from self.params.items()
        for name, values in self.columns.items():
            if values.ndim == 1:
                yield name, values
            else:
                for k in range(values.shape[1]):
                    yield f"{name}[{k}]", values[:, k]

    def to_dataframe(self) -> Any:
        """A pandas table with a row for every run: status, reason, t, steps, impacts and all columns, flat."""
        pandas = needed("pandas", "a table of runs")
        told = {"status": self.status, "reason": list(self.reason), "t": self.t, "steps": self.steps}
        return pandas.DataFrame(told | {"impacts": self.impacts} | dict(self.rows()))


def joined(parts: Sequence[Ensemble]) -> Ensemble:
    """One table of several, their rows one after the other; at least one."""
    first = parts[0]
    if len(parts) == 1:
        return first
    return Ensemble(
        np.concatenate([part.status for part in parts]),
        tuple(reason for part in parts for reason in part.reason),
        np.concatenate([part.t for part in parts]),
        np.concatenate([part.steps for part in parts]),
        np.concatenate([part.impacts for part in parts]),
        {name: np.concatenate([part.columns[name] for part in parts]) for name in first.columns},
        first.units,
        {name: np.concatenate([part.params[name] for part in parts]) for name in first.params},
        first.at,
    )
