"""Differences along a run: from its start through all its steps, impacts and changes of what is held."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
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


InOrder = Callable[[Model, Moving, Instant, FloatArray], tuple[FloatArray, Passed]]
"""From a difference (2 n, 1) before an instant whose contacts it parts to that behind it."""


class Stop(NamedTuple):
    """A time that was asked for: behind how many of the parts it lies, the state (q, u) there and what is held."""

    behind: int
    state: tuple[FloatArray, FloatArray]
    held: Held


class Course(NamedTuple):
    """A run as what its ``parts`` make of small differences one after the other, ``stops`` at the times that were asked
    for, and whether it has matrices of its steps or takes differences through them by ``sweeps``."""

    parts: Sequence[Part | Swept]
    stops: Sequence[Stop]
    sweeps: bool

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
            states = len(matrix)
            through = found[:, :states] @ matrix
            through[:, states:] += found[:, states:]
            found = through
            if passed is not None and passed.kind == "impact" and passed.t in missing:
                found += np.outer(missing.pop(passed.t), passed.dt)
        if missing:  # an impact that ends the run is not passed
            found[np.any(list(missing.values()), axis=0)] = np.nan
        return found


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
    doing = _doing(run)
    if doing:
        faults.add(f"{name}: {doing}")
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
            f"{name}: found contacts that crowded or jammed and came to rest from {run.rest_speed:.3g} m/s, "
            "expected impacts one by one; end the run before they accumulate"
        )
    if run.choices:
        faults.add(
            f"{name}: found {run.choices} instants at which contacts could as well have stayed as left, expected "
            "none: which of the two a change leads to is undecided"
        )
    for line, t, why in meetings(run, model):
        faults.add(f"{name}: found the ends of {line} to meet at t = {t:.9g} s, expected them apart: {why}")
    for since, held in [] if doing else _held(run):
        if why := cannot(held, model):
            faults.add(f"{name}: found no derivative from t = {since:.9g} s on: {why}")
    faults.stop_if_any()
    return model


def _doing(run: Record) -> str:
    """What is wrong with the first event of a run that has done something, if any has."""
    for event in run.events:
        sets = event.parameters or event.on or event.off
        if not sets and not (run.message.startswith(ENDED) and event.t == run.t[-1]):
            continue
        does = "sets parameters or switches effects" if sets else "ends the run"
        return (
            f"found {event.name} at t = {event.t:.9g} s, which {does}, expected events that are only told: what the "
            "instants of others move by is not differentiated; end the run before it"
        )
    return ""


def _held(run: Record) -> list[tuple[float, Held]]:
    """From when on which contacts are held, and how."""
    motion = run.motion
    if motion is None:
        return []
    return [
        (float(t), motion.ways[which])  # type: ignore[attr-defined]
        for t, which in zip(motion.since, motion.which, strict=True)  # type: ignore[attr-defined]
    ]


def along(run: Record, model: Model, moving: Moving, S: FloatArray, times: Sequence[float], *, forward: bool) -> Course:
    """What a run makes of small differences that begin with S (2 n, columns), with stops at ``times`` that grow, under
    the inputs that are set. Where they only go ``forward`` and are few, no matrices are formed of its steps."""
    every, helds = _pieces(run, times)
    refuse_parted(run, model, moving, every)
    sweeps = forward and few(S.shape[1], len(helds), moving)
    steps = _steps(run, model, moving, helds, every, sweeps)
    parts, stops = list[Part | Swept](), list[Stop]()
    wanted = list(times)
    first = helds[0] if helds else ()
    if first:
        _check_held(model, moving, float(every.t[0]), (every.q[0], every.u[0]), first, S)
    while wanted and wanted[0] <= run.t[0]:
        stops.append(Stop(0, (run.q[0], run.u[0]), first))
        wanted.pop(0)
    joints: dict[float, list[Impact]] = {}
    for impact in run.impacts:
        joints.setdefault(impact.t, []).append(impact)
    begins, ends, ways = every.t.tolist(), (every.t + every.h).tolist(), [*pairwise([(), *helds])]
    struck = [k for k, t in enumerate(begins) if t in joints]
    instants = [(joints[begins[k]], every.q[k], ways[k]) for k in struck]
    impacts = dict(zip(struck, pass_impacts(model, moving, instants), strict=True))
    for k, end in enumerate(ends):
        if k in impacts:
            parts.append(impacts[k])
        elif k and ways_differ(*ways[k]):
            parts.append(pass_change(model, moving, begins[k], every.q[k], every.u[k], ways[k]))
        parts.append(steps[k])
        if wanted and abs(wanted[0] - end) <= ROUNDING * abs(end):
            stops.append(Stop(len(parts), (every.q1[k], every.u1[k]), helds[k]))
            wanted.pop(0)
    return Course(parts, stops, sweeps)


def carried(
    course: Course, model: Model, moving: Moving, S: FloatArray, in_order: InOrder | None = None
) -> tuple[FloatArray, tuple[Passed, ...]]:
    """Differences (times, 2 n, columns) at the stops of a course that begin with S (2 n, columns), and the instants
    that were passed, under the inputs that are set. ``in_order`` takes them through instants whose contacts they part.

    Raises ``ValueError`` for columns that keep a part from having one matrix."""
    states, found, passed = len(S), list[FloatArray](), list[Passed]()
    at_instants: dict[int, FloatArray] = {}
    whole = np.vstack([S, moving.along])
    behind = [stop.behind for stop in course.stops]
    number, last = 0, len(course.parts)
    while True:
        if number in behind:
            found += [whole[:states].copy()] * behind.count(number)
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
            whole[:states], one = in_order(model, moving, part.instant, whole[:states].copy())
            passed.append(one)
            continue
        if part.passed is not None:
            at_instants[len(passed)] = whole.copy()
            passed.append(part.passed)
        whole[:states] = part.through(whole)
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
