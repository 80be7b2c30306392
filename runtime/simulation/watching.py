"""Where along a run a joint is to let go or to take hold: located in the states between its rows, to rounding."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..model.joint_gap import Ends
from ..model.whole import Whole
from ..run import Run
from .growing import blocks
from .watch import TOGETHER

LOOKS = 8
"""Instants of each step at which what is watched is looked at: a passage and back within an eighth of a step is seen by
rates, where there are some."""
HELD = 1e-6
"""A joint takes hold where its points are nearer than this, times the mechanism's length, unless its scene tells."""

Values = Callable[[FloatArray, FloatArray, FloatArray], tuple[FloatArray, FloatArray | None]]
"""From times (b,), and a structure's states (b, n), what is watched, which comes to zero from below, and its rate."""


@dataclass(frozen=True)
class Signal:
    """A change, by its number, and what is watched for it. ``level``: it comes at once where that is positive at first.
    ``meets``: where it comes to zero the points of the joint are nearest, and the change comes if they are near enough.
    """

    number: int
    values: Values
    level: bool = False
    meets: Ends | None = None
    within: float = 0.0


@dataclass(frozen=True)
class Instant:
    """Changes, by their numbers, that come at ``t`` (s)."""

    t: float
    numbers: tuple[int, ...]


def signal_of(whole: Whole, structure: int, number: int, run: Run) -> Signal | None:
    """What is watched for a change along a run of a structure; ``None`` where it comes at a time or at an impulse."""
    said = whole.data["switching"]["changes"][number]
    model = whole.structures[structure]
    if said["watch"] is not None:
        return Signal(number, _watched(whole, structure, said["watch"]))
    if said["force"] is not None:
        joint, limit = model.joints.index(said["joint"]), float(said["force"])

        def forces(t: FloatArray, q: FloatArray, u: FloatArray) -> tuple[FloatArray, None]:
            assert run.motion is not None
            carried = run.motion(t, q, u).reactions[:, joint, :2]
            return np.nan_to_num(np.hypot(carried[:, 0], carried[:, 1]) - limit, nan=-limit), None

        return Signal(number, forces, level=True)
    if said["kind"] == "hold" and said["at"] is None:
        ends = whole.ends[said["joint"]]

        def nearing(t: FloatArray, q: FloatArray, u: FloatArray) -> tuple[FloatArray, None]:
            miss, rate = ends.misses(*whole.links_of(structure, q, u), whole.length)
            return np.asarray(np.sum(miss * rate, axis=-1)), None

        return Signal(number, nearing, meets=ends, within=within_of(whole, said))
    return None


def within_of(whole: Whole, said: Mapping[str, Any]) -> float:
    """How far (m) the points of a joint may be from each other where it takes hold."""
    return HELD * whole.length if said["within"] is None else float(said["within"])


def first_instant(
    whole: Whole, structure: int, run: Run, signals: Sequence[Signal], begins: bool, first: int = 0
) -> Instant | None:
    """The first instant of a run, of its rows from ``first`` on, at which one of the ``signals`` comes; ``begins``: a
    structure begins with the run."""
    found: dict[int, float] = {}
    for part in blocks(run.t, first) if signals else ():
        times = _times(run.t[part])
        q, u = run.at(times)
        for signal in (one for one in signals if one.number not in found):
            values = signal.values(times, q, u)
            t = _first(whole, structure, run, signal, times, values, begins and part.start == 0)
            if t is not None:
                found[signal.number] = t
        if found and certain(min(found.values()), float(times[-1]), whole.duration):
            break
    if not found:
        return None
    earliest = min(found.values())
    span = TOGETHER * max(abs(earliest), whole.duration)
    return Instant(earliest, tuple(number for number, t in found.items() if t - earliest <= span))


def certain(t: float, looked: float, duration: float) -> bool:
    """Whether all that comes together with what comes at t (s) is known to one who has looked as far as that."""
    return looked - t > TOGETHER * max(abs(t), duration)


def _times(rows: FloatArray) -> FloatArray:
    """Times of rows, and instants between them."""
    rows = np.unique(rows)
    parts = np.arange(LOOKS) / LOOKS
    between = (rows[:-1, None] + parts * np.diff(rows)[:, None]).ravel()
    return np.append(between, rows[-1])


def _first(
    whole: Whole,
    structure: int,
    run: Run,
    signal: Signal,
    times: FloatArray,
    looked: tuple[FloatArray, FloatArray | None],
    begins: bool,
) -> float | None:
    values, rates = looked

    def value(t: float) -> float:
        at = np.array([t])
        return float(signal.values(at, *run.at(at))[0][0])

    def fall(t: float) -> float:
        at = np.array([t])
        rate = signal.values(at, *run.at(at))[1]
        assert rate is not None
        return -float(rate[0])

    if signal.level and begins and values[0] >= 0.0:
        return float(times[0])
    for k in range(len(times) - 1):
        a, b = float(times[k]), float(times[k + 1])
        t = None
        if values[k] < 0.0 <= values[k + 1]:
            t = passage(value, a, b)
        elif rates is not None and values[k] < 0.0 and rates[k] > 0.0 > rates[k + 1]:
            top = passage(fall, a, b)
            t = passage(value, a, top) if value(top) >= 0.0 else None
        if t is not None and (signal.meets is None or _near(whole, structure, run, signal, t)):
            return t
    return None


def _near(whole: Whole, structure: int, run: Run, signal: Signal, t: float) -> bool:
    assert signal.meets is not None
    miss, _ = signal.meets.misses(*whole.links_of(structure, *run.at(t)), whole.length)
    return float(np.linalg.norm(miss)) <= signal.within


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


def _watched(whole: Whole, structure: int, said: Mapping[str, Any]) -> Values:
    """What a scene's ``when`` watches, less its limit, with the sign by which that is passed from below."""
    quantity = _quantity(whole, structure, said["kind"], said["names"])
    sign, limit = said["sign"], said["limit"]

    def values(t: FloatArray, q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        value, rate = quantity(q, u)
        return sign * (value - limit), sign * rate

    return values


Quantity = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]


def _quantity(whole: Whole, structure: int, kind: str, names: Sequence[str]) -> Quantity:
    """From a structure's states (b, n) the quantity (b,) and its rate."""
    model = whole.structures[structure]

    def turning(q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        first, second = whole.between(names[0]) if kind == "angle" else (-1, whole.links.index(names[0]))
        of = [one[..., 2] for one in whole.links_of(structure, q, u)]
        angle, spin = (one[..., second] - (one[..., first] if first >= 0 else 0.0) for one in _padded(of, second))
        return angle, spin

    def sliding(q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        return whole.ends_of(names[0]).along(*whole.links_of(structure, q, u))

    def places(q: FloatArray, u: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
        own = [whole.name_in(model, name) for name in names]
        return [(model.point(name, q), model.point_velocity(name, q, u)) for name in own]

    def height(q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        ((place, speed),) = places(q, u)
        return place[..., 1], speed[..., 1]

    def distance(q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        (one, its), (other, others) = places(q, u)
        way, rate = other - one, others - its
        size = np.linalg.norm(way, axis=-1)
        return size, np.sum(way * rate, axis=-1) / np.where(size > 0.0, size, 1.0)

    return {"angle": turning, "direction": turning, "slide": sliding, "height": height, "distance": distance}[kind]


def _padded(of: list[FloatArray], link: int) -> list[FloatArray]:
    """Angles and spins of the links; with zeros for the ground, which has the number -1, where that is asked for."""
    return of if link >= 0 else [np.concatenate([one, np.zeros((*one.shape[:-1], 1))], axis=-1) for one in of]
