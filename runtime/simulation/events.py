"""A run through the events that its scene asks for, and through joints that let go and take hold (docs/theory.md,
sections 5.15 and 5.17)."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..faults import Faults, UnknownName
from ..model.model import Model, with_params
from ..model.tolerances import joint_miss
from ..record.event import ENDED, Event
from ..record.hybrid_state import HybridState
from ..record.impact import Impact
from ..record.joint_change import JointChange
from ..run import Run
from .advance import Advance
from .arguments import check_until
from .dead_point import Way
from .joint_changes import broken_by, fits, gate_of, take_hold, why, with_gate
from .one_run import simulate_one
from .pieces import Piece
from .stretches import strung
from .watch import TOGETHER, Crossing, Located, Signal, Watch, changes_of, signals_of

MOST_CHANGES = 10_000
"""Instants of a run at which something is set or changes; more are taken for one to and fro without end."""
STOP = "stop"
"""What a function of an event answers for the run to end there."""

Answer = Mapping[str, float] | str | None
OnEvent = Mapping[str, Callable[[Event], Answer]]


@dataclass(frozen=True)
class Safe:
    """As far as a run has gone: what it is where it is interrupted."""

    pieces: tuple[Piece, ...]
    events: tuple[Event, ...]
    joints: tuple[JointChange, ...]
    changed: frozenset[str]


@dataclass
class Course:
    """Where a run with events is, and what it has left.

    ``model`` has the values of now, gates of effects and joints among them; ``q``, ``u`` are its state, and ``memory``
    is all that a run goes on from, where it goes on as it was; where not, ``latched`` is what effects hold. ``joints``
    are the changes of joints so far, and ``struck`` the impacts by which some take hold where the next piece begins.
    """

    model: Model
    signals: tuple[Signal, ...]
    on_event: OnEvent
    t: float = 0.0
    q: ArrayLike | None = None
    u: ArrayLike | None = None
    memory: HybridState | None = None
    latched: FloatArray | None = None
    way: Way | None = None
    changed: frozenset[str] = frozenset()
    begun: bool = False
    armed: list[bool] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=dict)
    pieces: list[Piece] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    joints: list[JointChange] = field(default_factory=list)
    struck: tuple[Impact, ...] = ()
    given: float = 0.0
    nfev: int = 0
    changes: int = 0
    failed: bool = False
    safe: Safe | None = None

    @property
    def said(self) -> Sequence[Mapping[str, Any]]:
        said: Sequence[Mapping[str, Any]] = self.model.data.get("events", ())
        return said

    def change(self, signal: int) -> Mapping[str, Any] | None:
        """What is said of the change of a joint that a signal tells; ``None`` of an event."""
        number = self.signals[signal].event - len(self.said)
        return None if number < 0 else changes_of(self.model)[number]

    def may_come(self) -> list[bool]:
        """Which signals tell something that can come: not those of joints that are so already."""
        changes = map(self.change, range(len(self.signals)))
        return [said is None or fits(self.model, said) for said in changes]


def simulate_with_events(
    model: Model,
    q0: ArrayLike | None,
    u0: ArrayLike | None,
    *,
    until: float | None,
    params: Mapping[str, float] | None,
    on_event: OnEvent | None,
    state: HybridState | None = None,
    **options: Any,
) -> Run:
    """The run of a model whose scene has events, or joints that let go or take hold, with the arguments of
    :func:`~..simulate.simulate`."""
    faults = Faults()
    with faults.collecting():
        model = with_params(model, params)
    with faults.collecting():
        check_functions(model, on_event)
    end: float = model.duration if until is None else until
    with faults.collecting():
        check_until(end)
    faults.stop_if_any()
    if isinstance(state, HybridState):
        model = model.with_parameters(_set_before(model, state, params))
    signals = signals_of(model)
    course = Course(model, signals, on_event or {}, q=q0, u=u0, memory=state)
    if isinstance(state, HybridState):
        course.t, course.changed = state.t, state.changed
    course.armed = [_at_once(course, k, first=state is None) for k in range(len(signals))]
    try:
        message = _run_on(course, float(end), options)
    except KeyboardInterrupt:
        if course.safe is None or not options["keep_interrupted"]:
            raise
        return _interrupted(course, course.safe)
    run = strung(course.pieces, course.events, course.joints, course.nfev, message, course.changed)
    return replace(run, success=False) if course.failed else run


def _at_once(course: Course, signal: int, first: bool) -> bool:
    """Whether what a signal tells comes where it is looked for from now on, if it is not below zero: a force that is
    too large, and where the run begins the ``first`` time a time."""
    said = course.change(signal)
    return said is not None and fits(course.model, said) and bool(said["force"] or (first and said["at"] is not None))


def _interrupted(course: Course, safe: Safe) -> Run:
    """The run as far as it has gone."""
    run = strung(safe.pieces, safe.events, safe.joints, course.nfev, None, safe.changed)
    if run.success:  # of a stretch that was whole
        return replace(run, success=False, message=f"stopped at t = {run.t[-1]:.12g} s: interrupted")
    return run


def _set_before(model: Model, state: HybridState, params: Mapping[str, float] | None) -> dict[str, float]:
    """Values that events have set on the way to a state. What is asked for now is none of them, and is told of where
    the state has another value."""
    own = state.changed - set(params or ()) if state.changed <= model.parameters.keys() else ()
    return {path: state.parameters[path] for path in sorted(own) if path in state.parameters}


def check_functions(model: Model, on_event: object) -> None:
    """Raise ``ValueError`` or ``TypeError`` unless these are functions by names of the model's events, or nothing."""
    faults = Faults()
    names = [said["name"] for said in model.data.get("events", ())]
    if on_event is not None and not isinstance(on_event, Mapping):
        faults.note(TypeError(f"on_event: found {on_event!r}, expected functions by names of events, or None"))
    for name, function in on_event.items() if isinstance(on_event, Mapping) else ():
        if name not in names:
            faults.add(f"on_event: found {name!r}, expected the name of an event; {_known(names)}")
        if not callable(function):
            faults.note(TypeError(f"on_event: found {function!r} for {name!r}, expected a function of the event"))
    if model.folded and any(said["set"] for said in model.data.get("events", ())):
        faults.add(
            f"{model.name}: found events that set parameters, which are folded into the code as numbers, expected a "
            "model without --fold; generate it so"
        )
    faults.stop_if_any()


def _known(names: Sequence[str]) -> str:
    return f"those of the scene are {', '.join(names)}" if names else "the scene has no [[event]]"


def _run_on(course: Course, end: float, options: Mapping[str, Any]) -> str | None:
    """Go on to the ``end``; a sentence where an event ends the run, or it cannot go on."""
    while True:
        watch = Watch(course.signals, course.armed, _halts(course))
        try:
            run = _stretch(course, end, options, watch)
        except ValueError as error:
            if not course.pieces:
                raise
            return _stuck(course, error)
        found = watch.along(run)
        now, later = _groups(course, found, run)
        for crossing in now:
            course.events.append(_event(course, crossing))
        if not later:
            if not run.success or run.t[-1] >= end:
                course.pieces.append(_piece(course, run))
                return None
            _keep(course, run, found, {one.signal for one in now})
            course.safe = Safe((*course.pieces,), (*course.events,), (*course.joints,), course.changed)
            continue
        t = later[0].t
        _keep(
            course,
            run,
            found,
            {*(one.signal for one in now if _together(course, one.t, t)), *(one.signal for one in later)},
        )
        message = _happen(course, later)
        if message is not None:
            return _close(course, options) or message
        course.changes += 1
        if course.changes > MOST_CHANGES:
            course.failed = True
            what = "events set parameters" if course.said else "joints let go and take hold"
            return f"stopped at t = {course.t:.12g} s: {what} without end; change when they come"


def _halts(course: Course) -> list[int] | None:
    """After how many more of each event the run is another, or ends: -1 where it does not; ``None`` of all of them."""
    found = []
    for one in course.said:
        changes = one["set"] or one["on"] or one["off"] or one["name"] in course.on_event
        left = one["stop"] - course.counts.get(one["name"], 0) if one["stop"] else -1
        found.append(1 if changes else max(left, 1) if one["stop"] else -1)
    found += [1] * len(changes_of(course.model))
    return found if max(found) > 0 else None


def _stretch(course: Course, until: float, options: Mapping[str, Any], watch: Watch | None = None) -> Run:
    """A run from where the course is. Raises ``ValueError`` where what has been set has opened the loops."""
    given: dict[str, Any] = {"until": until, "params": None, "state": course.memory, **options}
    if course.begun and course.memory is None:
        _check_closed(course)
        given |= {"begin": course.t, "latched": course.latched}
    start = (None, None) if course.memory is not None and course.begun else (course.q, course.u)
    run = simulate_one(course.model, *start, way=course.way, watch=watch, **given)
    course.nfev += run.nfev
    return run


def _groups(course: Course, found: Sequence[Located], run: Run) -> tuple[list[Crossing], list[Crossing]]:
    """Instants along a run in the order of time before the first after which it is another, and those of that one."""
    every = [
        Crossing(t, number, state) for number, of_signal in enumerate(found) for t, state in of_signal.states.items()
    ]
    every.sort(key=lambda one: (one.t, one.signal))
    counted = dict(course.counts)
    for index, one in enumerate(every):
        changes = course.change(one.signal) is not None
        if not changes:
            said = course.said[course.signals[one.signal].event]
            counted[said["name"]] = counted.get(said["name"], 0) + 1
            changes = said["set"] or said["on"] or said["off"] or said["name"] in course.on_event
            changes = changes or (said["stop"] and counted[said["name"]] >= said["stop"])
        if changes:
            first = index
            while first and _together(course, every[first - 1].t, one.t):
                first -= 1
            last = index + 1
            while last < len(every) and _together(course, every[last].t, one.t):
                last += 1
            same = sorted(every[first:last], key=lambda other: other.signal)
            return every[:first], [replace(other, t=one.t, state=one.state) for other in same]
    return every, []


def _together(course: Course, one: float, other: float) -> bool:
    return abs(one - other) <= TOGETHER * max(abs(other), course.model.duration)


def _keep(course: Course, run: Run, found: Sequence[Located], came: set[int]) -> None:
    """Take a run for the next stretch; the signals that ``came`` at its end have to go below zero again."""
    course.pieces.append(_piece(course, run))
    course.given, course.struck = 0.0, ()
    course.t = float(run.t[-1])
    course.memory, course.begun = run.state, True
    course.q, course.u = run.q[-1], run.u[-1]
    course.way = (course.way or Way(run.t[0].item(), {})).on(run.model, run.q[0], run.q[-1])
    course.latched = run.advance.latched.at(course.t) if isinstance(run.advance, Advance) else None
    course.armed = [one.armed and number not in came for number, one in enumerate(found)]


def _piece(course: Course, run: Run) -> Piece:
    return Piece(run, not course.pieces or course.memory is None, course.given, course.struck)


def _event(course: Course, crossing: Crossing) -> Event:
    """The record of an instant along a run."""
    signal = course.signals[crossing.signal]
    name = course.said[signal.event]["name"]
    course.counts[name] = course.counts.get(name, 0) + 1
    q, u = crossing.state
    return Event(crossing.t, name, "rising" if signal.sign > 0 else "falling", course.counts[name], q, u)


def _happen(course: Course, crossings: Sequence[Crossing]) -> str | None:
    """What events of one instant do, and behind them joints, in the order of their tables; a message where one ends
    the run, or it cannot go on."""
    ends: list[str] = []
    could, before = course.may_come(), course.model
    for crossing in crossings:
        change = course.change(crossing.signal)
        message = _do(course, before, crossing, ends) if change is None else _change(course, change, why(change))
        if message is not None:
            return message
    for number, can in enumerate(course.may_come()):
        if can and not could[number]:
            course.armed[number] = _at_once(course, number, first=False)
    if ends:
        return f"{ENDED}{course.t:.12g} s by {' and '.join(dict.fromkeys(ends))}"
    return None


def _do(course: Course, before: Model, crossing: Crossing, ends: list[str]) -> str | None:
    """What one event does, which works out what it sets by the model ``before`` the instant, and what a function
    answers to it; it is one of the ``ends`` where it ends the run. A message where the run cannot go on."""
    event, number = _event(course, crossing), course.signals[crossing.signal].event
    said, values = course.said[number], _values(before, number, event)
    answer = course.on_event[event.name](event) if event.name in course.on_event else None
    answered = answer if isinstance(answer, Mapping) else {}
    if answer == STOP or (said["stop"] and event.number >= said["stop"]):
        ends.append(event.name)
    elif answer is not None and not isinstance(answer, Mapping):
        raise TypeError(
            f"on_event: found {answer!r} from the function of {event.name!r}, expected None, values of parameters "
            f'by path, or "{STOP}"'
        )
    model, off = course.model, frozenset(course.model.off)
    then = (off | frozenset(said["off"])) - frozenset(said["on"])
    for name, path in model.gates.items():
        if path in answered:
            then = then | {name} if answered[path] == 0.0 else then - {name}
    gates = {path: float(name not in then) for name, path in model.gates.items() if name in off ^ then}
    own = {path: value for path, value in values.items() if path not in answered}
    joints = {joint: answered[path] for joint, path in model.joint_gates.items() if path in answered}
    by = event.name
    try:
        model = _with(model, own | gates)
        by = f"the answer to {event.name}"
        _with(model, answered)  # all at once say what is wrong with them
        model = _with(model, {path: answered[path] for path in answered if path not in model.joint_gates.values()})
    except (ValueError, UnknownName) as error:
        return _unsettable(course, event, error, by)
    values |= {path: float(value) for path, value in answered.items() if path not in model.gates.values()}
    if values or gates or answered:
        event = replace(
            event,
            parameters=dict(values),
            before={path: course.model.parameters[path] for path in values},
            on=tuple(sorted(off - then)),
            off=tuple(sorted(then - off)),
        )
        event = replace(event, energy=_set(course, model, {*values, *gates}))
    course.events.append(event)
    because = f"as the function of {event.name} says"
    messages = (_change(course, _asked(course, joint, held), because) for joint, held in joints.items())
    return next(filter(None, messages), None)


def _asked(course: Course, joint: str, held: float) -> Mapping[str, Any]:
    """A change that a function asks for, and no table brings: a joint takes hold as its first table says."""
    kind = "hold" if held else "release"
    of_scene = (said for said in changes_of(course.model) if said["joint"] == joint and said["kind"] == kind)
    return {**next(of_scene, {"joint": joint, "kind": kind, "within": None})}


def _change(course: Course, said: Mapping[str, Any], because: str) -> str | None:
    """A joint lets go or takes hold, if another table has not had it do so at the same instant; a message where it
    cannot."""
    q, u, joint = np.asarray(course.q), np.asarray(course.u), said["joint"]
    if not fits(course.model, said):
        return None
    gap, energy, broken = 0.0, 0.0, list[Mapping[str, Any]]()
    if said["kind"] == "hold":
        try:
            held = take_hold(course.model, said, course.t, q, u)
        except ValueError as error:
            course.failed = True
            return f"stopped at t = {course.t:.12g} s: {error}"
        gap, energy, broken = held.gap, held.energy, broken_by(held.model, held.impact)
        course.struck = (*course.struck, held.impact)
        course.given += energy - held.impact.energy_loss
        course.q, course.u = held.q, held.u
    model = course.model
    number = next((number for number, one in enumerate(changes_of(model)) if one is said), -1)
    course.joints.append(JointChange(course.t, joint, said["kind"], because, gap, energy, number))
    course.model = with_gate(model, joint, said["kind"] == "hold")
    course.changed |= {gate_of(model, joint)}
    if said["kind"] == "hold" and course.latched is not None:
        _forget(course, model.data["switching"]["ends"][joint].get("latches", ()))
    course.memory = None
    return next(filter(None, (_change(course, one, why(one)) for one in broken)), None)


def _forget(course: Course, latches: Collection[str]) -> None:
    """Effects that come on hold nothing yet."""
    assert course.latched is not None
    held = zip(course.model.data.get("latches", ()), course.latched, strict=True)
    course.latched = np.array([np.nan if name in latches else value for name, value in held])


def _unsettable(course: Course, event: Event, error: Exception, by: str) -> str:
    """What ends a run in which an event sets what cannot be, or a function answers so."""
    course.failed = True
    course.events.append(event)
    return f"stopped at t = {course.t:.12g} s by {by}: {'; '.join(str(error).splitlines())}"


def _values(model: Model, number: int, event: Event) -> dict[str, float]:
    """What the event of a number sets parameters to, by those of the ``model``, before any is set."""
    every = model.data["events"]
    said = every[number]
    before = sum(len(one["set"]) + len({*one["on"], *one["off"]}) for one in every[:number])
    found = model.kernels.event_values(event.t, np.ascontiguousarray(event.q), np.ascontiguousarray(event.u))
    values = found[before : before + len(said["set"])]
    return {path: float(value) for path, value in zip(said["set"], values, strict=True)}


def _with(model: Model, values: Mapping[str, float]) -> Model:
    """The model with these values. Raises ``ValueError`` for those that it cannot have."""
    for path in values:
        if any(drive["speed"] == path for drive in model.data["drives"]):
            raise ValueError(
                f"{path}: found it set by an event, expected it kept: a driven joint keeps its first speed"
            )
    return model.with_parameters(values).as_nobody_changes_it() if values else model


def _set(course: Course, model: Model, changed: Collection[str]) -> float:
    """Go on with the ``model`` in which parameters have ``changed``, gates of effects among them; the energy (J) that
    the mechanism gets by that."""
    before, off = _energy(course), course.model.off
    course.model = model
    course.changed |= frozenset(changed)
    if course.latched is not None:
        gates = (one for one in model.data.get("gates", ()) if one["effect"] in off)
        _forget(course, [name for one in gates for name in one["latches"]])
    course.memory = None
    jump = _energy(course) - before
    course.given += jump
    return jump


def _check_closed(course: Course) -> None:
    """Raise ``ValueError`` unless the loops are shut and wheels mesh where the course is, with the values set."""
    model = course.model
    open_by = float(np.max(np.abs(model.closure(np.asarray(course.q))), initial=0.0))
    if open_by > joint_miss(model.core.REAL, model.length):
        raise ValueError(
            f"{model.name}: what events have set opens the loops by {open_by:.3g} m; set what leaves them shut"
        )


def _energy(course: Course) -> float:
    return float(sum(course.model.energy(np.asarray(course.q), np.asarray(course.u))))


def _close(course: Course, options: Mapping[str, Any]) -> str | None:
    """Where a run was cut, or goes on with other parameters, its state is that of a run that begins there; a message
    where none can begin."""
    if course.memory is None:
        try:
            run = _stretch(course, course.t, options)
        except ValueError as error:
            return _stuck(course, error)
        course.pieces.append(Piece(run, True, course.given, course.struck))
    return None


def _stuck(course: Course, error: ValueError) -> str:
    """What ends a run that cannot go on from where it is with the values that are set."""
    course.failed = True
    last = course.joints[-1] if course.struck else None
    drawn = (
        last is not None and last.kind == "hold" and last.gap > joint_miss(course.model.core.REAL, course.model.length)
    )
    apart = (
        f"{last.joint} took hold and drew links together by {last.gap:.3g} m, to where no run begins: "
        if last and drawn
        else ""
    )
    return f"stopped at t = {course.t:.12g} s: {apart}{error}"
