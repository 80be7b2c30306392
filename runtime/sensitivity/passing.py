"""How small differences pass an instant at which a run changes: impacts, and contacts that are held otherwise.

The instant moves along with them. What comes out is the saltation matrix, of contacts that strike together too
(M. A. Aizerman, F. R. Gantmakher, Journal of Applied Mathematics and Mechanics 22, 1958; R. I. Leine, H. Nijmeijer,
Dynamics and Bifurcations of Non-Smooth Mechanical Systems, 2004, chapter 7; docs/theory.md, eq. 11.8).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from ..arrays import FloatArray, IntArray
from ..model.forces import Held
from ..model.model import Model
from ..model.thresholds import characteristic_time
from ..record.impact import Impact
from .held import accelerations, changed
from .local import Local, Places, at_one
from .moving import Moving, whole_of
from .striking import after_impact, after_plain_impacts, plain_ones, prepare

MEET = 1e-6
"""Contacts meet at the instant of another where what their gaps differ by is below this part of the terms that it is
the sum of, or where all of it is rounding: below the square of that part of all that there is. Tangents are known to
about a hundred tolerances of the run; of what is not bound to meet, all is far above."""

SMOOTH = 1e-7
"""Accelerations that change by less than this part of what loads alone give to what is held at an instant do not jump
there: where it lies is known to rounding of the time, and they are to its root at the worst, where a force vanishes as
one. What stands until then has none of its own to compare with."""

RESTS = 1e-9
"""A rate is zero below this part of its terms."""

SLOW = 1e-6
"""An impact that closes slower than this part of the mechanism's speeds has no derivative: its instant moves by what
the gap moves, known to 1e-15 of lengths, over the approach, and would be known to less than 1e-9 of times. Bounces that
accumulate come below it."""


Check = Callable[[FloatArray], None]
"""Raises ``ValueError`` for columns (D, columns) of differences before a part that keep it from having one matrix."""


@dataclass(frozen=True, eq=False)
class Passed:
    """An instant ``t`` (s) that small differences have passed.

    ``contacts`` are those that struck, or slid until then, ``events`` those of the scene that set or switched something
    there, or ended the run, ``joints`` are what let go or took hold. ``dt`` (columns,) is by what the instant moves, s
    per unit of each column; ``behind`` (2 n, columns) is by what the state (q, u) behind the instant does, wherever
    that has moved: the derivative of the map onto a section. ``matrix`` (2 n, 2 n) is the saltation matrix, in units of
    the mechanism; where one direction passed that parted its contacts, what that does to this direction alone.
    """

    t: float
    kind: Literal["impact", "sliding ends", "force ends", "event", "release"]
    contacts: tuple[tuple[str, str], ...]
    dt: FloatArray
    behind: FloatArray
    matrix: FloatArray
    events: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()

    @cached_property
    def growth(self) -> float:
        """The largest factor by which a difference of the state, in units of the mechanism, grows there: near grazing,
        where a contact closes slowly, it is large, as one by the speed of closing."""
        return float(np.linalg.norm(self.matrix, 2))


def by_columns(instants: Sequence[Passed], whole: FloatArray) -> list[Passed]:
    """Instants whose ``dt`` and ``behind`` are by all D directions, by the columns of ``whole`` (instants, D,
    columns)."""
    dt = (np.array([one.dt for one in instants])[:, None] @ whole)[:, 0]
    behind = np.array([one.behind for one in instants]) @ whole
    return [
        replace(one, dt=its_dt, behind=its_behind) for one, its_dt, its_behind in zip(instants, dt, behind, strict=True)
    ]


class Parted(ValueError):
    """Contacts that strike together, which a column parts."""


Instant = tuple[Sequence[Impact], FloatArray, tuple[Held, Held]]
"""The impacts of one instant, the coordinates (n,) there, and what is held before it and after."""


class Part(NamedTuple):
    """What a part of a run makes of small differences: a ``matrix`` (2 n, D) from those of the state and the arguments
    before it to those of the state behind it, (D, D) to those of the arguments too where it changes these, and
    ``checks`` of the columns before it.

    Of an instant that is passed, ``passed`` has rows by all D directions instead of columns; ``instant`` is that of
    impacts.
    """

    matrix: FloatArray
    checks: tuple[Check, ...] = ()
    passed: Passed | None = None
    instant: Instant | None = None

    def through(self, whole: FloatArray) -> FloatArray:
        """Differences behind the part, (2 n, columns) or (D, columns), of those (D, columns) before it."""
        return np.asarray(self.matrix @ whole)


def pass_impacts(model: Model, moving: Moving, instants: Sequence[Instant]) -> list[Part]:
    """The instants at which impacts come; what they need is found for all at once."""
    if not instants:
        return []
    firsts, lasts = ([one[0][which] for one in instants] for which in (0, -1))
    contacts = [[model._contact(contact) for contact in one.contacts] for one in firsts]
    at = Places(model, moving, np.array([one.t for one in firsts]), np.array([one[1] for one in instants]))
    u_minus, u_plus = np.array([one.u_minus for one in firsts]), np.array([one.u_plus for one in lasts])
    before, after = (_sides(at, [one[2][side] for one in instants], u) for side, u in enumerate((u_minus, u_plus)))
    rates = (at.gap_rows @ u_minus[:, :, None])[:, :, 0]
    trigger = _triggers(at, firsts, contacts, rates, u_minus)
    each, (b, n) = np.arange(len(firsts)), u_minus.shape
    gaps = at.gaps_move()
    dt = -gaps[each, trigger] / rates[each, trigger][:, None]
    D = dt.shape[1]
    there = np.repeat(np.eye(D)[None], b, axis=0)
    there[:, : 2 * n] += np.concatenate([u_minus, before], axis=1)[:, :, None] * dt[:, None]
    which = plain_ones(model, [one[0] for one in instants], contacts)
    jumps, kept = np.zeros((b, n, D)), list[list[Check]]([[] for _ in instants])
    if which.size:
        plain = at if which.size == b else at.some(which)
        jumps[which] = after_plain_impacts(plain, [firsts[i] for i in which], [contacts[i][0] for i in which])
    if which.size < b:
        others = np.delete(each, which)
        apart = at.some(others, known={})
        prepare(apart, [firsts[i] for i in others])
        for number, i in enumerate(others.tolist()):
            jumps[i], kept[i] = _struck(Local(apart, number), instants[i][0], np.eye(2 * n, D)[n:])
    matrices, behind = _salted(there, jumps, dt, np.concatenate([u_plus, after], axis=1))
    parts, units = [], in_units(model, matrices)
    for i, (impacts, _, _) in enumerate(instants):
        checks = [_there(there[i], check) for check in kept[i]]
        if len(impacts) > 1 or len(contacts[i]) > 1:
            struck = list(dict.fromkeys(model._contact(contact) for impact in impacts for contact in impact.contacts))
            if len(struck) > 1:
                checks.insert(0, _meet(Local(at, i), struck, int(trigger[i]), gaps[i], u_minus[i], dt[i]))
        passed = Passed(firsts[i].t, "impact", tuple(firsts[i].contacts), dt[i], behind[i], units[i])
        parts.append(Part(matrices[i], tuple(checks), passed, instants[i]))
    return parts


def _sides(at: Places, held: Sequence[Held], u: FloatArray) -> FloatArray:
    """Accelerations (b, n) on one side of the instants, with what is held there."""
    if not any(held):
        return accelerations(at.model, (), at.t, at.q, u)[0]
    found = np.zeros_like(u)
    flies = np.array([not one for one in held])
    if flies.any():
        found[flies] = accelerations(at.model, (), at.t[flies], at.q[flies], u[flies])[0]
    for i in np.flatnonzero(~flies).tolist():
        some = slice(i, i + 1)
        found[i] = accelerations(at.model, held[i], at.t[some], at.q[some], u[some])[0][0]
    return found


def _triggers(
    at: Places, impacts: Sequence[Impact], contacts: Sequence[Sequence[int]], rates: FloatArray, u: FloatArray
) -> IntArray:
    """Of the ``contacts`` of each impact the one that closes fastest, in terms of the size of its rows, by which rates
    of stops and of grounds are comparable. ``rates`` (b, contacts) are those before, at u (b, n)."""
    sizes = RESTS * (np.abs(at.gap_rows) @ np.abs(u)[:, :, None])[:, :, 0]
    least = SLOW * np.abs(at.gap_rows) @ (at.model.coordinate_units / characteristic_time(at.model))
    closes, found = (rates < -np.maximum(sizes, least)).tolist(), np.zeros(len(impacts), dtype=np.int_)
    for i, impact in enumerate(impacts):
        closing = [c for c in contacts[i] if closes[i][c]]
        if not closing:
            raise ValueError(
                f"{at.model.name}: the impact at t = {impact.t:.9g} s has no derivative: none of its contacts closes "
                f"faster than {SLOW:g} of the mechanism's speeds, as where bounces accumulate, friction jams or a "
                "contact grazes; end the run before it"
            )
        found[i] = closing[0]
        if len(closing) > 1:
            scales = np.sqrt(np.sum(at.gap_rows[i, closing] ** 2, axis=1))
            found[i] = closing[int(np.argmin(rates[i, closing] / scales))]
    return found


def _there(there: FloatArray, check: Check) -> Check:
    """A check of the differences ``there`` at the instant, as one of those before it."""
    return lambda whole: check(there @ whole)


def _struck(at: Local, impacts: Sequence[Impact], moves: FloatArray) -> tuple[FloatArray, list[Check]]:
    """What u moves by (n, D) behind all impacts, in the directions of ``at``, one after the other at the same instant;
    and checks of the directions (D, columns) that there are at the instant."""
    checks: list[Check] = []
    for impact in impacts:
        moves, more = after_impact(at, impact, moves)
        checks += more
    return moves, checks


def _salted(there: FloatArray, jumps: FloatArray, dt: FloatArray, after: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Matrices (b, 2 n, D) of the differences behind instants, at the time of the run and where the instants are: to
    the instants that move by ``dt`` (b, D), where differences are ``there`` (b, D, D), through the jumps (b, n, D) of
    the rates there, and back to the time of the run, with what states change at ``after`` (b, 2 n) (docs/theory.md, eq.
    11.8)."""
    behind = np.concatenate([there[:, : jumps.shape[1]], jumps @ there], axis=1)
    return behind - after[:, :, None] * dt[:, None], behind


def _meet(
    at: Local, struck: Sequence[int], trigger: int, gaps: FloatArray, u: FloatArray, dt_moves: FloatArray
) -> Check:
    """All contacts of the instant are closed there for the differences too, whatever the column."""

    def check(whole: FloatArray) -> None:
        dt = dt_moves @ whole
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
                f"{column} parts: which of them comes first then depends on the sign of the change, and there is no "
                "one matrix of derivatives; leave out that column, derive along one direction with directional, or "
                "start where they do not strike together"
            )

    return check


def pass_change(model: Model, moving: Moving, t: float, q: FloatArray, u: FloatArray, ways: tuple[Held, Held]) -> Part:
    """An instant without an impact at which contacts are held otherwise."""
    n, D = len(q), len(moving.directions.columns)
    before, after = _accelerations(model, t, q, u, u, ways)
    at = at_one(model, moving, t, q)
    slid = changed(*ways)
    names = tuple(model.contacts[c] for c in slid)
    moved = [c for c, *_ in (*ways[0], *ways[1])]
    of_contacts = np.any(np.concatenate([at.gap_rows[moved], at.slip_rows[moved]]) != 0.0, axis=0)
    free = accelerations(model, (), np.array([t]), q[None], np.ascontiguousarray(u[None]))[0][0] * of_contacts
    unit = model.coordinate_units
    size = max(float(np.max(np.abs(each) / unit)) for each in (before, after, free))
    if float(np.max(np.abs(after - before) / unit)) <= SMOOTH * size:
        let_go = tuple(model.contacts[c] for c, *_ in ways[0] if c not in {x for x, *_ in ways[1]})
        none = np.full((2 * n + 1, D), np.nan)
        return Part(np.eye(2 * n, D), (), Passed(t, "force ends", names or let_go, none[0], none[1:], np.eye(2 * n)))
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
    dt = -slips[trigger] / rates[trigger]

    def check(whole: FloatArray) -> None:
        for c in ended:
            apart = slips[c] @ whole + rates[c] * (dt @ whole)
            terms = np.abs(slips[c]) @ np.abs(whole) + np.abs(rates[c] * (dt @ whole))
            most = whole_of(model, moving, at.slip_rows[c]) / characteristic_time(model)
            if np.any(np.abs(apart) > MEET * (terms + MEET * most)):
                one, other = ("{} on {}".format(*model.contacts[x]) for x in (trigger, c))
                raise ValueError(
                    f"{model.name}: found sliding of {one} and {other} that ends together at t = {t:.9g} s, which the "
                    "directions part; there is no one matrix of derivatives"
                )

    there = np.eye(D)
    there[: 2 * n] += np.outer(np.concatenate([u, before]), dt)
    matrices, behind = _salted(there[None], np.eye(2 * n, D)[None, n:], dt[None], np.hstack([u, after])[None])
    passed = Passed(t, "sliding ends", names, dt, behind[0], in_units(model, matrices)[0])
    return Part(matrices[0], (check,) if len(ended) > 1 else (), passed)


def _accelerations(
    model: Model, t: float, q: FloatArray, u_minus: FloatArray, u_plus: FloatArray, ways: tuple[Held, Held]
) -> tuple[FloatArray, FloatArray]:
    times = np.array([t])
    before = accelerations(model, ways[0], times, q[None], np.ascontiguousarray(u_minus[None]))[0][0]
    after = accelerations(model, ways[1], times, q[None], np.ascontiguousarray(u_plus[None]))[0][0]
    return before, after


def in_units(model: Model, matrices: FloatArray) -> FloatArray:
    """By the state alone, (b, 2 n, 2 n), in units of the mechanism."""
    unit = model.coordinate_units
    units = np.concatenate([unit, unit / characteristic_time(model)])
    return np.asarray(matrices[:, :, : len(units)] * (units / units[:, None]))
