"""A run through the events that its scene asks for (docs/theory.md, section 5.17)."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..faults import Faults, UnknownName
from ..loading.structures import structures_of
from ..model.model import Model, with_params
from ..model.tolerances import joint_miss
from ..model.whole import Whole
from ..record.event import ENDED, Event
from ..record.hybrid_state import HybridState
from ..run import Run
from .advance import Advance
from .arguments import check_until
from .crossings import Crossing, Seen, Signal, Watched, seen, signals_of
from .dead_point import Way
from .growing import Enough, Look, at_the_start, sure_rows, wanted
from .one_run import simulate_one
from .pieces import Piece, SwitchedRun, number_at
from .quantities import Quantity
from .stretches import cut, strung
from .switching import STRETCHES, simulate_switching
from .watch import TOGETHER, Located, Watch
from .watching import certain

MOST_CHANGES = 10_000
"""Events of a run that set something; more are taken for a parameter that is set to and fro without end."""
SAME = 1e-9
"""An event that has cut a run through structures, and comes again within this part of the time, or of the duration, is
the same: the run up to there is made again, and ends nearer or farther from zero than its first making by the error of
its steps."""
STOP = "stop"
"""What a function of an event answers for the run to end there."""

Answer = Mapping[str, float] | str | None
OnEvent = Mapping[str, Callable[[Event], Answer]]


@dataclass(frozen=True)
class Safe:
    """As far as a run has been looked at: what it is where it is interrupted. Along the last of its ``pieces`` the
    ``crossings`` are events beside those before."""

    pieces: tuple[Piece, ...]
    events: tuple[Event, ...]
    crossings: tuple[Crossing, ...]
    counts: Mapping[str, int]
    changed: frozenset[str]


@dataclass
class Course:
    """Where a run with events is, and what it has left.

    ``model`` has the values of now, gates of effects among them. ``structure`` is what the mechanism is, where joints
    let go and take hold; ``q``, ``u`` are its state, and ``memory`` is all that a run goes on from, where it goes on as
    it was; where not, ``latched`` is what effects hold.
    """

    model: Model
    signals: tuple[Signal, ...]
    on_event: OnEvent
    t: float = 0.0
    structure: int = 0
    q: ArrayLike | None = None
    u: ArrayLike | None = None
    memory: HybridState | None = None
    latched: FloatArray | None = None
    way: Way | None = None
    changed: frozenset[str] = frozenset()
    begun: bool = False
    armed: list[bool] = field(default_factory=list)
    cut_at: dict[int, float] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    pieces: list[Piece] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    given: float = 0.0
    nfev: int = 0
    changes: int = 0
    failed: bool = False
    safe: Safe | None = None

    @property
    def said(self) -> Sequence[Mapping[str, Any]]:
        said: Sequence[Mapping[str, Any]] = self.model.data["events"]
        return said

    def interrupts(self, signal: int) -> bool:
        """Whether the next instant of a signal may be one after which the run is another."""
        said = self.said[self.signals[signal].event]
        ends = said["stop"] and self.counts.get(said["name"], 0) + 1 >= said["stop"]
        return bool(ends or said["set"] or said["on"] or said["off"] or said["name"] in self.on_event)


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
    """The run of a model whose scene has events, with the arguments of :func:`~..simulate.simulate`."""
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
    signals = signals_of(model.data["events"])
    armed = [False] * len(signals)
    course = Course(model, signals, on_event or {}, q=q0, u=u0, memory=state, armed=armed)
    if isinstance(state, HybridState):
        course.t, course.changed = state.t, state.changed
    try:
        message = _run_on(course, float(end), options)
    except KeyboardInterrupt:
        if course.safe is None or not options["keep_interrupted"]:
            raise
        return _interrupted(course, course.safe)
    run = strung(course.pieces, course.events, course.nfev, message, course.changed)
    return replace(run, success=False) if course.failed else run


def _interrupted(course: Course, safe: Safe) -> Run:
    """The run as far as it has been looked at."""
    course.counts = dict(safe.counts)
    events = [*safe.events, *(_event(course, crossing, safe.pieces[-1].run) for crossing in safe.crossings)]
    counted = any(piece.run is safe.pieces[-1].run for piece in course.pieces)
    nfev = course.nfev + (0 if counted else safe.pieces[-1].run.nfev)
    run = strung(safe.pieces, events, nfev, None, safe.changed)
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
    interrupting, switching = _interrupting(course), course.model.data.get("switching") is not None
    while True:
        until = _border(course, end) if interrupting and switching else end
        try:
            run, found = _looked_at(course, until, options)
        except ValueError as error:
            if not course.pieces:
                raise
            return _stuck(course, error)
        now, later = _groups(course, found, run)
        for crossing in now:
            course.events.append(_event(course, crossing, run))
        if not later:
            if not run.success or run.t[-1] >= end:
                course.pieces.append(_piece(course, run))
                return None
            _keep(course, run, found, float(np.nextafter(run.t[-1], np.inf)), {one.signal for one in now})
            course.safe = Safe((*course.pieces,), (*course.events,), (), dict(course.counts), course.changed)
            continue
        t = later[0].t
        if switching and t < run.t[-1]:
            struck = t == run.t[0] or any(impact.t == t for impact in run.impacts)
            run = cut(run, t) if struck else _stretch(course, t, options)
        came = {one.signal for one in later} | {one.signal for one in now if _together(course, one.t, t)}
        _keep(course, run, found, t, came)
        if switching:
            course.cut_at |= dict.fromkeys(came, t)
        message = _happen(course, later, run)
        if message is not None:
            return _close(course, options) or message
        course.changes += 1
        if course.changes > MOST_CHANGES:
            course.failed = True
            return f"stopped at t = {course.t:.12g} s: events set parameters without end; change when they come"


def _interrupting(course: Course) -> bool:
    """Whether an event may come after which the run is another."""
    return any(course.interrupts(k) for k in range(len(course.signals))) or any(one["stop"] for one in course.said)


def _halts(course: Course) -> list[int] | None:
    """After how many more of each event the run is another, or ends: -1 where it does not; ``None`` of all of them."""
    found = []
    for one in course.said:
        changes = one["set"] or one["on"] or one["off"] or one["name"] in course.on_event
        left = one["stop"] - course.counts.get(one["name"], 0) if one["stop"] else -1
        found.append(1 if changes else max(left, 1) if one["stop"] else -1)
    return found if max(found) > 0 else None


def _border(course: Course, end: float) -> float:
    """How far the run goes before it is looked at."""
    stretch = course.model.duration / STRETCHES
    border = stretch * (math.floor(course.t / stretch) + 1)
    return min(end, border if border > course.t else border + stretch)


def _looked_at(course: Course, until: float, options: Mapping[str, Any]) -> tuple[Run, tuple[Watched | Located, ...]]:
    """A run from where the course is to ``until``, or as far as it is sure what changes it first, and what
    comes along it."""
    if course.model.data.get("switching") is None:
        watch = Watch([(one.event, one.sign) for one in course.signals], course.armed, _halts(course))
        run = _stretch(course, until, options, None, watch)
        return run, watch.along(run)
    before: Seen | None = None
    changes = _interrupting(course)

    def look(run: Run) -> int:
        nonlocal before
        earlier, before = before, seen(before, run, course.signals, course.armed)
        now, later = _groups(course, before.found, run)
        if later and certain(later[0].t, float(run.t[-1]), course.model.duration):
            raise Enough(look)
        sure = None if later else sure_rows(None if earlier is None else earlier.run, run, changes)
        if sure is not None:
            came = tuple(one for one in now if one.t <= sure.t[-1])
            pieces = (*course.pieces, _piece(course, sure))
            course.safe = Safe(pieces, tuple(course.events), came, dict(course.counts), course.changed)
        return wanted(len(run.t))

    try:
        run = _stretch(course, until, options, look)
    except Enough:
        assert before is not None
        course.nfev += before.run.nfev
        return before.run, before.found
    return run, seen(before, run, course.signals, course.armed).found


def _stretch(
    course: Course,
    until: float,
    options: Mapping[str, Any],
    look: Look | None = at_the_start,
    watch: Watch | None = None,
) -> Run:
    """A run from where the course is. Raises ``ValueError`` where what has been set has opened the loops."""
    if course.begun and course.memory is None:
        _check_closed(course)
    switching = course.model.data.get("switching") is not None
    make: Callable[..., Run] = simulate_switching if switching else simulate_one
    given: dict[str, Any] = {"until": until, "params": None, "state": course.memory, "look": look, **options}
    if course.begun and course.memory is None:
        begin = {"begin": course.t, "latched": course.latched}
        given |= {"begin": (course.structure, course.t, course.latched)} if switching else begin
    if watch is not None:
        given["watch"] = watch
    start = (None, None) if course.memory is not None and course.begun else (course.q, course.u)
    run = make(course.model, *start, way=course.way, **given)
    course.nfev += run.nfev
    return run


def _groups(course: Course, found: Sequence[Watched | Located], run: Run) -> tuple[list[Crossing], list[Crossing]]:
    """Instants along a run in the order of time before the first after which it is another, and those of that one.

    What comes together with an impact comes at its instant, to the last digit.
    """
    struck = np.array([impact.t for impact in run.impacts])
    every: list[Crossing] = []
    for number, of_signal in enumerate(found):
        since = course.cut_at.get(number, -math.inf)
        for t in of_signal.times:
            if t - since <= SAME * max(abs(t), course.model.duration):
                continue
            near = struck[np.abs(struck - t) <= TOGETHER * max(abs(t), course.model.duration)]
            near = near if isinstance(of_signal, Watched) else near[:0]  # the core has done so
            at = float(near[np.argmin(np.abs(near - t))]) if near.size else t
            every.append(Crossing(at, number, of_signal.states.get(at)))
    every.sort(key=lambda one: (one.t, one.signal))
    counted = dict(course.counts)
    for index, one in enumerate(every):
        said = course.said[course.signals[one.signal].event]
        counted[said["name"]] = counted.get(said["name"], 0) + 1
        changes = said["set"] or said["on"] or said["off"] or said["name"] in course.on_event
        if changes or (said["stop"] and counted[said["name"]] >= said["stop"]):
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


def _keep(course: Course, run: Run, found: Sequence[Watched | Located], t: float, came: set[int]) -> None:
    """Take a run for the next stretch, up to ``t`` (s); the signals that ``came`` there have to go below zero again."""
    course.pieces.append(_piece(course, run))
    course.given = 0.0
    course.t = float(run.t[-1])
    course.memory, course.begun = run.state, True
    course.q, course.u = run.q[-1], run.u[-1]
    advance, inner = run.advance, [course.pieces[-1]]
    if isinstance(run, SwitchedRun):
        inner = run.advance.pieces  # type: ignore[attr-defined]
        piece = inner[number_at(inner, course.t, before=False)]
        course.structure, advance = piece.structure, piece.run.advance
        course.q, course.u = piece.run.at(min(course.t, piece.run.t[-1]))
    for part in (piece.run for piece in inner):
        course.way = (course.way or Way(part.t[0].item(), {})).on(part.model, part.q[0], part.q[-1])
    course.latched = advance.latched.at(course.t) if isinstance(advance, Advance) else None
    course.armed = [one.armed_at(t) and number not in came for number, one in enumerate(found)]


def _piece(course: Course, run: Run) -> Piece:
    return Piece(course.structure, run, not course.pieces or course.memory is None, course.given)


def _event(course: Course, crossing: Crossing, run: Run) -> Event:
    """The record of an instant along a run."""
    signal = course.signals[crossing.signal]
    name = course.said[signal.event]["name"]
    course.counts[name] = course.counts.get(name, 0) + 1
    q, u = run.at(crossing.t) if crossing.state is None else crossing.state
    return Event(crossing.t, name, "rising" if signal.sign > 0 else "falling", course.counts[name], q, u)


def _happen(course: Course, crossings: Sequence[Crossing], run: Run) -> str | None:
    """What events of one instant do, in the order of their tables; a message where one ends the run."""
    ends: list[str] = []
    for crossing in crossings:
        event = _event(course, crossing, run)
        said = course.said[course.signals[crossing.signal].event]
        try:
            values = {path: _number(course, value, run, event) for path, value in said["set"].items()}
        except ValueError as error:
            return _unsettable(course, event, error, event.name)
        answer = course.on_event[event.name](event) if event.name in course.on_event else None
        answered = answer if isinstance(answer, Mapping) else {}
        if answer == STOP or (said["stop"] and event.number >= said["stop"]):
            ends.append(event.name)
        elif answer is not None and not isinstance(answer, Mapping):
            raise TypeError(
                f"on_event: found {answer!r} from the function of {event.name!r}, expected None, values of parameters "
                f'by path, or "{STOP}"'
            )
        off = frozenset(course.model.off)
        then = (off | frozenset(said["off"])) - frozenset(said["on"])
        for name, path in course.model.gates.items():
            if path in answered:
                then = then | {name} if answered[path] == 0.0 else then - {name}
        gates = {path: float(name not in then) for name, path in course.model.gates.items() if name in off ^ then}
        own = {path: value for path, value in values.items() if path not in answered}
        told = {path: value for path, value in answered.items() if path not in course.model.gates.values()}
        by = event.name
        try:
            model = _with(course.model, own | gates)
            by = f"the answer to {event.name}"
            model = _with(model, answered)
        except (ValueError, UnknownName) as error:
            return _unsettable(course, event, error, by)
        values |= {path: float(value) for path, value in told.items()}
        if values or gates or answered:
            parameters = course.model.parameters
            event = replace(
                event,
                parameters=dict(values),
                before={path: parameters[path] for path in values if path in parameters},
                on=tuple(sorted(off - then)),
                off=tuple(sorted(then - off)),
            )
            event = replace(event, energy=_set(course, model, {*values, *gates}))
        course.events.append(event)
    if ends:
        return f"{ENDED}{course.t:.12g} s by {' and '.join(dict.fromkeys(ends))}"
    return None


def _unsettable(course: Course, event: Event, error: Exception, by: str) -> str:
    """What ends a run in which an event sets what cannot be, or a function answers so."""
    course.failed = True
    course.events.append(event)
    return f"stopped at t = {course.t:.12g} s by {by}: {'; '.join(str(error).splitlines())}"


def _number(course: Course, value: float | str, run: Run, event: Event) -> float:
    """What a parameter is set to."""
    if isinstance(value, str):
        return Quantity(value).at(run.model, event.t, event.q, event.u)
    return value


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
        there = _structure(course)
        gates = (one for one in there.data.get("gates", ()) if one["effect"] in off)
        forgotten = [name for one in gates for name in one["latches"]]
        held = zip(there.data.get("latches", ()), course.latched, strict=True)
        course.latched = np.array([np.nan if name in forgotten else value for name, value in held])
    course.memory = None
    jump = _energy(course) - before
    course.given += jump
    return jump


def _check_closed(course: Course) -> None:
    """Raise ``ValueError`` unless the loops are shut and wheels mesh where the course is, with the values set."""
    model = _structure(course)
    open_by = float(np.max(np.abs(model.closure(np.asarray(course.q))), initial=0.0))
    if open_by > joint_miss(model.core.REAL, model.length):
        raise ValueError(
            f"{model.name}: what events have set opens the loops by {open_by:.3g} m; set what leaves them shut"
        )


def _structure(course: Course) -> Model:
    """The model of what the mechanism is at present."""
    if course.model.data.get("switching") is None:
        return course.model
    return Whole(structures_of(course.model)).structures[course.structure]


def _energy(course: Course) -> float:
    model = _structure(course)
    return float(sum(model.energy(np.asarray(course.q), np.asarray(course.u))))


def _close(course: Course, options: Mapping[str, Any]) -> str | None:
    """Where a run was cut, or goes on with other parameters, its state is that of a run that begins there; a message
    where none can begin."""
    if course.memory is None:
        try:
            run = _stretch(course, course.t, options)
        except ValueError as error:
            return _stuck(course, error)
        course.pieces.append(Piece(course.structure, run, True, course.given))
    return None


def _stuck(course: Course, error: ValueError) -> str:
    """What ends a run that cannot go on from where it is with the values that are set."""
    course.failed = True
    return f"stopped at t = {course.t:.12g} s: {error}"
