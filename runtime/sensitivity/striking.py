"""What the rates after an impact move by: its law, linearised about what each contact did (docs/theory.md, eq. 11.9).

What each contact did, pushed or left, stuck or slid, is read off its impulses and rates and held to the law's own
conditions; an impact that is within rounding of another way has no derivative, and is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from ..arrays import FloatArray, IntArray
from ..model.model import Model
from ..record.impact import Impact
from .held import DEPENDENT, FIXED, solved
from .local import Local, Places
from .moving import whole_of

UNDECIDED = 1e-9
"""Rates and impulses count as zero below this part of those of the impact: laws of impact are decided to 1e-10 of the
terms that they compare (docs/theory.md, section 5.7), and what is ten times that may still be either."""

MISSED = 1e-6
"""Rows keep their rates where they miss them by less than this part of their terms: as of gaps that meet (``MEET``)."""

GAINS = 1e-7
"""An impact that gains no energy with its share of restitution, and would with more, keeps it to this part: the share
is found to 1e-9 (docs/events.md), and near a wedge energy changes with it by a hundred times as much."""

Normal = Literal["rate", "given", "leaves"]

Checks = list[Callable[[FloatArray], None]]
"""Raise ``ValueError`` for directions (D, columns) that there are, all contacts closed, that part what has to keep."""


@dataclass
class Way:
    """How one contact takes part in one stage of an impact, and with which impulses.

    Its rate along the normal after the stage is given, or its impulse is, or it leaves without one; along the ground it
    ``sticks``, or its friction is ``sign`` times the limit, or it has none (``sign`` 0). ``kept`` says what else stays
    at rest because others do: its normal rate, though it does not push, or its sliding, though friction is at the
    limit.
    """

    contact: int
    normal: Normal
    sticks: bool = False
    sign: float = 0.0
    P: float = 0.0
    F: float = 0.0
    kept: tuple[Literal["normal", "sliding"], ...] = ()


@dataclass
class Stage:
    """From the rates ``before`` to those ``after`` (n,), with what these rates move by: (n, D) each. ``checks`` are of
    the directions (D, columns) that there are, all contacts closed.

    ``by_share`` (n,) is what the rates after it move by with the part of restitution that contacts have, which gives
    the rates ``share`` by contact. ``P`` (contacts, D) is what normal impulses move by; ``wanted`` (contacts, D) is
    what normal rates after it are to move by, where they are given.
    """

    ways: Sequence[Way]
    before: FloatArray
    after: FloatArray
    before_moves: FloatArray
    wanted: FloatArray
    P: FloatArray
    checks: Checks
    after_moves: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    share: dict[int, float] = field(default_factory=dict)
    by_share: FloatArray = field(default_factory=lambda: np.zeros(0))


def after_impact(at: Local, impact: Impact, before_moves: FloatArray) -> tuple[FloatArray, Checks]:
    """What u+ of an impact moves by, (n, D), where u- moves by ``before_moves`` (n, D) in the directions of ``at``; and
    checks of those that there are.

    Raises ``ValueError`` for an impact that has no derivative, or whose law is not covered, and says why.
    """
    model = at.model
    chosen = [model._contact(contact) for contact in impact.contacts]
    mu, e = model.kernels.friction[chosen], restitution_of(model, chosen)
    law = model.data["law"]
    if impact.restitution_share < 1.0 and (law != "newton" or model.data["drives"]):
        raise _refused(
            at,
            impact,
            "its contacts had less than their restitution, as all of it would have gained energy or has no impulses, "
            "which is covered by Newton's law without drives alone",
        )
    alike = len({model.contacts[contact][1] for contact in chosen}) == 1
    if law == "newton" or not e.any() or (not mu.any() and alike):
        return _by_newton(at, impact, chosen, e, mu, before_moves)
    if law == "poisson":
        return _by_poisson(at, impact, chosen, e, mu, before_moves)
    if len(chosen) == 1 and _slides_through(at, impact, chosen[0]):
        return _by_newton(at, impact, chosen, e, mu, before_moves)
    raise _refused(
        at,
        impact,
        "by Stronge's law what is given back is followed along the impulses where sliding ends within an impact, or "
        "where "
        'several contacts have friction or differ in restitution; use law = "newton" or "poisson"',
    )


def _refused(at: Local, impact: Impact, why: str) -> ValueError:
    where = " and ".join("{} on {}".format(*contact) for contact in impact.contacts)
    return ValueError(f"{at.model.name}: the impact of {where} at t = {impact.t:.9g} s has no derivative here: {why}")


def restitution_of(model: Model, chosen: Sequence[int]) -> FloatArray:
    """The coefficients of contacts."""
    grounds = [model.contacts[contact][1].partition(".")[0] for contact in chosen]
    return np.array([model.parameters[f"{ground}.restitution"] for ground in grounds])


def _slides_through(at: Local, impact: Impact, contact: int) -> bool:
    """Whether the one contact slides in the same direction from the beginning of the impact to its end."""
    before, after = (float(at.slip_rows[contact] @ u) for u in (impact.u_minus, impact.u_plus))
    speed = _speed(at, contact, impact.u_minus)
    return before * after > 0.0 and min(abs(before), abs(after)) > UNDECIDED * speed


def _speed(at: Local, contact: int, *u: FloatArray) -> float:
    """The size of the terms that a contact's rates consist of (m/s, or rad/s)."""
    sizes = np.abs(at.gap_rows[contact]) + np.abs(at.slip_rows[contact])
    return max(float(sizes @ np.abs(one)) for one in u) or 1.0


def prepare(at: Places, impacts: Sequence[Impact]) -> None:
    """Find what impacts at as many configurations need, for all of them at once: where several follow each other at
    one, the first of them; by Poisson's law the rest follows from what its compression ends with."""
    count, by = len(at.model.contacts), ("q", "k")
    before, after = (np.array([getattr(one, name) for one in impacts]) for name in ("u_minus", "u_plus"))
    P, F = np.zeros((len(impacts), count)), np.zeros((len(impacts), count))
    for i, one in enumerate(impacts):
        chosen = [at.model._contact(contact) for contact in one.contacts]
        P[i, chosen] = one.impulses
        if one.friction.size:
            F[i, chosen] = one.friction
    at.gap_rates_move(before, by)
    at.gap_rates_move(after, by)
    at.closure_rates_move(after, by)
    at.pushes_move(P, F)
    at.tangent("jump", len(after[0]) + len(at.model.rows), after - before, by, multipliers=at.loop_impulses(P, F))
    if F.any():
        at.slips_move(after, by)


def plain_ones(model: Model, impacts: Sequence[Sequence[Impact]], contacts: Sequence[Sequence[int]]) -> IntArray:
    """The instants whose impact is that of one smooth contact that surely pushes, with all of its restitution: laws are
    alike then. ``contacts`` are those of the first impact of each."""
    smooth = (model.kernels.friction == 0.0).tolist()
    found = [
        i
        for i, (one, chosen) in enumerate(zip(impacts, contacts, strict=True))
        if len(one) == len(chosen) == 1
        and smooth[chosen[0]]
        and one[0].restitution_share == 1.0
        and one[0].impulses[0] > 0.0
    ]
    return np.array(found, dtype=np.intp)


def after_plain_impacts(at: Places, impacts: Sequence[Impact], contacts: Sequence[int]) -> FloatArray:
    """What u+ of plain impacts of ``contacts`` at as many configurations moves by, (impacts, n, D): ``_by_newton`` of
    all at once, with one unknown impulse each."""
    model, (_, n), by = at.model, at.q.shape, ("q", "k")
    e, each = restitution_of(model, range(len(model.contacts)))[list(contacts)], np.arange(len(impacts))
    before, after = (np.array([getattr(one, name) for one in impacts]) for name in ("u_minus", "u_plus"))
    N, response = at.gap_rows[each, contacts], at.responses[:, :n]
    P = np.zeros((len(impacts), len(model.contacts)))
    P[each, contacts] = [impact.impulses[0] for impact in impacts]
    none = np.zeros_like(P)
    terms = N * np.array([before, after])
    (rate, left), speeds = terms.sum(axis=2), np.abs(terms).sum(axis=2).max(axis=0)
    for i in np.flatnonzero(np.abs(left + e * rate) > UNDECIDED * np.where(speeds > 0.0, speeds, 1.0)).tolist():
        name = "{} on {}".format(*impacts[i].contacts[0])
        raise _refused(Local(at, i), impacts[i], f"{name} does not leave as one step of the law has it")
    size = n + len(model.rows)
    held = at.tangent("jump", size, after - before, by, multipliers=at.loop_impulses(P, none))[:, :n]
    start = np.eye(2 * n, held.shape[2])[n:]
    f = held + at.pushes_move(P, none)
    shut = -at.closure_rates_move(after, by) - at.closure_rows @ start
    moved = start + response[:, :, :n] @ f + response[:, :, n:] @ shut
    answer = (response[:, :, :n] @ N[:, :, None])[:, :, 0]
    # N (u+ + e u-), linear in the rates
    bent = at.gap_rates_move(after + e[:, None] * before, by)[each, contacts]
    changes = at.coefficients_move("restitution")[contacts]
    wanted = -bent - e[:, None] * (N @ start) - changes * rate[:, None]
    missing = wanted - (N[:, None] @ moved)[:, 0]
    return np.asarray(moved + answer[:, :, None] * (missing / np.sum(N * answer, axis=1)[:, None])[:, None])


def _by_newton(
    at: Local,
    impact: Impact,
    chosen: Sequence[int],
    e: FloatArray,
    mu: FloatArray,
    before_moves: FloatArray,
) -> tuple[FloatArray, Checks]:
    """N u+ = -e N u- where it pushes."""
    u_minus, u_plus, share = impact.u_minus, impact.u_plus, impact.restitution_share
    whole, e = e, share * e
    targets = {c: -e_c * float(at.gap_rows[c] @ u_minus) for c, e_c in zip(chosen, e, strict=True)}
    friction = impact.friction if impact.friction.size else np.zeros(len(chosen))
    P = dict(zip(chosen, impact.impulses, strict=True))
    F = dict(zip(chosen, friction, strict=True))
    ways = _ways(at, impact, chosen, mu, u_minus, u_plus, P, F, targets)
    count = len(at.model.contacts)
    wanted = np.zeros((count, before_moves.shape[1]))
    changes = at.coefficients_move("restitution")
    approach = at.gap_rates_move(u_minus, ("q", "k")) + at.gap_rows @ before_moves
    for c, e_c in zip(chosen, e, strict=True):
        wanted[c] = -e_c * approach[c] - share * changes[c] * float(at.gap_rows[c] @ u_minus)
    stage = Stage(ways, u_minus, u_plus, before_moves, wanted, np.zeros_like(wanted), [])
    if share < 1.0:
        stage.share = {c: -e_c * float(at.gap_rows[c] @ u_minus) for c, e_c in zip(chosen, whole, strict=True)}
    _move(at, stage)
    return stage.after_moves if share == 1.0 else _without_gain(at, impact, stage), stage.checks


def _without_gain(at: Local, impact: Impact, stage: Stage) -> FloatArray:
    """What the rates after an impact move by (n, D) whose share of restitution is the one with which no energy is
    gained: that share moves so that the kinetic energy behind it stays that before it.

    Raises ``ValueError`` where more of it would not gain energy little by little, but by another way to strike.
    """
    momenta, energies, moves = [], [], []
    for u in (stage.before, stage.after):
        momenta.append(at.model.kernels.of_state("momentum", at.q[None], u[None])[0])
        energies.append(float(at.model.kernels.of_state("energy", at.q[None], u[None])[0, 0]))
        moves.append(at.tangent("energy", 2, u, ("q", "k"))[0])
    if abs(energies[1] - energies[0]) > GAINS * energies[0]:
        raise _refused(
            at,
            impact,
            f"its contacts had {impact.restitution_share:.6g} of their restitution, where more of it would be "
            "another way to strike that gains energy, or has no impulses",
        )
    gained = moves[1] + momenta[1] @ stage.after_moves - moves[0] - momenta[0] @ stage.before_moves
    rate = float(momenta[1] @ stage.by_share)
    return np.asarray(stage.after_moves - np.outer(stage.by_share, gained / rate))


def _by_poisson(
    at: Local,
    impact: Impact,
    chosen: Sequence[int],
    e: FloatArray,
    mu: FloatArray,
    before_moves: FloatArray,
) -> tuple[FloatArray, Checks]:
    """Compression to N u = 0, then at least e times its impulses."""
    model, count, k = at.model, len(at.model.contacts), len(chosen)
    compressed, impulses, outcome = model.kernels.impact(
        at.q, np.ascontiguousarray(impact.u_minus), np.array(chosen, dtype=np.int32), np.zeros(k)
    )
    if outcome != "done":
        raise _refused(at, impact, f"its compression has no impulses by itself ({outcome.replace('_', ' ')})")
    friction = impact.friction if impact.friction.size else np.zeros(k)
    P, F = impulses[:k], impulses[k : 2 * k]
    still = dict.fromkeys(chosen, 0.0)
    named = [dict(zip(chosen, one.tolist(), strict=True)) for one in (P, F, impact.impulses - P, friction - F)]
    first = _ways(at, impact, chosen, mu, impact.u_minus, compressed, named[0], named[1], still)
    none = np.zeros((count, before_moves.shape[1]))
    compression = Stage(first, impact.u_minus, compressed, before_moves, none, none.copy(), [])
    _move(at, compression)
    least = dict(zip(chosen, (e * P).tolist(), strict=True))
    then = _ways(at, impact, chosen, mu, compressed, impact.u_plus, named[2], named[3], still, least)
    given = none.copy()
    changes = at.coefficients_move("restitution")
    for i, c in enumerate(chosen):
        given[c] = e[i] * compression.P[c] + changes[c] * P[i]
    expansion = Stage(then, compressed, impact.u_plus, compression.after_moves, none, given, compression.checks)
    _move(at, expansion)
    return expansion.after_moves, expansion.checks


def _ways(
    at: Local,
    impact: Impact,
    chosen: Sequence[int],
    mu: FloatArray,
    before: FloatArray,
    after: FloatArray,
    P: dict[int, float],
    F: dict[int, float],
    targets: dict[int, float],
    least: dict[int, float] | None = None,
) -> list[Way]:
    """What each contact did in one stage: it has its target rate and pushes more than the ``least``, or pushes with
    that."""
    ways = []
    # what an impulse is known to: that of the contact that has most, by the rates that it gives
    units = {c: _strength(at, c) for c in chosen}
    largest = max(P[c] * units[c] for c in chosen)
    # rates are known to what is struck with, of all contacts together: one may be at rest to rounding
    speed = max(_speed(at, c, before, after) for c in chosen)
    for c, mu_c in zip(chosen, mu, strict=True):
        at_rate = abs(float(at.gap_rows[c] @ after) - targets[c]) <= UNDECIDED * speed
        own = P[c] - (least[c] if least else 0.0)
        pushes = own * units[c] > UNDECIDED * max(largest, 0.0)
        name = "{} on {}".format(*at.model.contacts[c])
        if pushes and not at_rate:
            raise _refused(at, impact, f"{name} does not leave as one step of the law has it")
        given = bool(least) and not pushes
        if not pushes and abs(own) * units[c] > UNDECIDED * largest:
            raise _refused(at, impact, f"{name} pushes less than one step of the law has it")
        normal: Normal = "rate" if pushes else "given" if given else "leaves"
        way = Way(c, normal, P=P[c], F=F[c], kept=("normal",) if at_rate and not pushes else ())
        if mu_c > 0.0 and P[c] * units[c] > UNDECIDED * largest:
            _rub(at, impact, way, mu_c, after, speed)
        ways.append(way)
    _check_decided(at, impact, ways, targets)
    return ways


def _check_decided(at: Local, impact: Impact, ways: Sequence[Way], targets: dict[int, float]) -> None:
    """What rests without a force of its own that could keep it there does so because others rest, which surely do."""
    if not any(way.kept for way in ways):
        return
    rows = [at.gap_rows[way.contact] for way in ways if way.normal == "rate" and targets[way.contact] == 0.0]
    rows += [at.slip_rows[way.contact] for way in ways if way.sticks]
    for way in ways:
        name = "{} on {}".format(*at.model.contacts[way.contact])
        if "normal" in way.kept and not (targets[way.contact] == 0.0 and _follows(at, at.gap_rows[way.contact], rows)):
            raise _refused(
                at, impact, f"whether {name} pushes is undecided: it leaves as if it did, without an impulse"
            )
        if "sliding" in way.kept and not _follows(at, at.slip_rows[way.contact], rows):
            raise _refused(at, impact, f"whether {name} sticks is undecided: it rests, with friction at its limit")


def _follows(at: Local, row: FloatArray, rows: Sequence[FloatArray]) -> bool:
    """Whether a contact's rate is zero because others are, loops held shut: no impulse moves it beside those that move
    none of these."""
    every = np.array([*rows, row])
    mobility = every @ at.response(every.T, np.zeros((len(at.model.rows), len(every))))
    own = float(mobility[-1, -1])
    if not rows:
        return own <= 0.0
    left = own - mobility[-1, :-1] @ np.linalg.pinv(mobility[:-1, :-1], rcond=DEPENDENT) @ mobility[:-1, -1]
    return bool(abs(left) <= DEPENDENT * max(own, float(np.max(np.diag(mobility))) * FIXED))


def _strength(at: Local, contact: int) -> float:
    """What a unit impulse at a contact changes its own normal rate by, loops held shut."""
    column = at.gap_rows[contact][:, None]
    return float(at.gap_rows[contact] @ at.response(column, np.zeros((len(at.model.rows), 1)))[:, 0])


def _rub(at: Local, impact: Impact, way: Way, mu: float, after: FloatArray, speed: float) -> None:
    """Whether a contact that pushes sticks at the end of a stage, or in which direction friction is at its limit."""
    slip = float(at.slip_rows[way.contact] @ after)
    rests = abs(slip) <= UNDECIDED * speed
    limit = abs(mu * way.P - abs(way.F)) <= UNDECIDED * mu * way.P
    name = "{} on {}".format(*at.model.contacts[way.contact])
    if rests and limit:
        way.kept, way.sign = (*way.kept, "sliding"), float(np.sign(way.F))
        return
    if not rests and (not limit or way.F * slip > 0.0):
        raise _refused(at, impact, f"friction at {name} is not that of one step of the law")
    way.sticks, way.sign = rests, 0.0 if rests else float(np.sign(way.F))


def _move(at: Local, stage: Stage) -> None:
    """Fill in what the rates after a stage and its impulses move by: the linear equations of docs/theory.md, eq.
    11.9."""
    model, count = at.model, len(at.model.contacts)
    n, rows = len(at.q), len(model.rows)
    P, F = np.zeros(count), np.zeros(count)
    for way in stage.ways:
        P[way.contact], F[way.contact] = way.P, way.F
    jump = np.ascontiguousarray(stage.after - stage.before)
    Lambda = at.loop_impulses(P, F)
    held = at.tangent("jump", n + rows, jump, ("q", "k"), multipliers=Lambda)
    f = held[:n] + at.pushes_move(P, F)
    friction = model.kernels.friction
    changes = at.coefficients_move("friction") if any(way.sign for way in stage.ways) else np.zeros((count, 0))
    columns, wanted, which = [], [], []
    rubs = any(way.sticks or "sliding" in way.kept for way in stage.ways)
    slips = at.slips_move(stage.after, ("q", "k")) if rubs else None
    for way in stage.ways:
        c = way.contact
        column = at.gap_rows[c] + way.sign * friction[c] * at.slip_rows[c]
        if way.sign:
            f = f + way.sign * way.P * np.outer(at.slip_rows[c], changes[c])
        if way.normal == "given":
            f = f + np.outer(column, stage.P[c])
        if way.normal == "rate":
            columns.append(column)
            wanted.append((at.gap_rows[c], stage.wanted[c] - at.gap_rates_move(stage.after, ("q", "k"))[c]))
            which.append(c)
    for way in stage.ways:
        if way.sticks and slips is not None:
            columns.append(at.slip_rows[way.contact])
            wanted.append((at.slip_rows[way.contact], -slips[way.contact]))
    # A (du- + change) = -dA u+
    shut = -at.closure_rates_move(stage.after, ("q", "k")) - at.closure_rows @ stage.before_moves
    moved = stage.before_moves + at.response(f, shut)
    if columns:
        answer = at.response(np.array(columns).T, np.zeros((rows, len(columns))))
        N = np.array([row for row, _ in wanted])
        rates, alike = np.array([rate for _, rate in wanted]), not any(way.sign for way in stage.ways)
        z, unique = solved(at, N @ answer, rates - N @ moved, alike=alike)
        if not unique:
            _keep(at, stage, N, rates, N @ (moved + answer @ z), np.abs(N) @ np.abs(moved))
        moved = moved + answer @ z
        for i, c in enumerate(which):
            stage.P[c] = z[i]
        if stage.share:
            more = np.array([[stage.share.get(c, 0.0)] for c in which] + [[0.0]] * (len(columns) - len(which)))
            stage.by_share = (answer @ solved(at, N @ answer, more, alike=alike)[0])[:, 0]
    _keep_all(at, stage, moved, slips)
    stage.after_moves = moved


def _keep_all(at: Local, stage: Stage, moved: FloatArray, slips: FloatArray | None) -> None:
    """What rests beside others stays at rest in all directions, which move rates by ``moved`` and bend ``slips``."""
    for way in stage.ways:
        for kept in way.kept:
            row, bent = at.gap_rows[way.contact], at.gap_rates_move(stage.after, ("q", "k"))[way.contact]
            if kept == "sliding" and slips is not None:
                row, bent = at.slip_rows[way.contact], slips[way.contact]
            rate = (row @ moved + bent)[None]
            sizes = (np.abs(row) @ np.abs(moved) + np.abs(bent))[None]
            _keep(at, stage, row[None], np.zeros_like(rate), rate, sizes)


def _keep(at: Local, stage: Stage, rows: FloatArray, wanted: FloatArray, found: FloatArray, sizes: FloatArray) -> None:
    """Rows have the rates that they are to have, in all directions that there are, dependent ones too: that is to be
    checked."""

    def check(along: FloatArray) -> None:
        missed = np.max(np.abs((found - wanted) @ along), axis=0)
        terms = np.max((sizes + np.abs(wanted)) @ np.abs(along), axis=0)
        # of what no column moves all is rounding
        most = np.max([whole_of(at.model, at.moving, row) for row in rows], axis=0) / (
            at.model.time or at.model.duration
        )
        allowed = MISSED * (terms + MISSED * most)
        if np.any(missed > allowed):
            column = at.moving.columns[int(np.argmax(missed - allowed))]
            raise ValueError(
                f"{at.model.name}: found contacts that strike at t = {at.t:.9g} s with rows that depend on each "
                f"other, which {column} parts; there is no derivative by it"
            )

    stage.checks.append(check)
