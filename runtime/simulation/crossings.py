"""Where along a run an expression comes to zero: located in the states between its rows, to rounding."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..arrays import BoolArray, FloatArray
from ..run import Run
from .growing import blocks
from .quantities import Of, Quantity
from .watch import ZERO, State
from .watching import LOOKS, passage


@dataclass(frozen=True)
class Signal:
    """One direction of an event: ``sign`` times its expression comes to zero from below."""

    event: int
    sign: int
    quantity: Quantity


@dataclass(frozen=True)
class Crossing:
    """A ``signal``, by its number, comes to zero at ``t`` (s), in a ``state`` where that is known."""

    t: float
    signal: int
    state: State | None = None


def signals_of(events: list[Mapping[str, Any]]) -> tuple[Signal, ...]:
    """What is watched for the events of a model."""
    signs = {"rising": (1,), "falling": (-1,), "either": (1, -1)}
    return tuple(
        Signal(number, sign, Quantity(said["when"]))
        for number, said in enumerate(events)
        for sign in signs[said["direction"]]
    )


@dataclass(frozen=True)
class Looks:
    """Instants of a run at which signals are looked at, the last one before an impact among them, and the states."""

    run: Run
    t: FloatArray
    q: FloatArray
    u: FloatArray

    @classmethod
    def of(cls, run: Run, part: slice) -> Looks:
        """The rows of a part of a run, and instants between them."""
        times = run.t[part]
        rows = np.unique(times)
        parts = np.arange(LOOKS) / LOOKS
        struck = [impact.t for impact in run.impacts[_first_impact(run, float(rows[0])) :]]
        before = [np.nextafter(t, -np.inf) for t in struck if rows[0] < t <= rows[-1]]
        between = (rows[:-1, None] + parts * np.diff(rows)[:, None]).ravel()
        t = np.unique(np.concatenate([between, before, rows[-1:]]))
        q, u = run.at(t)
        if struck and len(times) > 1 and struck[0] == times[0] == times[1]:
            first = part.start
            t, q, u = np.append(rows[:1], t), np.vstack([run.q[first], q]), np.vstack([run.u[first], u])
        return cls(run, t, q, u)

    def beside_borders(self, signal: Signal, model: Of, none: BoolArray) -> Looks:
        """These, of which a signal has no value at some, ``none``, and one more wherever between two of them it begins
        or ends to have values: on that side, and as far from there as its rounding, which has no bound there for roots
        and logarithms, is still known to half its digits (``look_at_borders`` of interface/crossings.c)."""
        borders: list[float] = []
        for k in np.flatnonzero((none[:-1] != none[1:]) & (self.t[:-1] < self.t[1:])).tolist():
            first, last = a, b = float(self.t[k]), float(self.t[k + 1])
            epsilon = float(np.finfo(self.t.dtype).eps)
            near = max(math.sqrt(epsilon) * (b - a), 4.0 * epsilon * max(abs(a), abs(b)))
            while b - a > near and a < (middle := 0.5 * (a + b)) < b:
                if math.isnan(signal.quantity.at(model, middle, *self.run.at(middle))) == none[k]:
                    a = middle
                else:
                    b = middle
            border = b + near if none[k] else a - near
            borders += [border] if first < border < last else []
        if not borders:
            return self
        times = np.array(borders, dtype=self.t.dtype)
        places, (q, u) = np.searchsorted(self.t, times), self.run.at(times)
        return replace(
            self,
            t=np.insert(self.t, places, times),
            q=np.insert(self.q, places, q, axis=0),
            u=np.insert(self.u, places, u, axis=0),
        )


def _first_impact(run: Run, t: float) -> int:
    """The first impact that is not before t (s)."""
    return bisect_left(run.impacts, t, key=lambda impact: impact.t)


@dataclass(frozen=True)
class Watched:
    """A signal along a run: when it came to zero, and from which look on it was below zero beyond rounding."""

    times: tuple[float, ...]
    looks: FloatArray
    below: Any
    states: Mapping[float, State] = field(default_factory=dict)

    @classmethod
    def joined(cls, parts: Sequence[Watched]) -> Watched:
        """What was found along parts of a run that follow each other."""
        if len(parts) == 1:
            return parts[0]
        times = tuple(t for part in parts for t in part.times)
        return cls(
            times, np.concatenate([part.looks for part in parts]), np.concatenate([part.below for part in parts])
        )

    def armed_at(self, t: float) -> bool:
        """Whether, by the last look before ``t`` (s), it was below zero."""
        return bool(self.below[max(int(np.searchsorted(self.looks, t, side="left")) - 1, 0)])


def watched(signal: Signal, looks: Looks, model: Of, armed: bool) -> Watched:
    """The instants of a signal along a run; ``armed``: it was below zero where the run begins.

    It comes to zero where it is not below any more. Between two looks it may come above zero and go back, or below and
    come back: there its rate changes its sign. What is not a number counts as what was there before.
    """
    found = signal.quantity.along(model, looks.t, looks.q, looks.u)
    none = np.isnan(found.value)
    if none.any():
        looks = looks.beside_borders(signal, model, none)
        found = signal.quantity.along(model, looks.t, looks.q, looks.u)
    values = signal.sign * found.value
    zero = ZERO * np.finfo(values.dtype).eps * found.size
    zero = np.where(np.isfinite(zero), zero, 0.0)  # it has no bound where a root begins
    below = np.asarray(values < -zero)
    for k in np.flatnonzero(np.isnan(values)).tolist():
        below[k] = below[k - 1] if k else armed

    def value(t: float) -> float:
        return signal.sign * signal.quantity.at(model, t, *looks.run.at(t))

    def rate(t: float) -> float:
        q, u = looks.run.at(t)
        rates = signal.quantity.along(model, np.array([t]), q[None], u[None]).rate
        assert rates is not None
        return signal.sign * float(rates[0])

    times = [float(looks.t[0])] if armed and not below[0] else []
    peaks = dips = np.zeros(len(below) - 1, dtype=bool)
    if found.rate is not None:
        rates = signal.sign * found.rate
        valued = ~np.isnan(values)
        peaks = valued[:-1] & valued[1:] & below[:-1] & below[1:] & (rates[:-1] > 0.0) & (rates[1:] < 0.0)
        dips = (values[:-1] > 0.0) & (values[1:] > 0.0) & (rates[:-1] < 0.0) & (rates[1:] > 0.0)
    for k in np.flatnonzero((below[:-1] & ~below[1:]) | peaks | dips).tolist():
        a, b, last = float(looks.t[k]), float(looks.t[k + 1]), float(values[k + 1])
        if peaks[k]:
            b = passage(lambda t: -rate(t), a, b)
            last = value(b)
        elif dips[k]:
            a = passage(rate, a, b)
        if (peaks[k] and not last >= -zero[k]) or (dips[k] and not value(a) < -zero[k]):  # nor where it is no number
            continue
        if math.isnan(values[k]):  # it begins beyond zero
            times.append(b)
            continue
        level = min(last, 0.0)
        times.append(float(passage(lambda t, level=level: value(t) - level, a, b)))  # type: ignore[misc]
    return Watched(tuple(times), looks.t, below)


@dataclass(frozen=True)
class Seen:
    """What has come of each signal along a ``run`` that grows, so far."""

    run: Run
    found: tuple[Watched, ...]


def seen(before: Seen | None, run: Run, signals: Sequence[Signal], armed: Sequence[bool]) -> Seen:
    """What has come along a run, of which less was seen ``before``; which signals are ``armed`` where it begins. A run
    that has fewer rows than were seen, since it is cut where it ends at a dead point, is looked at anew."""
    if before is not None and len(before.run.t) > len(run.t):
        before = None
    if before is not None and len(before.run.t) == len(run.t):
        return replace(before, run=run)
    parts: list[list[Watched]] = [[one] for one in before.found] if before is not None else [[] for _ in signals]
    for part in blocks(run.t, 0 if before is None else len(before.run.t) - 1):
        looks = Looks.of(run, part)
        for of_signal, signal, first in zip(parts, signals, armed, strict=True):
            was_below = bool(of_signal[-1].below[-1]) if of_signal else first
            of_signal.append(watched(signal, looks, run.model, was_below))
    return Seen(run, tuple(Watched.joined(of_signal) for of_signal in parts))
