"""Differences along a run: from its start through all its steps, impacts and changes of what is held."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..faults import Faults
from ..model.derivatives import need_derivatives
from ..model.forces import Held
from ..model.model import Model
from ..model.thresholds import characteristic_time
from ..precision import need_doubles
from ..record.event import ENDED
from ..record.impact import Impact
from ..record.record import Record
from .acting import Change, Stretch, does, pass_end, pass_events
from .change_points import refuse_parted
from .held import cannot, pushing, ways_differ
from .local import Local, at_one
from .meeting_ends import meetings
from .moving import Moving, whole_of
from .passing import Check, Instant, Part, Parted, Passed, by_columns, pass_change, pass_impacts
from .shutting import Shutting, shutting_of
from .steps import Steps, maps, motion_along
from .swept import Swept, few, swept

KEPT = 1e-6
"""Contacts stay as they are held where their rates move by less than this part of their terms in a step, which is what
gaps that meet may miss (``MEET``); the step itself is exact to about a tolerance."""


ROUNDING = 4.0 * float(np.finfo(float).eps)
"""Ends of steps, sums of two times, are these by so much of themselves."""

Passing = Callable[
    [Model, Moving, Sequence[Impact], FloatArray, FloatArray, tuple[Held, Held]], tuple[FloatArray, Passed]
]
"""From differences before the impacts of an instant to those behind."""


Leg = tuple[Stretch, Steps, list[Held]]
"""A stretch, its steps, and what is held on each."""

InOrder = Callable[[Model, Moving, Instant, FloatArray], tuple[FloatArray, Passed]]
"""From a difference (2 n, 1) before an instant whose contacts it parts to that behind it."""


class Stop(NamedTuple):
    """A time that was asked for: behind how many of the parts it lies, the state (q, u) there, what is held, and the
    stretch that it is in."""

    behind: int
    state: tuple[FloatArray, FloatArray]
    held: Held
    stretch: Stretch


class Course(NamedTuple):
    """A run as what its ``parts`` make of small differences one after the other, ``stops`` at the times that were asked
    for, and whether it has matrices of its steps or takes differences through them by ``sweeps``. The ``stretches``
    begin with the parts of the numbers ``begins``."""

    parts: Sequence[Part | Swept]
    stops: Sequence[Stop]
    sweeps: bool
    stretches: Sequence[Stretch]
    begins: Sequence[int]

    def stretch_of(self, number: int) -> Stretch:
        """That of the part of a number."""
        return self.stretches[bisect_right(self.begins, number) - 1]

    def back(self, at_stops: FloatArray, at_impacts: Mapping[float, FloatArray]) -> FloatArray:
        """Covectors (k, D) at the start of the run, of differences of the state there and the arguments.

        They are the sums of those ``at_stops`` (times, k, D), and of ``at_impacts``, (k,) by the times of impacts, of
        what these times move by; each part is applied to them from the left (adjoint mode: docs/theory.md, eq.
        11.11)."""
        found = np.zeros(at_stops.shape[1:])
        left, missing = len(self.stops), dict(at_impacts)
        for number in range(len(self.parts), -1, -1):
            while left and self.stops[left - 1].behind == number:
                left -= 1
                found += at_stops[left]
            if not number:
                break
            matrix, passed = self.parts[number - 1].matrix, self.parts[number - 1].passed
            moved = len(matrix)
            through = found[:, :moved] @ matrix
            through[:, moved:] += found[:, moved:]
            found = through
            if passed is not None and passed.kind == "impact" and passed.t in missing:
                found += np.outer(missing.pop(passed.t), passed.dt)
        if missing:  # an impact that ends the run is not passed
            found[np.any(list(missing.values()), axis=0)] = np.nan
        return found


def check(run: Record) -> Model:
    """The run's model. Raises ``ValueError`` for a run that has no derivatives, with all that stands in their way."""
    model, faults = run.model, Faults()
    assert isinstance(model, Model)
    need_doubles(model.precision, model.name, "derivatives of a run")
    name = model.name
    with faults.collecting():
        need_derivatives(model)
    if model.kernels.sizes["switches"] and not model.data.get("continuous", False):
        faults.add(
            f"{name}: found effects with kinks at which loads may jump, expected loads that are continuous, as laws of "
            "the state and motors with a limit are: the instants at which others switch are not differentiated"
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
            f"{name}: found contacts that crowded or jammed and came to rest from {run.rest_speed:.3g} m/s, "
            "expected impacts one by one; end the run before they accumulate"
        )
    if run.choices:
        faults.add(
            f"{name}: found {run.choices} instants at which contacts could as well have stayed as left, expected "
            "none: which of the two a change leads to is undecided"
        )
    for wrong in (*_of_events(run, model), *_of_stretches(run)):
        faults.add(f"{name}: {wrong}")
    faults.stop_if_any()
    return model


def _of_events(run: Record, model: Model) -> Iterator[str]:
    """What is wrong with the first event that has done something, if anything is."""
    doing = [event for event in run.events if does(event)]
    if doing and "indicators" not in (model.kernels.derivatives or ("indicators",)):
        yield (
            f"found {doing[0].name}, of which an earlier version of ccgen has generated no derivatives, expected "
            "those; generate the model anew"
        )


def _of_stretches(run: Record) -> Iterator[str]:
    """What stands in the way where parameters stay as they are."""
    for part in run.stretches:
        assert isinstance(part.model, Model)
        for line, t, why in meetings(part, part.model):
            yield f"found the ends of {line} to meet at t = {t:.9g} s, expected them apart: {why}"
        for since, held in _held(part):
            if why := cannot(held, part.model):
                yield f"found no derivative from t = {since:.9g} s on: {why}"


def _held(run: Record) -> list[tuple[float, Held]]:
    """From when on which contacts are held, and how."""
    motion = run.motion
    if motion is None:
        return []
    return [
        (float(t), motion.ways[which])  # type: ignore[attr-defined]
        for t, which in zip(motion.since, motion.which, strict=True)  # type: ignore[attr-defined]
    ]


def along(run: Record, stretches: Sequence[Stretch], S: FloatArray, times: Sequence[float], *, forward: bool) -> Course:
    """What a run makes of small differences that begin with S (2 n, columns), with stops at ``times`` that grow, under
    the inputs that are set. Where they only go ``forward`` and are few, no matrices are formed of its steps."""
    legs = [(stretch, *_pieces(stretch.run, times)) for stretch in stretches]
    count = sum(len(helds) for *_, helds in legs)
    sweeps = forward and few(S.shape[1], count, stretches[0].moving)
    parts, stops, begins = list[Part | Swept](), list[Stop](), list[int]()
    wanted = list(times)
    stretch, every, helds = legs[0]
    first = helds[0] if helds else ()
    if first:
        _check_held(stretch.model, stretch.moving, float(every.t[0]), (every.q[0], every.u[0]), first, S)
    while wanted and wanted[0] <= run.t[0]:
        stops.append(Stop(0, (run.q[0], run.u[0]), first, stretch))
        wanted.pop(0)
    before: Leg | None = None
    skipped = list[Stretch]()
    for number, leg in enumerate(legs):
        stretch, every, helds = leg
        if not helds:  # joints may let go where the run begins
            before = leg if leg is legs[0] else before
            skipped += [stretch] * (leg is not legs[0])
            continue
        if before is not None:
            parts += _between(run, before, leg, skipped)
        begins.append(len(parts) if begins else 0)
        refuse_parted(stretch.run, stretch.model, _may_move(stretch.moving) if number else stretch.moving, every)
        for part, end, state, held in _through(leg, sweeps):
            parts.append(part)
            if wanted and end is not None and abs(wanted[0] - end) <= ROUNDING * abs(end):
                stops.append(Stop(len(parts), state, held, stretch))
                wanted.pop(0)
        before, skipped = leg, []
    if before is not None and before[2]:
        parts += _ended(run, before)
    of_steps = [stretch for stretch, _, helds in legs if helds] or [stretches[0]]
    return Course(parts, stops, sweeps, of_steps, begins or [0])


def _may_move(moving: Moving) -> Moving:
    """The same, with what does not move at first as if it did: events may have set it to what moves."""
    still = np.logical_not(moving.along.any(axis=1))
    return replace(moving, along=np.where(still[:, None], 1.0, moving.along))


def _through(
    leg: Leg, sweeps: bool
) -> Iterator[tuple[Part | Swept, float | None, tuple[FloatArray, FloatArray], Held]]:
    """The parts of a stretch, of steps with the time and the state (q, u) of their ends, and what is held."""
    (run, model, moving), every, helds = leg
    steps = _steps(run, model, moving, helds, every, sweeps)
    joints: dict[float, list[Impact]] = {}
    for impact in run.impacts:
        joints.setdefault(impact.t, []).append(impact)
    begins, ends, ways = every.t.tolist(), (every.t + every.h).tolist(), [*pairwise([(), *helds])]
    struck = [k for k, t in enumerate(begins) if t in joints]
    instants = [(joints[begins[k]], every.q[k], ways[k]) for k in struck]
    impacts = dict(zip(struck, pass_impacts(model, moving, instants), strict=True))
    for k, end in enumerate(ends):
        state = every.q1[k], every.u1[k]
        if k in impacts:
            yield impacts[k], None, state, helds[k]
        elif k and ways_differ(*ways[k]):
            yield pass_change(model, moving, begins[k], every.q[k], every.u[k], ways[k]), None, state, helds[k]
        yield steps[k], end, state, helds[k]


def _between(run: Record, before: Leg, after: Leg, skipped: Sequence[Stretch]) -> list[Part]:
    """What comes where one stretch goes over into another: events that do something, joints that change, or what comes
    within a stretch too. Those that are ``skipped`` took no time."""
    (first, model, moving), _, helds = before
    t, q, u = float(first.t[-1]), first.q[-1], first.u[-1]
    ways = helds[-1] if helds else (), after[2][0]
    impacts = [impact for impact in first.impacts if impact.t == t]
    others = [impact for impact in after[0].run.impacts if impact.t == t]
    events = [event for event in run.events if event.t == t and does(event)]
    joints = [change for change in run.changes if change.t == t]
    if events or joints:
        if others or float(after[1].t[0]) != t:
            what = "contacts strike at once" if others else "another event comes at once"
            name = events[0].name if events else joints[0].joint
            raise ValueError(
                f"{model.name}: found {name} at t = {t:.9g} s, behind which {what}, expected motion to go on from "
                "there; end the run before it"
            )
        begins = after[1].q[0], after[1].u[0]
        holds = [impact for impact in run.impacts if impact.t == t and impact.contacts[0][1] == "hold"]
        change = Change(t, q, u, begins, ways, impacts, events, joints, holds, skipped)
        return [pass_events(before[0], after[0], change)]
    if not helds:
        return []
    if impacts or others:
        return pass_impacts(model, moving, [([*impacts, *others], q, ways)])
    return [pass_change(model, moving, t, q, u, ways)] if ways_differ(*ways) else []


def _ended(run: Record, last: Leg) -> list[Part]:
    """The instant of the event that has ended a run, if one has."""
    t = float(run.t[-1])
    names = run.message.removeprefix(ENDED).partition(" by ")[2].split(" and ") if run.message.startswith(ENDED) else []
    ends = [event for event in run.events if event.t == t and event.name in names]
    stretch, every, helds = last
    found = [pass_end(stretch, t, (every.q1[-1], every.u1[-1]), helds[-1], event) for event in ends[:1]]
    return [part for part in found if part is not None]


def carried(course: Course, S: FloatArray, in_order: InOrder | None = None) -> tuple[FloatArray, tuple[Passed, ...]]:
    """Differences (times, D, columns) of the state and the arguments at the stops of a course that begin with S (2 n,
    columns), and the instants that were passed, under the inputs that are set. ``in_order`` takes them through instants
    whose contacts they part.

    Raises ``ValueError`` for columns that keep a part from having one matrix."""
    found, passed = list[FloatArray](), list[Passed]()
    at_instants: dict[int, FloatArray] = {}
    whole = np.vstack([S, course.stretches[0].moving.along])
    behind = [stop.behind for stop in course.stops]
    number, last, states = 0, len(course.parts), len(S)
    while True:
        if number in behind:
            found += [whole.copy()] * behind.count(number)
        if number == last:
            break
        part = course.parts[number]
        if isinstance(part, Swept):
            until = next((stop for stop in behind if stop > number), last)
            stretch = part.stretch(course.parts[number:until])
            whole[:states], seen = part.through(whole, stretch)
            instants = [one.passed for one in stretch if one.passed is not None]
            at_instants |= zip(range(len(passed), len(passed) + len(instants)), seen, strict=True)
            passed += instants
            number += len(stretch)
            continue
        number += 1
        try:
            for check in part.checks:
                check(whole)
        except Parted:
            if in_order is None or part.instant is None:
                raise
            _, model, moving = course.stretch_of(number - 1)
            now = replace(moving, along=whole[states:].copy())
            whole[:states], one = in_order(model, now, part.instant, whole[:states].copy())
            passed.append(one)
            continue
        if part.passed is not None:
            at_instants[len(passed)] = whole.copy()
            passed.append(part.passed)
        whole[: len(part.matrix)] = part.through(whole)
    if at_instants:
        of_columns = by_columns([passed[k] for k in at_instants], np.array(list(at_instants.values())))
        for k, one in zip(at_instants, of_columns, strict=True):
            passed[k] = one
    return np.array(found), tuple(passed)


def _pieces(run: Record, times: Sequence[float]) -> tuple[Steps, list[Held]]:
    """The steps of the run, parted at ``times`` too, which grow, and what is held on each."""
    t, q, u = run.t, run.q, run.u
    known = set(t.tolist())
    between = [at for at in times if t[0] < at < t[-1] and at not in known]
    if between:
        places, states = np.searchsorted(t, between), [run.at(at) for at in between]
        t = np.insert(t, places, between)
        q, u = (np.insert(x, places, [state[i] for state in states], axis=0) for i, x in enumerate((q, u)))
    start = np.flatnonzero(t[1:] > t[:-1])
    end, changes = start + 1, _held(run)
    every = Steps(t[start], t[end] - t[start], q[start], u[start], q[end], u[end])
    last = np.searchsorted([since for since, _ in changes], every.t, side="right")
    return every, [changes[number - 1][1] if number else () for number in last.tolist()]


def _steps(
    run: Record, model: Model, moving: Moving, helds: Sequence[Held], every: Steps, sweeps: bool
) -> list[Part | Swept]:
    """What each step makes of differences with what is held on it, by ``sweeps`` or as matrices; all that are held
    alike at once."""
    tolerance = getattr(run.advance, "tolerances", (0.0, 0.0))
    groups: dict[tuple[tuple[int, str], ...], list[int]] = {}
    for k, one in enumerate(helds):
        groups.setdefault(tuple(tuple(contact) for contact in one), []).append(k)  # type: ignore[misc]
    found: dict[int, Part | Swept] = {}
    for held, which in groups.items():
        steps = every.some(which) if len(groups) > 1 else every
        projected = (model.rows and run.drift == "projected") or held
        shut = shutting_of(model, moving, held, steps.t + steps.h, steps.q1, steps.u1) if projected else None
        if sweeps and not (shut is not None and shut.unsure.size):
            parts = _swept(model, moving, held, steps, tolerance, shut)
        else:
            parts = _matrices(model, moving, held, steps, tolerance, shut)
        found |= dict(zip(which, parts, strict=True))
    return [found[k] for k in range(len(helds))]


def _matrices(
    model: Model, moving: Moving, held: Held, steps: Steps, tolerance: tuple[float, float], shut: Shutting | None
) -> list[Part | Swept]:
    """Steps as matrices, side by side."""
    matrices = maps(model, moving, held, steps, tolerance)
    if shut is None:
        return [Part(matrix) for matrix in matrices]
    checks = _checks(shut, matrices)
    return [Part(*one) for one in zip(shut.behind(matrices), checks, strict=True)]


def _swept(
    model: Model, moving: Moving, held: Held, steps: Steps, tolerance: tuple[float, float], shut: Shutting | None
) -> list[Part | Swept]:
    """Steps by sweeps; those that have to be halved as matrices."""
    stages, missed = motion_along(model, held, steps, tolerance)
    if not missed.any():
        return list(swept(model, moving, held, steps, stages, shut))
    good, others = np.flatnonzero(~missed), np.flatnonzero(missed)
    of = [shut.some(which) if shut is not None else None for which in (good, others)]
    parts = list[Part | Swept](swept(model, moving, held, steps.some(good), stages[good], of[0]))
    parts += _matrices(model, moving, held, steps.some(others), tolerance, of[1])
    return [parts[place] for place in np.argsort(np.concatenate([good, others]))]


def _checks(shut: Shutting, matrices: FloatArray) -> list[tuple[Check, ...]]:
    """What columns before each step have to fulfil, of which these are the matrices (k, 2 n, D) before they are put
    back."""
    k, states, D = matrices.shape
    checks: list[tuple[Check, ...]] = [()] * k
    for i in shut.unsure.tolist():
        rows = shut.rows[i]
        if np.linalg.matrix_rank(rows, tol=1e-10 * float(np.linalg.norm(rows))) < len(rows):
            through = np.vstack([matrices[i], np.eye(D)[states:]])
            checks[i] = (_kept(Local(shut.at, i), rows, shut.rates[i], through),)
    return checks


def _check_held(
    model: Model, moving: Moving, t: float, state: tuple[FloatArray, FloatArray], held: Held, S: FloatArray
) -> None:
    """Contacts that are closed from the start (q, u) on stay closed whatever column moves it."""
    q, u = state
    n = len(q)
    at = at_one(model, moving, t, q)
    chosen = [contact for contact, _ in pushing(held)]
    whole = moving.whole(S[:n], S[n:])
    sticks = [contact for contact, how in pushing(held) if how == "sticks"]
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


def _kept(at: Local, rows: FloatArray, rates: FloatArray, through: FloatArray) -> Check:
    """Rates of contacts are kept by the step's own equations where their rows depend on each other: there not all need
    be solved for. ``through`` (D, D) is the step. What rounding leaves of what is at rest is compared with places per
    characteristic time."""
    model, n = at.model, len(at.q)
    per = characteristic_time(model)

    def check(before: FloatArray) -> None:
        whole = through @ before
        size = np.abs(rows) @ np.abs(whole[:n]) / per + np.abs(rows) @ np.abs(whole[n : 2 * n])
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

    return check
