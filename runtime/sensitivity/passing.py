"""How small differences pass an instant at which a run changes: impacts, and contacts that are held otherwise.

The instant moves along with them. What comes out is the saltation matrix, of contacts that strike together too
(M. A. Aizerman, F. R. Gantmakher, Journal of Applied Mathematics and Mechanics 22, 1958; R. I. Leine, H. Nijmeijer,
Dynamics and Bifurcations of Non-Smooth Mechanical Systems, 2004, chapter 7; docs/theory.md, eq. 11.8).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..arrays import FloatArray
from ..model.forces import Held
from ..model.model import Model
from ..model.thresholds import characteristic_time
from ..record.impact import Impact
from .held import accelerations, changed
from .local import Local
from .moving import Moving, whole_of
from .striking import after_impact

MEET = 1e-6
"""Contacts meet at the instant of another where what their gaps differ by is below this part of the terms that it is
the sum of, or where all of it is rounding: below the square of that part of all that there is. Tangents are known to
about a hundred tolerances of the run; of what is not bound to meet, all is far above."""

SMOOTH = 1e-7
"""Accelerations that change by less than this part of themselves at an instant do not jump there: where it lies is
known to rounding of the time, and they are to its root at the worst, where a force vanishes as one."""

RESTS = 1e-9
"""A rate is zero below this part of its terms."""


@dataclass(frozen=True, eq=False)
class Passed:
    """An instant ``t`` (s) that small differences have passed.

    ``contacts`` are those that struck, or slid until then. ``dt`` (columns,) is by what the instant moves, s per unit
    of each column; ``behind`` (2 n, columns) is by what the state (q, u) behind the instant does, wherever that has
    moved: the derivative of the map onto a section. ``growth`` is the largest factor by which a difference of the
    state, in units of the mechanism, grows there: near grazing, where a contact closes slowly, it is large, as one by
    the speed of closing.
    """

    t: float
    kind: Literal["impact", "sliding ends", "force ends"]
    contacts: tuple[tuple[str, str], ...]
    dt: FloatArray
    behind: FloatArray
    growth: float


class Parted(ValueError):
    """Contacts that strike together, which a column parts."""


def pass_impacts(
    model: Model,
    moving: Moving,
    impacts: Sequence[Impact],
    q: FloatArray,
    S: FloatArray,
    ways: tuple[Held, Held],
) -> tuple[FloatArray, Passed]:
    """Differences S (2 n, columns) of the state behind the impacts of one instant, from those before."""
    first, last = impacts[0], impacts[-1]
    t, n = first.t, len(q)
    at = Local(model, moving, t, q)
    before, after = _accelerations(model, t, q, first.u_minus, last.u_plus, ways)
    chosen = [model._contact(contact) for contact in first.contacts]
    rates = {c: float(at.gap_rows[c] @ first.u_minus) for c in chosen}
    closing = [c for c in chosen if rates[c] < -RESTS * float(np.abs(at.gap_rows[c]) @ np.abs(first.u_minus))]
    if not closing:
        raise ValueError(
            f"{model.name}: the impact at t = {t:.9g} s has no derivative: none of its contacts closes, as where "
            "bounces accumulate, friction jams or a contact grazes; end the run before it"
        )
    trigger = min(closing, key=lambda c: rates[c] / at_scale(at, c))
    gaps = at.gaps_move()
    whole = moving.whole(S[:n], S[n:])
    guard = gaps[trigger]
    dt = -(guard @ whole) / rates[trigger]
    struck = list(dict.fromkeys(model._contact(contact) for impact in impacts for contact in impact.contacts))
    _check_meet(at, struck, trigger, gaps, whole, first.u_minus, dt)
    there = whole.copy()
    there[: 2 * n] += np.outer(np.concatenate([first.u_minus, before]), dt)
    D = _struck(at, impacts, np.eye(2 * n, whole.shape[0])[n:], there)
    sides = (first.u_minus, before), (last.u_plus, after)
    found, behind, matrix = _salted(at, S, guard, rates[trigger], dt, sides, D)
    return found, Passed(t, "impact", tuple(first.contacts), dt, behind, _growth(model, matrix))


def at_scale(at: Local, contact: int) -> float:
    """The size of the rows of a contact, by which rates of stops and of grounds are comparable."""
    return float(np.linalg.norm(at.gap_rows[contact])) or 1.0


def _struck(at: Local, impacts: Sequence[Impact], moves: FloatArray, along: FloatArray) -> FloatArray:
    """What u moves by (n, D) behind all impacts, in the directions of ``at``, one after the other at the same instant;
    ``along`` (D, columns) are the directions that there are at the instant."""
    for impact in impacts:
        moves = after_impact(at, impact, moves, along)
    return moves


def _salted(
    at: Local,
    S: FloatArray,
    guard: FloatArray,
    rate: float,
    dt: FloatArray,
    sides: tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]],
    D: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Differences behind an instant, at the time of the run and where the instant is, and the matrix (2 n, 2 n) of the
    former by those in the state: to the instant that moves, through the jump D there, and back to the time of the run
    (docs/theory.md, eq. 11.8)."""
    n, (before, after) = len(at.q), sides

    def through(states: FloatArray, arguments: FloatArray, moved: FloatArray) -> tuple[FloatArray, FloatArray]:
        q = states[:n] + np.outer(before[0], moved)
        u = states[n:] + np.outer(before[1], moved)
        jumped = D @ np.vstack([q, u, arguments])
        there = np.vstack([q, jumped])
        return there - np.outer(np.concatenate(after), moved), there

    none = np.zeros((len(at.moving.along), 2 * n))
    matrix, _ = through(np.eye(2 * n), none, -guard[: 2 * n] / rate)
    return *through(S, at.moving.along, dt), matrix


def _check_meet(
    at: Local,
    struck: Sequence[int],
    trigger: int,
    gaps: FloatArray,
    whole: FloatArray,
    u: FloatArray,
    dt: FloatArray,
) -> None:
    """All contacts of the instant are closed there for the differences too, whatever the column."""
    for c in struck:
        apart = gaps[c] @ whole + float(at.gap_rows[c] @ u) * dt
        terms = np.abs(gaps[c]) @ np.abs(whole) + np.abs(at.gap_rows[c]) @ np.abs(u) * np.abs(dt)
        wrong = np.abs(apart) > MEET * (terms + MEET * whole_of(at.model, at.moving, at.gap_rows[c]))
        if not wrong.any():
            continue
        column = at.moving.columns[int(np.flatnonzero(wrong)[0])]
        one, other = ("{} on {}".format(*at.model.contacts[x]) for x in (trigger, c))
        raise Parted(
            f"{at.model.name}: found contacts that strike together at t = {at.t:.9g} s, {one} and {other}, which "
            f"{column} parts: which of them comes first then depends on the sign of the change, and there is no one "
            "matrix of derivatives; leave out that column, derive along one direction with directional, or start where "
            "they do not strike together"
        )


def pass_change(
    model: Model, moving: Moving, t: float, q: FloatArray, u: FloatArray, S: FloatArray, ways: tuple[Held, Held]
) -> tuple[FloatArray, Passed]:
    """Differences S (2 n, columns) behind an instant without an impact at which contacts are held otherwise."""
    n = len(q)
    before, after = _accelerations(model, t, q, u, u, ways)
    at = Local(model, moving, t, q)
    slid = changed(*ways)
    names = tuple(model.contacts[c] for c in slid)
    jump = float(np.max(np.abs(after - before)))
    size = max(float(np.max(np.abs(after))), float(np.max(np.abs(before))))
    if jump <= SMOOTH * size:
        let_go = tuple(model.contacts[c] for c, *_ in ways[0] if c not in {x for x, *_ in ways[1]})
        return S, Passed(t, "force ends", names or let_go, np.full(S.shape[1], np.nan), np.full_like(S, np.nan), 1.0)
    whole = moving.whole(S[:n], S[n:])
    slips = at.slips_move(u)
    ended = [
        c
        for c in slid
        if abs(float(at.slip_rows[c] @ u)) <= MEET * float(np.abs(at.slip_rows[c]) @ np.abs(u))
        or abs(float(at.slip_rows[c] @ u)) <= RESTS * model.length / characteristic_time(model)
    ]
    if closed := [model.contacts[c] for c, *_ in ways[1] if c not in {x for x, *_ in ways[0]}]:
        where = " and ".join("{} on {}".format(*one) for one in closed)
        raise ValueError(
            f"{model.name}: found {where} at rest from t = {t:.9g} s on, where its bounces accumulate or it touches "
            "without striking, expected a run of impacts one by one; end the run before"
        )
    if not ended:
        raise ValueError(
            f"{model.name}: found accelerations that jump at t = {t:.9g} s without an impact and without an end of "
            "sliding, expected one of these; runs have no derivatives there"
        )
    bias = model.kernels.of_state("slip_bias", q[None], u[None])[0]
    rates = {c: float(at.slip_rows[c] @ before + bias[c]) for c in ended}
    trigger = max(ended, key=lambda c: abs(rates[c]))
    if rates[trigger] == 0.0:
        raise ValueError(
            f"{model.name}: found sliding at t = {t:.9g} s that ends without slowing down; it has no derivative"
        )
    dt = -(slips[trigger] @ whole) / rates[trigger]
    for c in ended:
        apart = slips[c] @ whole + rates[c] * dt
        terms = np.abs(slips[c]) @ np.abs(whole) + np.abs(rates[c] * dt)
        most = whole_of(model, moving, at.slip_rows[c]) / characteristic_time(model)
        if np.any(np.abs(apart) > MEET * (terms + MEET * most)):
            one, other = ("{} on {}".format(*model.contacts[x]) for x in (trigger, c))
            raise ValueError(
                f"{model.name}: found sliding of {one} and {other} that ends together at t = {t:.9g} s, which the "
                "directions part; there is no one matrix of derivatives"
            )
    D = np.eye(2 * n, whole.shape[0])[n:]
    found, behind, matrix = _salted(at, S, slips[trigger], rates[trigger], dt, ((u, before), (u, after)), D)
    return found, Passed(t, "sliding ends", names, dt, behind, _growth(model, matrix))


def _accelerations(
    model: Model, t: float, q: FloatArray, u_minus: FloatArray, u_plus: FloatArray, ways: tuple[Held, Held]
) -> tuple[FloatArray, FloatArray]:
    times = np.array([t])
    before = accelerations(model, ways[0], times, q[None], np.ascontiguousarray(u_minus[None]))[0][0]
    after = accelerations(model, ways[1], times, q[None], np.ascontiguousarray(u_plus[None]))[0][0]
    return before, after


def _growth(model: Model, matrix: FloatArray) -> float:
    """The largest singular value, in units of the mechanism."""
    unit = model.coordinate_units
    units = np.concatenate([unit, unit / characteristic_time(model)])
    return float(np.linalg.norm(matrix * units / units[:, None], 2))
