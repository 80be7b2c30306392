"""Where along a run the events of its scene come, as its core tells."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .._core import TOLERANCES
from ..arrays import FloatArray
from ..run import Run

ZERO = 64.0
"""What is nearer to zero than this many roundings of an expression is zero."""
TOGETHER = TOLERANCES["TOGETHER"].value
"""Changes that come nearer to each other than this part of the time, or of the duration, are of one instant."""
State = tuple[FloatArray, FloatArray]


@dataclass(frozen=True)
class Located:
    """When one direction of an event came along a run, and the states there; ``armed``: it may come where that ends."""

    armed: bool
    times: tuple[float, ...]
    states: Mapping[float, State]

    def armed_at(self, t: float) -> bool:
        """Whether, where the run has ended, which is at ``t`` (s), it was below zero and has not come."""
        return self.armed


@dataclass
class Watch:
    """What is found along a run, of each of the ``signals`` (event, sign). ``armed``: which were below zero where it
    begins; ``halts``: after how many more of each event it ends, -1 where it does not; ``None`` of all of them."""

    signals: Sequence[tuple[int, int]]
    armed: Sequence[bool]
    halts: Sequence[int] | None = None
    found: list[tuple[float, int, int]] = field(default_factory=list)
    states: FloatArray = field(default_factory=lambda: np.empty((0, 0)))
    after: Sequence[tuple[bool, bool]] = ()

    @property
    def armed_before(self) -> list[list[bool]]:
        """Of each event, whether its rise and its fall are armed."""
        table = [[False, False] for _ in range(1 + max(event for event, _ in self.signals))]
        for (event, sign), armed in zip(self.signals, self.armed, strict=True):
            table[event][0 if sign > 0 else 1] = armed
        return table

    def take(self, found: Mapping[str, Any]) -> None:
        """Take what the core has found so far: nothing of a run that has not begun."""
        self.found = found.get("crossings", [])
        self.states = found.get("crossed", np.empty((0, 2 * found["q"].shape[1])))
        self.after = found.get("armed", self.armed_before)

    def along(self, run: Run) -> tuple[Located, ...]:
        """The same by signals, as far as the run goes, and what comes together with its end."""
        n, end = self.states.shape[1] // 2, float(run.t[-1])
        last = end + TOGETHER * max(abs(end), run.model.duration)
        came: dict[tuple[int, int], dict[float, State]] = {signal: {} for signal in self.signals}
        for (t, event, sign), y in zip(self.found, self.states, strict=True):
            if t <= last:
                came[event, sign][t] = y[:n], y[n:]
        return tuple(
            Located(self.after[event][0 if sign > 0 else 1], tuple(states), states)
            for (event, sign), states in came.items()
        )
