"""Where along a run an expression comes to zero, by looks at its states in Python: what the core finds is held against
this."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ccgen.runtime import Run
from ccgen.runtime.arrays import FloatArray
from ccgen.runtime.model.model import Model

from .quantities import Quantity

ZERO = 64.0
"""What is nearer to zero than this many roundings of an expression is zero."""
LOOKS = 8
"""Instants of each step at which signals are looked at."""
BLOCK = 16
"""Rows that are looked at together."""
State = tuple[FloatArray, FloatArray]


@dataclass(frozen=True)
class Signal:
    """One direction of an event: ``sign`` times its expression comes to zero from below."""

    event: int
    sign: int
    quantity: Quantity


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


def watched(signal: Signal, looks: Looks, model: Model, armed: bool) -> Watched:
    """The instants of a signal along a run; ``armed``: it was below zero where the run begins.

    It comes to zero where it is not below any more. Between two looks it may come above zero and go back, or below and
    come back: there its rate changes its sign. What is not a number counts as what was there before.
    """
    found = signal.quantity.along(model, looks.t, looks.q, looks.u)
    values = signal.sign * found.value
    zero = ZERO * np.finfo(values.dtype).eps * found.size
    below = np.asarray(values < -zero)
    for k in np.flatnonzero(~np.isfinite(values)).tolist():
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
        peaks = below[:-1] & below[1:] & (rates[:-1] > 0.0) & (rates[1:] < 0.0)
        dips = (values[:-1] > 0.0) & (values[1:] > 0.0) & (rates[:-1] < 0.0) & (rates[1:] > 0.0)
    for k in np.flatnonzero((below[:-1] & ~below[1:]) | peaks | dips).tolist():
        a, b, last = float(looks.t[k]), float(looks.t[k + 1]), float(values[k + 1])
        if peaks[k]:
            b = passage(lambda t: -rate(t), a, b)
            last = value(b)
        elif dips[k]:
            a = passage(rate, a, b)
        if (peaks[k] and last < -zero[k]) or (dips[k] and value(a) >= -zero[k]):
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


def passage(value: Callable[[float], float], a: float, b: float) -> float:
    """The instant, to rounding, at which ``value``, negative at ``a``, comes to zero; it is not negative there.

    By regula falsi with Illinois' halving, and bisection where that goes slowly.
    """
    low, high = value(a), value(b)
    while True:
        middle = 0.5 * (a + b)
        if not a < middle < b:
            return b
        width = b - a
        for _ in range(3):
            t = b - high * (b - a) / (high - low) if high > low else 0.5 * (a + b)
            t = min(max(t, np.nextafter(a, b)), np.nextafter(b, a))
            if not a < t < b:
                return b
            found = value(t)
            if found < 0.0:
                a, low, high = t, found, 0.5 * high
            else:
                b, high, low = t, found, 0.5 * low
        middle = 0.5 * (a + b)
        if b - a > 0.5 * width and a < middle < b:
            found = value(middle)
            a, b = (middle, b) if found < 0.0 else (a, middle)
            low, high = (found, high) if found < 0.0 else (low, found)


def blocks(t: FloatArray, first: int) -> Iterator[slice]:
    """Rows at the times ``t`` (rows,) that never decrease, from ``first`` on, some at a time: each block begins with
    the last row of the one before, which is the last of its time."""
    last = len(t) - 1
    while True:
        end = min(first + BLOCK, last)
        while end < last and t[end + 1] == t[end]:
            end += 1
        yield slice(first, end + 1)
        if end == last:
            return
        first = end
