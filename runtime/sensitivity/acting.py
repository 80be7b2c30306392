"""How small differences pass an instant at which events of the scene set parameters, switch effects or end the run, and
joints let go or take hold.

The instant moves along with them, and what parameters are set to moves by the state there; the state itself goes on,
but where a joint takes hold (docs/theory.md, eq. 11.12, 11.13 and 11.14).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal, NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..model.directions import directions_of
from ..model.forces import Held
from ..model.model import Model
from ..model.thresholds import characteristic_time
from ..record.event import Event
from ..record.impact import Impact
from ..record.joint_change import JointChange
from ..record.record import Record
from .held import accelerations, pushing
from .local import at_one
from .moving import Moving, whole_of
from .passing import MEET, RESTS, SLOW, Check, Part, Passed, in_units, pass_impacts
from .striking import UNDECIDED
from .taking_hold import Drawn, take_hold
from .watched import ALL, Cause, causes_of, check_forces, events_of, no_instant, timed, together, values, watched

JUMPS = 1e-9
"""States that differ by more than this, in units of the mechanism, jump: loops may be open by as much where a run
begins anew, and are shut then. Values that differ by less are the same, computed in two ways."""


class Stretch(NamedTuple):
    """A part of a run in which parameters stay as they are: its ``run``, the ``model`` with these values, and what
    moves, by that model."""

    run: Record
    model: Model
    moving: Moving


class Change(NamedTuple):
    """Where one stretch goes over into another at ``t``: the state q, u (n,) that the one ends in and ``begins``
    (q, u) of the other, what is held before and after, and the impacts, events and changes of joints of that instant,
    with the impacts by which these take hold, ``holds``; what comes in turn there has stretches without time in
    ``between``."""

    t: float
    q: FloatArray
    u: FloatArray
    begins: tuple[FloatArray, FloatArray]
    ways: tuple[Held, Held]
    impacts: Sequence[Impact]
    events: Sequence[Event]
    joints: Sequence[JointChange]
    holds: Sequence[Impact]
    between: Sequence[Stretch]


class Moved(NamedTuple):
    """By what an instant moves with all directions, ``dt`` (D,), and by what the state behind it does wherever that
    is, ``behind`` (2 n, D); and what columns have to fulfil."""

    dt: FloatArray
    behind: FloatArray
    checks: Sequence[Check]


def does(event: Event) -> bool:
    """Whether an event has set or switched something."""
    return bool(event.parameters or event.on or event.off)


def stretches_of(run: Record, moving: Moving) -> list[Stretch]:
    """The stretches of a run, in which also moves what events set to expressions of the state.

    Raises ``ValueError`` where that is a time at which a load jumps.
    """
    parts = [(part, part.model) for part in run.stretches]
    if len(parts) == 1:
        part, model = parts[0]
        assert isinstance(model, Model)
        return [Stretch(part, model, moving)]
    said = {one["name"]: one["set"] for one in run.model.data.get("events", ())}  # type: ignore[attr-defined]
    set_here = [(path, value) for event in run.events if does(event) for path, value in said[event.name].items()]
    more = [path for path, value in set_here if isinstance(value, str) and path not in moving.arguments]
    for path in more:
        if path in run.model.data["instants"]:  # type: ignore[attr-defined]
            raise ValueError(
                f"{run.model.name}: found {path} set to an expression by an event, a time at which a load jumps, "
                "expected a parameter that forces depend on, or a number; there is no derivative"
            )
    arguments = (*moving.arguments, *dict.fromkeys(more))
    along = np.zeros((len(arguments), len(moving.columns)))
    along[: len(moving.arguments)] = moving.along
    found = []
    for part, model in parts:
        assert isinstance(model, Model)
        directions = directions_of(model, ("q", "u", *arguments))
        found.append(Stretch(part, model, replace(moving, arguments=arguments, along=along, directions=directions)))
    return found


def pass_events(before: Stretch, after: Stretch, change: Change) -> Part:
    """An instant at which events set parameters or switch effects, or joints let go or take hold, of all directions the
    state and the arguments behind it, (D, D).

    Raises ``ValueError`` where it has no derivative.
    """
    model, moving, states = before.model, before.moving, before.moving.states
    names = tuple(dict.fromkeys(event.name for event in change.events))
    changed = [f"{one.joint} to {'let go' if one.kind == 'release' else 'take hold'}" for one in change.joints]
    where = f"{model.name}: found {' and '.join([*names, *changed])} at t = {change.t:.9g} s"
    _check_answered(where, model, change)
    instant = _instant(before, change, where)
    there = np.eye(len(instant.dt))
    there[:states] = instant.behind
    matrix = there.copy()
    matrix[states:] = _set_moves(where, model, moving, change, there, instant.dt)
    drawn = _taken_hold(before, after, change, Drawn(change.q, change.u, instant.behind), matrix[states:])
    _check_ways(where, model, change, drawn)
    matrix[:states] = drawn.moves
    q, u = change.begins
    matrix[:states] -= np.outer(_motion(after.model, change.ways[1], change.t, q, u), instant.dt)
    checks = (*instant.checks, _stays_shut(after, change, matrix, where))
    units = in_units(model, matrix[None, :states])[0]
    impacts = [*change.impacts, *change.holds]
    contacts = tuple(contact for one in impacts for contact in one.contacts) if change.holds else ()
    contacts = contacts or (tuple(impacts[0].contacts) if impacts else ())
    kind: Literal["impact", "event", "release"] = "impact" if impacts else "event" if names else "release"
    joints = tuple(one.joint for one in change.joints)
    return Part(matrix, checks, Passed(change.t, kind, contacts, instant.dt, drawn.moves, units, names, joints))


def pass_end(stretch: Stretch, t: float, state: tuple[FloatArray, FloatArray], held: Held, ended: Event) -> Part | None:
    """The instant at which an event has ended a run, which changes nothing before; None where it has no derivative."""
    q, u = state
    model, moving, n = stretch.model, stretch.moving, len(q)
    if any(impact.t == t for impact in stretch.run.impacts):
        return None
    seen = watched(model, moving, t, q, u, held, causes_of(model, "", [ended], (), ()))
    if no_instant(model, seen):
        return None
    dt = -seen.by[0, :-1] / seen.rates[0]
    same = np.eye(2 * n, len(dt))
    behind = same + np.outer(_motion(model, held, t, q, u), dt)
    return Part(same, (), Passed(t, "event", (), dt, behind, np.eye(2 * n), (ended.name,)))


def _motion(model: Model, held: Held, t: float, q: FloatArray, u: FloatArray) -> FloatArray:
    """How fast the state changes, (2 n,): rates and accelerations."""
    u_dot = accelerations(model, held, np.array([t]), q[None], np.ascontiguousarray(u[None]))[0][0]
    return np.concatenate([u, u_dot])


def _instant(before: Stretch, change: Change, where: str) -> Moved:
    """By what the instant moves: with the impacts that come there, or with what events and joints watch. The start of a
    run stays where it is."""
    model, moving = before.model, before.moving
    causes = causes_of(model, where, change.events, change.joints, [*change.impacts, *change.holds])
    after_too = change.ways[1] if change.impacts or change.between else ()
    check_forces(where, (*change.ways[0], *after_too), causes)
    causes = [one for one in causes if not _follows(before, change, one, where)]
    if before.run.t[0] == change.t:
        D = len(moving.directions.columns)
        return Moved(np.zeros(D), np.eye(moving.states, D), ())
    if change.impacts:
        return _with_impacts(before, change, causes, where)
    seen = watched(model, moving, change.t, change.q, change.u, change.ways[0], causes)
    if why := no_instant(model, seen):
        raise ValueError(f"{where}, {why}")
    trigger = int(np.argmax(np.abs(seen.rates) / seen.sizes))
    dt = -seen.by[trigger, :-1] / seen.rates[trigger]
    behind = np.eye(moving.states, len(dt))
    behind += np.outer(_motion(model, change.ways[0], change.t, change.q, change.u), dt)
    return Moved(dt, behind, [] if len(causes) == 1 else [together(model, moving, where, seen, trigger)])


def _follows(before: Stretch, change: Change, cause: Cause, where: str) -> bool:
    """Whether a force is above its limit from the start of the run on, or by what has come at the same instant before:
    then it breaks its joint whatever that moves by.

    Raises ``ValueError`` where it is at its limit there, to rounding.
    """
    if not cause.limit:
        return False
    stretches = list(change.between)
    if before.run.t[0] == change.t:
        stretches.insert(0, before)
    elif _force_in(before.model, change.t, change.q, change.u, cause) > -MEET * cause.limit:
        return False  # it comes to its limit by itself
    forces = [_force_in(part.model, change.t, part.run.q[0], part.run.u[0], cause) for part in stretches]
    if any(abs(one) <= UNDECIDED * cause.limit for one in forces):
        raise ValueError(
            f"{where}, where the force in {cause.name} is its limit to rounding: whether it lets go is undecided; let "
            "the limit be another"
        )
    return any(one > 0.0 for one in forces)


def _force_in(model: Model, t: float, q: FloatArray, u: FloatArray, cause: Cause) -> float:
    """By how much the force in a joint is above its limit (N); far below of one that is open."""
    held = bool(model.parameters[model.joint_gates[cause.name]])
    return float(values(model, t, q, u, [cause])[0]) if held else -cause.limit


def _with_impacts(before: Stretch, change: Change, causes: Sequence[Cause], where: str) -> Moved:
    """Of what comes with impacts."""
    (struck,) = pass_impacts(before.model, before.moving, [(change.impacts, change.q, (change.ways[0], ()))])
    assert struck.passed is not None
    dt, behind = struck.passed.dt, struck.passed.behind
    checks = _come_with(before, change, causes, where, dt) if causes else []
    return Moved(dt, behind, [*struck.checks, *checks])


def _taken_hold(before: Stretch, after: Stretch, change: Change, state: Drawn, arguments: FloatArray) -> Drawn:
    """The state behind all joints that take hold at the instant, one after the other, from that before, where
    ``arguments`` (arguments, D) have moved already: events set them before joints change."""
    gates = before.model.joint_gates
    values = {path: before.model.parameters[path] for path in gates.values()}
    for one in change.joints:
        values[gates[one.joint]] = float(one.kind == "hold")
        if one.kind == "hold":
            there = after.model.with_parameters(values)
            state = take_hold(there, after.moving, change.t, state, arguments)
    return state


def _check_answered(where: str, model: Model, change: Change) -> None:
    """Raise ``ValueError`` where a function of Python has set or switched what the tables of events do not."""
    found = model.kernels.event_values(change.t, change.q, change.u) if change.events else np.zeros(0)
    for event in change.events:
        first, said = _table(model, event.name)
        told = dict(zip(said["set"], found[first:].tolist(), strict=False))
        others = [
            path
            for path, value in event.parameters.items()
            if path not in told or abs(told[path] - value) > JUMPS * abs(value)
        ]
        others += [name for name in (*event.on, *event.off) if name not in (*said["on"], *said["off"])]
        if others:
            raise ValueError(
                f"{where}, where a function of Python has changed {others[0]}, expected what the event's table says: "
                "nobody knows the derivatives of that function"
            )


def _table(model: Model, name: str) -> tuple[int, Mapping[str, Any]]:
    """Which of all values that events set is the first of one, and what is said of it: gates come behind the rest."""
    first = 0
    for said in events_of(model):
        if said["name"] == name:
            return first, said
        first += len(said["set"]) + len({*said["on"], *said["off"]})
    raise KeyError(name)


def _come_with(before: Stretch, change: Change, causes: Sequence[Cause], where: str, dt: FloatArray) -> list[Check]:
    """What comes at the instant of an impact comes with it: what it watches jumps over zero there, or is zero where the
    contact is closed."""
    model, moving = before.model, before.moving
    n, D = len(change.q), len(moving.directions.columns)
    u_minus = np.asarray(change.impacts[0].u_minus)
    seen = watched(model, moving, change.t, change.q, u_minus, change.ways[0], causes)
    after = values(model, change.t, change.q, change.u, causes)
    least = MEET * characteristic_time(model) * np.maximum(seen.sizes, seen.terms)
    checks = list[Check]()
    for k, cause in enumerate(causes):
        if seen.values[k] * after[k] < 0.0 and min(abs(seen.values[k]), abs(after[k])) > least[k]:
            continue
        if max(abs(seen.values[k]), abs(after[k])) > least[k]:
            raise ValueError(
                f"{where}, the instant of an impact, at which what {cause.name} watches jumps from "
                f"{seen.values[k]:.3g} to {after[k]:.3g}, expected it on both sides of zero: whether it comes is "
                "undecided; end the run before it"
            )
        if abs(seen.rates[k]) <= max(RESTS * seen.terms[k], SLOW * seen.sizes[k]):
            raise ValueError(
                f"{where}, the instant of an impact, before which what {cause.name} watches does not change, expected "
                "a crossing: its instant has no derivative; end the run before it"
            )

        def check(whole: FloatArray, k: int = k) -> None:
            missed = np.abs(seen.by[k, :D] @ whole + seen.rates[k] * (dt @ whole))
            terms = np.abs(seen.by[k, :D]) @ np.abs(whole) + np.abs(seen.rates[k] * (dt @ whole))
            row = seen.by[k, :n]
            wrong = missed > MEET * (terms + MEET * whole_of(model, moving, row))
            if wrong.any():
                raise ValueError(
                    f"{where}, the instant of an impact, which {moving.columns[int(np.argmax(wrong))]} parts: which "
                    "comes first then depends on the sign of the change, and there is no one matrix of derivatives; "
                    "leave out that column"
                )

        checks.append(check)
    return checks


def _set_moves(
    where: str, model: Model, moving: Moving, change: Change, there: FloatArray, dt: FloatArray
) -> FloatArray:
    """What arguments move by behind the instant, (arguments, D): those that are set by what they are set to, where
    the state moves by ``there`` (D, D) and the time by ``dt`` (D,)."""
    found = there[moving.states :].copy()
    if not change.events:
        return found
    q, u = change.q, change.u
    count = len(model.kernels.event_values(change.t, q, u))
    by = timed(model, moving, change.t, q).tangent("event_values", count, u, ALL)
    for event in change.events:
        first, said = _table(model, event.name)
        for number, path in enumerate(said["set"]):
            if path in moving.arguments:
                row = by[first + number]
                found[moving.arguments.index(path)] = row[:-1] @ there + row[-1] * dt
    if not np.isfinite(found).all():
        raise ValueError(f"{where}, where what is set has no finite derivative, expected one; end the run before it")
    return found


def _check_ways(where: str, model: Model, change: Change, state: Drawn) -> None:
    """Raise ``ValueError`` where the state is another than that behind joints that take hold, or a contact begins to be
    held, by what events have done."""
    before = dict(change.ways[0])
    (q, u), per = change.begins, characteristic_time(model)
    unit = model.coordinate_units
    jump = max(np.max(np.abs(q - state.q) / unit), np.max(np.abs(u - state.u) / unit) * per)
    if jump > JUMPS * max(1.0, np.max(np.abs(change.u) / unit) * per):
        raise ValueError(f"{where}, by which the state jumps, expected one that goes on; there is no derivative")
    struck = {model._contact(contact) for impact in change.impacts for contact in impact.contacts}
    for contact, how in change.ways[1]:
        name = "({}, {})".format(*model.contacts[contact])
        if contact not in before and contact not in struck:
            raise ValueError(
                f"{where}, from which on {name} is held, expected contacts that close by an impact: whether it touches "
                "there is undecided; end the run before it"
            )
        slid = before.get(contact, "").startswith("slides") and how != before[contact]
        if slid and not change.impacts:
            raise ValueError(
                f"{where}, from which on {name} {how}, which {before[contact]} until then, expected sliding that ends "
                "by itself; end the run before it"
            )


def _stays_shut(after: Stretch, change: Change, matrix: FloatArray, where: str) -> Check:
    """Loops and held contacts are shut behind the instant, whatever the column."""
    model, moving, (q, u) = after.model, after.moving, change.begins
    at, per = at_one(model, moving, change.t, q), characteristic_time(model)
    held = [contact for contact, _ in pushing(change.ways[1])]
    sticks = [contact for contact, how in pushing(change.ways[1]) if how == "sticks"]
    parts = [(at.closure_moves(), at.closure_rows, 1.0), (at.closure_rates_move(u), at.closure_rows, per)]
    parts += [(at.gaps_move()[held], at.gap_rows[held], 1.0), (at.gap_rates_move(u)[held], at.gap_rows[held], per)]
    parts.append((at.slips_move(u)[sticks], at.slip_rows[sticks], per))

    def check(whole: FloatArray) -> None:
        behind = matrix @ whole
        for moves, rows, time in parts:
            for row, of in zip(moves, rows, strict=True):
                missed, terms = np.abs(row @ behind), np.abs(row) @ np.abs(behind)
                wrong = missed > MEET * (terms + MEET * whole_of(model, moving, of) / time)
                if wrong.any():
                    raise ValueError(
                        f"{where}, where {moving.columns[int(np.argmax(wrong))]} opens loops or contacts that what is "
                        "set leaves shut, expected columns that keep them so; there is no derivative by it"
                    )

    return check
