"""Where driven joints come to a stop: a dead point, beyond which loops do not close, or contacts that are held open,
with the joints where they are to be.

There the rows of the closure, of the drives and of the contacts become dependent while their right-hand side does not
follow: with the least singular value s, velocities grow as 1/s, and s as the root of the time that is left
(docs/mechanisms.md).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..model.drives import drive_rows, rate_rows
from ..model.lined_up import lined_up
from ..model.model import Model

BoolArray = np.ndarray[Any, np.dtype[np.bool_]]

BEFORE = 1e-2
"""How much nearer to dependence than elsewhere rows come in what is recorded: from there on velocities are a hundred
times as large as elsewhere, energies ten thousand times, in the last ten-thousandth of the time."""
DEEP = 1e-4
"""The same where the stop is found from: by a straight line, which misses it by this part of what is left."""
PUSHED = 1e-6
"""Part of what dependent rows exclude: drives with less than that have no part in it."""
DEPENDENT = 1e-9
"""Rows whose least singular value is below that part of the largest depend on each other."""
LOOKS = 32
"""Rows of a record that say how near is usual."""
WALK = 200
"""Steps from the end of a record of fixed steps towards a dead point."""
State = tuple[float, FloatArray, FloatArray]
Step = Callable[[float, FloatArray, FloatArray, float], tuple[FloatArray, FloatArray]]


@dataclass(frozen=True)
class Way:
    """How far drives have ``gone`` (rad, m) since the time ``t`` (s), by their joints' names."""

    t: float
    gone: Mapping[str, float]

    def on(self, model: Model, before: FloatArray, after: FloatArray) -> Way:
        """The way to the coordinates ``after`` (nq,) of a stretch that has begun at those ``before``."""
        names = [drive["joint"] for drive in model.data["drives"]]
        steps = zip(names, (drive_rows(model) @ (after - before)).tolist(), strict=True)
        return Way(self.t, {**self.gone, **{name: self.gone.get(name, 0.0) + step for name, step in steps}})


@dataclass(frozen=True)
class DeadPoint:
    """A stop at the time ``t`` (s), which ``text`` describes; the first ``rows`` rows of the record lie before it."""

    t: float
    rows: int
    text: str


def dead_point(
    model: Model,
    t: FloatArray,
    q: FloatArray,
    u: FloatArray,
    ahead: float,
    step: Step,
    way: Way,
    since: int = 0,
    held: Sequence[tuple[int, str]] = (),
) -> DeadPoint | None:
    """The dead point at which a run could not go on, from its rows ``t`` (nt,), ``q`` and ``u`` (nt, n); ``None`` where
    it was none.

    A record of fixed steps may end well before: it is gone on from by steps ``ahead`` (s) at first, where ``step`` is
    the state a while after one, or a ``ValueError``; 0 where the rows lead to the place themselves. ``way`` is that
    of the drives to the first row. From row ``since`` on the contacts ``held`` are held, each as the second of its pair
    says.
    """

    def rows_at(place: FloatArray, rank: int | None = None) -> _Rows:
        return _Rows(model, place, held, rank)

    count = len(t) - since
    own_t, own_q, own_u = t[since:], q[since:], u[since:]
    looked = np.unique(np.linspace(0, count - 1, min(LOOKS, count)).astype(int))
    rank = max(rows_at(own_q[k]).rank for k in looked)
    usual = max(rows_at(own_q[k], rank).nearest for k in looked)
    kept = _last(lambda k: rows_at(own_q[k], rank).nearest >= BEFORE * usual, count)
    deep = _last(lambda k: k <= kept + 1 or rows_at(own_q[k], rank).nearest >= DEEP * usual, count)
    states = [(float(own_t[k]), own_q[k], own_u[k]) for k in range(kept, deep + 1)]
    if kept == count - 1:
        states = _walk(rows_at, rank, states[-1], ahead, step, DEEP * usual)
    if len(states) < 2:
        return None
    (t0, q0, _), (t1, q1, u1) = states[-2:]
    before, rows = rows_at(q0, rank), rows_at(q1, rank)
    speeds = np.asarray(drive_rows(model) @ u1, dtype=float)
    loops = len(model.rows)
    pushes = rows.left[loops : loops + len(speeds)] * speeds
    if not rows.least < before.least or rows.nearest >= BEFORE * usual:
        return None
    nearer = rows_at(states[0][1], rank).nearest / rows.nearest
    if np.abs(u1).max() < np.sqrt(nearer) * np.abs(states[0][2]).max():  # it can be passed: velocities do not grow
        return None
    left = (t1 - t0) * rows.least**2 / (before.least**2 - rows.least**2)
    gone = way.on(model, q[0], q1).gone
    turned = np.array([gone[drive["joint"]] for drive in model.data["drives"]]) + speeds * left
    stopped = np.abs(pushes) > PUSHED * np.abs(pushes).max()
    told = _said(model, turned, stopped) + (f" since t = {way.t:.10g} s" if way.t else "")
    text = (
        f"{told}, at t = {t1 + left:.10g} s: {lined_up(model, q1, rows.motion)}no motion "
        f"{_kept(model, held)} beyond; let what is prescribed end before, or use a [[motor]], which can give way"
    )
    return DeadPoint(t1 + left, since + kept + 1, text)


def _kept(model: Model, held: Sequence[tuple[int, str]]) -> str:
    """What no motion does beyond a dead point."""
    if not held:
        return "closes the loops"
    contacts = " and ".join("{} on {}".format(*model.contacts[contact]) for contact, _ in held)
    return f"{'closes the loops and ' if model.rows else ''}keeps {contacts}"


def _said(model: Model, turned: FloatArray, stopped: BoolArray) -> str:
    """Which drives come to a stop, and how far they have gone by then (rad, m)."""
    ways = [
        (drive["joint"], f"after {f'{way:.6g} m' if drive['slides'] else f'{np.degrees(way):.6g}°'}")
        for drive, way, stops in zip(model.data["drives"], turned, stopped, strict=True)
        if stops
    ]
    if len(ways) == 1:
        return f"{ways[0][0]} comes to a stop {ways[0][1]}"
    return f"{' and '.join(name for name, _ in ways)} come to a stop together ({', '.join(way for _, way in ways)})"


def cut(found: dict[str, Any], rows: int) -> dict[str, Any]:
    """What the core has found, up to and with its first ``rows`` rows."""
    end = found["t"][rows - 1]
    impacts = int(np.searchsorted(found["after"], rows))
    changes = int(np.searchsorted(found["hold_t"], end, side="right"))
    contacts = found["first"][impacts]
    lengths = dict.fromkeys(("t", "q", "u", "work", "latched"), rows)
    lengths |= dict.fromkeys(("impact_t", "u_minus", "u_plus", "energy_loss", "after"), impacts)
    lengths |= dict.fromkeys(("contacts", "impulses", "friction"), contacts) | {"first": impacts + 1}
    lengths |= dict.fromkeys(("hold_t", "held"), changes)
    stepping = [
        (t0, min(t1, end), step, miss, first, min(last, rows - 1))
        for t0, t1, step, miss, first, last in found["stepping"]
        if first < rows - 1
    ]
    kept = {name: found[name][:length] for name, length in lengths.items()}
    return found | kept | {"t_end": end, "stepping": stepping, "jumps": found["jumps"][: len(stepping)]}


class _Rows:
    """The closure's rows over the mechanism's length, below them the drives', and below them those of the contacts
    ``held``, at a configuration. ``rank`` of them are independent elsewhere: redundant joints make that less than
    there are."""

    def __init__(self, model: Model, q: FloatArray, held: Sequence[tuple[int, str]], rank: int | None = None) -> None:
        normals = [contact for contact, how in held if how != "carried"]
        sticking = [contact for contact, how in held if how == "sticks"]
        parts = [model.jacobian(q) / model.length, drive_rows(model)]
        parts += [rate_rows(model, "gap_rates", q)[normals] / model.length] if normals else []
        parts += [rate_rows(model, "slips", q)[sticking] / model.length] if sticking else []
        rows = np.asarray(np.vstack(parts), dtype=float)
        left, values, right = np.linalg.svd(rows)
        self.rank = rank or int(np.count_nonzero(values > DEPENDENT * values[0]))
        last = self.rank - 1
        self.least = float(values[last])
        self.nearest = self.least / float(values[0])
        self.left = left[:, last]
        """The combination of rows that comes to vanish."""
        self.motion = right[last]
        """The motion that they come to leave open."""


def _last(holds: Callable[[int], bool], count: int) -> int:
    """The last of ``count`` numbers from 0 on for which something holds that holds for 0 and, in the end, does so no
    more, or still does."""
    low, high, width = count - 1, count, 1
    while low > 0 and not holds(low):
        high, low, width = low, max(0, low - width), 2 * width
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low


def _walk(
    rows_at: Callable[[FloatArray, int], _Rows], rank: int, start: State, h: float, step: Step, near: float
) -> list[State]:
    """States on the way from ``start``, by ``h`` (s) at first, to where rows are as ``near`` to dependence as that."""
    states, least = [start], rows_at(start[1], rank).nearest
    for _ in range(WALK):
        t, q, u = states[-1]
        if least < near or not t + h > t:
            break
        try:
            there = step(t, q, u, h)
            least = rows_at(there[0], rank).nearest  # raises where a step beyond the place has turned links too far
        except ValueError:
            h /= 2.0
        else:
            states.append((t + h, *there))
    return states
