"""Where along a run the events of its scene come, as its core tells."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .._core import TOLERANCES
from ..arrays import FloatArray
from ..model.model import Model
from ..run import Run

TOGETHER = TOLERANCES["TOGETHER"].value
"""Changes that come nearer to each other than this part of the time, or of the duration, are of one instant."""
State = tuple[FloatArray, FloatArray]


@dataclass(frozen=True)
class Signal:
    """One direction of an event, or of a change of a joint, of which the model has that number: ``sign`` times its
    indicator comes to zero from below."""

    event: int
    sign: int


@dataclass(frozen=True)
class Crossing:
    """A ``signal``, by its number, comes to zero at ``t`` (s), in a ``state``."""

    t: float
    signal: int
    state: State


def signals_of(model: Model) -> tuple[Signal, ...]:
    """What is watched for the events of a model, and behind these for its joints that let go and take hold."""
    signs = {"rising": (1,), "falling": (-1,), "either": (1, -1)}
    events, changes = model.data.get("events", ()), changes_of(model)
    found = [Signal(number, sign) for number, said in enumerate(events) for sign in signs[said["direction"]]]
    return (*found, *(Signal(number, 1) for number in range(len(events), len(events) + len(changes))))


def changes_of(model: Model) -> Sequence[Mapping[str, Any]]:
    """What a model's data say of its joints that let go and take hold."""
    switching = model.data.get("switching")
    return () if switching is None else switching["changes"]


@dataclass(frozen=True)
class Located:
    """When one direction of an event came along a run, and the states there; ``armed``: it may come where that ends,
    being below zero and not having come."""

    armed: bool
    states: Mapping[float, State]


@dataclass
class Watch:
    """What is found along a run, of each of the ``signals`` (event, sign). ``armed``: which were below zero where it
    begins; ``halts``: after how many more of each event it ends, -1 where it does not; ``None`` of all of them."""

    signals: Sequence[Signal]
    armed: Sequence[bool]
    halts: Sequence[int] | None = None
    found: list[tuple[float, int, int]] = field(default_factory=list)
    states: FloatArray = field(default_factory=lambda: np.empty((0, 0)))
    after: Sequence[tuple[bool, bool]] = ()

    @property
    def armed_before(self) -> list[list[bool]]:
        """Of each event, whether its rise and its fall are armed."""
        table = [[False, False] for _ in range(1 + max(one.event for one in self.signals))]
        for one, armed in zip(self.signals, self.armed, strict=True):
            table[one.event][0 if one.sign > 0 else 1] = armed
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
        came: dict[Signal, dict[float, State]] = {signal: {} for signal in self.signals}
        for (t, event, sign), y in zip(self.found, self.states, strict=True):
            if t <= last:
                came[Signal(event, sign)][t] = y[:n], y[n:]
        return tuple(Located(self.after[one.event][0 if one.sign > 0 else 1], states) for one, states in came.items())
