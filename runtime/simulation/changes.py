"""What events of a scene and joints have changed along a run, read from what its core tells."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any, Literal, NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..model.assembly import project
from ..model.model import Model
from ..record.event import Event
from ..record.impact import Impact
from ..record.joint_change import JointChange
from .joint_changes import changes_of, why

DIRECTIONS: Mapping[int, Literal["rising", "falling"]] = {1: "rising", -1: "falling"}


class Answered(NamedTuple):
    """What a function has answered to the event of a ``name`` and ``number``: ``values`` of parameters by path, or that
    the run ``ends``; or values that cannot be, for which ``error`` says why."""

    name: str
    number: int
    values: Mapping[str, float]
    ends: bool = False
    error: Exception | None = None


class Change(NamedTuple):
    """One that the core tells: at ``t`` (s) by the event, or the table of a joint, of the number ``indicator``, or by
    none, -1. It set values, or, unless it is -1, the ``gate`` of a joint. The mechanism got ``energy`` (J) by it;
    points that it drew together were ``gap`` (m) apart. It came by the ``crossing`` of that number; a joint took hold
    by the ``impact`` of that number."""

    t: float
    indicator: int
    gate: int
    energy: float
    gap: float
    crossing: int
    impact: int


@dataclass(frozen=True)
class Begin:
    """Where a run begins, or begins anew behind changes: by a ``model``, at that ``row`` of the whole, with that
    ``impact`` and that entry of how contacts are held, ``mode``. ``scales`` are those of the motion from there on.
    ``given`` is the energy (J) that the mechanism is said to have got there, and ``struck`` are impacts by which joints
    have taken hold."""

    model: Model
    scales: tuple[float, float]
    row: int = 0
    impact: int = 0
    mode: int = 0
    given: float = 0.0
    struck: tuple[Impact, ...] = ()


@dataclass(frozen=True)
class Told:
    """All that events and joints did: where the run ``begins``, and begins anew, the ``events`` and changes of
    ``joints``, and the paths of parameters that were ``set``; ``ends`` are names of events that have ended it."""

    begins: Sequence[Begin]
    events: Sequence[Event]
    joints: Sequence[JointChange]
    set: frozenset[str]
    ends: Sequence[str]


def with_values(model: Model, before: FloatArray, after: FloatArray) -> Model:
    """The ``model``, whose settable parameters are ``before`` (parameters,) in the core, with those ``after``."""
    names = [*model.settable]
    values = {names[k]: float(after[k]) for k in np.flatnonzero(before != after)}
    return model.with_parameters(values).as_nobody_changes_it() if values else model


def values_of(model: Model) -> FloatArray:
    """The settable parameters of a model as its core has them: (parameters,)."""
    return np.array([*model.settable.values()], dtype=model.core.REAL)


def check_settable(model: Model, paths: Iterable[str]) -> None:
    """Raise ``ValueError`` if one of the ``paths`` is a parameter that no event may set."""
    speeds = {drive["speed"] for drive in model.data["drives"]}
    for path in paths:
        if path in speeds:
            raise ValueError(
                f"{path}: found it set by an event, expected it kept: a driven joint keeps its first speed"
            )


def told_of(model: Model, found: Mapping[str, Any], answers: Sequence[Answered]) -> Told:
    """What the core has ``found`` in the run of a ``model``, whose functions have given these ``answers``."""
    said, joints = model.data.get("events", ()), list[JointChange]()
    events, given = events_of(model, found), {(one.name, one.number): one for one in answers}
    answered = {
        k: given[event.name, event.number] for k, event in events.items() if (event.name, event.number) in given
    }
    paths, joint_of = [*model.settable], {path: joint for joint, path in model.joint_gates.items()}
    now, values, kept, done = model, values_of(model), {values_of(model).tobytes(): model}, dict[int, Event]()
    begins, sets = [Begin(model, found["scales"])], set[str]()
    for (row, impact, mode, scales), instant in groupby(range(len(found["origins"])), found["origins"].__getitem__):
        got, struck, q = 0.0, list[Impact](), found["q"][row - 1]
        for k in instant:
            change, after = Change(*found["changes"][k]), found["values"][k]
            if after.tobytes() not in kept:
                kept[after.tobytes()] = with_values(now, values, after)
            then = kept[after.tobytes()]
            event, answer = events.get(change.crossing), answered.get(change.crossing)
            if event and change.indicator < len(said) and change.crossing not in done:
                own = said[change.indicator]["set"] if change.indicator >= 0 else ()
                energy = change.energy if change.gate < 0 else 0.0
                done[change.crossing] = _done(event, own, answer, (now, then), energy)
                sets |= {*done[change.crossing].parameters, *(now.gates[name] for name in set(now.off) ^ set(then.off))}
            got += change.energy
            if change.gate >= 0:
                joint, holds = joint_of[paths[change.gate]], bool(after[change.gate])
                number = change.indicator - len(said) if change.indicator >= 0 else -1
                because = why(changes_of(model)[number]) if number >= 0 or not event else _asked_by(event)
                kind: Literal["hold", "release"] = "hold" if holds else "release"
                joints.append(JointChange(change.t, joint, kind, because, change.gap, change.energy, number))
                sets.add(paths[change.gate])
                if holds:
                    struck.append(_struck(then, found, change, joint, q))
                    got -= struck[-1].energy_loss
                    q = project(then, q, struck[-1].u_plus)[0] if change.gap else q
            now, values = then, after
        begins.append(Begin(now, scales, row, impact, mode, got, tuple(struck)))
    unset = found["t"][-1] if len(found["changes"]) > len(found["origins"]) else np.nan  # when nothing could be set
    for k, answer in answered.items():
        if answer.values and k not in done and events[k].t != unset:  # what was in force already
            there = [one.model for one in begins if found["t"][one.row] < events[k].t or one.row == 0][-1]
            done[k] = _done(events[k], (), answer, (there, there), 0.0)
    every = [done.get(k, event) for k, event in events.items()]
    last = [event for k, event in events.items() if event.t == found["t"][-1] and _ends(model, event, answered.get(k))]
    ends = [*dict.fromkeys(event.name for event in last)] if found["ended"] else []
    return Told(begins, every, joints, frozenset(sets), ends)


def events_of(model: Model, found: Mapping[str, Any]) -> dict[int, Event]:
    """The events along a run as they came, by the numbers of their crossings."""
    said, n = model.data.get("events", ()), len(model.q_names)
    counts, events = dict[str, int](), dict[int, Event]()
    for k, ((t, indicator, sign), y) in enumerate(zip(found["crossings"], found["crossed"], strict=True)):
        if indicator < len(said):
            name = said[indicator]["name"]
            counts[name] = counts.get(name, 0) + 1
            events[k] = Event(t, name, DIRECTIONS[sign], counts[name], y[:n], y[n:])
    return events


def _done(
    event: Event, own: Iterable[str], answer: Answered | None, models: tuple[Model, Model], energy: float
) -> Event:
    """The event with what it and the answer to it have set and switched, between the ``models`` before and after."""
    before, after = models
    answered = answer.values if answer is not None else {}
    gates = {*before.gates.values()}
    values = {path: answered.get(path, after.parameters[path]) for path in own}
    values |= {path: value for path, value in answered.items() if path not in gates}
    return replace(
        event,
        parameters=values,
        before={path: before.parameters[path] for path in values},
        on=tuple(sorted({*before.off} - {*after.off})),
        off=tuple(sorted({*after.off} - {*before.off})),
        energy=energy,
    )


def _asked_by(event: Event) -> str:
    return f"as the function of {event.name} says"


def _struck(model: Model, found: Mapping[str, Any], change: Change, joint: str, q: FloatArray) -> Impact:
    """The impact by which a joint has taken hold of a ``model`` that has it, at ``q``."""
    k = change.impact
    u_minus, u_plus = found["u_minus"][k], found["u_plus"][k]
    none = np.zeros((1, 2 * len(model.contacts)), dtype=model.core.REAL)
    impulses, _ = model.kernels.joint_impulses(np.ascontiguousarray(q[None]), (u_plus - u_minus)[None], none)
    reactions = impulses.reshape(len(model.joints), 3)
    size = float(np.hypot(*reactions[model.joints.index(joint), :2]))
    loss = float(found["energy_loss"][k])
    return Impact(change.t, ((joint, "hold"),), u_minus, u_plus, np.array([size]), loss, np.zeros(1), reactions)


def _ends(model: Model, event: Event, answer: Answered | None) -> bool:
    """Whether an event ends its run."""
    stop = next(one["stop"] for one in model.data["events"] if one["name"] == event.name)
    return bool(stop and event.number >= stop) or (answer is not None and answer.ends)
