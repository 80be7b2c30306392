"""Differences along a run: from its start through all its steps, impacts and changes of what is held."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..faults import Faults
from ..model.derivatives import need_derivatives
from ..model.forces import Held
from ..model.model import Model
from ..model.thresholds import characteristic_time
from ..precision import need_doubles
from ..record.impact import Impact
from ..record.record import Record
from .held import cannot, pushing, ways_differ
from .local import Local
from .moving import Moving, whole_of
from .passing import Passed, pass_change, pass_impacts
from .steps import Steps, maps

KEPT = 1e-6
"""Contacts stay as they are held where their rates move by less than this part of their terms in a step, which is what
gaps that meet may miss (``MEET``); the step itself is exact to about a tolerance."""


Passing = Callable[
    [Model, Moving, Sequence[Impact], FloatArray, FloatArray, tuple[Held, Held]], tuple[FloatArray, Passed]
]
"""From differences before the impacts of an instant to those behind."""


class Piece(NamedTuple):
    """A step of the run from one state to the next, with what is held on it."""

    t: float
    h: float
    start: tuple[FloatArray, FloatArray]
    end: tuple[FloatArray, FloatArray]
    held: Held


class Found(NamedTuple):
    """Differences S (times, 2 n, columns) at the times that were asked for, with the states (q, u) there and what is
    held; and what was passed."""

    S: FloatArray
    states: list[tuple[FloatArray, FloatArray]]
    held: list[Held]
    passed: tuple[Passed, ...]


def check(run: Record) -> Model:
    """The run's model. Raises ``ValueError`` for a run that has no derivatives, with all that stands in their way."""
    model, faults = run.model, Faults()
    if not isinstance(model, Model):
        raise ValueError(
            f"{run.model.name}: found joints that let go or take hold, expected none; runs with them have no "
            "derivatives"
        )
    need_doubles(model.precision, model.name, "derivatives of a run")
    name = model.name
    with faults.collecting():
        need_derivatives(model)
    if model.data.get("events") or run.events:
        faults.add(f"{name}: found [[event]] tables, expected none: the instants of events are not differentiated")
    if model.kernels.sizes["switches"]:
        faults.add(
            f"{name}: found effects with kinks, expected loads that are smooth: the instants at which they switch "
            "are not differentiated"
        )
    if run.drift == "damped":
        faults.add(f'{name}: found drift="damped", expected "projected" or "left"')
    if not run.success:
        faults.add(f"{name}: found a run that stopped early, expected one that reached its end: {run.message}")
    for phase in run.phases:
        if phase.kind == "steps":
            faults.add(
                f"{name}: found time stepping from t = {phase.start:.9g} to {phase.end:.9g} s, expected a run event "
                "by event: steps in time have no derivatives"
            )
    if run.rest_speed > 0.0:
        faults.add(
            f"{name}: found bounces that crowded and came to rest below {run.rest_speed:.3g} m/s, expected impacts "
            "one by one; end the run before they accumulate"
        )
    if run.choices:
        faults.add(
            f"{name}: found {run.choices} instants at which contacts could as well have stayed as left, expected "
            "none: which of the two a change leads to is undecided"
        )
    for since, held in _held(run):
        if why := cannot(held, model):
            faults.add(f"{name}: found no derivative from t = {since:.9g} s on: {why}")
    faults.stop_if_any()
    return model


def _held(run: Record) -> list[tuple[float, Held]]:
    """From when on which contacts are held, and how."""
    motion = run.motion
    if motion is None:
        return []
    return [
        (float(t), motion.ways[which])  # type: ignore[attr-defined]
        for t, which in zip(motion.since, motion.which, strict=True)  # type: ignore[attr-defined]
    ]


def along(
    run: Record,
    model: Model,
    moving: Moving,
    S: FloatArray,
    times: Sequence[float],
    passing: Passing = pass_impacts,
) -> Found:
    """Differences along a run that begin with S (2 n, columns), at ``times`` that grow, under the inputs that are set;
    ``passing`` is how they pass impacts."""
    pieces, joints = _pieces(run, times)
    steps = _maps(run, model, moving, pieces)
    found, states, helds, passed = [], [], [], []
    wanted = list(times)
    if pieces:
        _check_held(model, moving, pieces[0], S)
    while wanted and wanted[0] <= run.t[0]:
        found.append(S)
        states.append((run.q[0], run.u[0]))
        helds.append(pieces[0].held if pieces else ())
        wanted.pop(0)
    for k, piece in enumerate(pieces):
        struck = joints.get(piece.t, ())
        before: Held = pieces[k - 1].held if k else ()
        if struck:
            ways = (before, piece.held)
            S, one = passing(model, moving, struck, piece.start[0], S, ways)
            passed.append(one)
        elif k and ways_differ(before, piece.held):
            S, one = pass_change(model, moving, piece.t, *piece.start, S, (before, piece.held))
            passed.append(one)
        n = len(piece.start[0])
        S = steps[k][:, : 2 * n] @ S + steps[k][:, 2 * n :] @ moving.along
        end = piece.t + piece.h
        S = _shut(model, moving, piece, S) if run.drift == "projected" or piece.held else S
        if wanted and abs(wanted[0] - end) <= 4.0 * np.finfo(float).eps * abs(end):
            found.append(S)
            states.append(piece.end)
            helds.append(piece.held)
            wanted.pop(0)
    return Found(np.array(found), states, helds, tuple(passed))


def _pieces(run: Record, times: Sequence[float]) -> tuple[list[Piece], dict[float, Sequence[Impact]]]:
    """The steps of the run, parted at ``times`` too, and its impacts by the times of the steps behind them."""
    joints: dict[float, list[Impact]] = {}
    for impact in run.impacts:
        joints.setdefault(impact.t, []).append(impact)
    changes = _held(run)
    pieces: list[Piece] = []
    inner = [t for t in times if run.t[0] < t < run.t[-1] and t not in run.t]
    number = 0
    for row in range(len(run.t) - 1):
        t0, t1 = float(run.t[row]), float(run.t[row + 1])
        if t1 <= t0:
            continue
        while number < len(changes) and changes[number][0] <= t0:
            number += 1
        held: Held = changes[number - 1][1] if number else ()
        marks = [t0, *(t for t in inner if t0 < t < t1), t1]
        states = [(run.q[row], run.u[row]), *(run.at(t) for t in marks[1:-1]), (run.q[row + 1], run.u[row + 1])]
        pieces += [
            Piece(a, b - a, one, other, held)
            for a, b, one, other in zip(marks, marks[1:], states, states[1:], strict=False)
        ]
    return pieces, {t: tuple(found) for t, found in joints.items()}


def _maps(run: Record, model: Model, moving: Moving, pieces: Sequence[Piece]) -> list[FloatArray]:
    """The map (2 n, D) of each piece; all that are held alike at once."""
    tolerance = getattr(run.advance, "tolerances", (0.0, 0.0))
    groups: dict[tuple[tuple[int, str, float], ...], list[int]] = {}
    for k, piece in enumerate(pieces):
        groups.setdefault(tuple(tuple(one) for one in piece.held), []).append(k)  # type: ignore[misc]
    found: dict[int, FloatArray] = {}
    for held, which in groups.items():
        some = [pieces[k] for k in which]
        steps = Steps(
            np.array([one.t for one in some]),
            np.array([one.h for one in some]),
            *(np.array([one.start[part] for one in some]) for part in (0, 1)),
            *(np.array([one.end[part] for one in some]) for part in (0, 1)),
        )
        found |= dict(zip(which, maps(model, moving, held, steps, tolerance), strict=True))
    return [found[k] for k in range(len(pieces))]


def _rows(at: Local, held: Held, u: FloatArray) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
    """Rows that a motion keeps, and by what they change, (rows, n) and (rows, D): of places, and of rates at u."""
    chosen = [contact for contact, _ in pushing(held)]
    sticks = [contact for contact, how in pushing(held) if how == "sticks"]
    R = np.vstack([at.closure_rows, at.gap_rows[chosen]])
    places, rates = at.closure_moves(), at.closure_rates_move(u)
    if chosen:
        places = np.vstack([places, at.gaps_move()[chosen]])
        rates = np.vstack([rates, at.gap_rates_move(u)[chosen]])
    Rs = R
    if sticks:
        Rs = np.vstack([R, at.slip_rows[sticks]])
        rates = np.vstack([rates, at.slips_move(u)[sticks]])
    return (R, places), (Rs, rates)


def _shut(model: Model, moving: Moving, piece: Piece, S: FloatArray) -> FloatArray:
    """S put back onto the loops and the contacts that are held, as the run is after each step."""
    if not model.rows and not piece.held:
        return S
    q, u = piece.end
    n = len(q)
    at = Local(model, moving, piece.t + piece.h, q)
    (R, places), (Rs, rates) = _rows(at, piece.held, u)
    unit = model.coordinate_units
    free = np.eye(n)
    if len(at.drive_rows):  # driven joints stay where they are
        free = free - np.linalg.pinv(at.drive_rows) @ at.drive_rows

    def put(rows: FloatArray, missed: FloatArray) -> FloatArray:
        return np.asarray(
            unit[:, None] * (free @ (np.linalg.pinv(rows @ (unit[:, None] * free), rcond=1e-10) @ missed))
        )

    _check_kept(at, Rs, rates, S)
    moved_q = S[:n] - put(R, places @ moving.whole(S[:n], S[n:]))
    moved_u = S[n:] - put(Rs, rates @ moving.whole(moved_q, S[n:]))
    return np.vstack([moved_q, moved_u])


def _check_held(model: Model, moving: Moving, first: Piece, S: FloatArray) -> None:
    """Contacts that are closed from the start on stay closed whatever column moves it."""
    if not first.held:
        return
    q, u = first.start
    n = len(q)
    at = Local(model, moving, first.t, q)
    chosen = [contact for contact, _ in pushing(first.held)]
    whole = moving.whole(S[:n], S[n:])
    sticks = [contact for contact, how in pushing(first.held) if how == "sticks"]
    per = characteristic_time(model)
    checked = (
        (at.gaps_move(), chosen, at.gap_rows),
        (at.gap_rates_move(u), chosen, at.gap_rows / per),
        (at.slips_move(u), sticks, at.slip_rows / per),
    )
    for rows, which, of in checked:
        for c in which:
            moved, terms = np.abs(rows[c] @ whole), np.abs(rows[c]) @ np.abs(whole)
            allowed = KEPT * (terms + KEPT * whole_of(model, moving, of[c]))
            if np.any(moved > allowed):
                column = moving.columns[int(np.argmax(moved - allowed))]
                raise ValueError(
                    f"{model.name}: found {'({}, {})'.format(*model.contacts[c])} held from the start on, which "
                    f"{column} opens or makes strike or slide, expected columns that leave it as it is; there is no "
                    "one derivative"
                )


def _check_kept(at: Local, rows: FloatArray, rates: FloatArray, S: FloatArray) -> None:
    """Rates of contacts are kept by the step's own equations where their rows depend on each other: there not all need
    be solved for. What rounding leaves of what is at rest is compared with places per characteristic time."""
    if np.linalg.matrix_rank(rows, tol=1e-10 * float(np.linalg.norm(rows))) == len(rows):
        return
    model, n = at.model, len(at.q)
    whole = at.moving.whole(S[:n], S[n:])
    per = characteristic_time(model)
    size = np.abs(rows) @ np.abs(S[:n]) / per + np.abs(rows) @ np.abs(S[n:])
    terms = np.max(np.abs(rates) @ np.abs(whole) + size, axis=0)
    missed = np.max(np.abs(rates @ whole), axis=0)
    # of what no column moves all is rounding
    whole_size = np.max([whole_of(model, at.moving, row) for row in rows], axis=0)
    allowed = KEPT * (terms + KEPT * whole_size / per)
    if np.any(missed > allowed):
        column = at.moving.columns[int(np.argmax(missed - allowed))]
        raise ValueError(
            f"{model.name}: found contacts held until t = {at.t:.9g} s with rows that depend on each other, which "
            f"{column} parts; there is no derivative by it"
        )
