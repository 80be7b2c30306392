"""Joints that let go and take hold in C programs: states, interruption, and changes that cannot be."""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import ensemble, simulate

from ..support.c_library import Crossing, Library
from ..support.folders import ROOT
from ..support.workshop import Workshop
from .test_interrupted_anywhere import CAUGHT, SET
from .test_release_and_hold import CHAIN, COUPLING, HOOK, TREBUCHET

ACT, CROSSES = 3, 4


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Library:
    """The core without a model."""
    return Library(ROOT / "runtime", Path(tmp_path_factory.mktemp("core")) / "libccgen.so")


def begun(library: Library, model: Any, **settings: Any) -> Any:
    outcome, made = library.create(model, events=ACT, **settings)
    assert outcome == "done" and made.reset(*model.start()) == "done"
    return made


SCENES = {"coupling": COUPLING, "trebuchet": TREBUCHET, "chain": CHAIN}


@pytest.mark.parametrize("method", [b"gauss", b"dop853", b"dopri5", b"radau"])
@pytest.mark.parametrize("name", SCENES)
def test_motion_goes_on_from_states_across_changes(
    name: str, method: bytes, library: Library, workshop: Workshop
) -> None:
    """By the same bits, from states at forty times, at changes too."""
    model = workshop.model(SCENES[name])
    made, other = (begun(library, model, method=method) for _ in range(2))
    run = simulate(model, method=method.decode())
    expected = [(change.t, change.joint) for change in run.changes]
    stops = sorted([*np.linspace(0.0, model.duration, 41)[1:], *(t for t, _ in expected)])

    def on(one: Any, until: float) -> list[tuple[float, int, int, int]]:
        found = []
        while one.motion()[0] < until:
            outcome, event = one.step_to_event(until)
            assert outcome == "done"
            found.append((event.t, event.kind, event.indicator, event.impacts))
        return found

    states, met = [made.state()], []
    for stop in stops:
        met.append(on(made, stop))
        states.append(made.state())
    crosses = [
        one[0] for part in met for one in part if one[1] == CROSSES and one[2] >= len(model.data.get("events", ()))
    ]
    assert crosses == pytest.approx([t for t, _ in expected], abs=1e-7)
    end = np.concatenate(made.motion()[1:])
    for k in range(0, len(stops), 3):
        assert other.set_state(states[k]) == "done"
        rest = [on(other, stop) for stop in stops[k:]]
        assert rest == met[k:] and np.array_equal(np.concatenate(other.motion()[1:]), end)
        assert other.parameters() == made.parameters()


def test_an_impact_by_which_a_joint_takes_hold_is_told(library: Library, workshop: Workshop) -> None:
    model = workshop.model(HOOK.format(more="", height=-1.5))
    made = begun(library, model)
    assert made.parameters()["grip.held"] == 0.0
    outcome, event = made.step_to_event(1.0)
    assert (outcome, event.kind, event.indicator, event.impacts) == ("done", CROSSES, 0, 1)
    assert event.t == pytest.approx(0.5, abs=1e-12) and made.parameters()["grip.held"] == 1.0
    assert np.array_equal(made.motion()[2], simulate(model).at(event.t)[1])
    assert made.crossings()[1] == [(event.t, 0, 1)]


@pytest.mark.parametrize("settings", [{}, {"method": b"moreau", "fixed_step": 0.005}], ids=["gauss", "moreau"])
def test_an_interrupted_motion_changes_as_one_that_is_not(
    settings: dict[str, Any], library: Library, workshop: Workshop
) -> None:
    """By every second, third and seventh tick; time stepping asks at each step, and on the way to changes."""
    model = workshop.model(COUPLING)
    ask = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_double)

    def changes(every: int) -> tuple[list[float], Any]:
        asked, found, calls = 0, [], 0

        def tick(_: object, __: float) -> int:
            nonlocal asked
            asked += 1
            return asked % every == 0

        call = ask(tick)
        made = begun(library, model, tick=ctypes.cast(call, ctypes.c_void_p), **settings)
        while made.motion()[0] < model.duration and (calls := calls + 1) < 3000:
            outcome, event = made.step_to_event(model.duration)
            if outcome == "done" and event.kind == CROSSES:
                found.append(event.t)
        return found, made.motion()[1]

    times, end = changes(10**9)
    assert len(times) == 2
    for every in (2, 3, 7):
        found, there = changes(every)
        assert found == pytest.approx(times, abs=1e-9) and there == pytest.approx(end, abs=1e-8)


FLOOR = '\n[[ground]]\npoint = [0, -1.4]\ncontacts = ["ball.C"]\nrestitution = 0.5\n'


@pytest.mark.parametrize(
    ("height", "more", "outcome"),
    [(-1.5, "at = 0.4", "too_far"), (-1.3, "at = 0.5\nwithin = 0.3", "inside")],
    ids=["apart", "behind-a-ground"],
)
def test_a_joint_that_cannot_take_hold_leaves_all_as_it_was(
    height: float, more: str, outcome: str, library: Library, workshop: Workshop
) -> None:
    """Also where its impact is over, and then links are drawn to where motion cannot begin."""
    text = HOOK.format(more=more, height=height) + (FLOOR if outcome == "inside" else "")
    model = workshop.model(text)
    made, free = begun(library, model), library.create(model)[1]
    assert free.reset(*model.start()) == "done"
    t = 0.4 if outcome == "too_far" else 0.5
    found, event = made.step_to_event(1.0)
    assert (found, event.kind, event.indicator, event.impacts) == (outcome, CROSSES, 0, 0)
    assert free.step_to_event(t)[0] == "done"
    assert made.motion()[0] == t and made.parameters()["grip.held"] == 0.0
    assert np.array_equal(made.constants(), free.constants())
    assert np.concatenate(made.motion()[1:]) == pytest.approx(np.concatenate(free.motion()[1:]), abs=1e-13)
    assert len(made.rows()[0]) == np.unique(made.rows()[0]).size
    kept = made.state()
    for _ in range(2):  # motion goes on without it, from a state of there too
        assert made.step_to_event(1.0)[0] == free.step_to_event(1.0)[0] == "done"
        assert np.concatenate(made.motion()[1:]) == pytest.approx(np.concatenate(free.motion()[1:]), abs=1e-13)
        assert made.set_state(kept) == "done"
    told = ensemble(model, observe=["q", "u", "impacts"])
    run = simulate(model)
    assert told.status[0] == "stopped" and told.reason[0] == run.message
    assert np.array_equal(told["q"][0], run.q[-1]) and told["impacts"][0] == len(run.impacts)


@pytest.mark.parametrize("held", [0.5, -1.0, float("nan")])
def test_a_gate_that_is_neither_1_nor_0_is_refused(held: float, library: Library, workshop: Workshop) -> None:
    model = workshop.model(CHAIN)
    outcome, made = library.create(model)
    assert outcome == "done"
    made.values[list(model.parameters).index(next(iter(model.joint_gates.values())))] = held
    again = made.calls.ccgen_create(
        ctypes.c_void_p(model.kernels.address), ctypes.byref(made.settings), ctypes.byref(ctypes.c_void_p())
    )
    assert library.outcome(again) == "bad_settings"


LEVEL = """
[[event]]
name = "level"
when = "x(ball.C) + 1.4"
set = { "rod.inertia" = "0.7 + t" }
[[event]]
name = "told"
when = "t - 0.1"
"""
GO_ON, END, REFUSE = 0, 1, 2


@pytest.mark.parametrize("answers", ["sets", "ends", "refuses", "breaks off"])
def test_a_program_answers_at_events(answers: str, library: Library, workshop: Workshop) -> None:
    """As a function in Python: it writes into the parameters, has a joint take hold, ends the motion or refuses."""
    model = workshop.model(HOOK.format(more="at = 5", height=-1.5).replace("[[hold]]", LEVEL + "[[hold]]"))
    names, asked, broken = [*model.settable], list[tuple[int, float]](), [answers == "breaks off"]
    call = ctypes.CFUNCTYPE(
        ctypes.c_int,
        ctypes.c_void_p,
        ctypes.POINTER(Crossing),
        *[ctypes.POINTER(ctypes.c_double)] * 3,
    )

    def on_event(_: object, event: Any, q: Any, u: Any, parameters: Any) -> int:
        asked.append((event[0].indicator, event[0].t))
        if broken[0]:
            broken[0] = False
            return -1
        parameters[names.index("ball.mass")] = 2.5
        return {"ends": END, "refuses": REFUSE}.get(answers, GO_ON)

    function, mask = call(on_event), (ctypes.c_ubyte * 3)(1, 0, 0)
    made = begun(
        library,
        model,
        on_event=ctypes.cast(function, ctypes.c_void_p),
        answered=ctypes.cast(mask, ctypes.c_void_p),
    )
    outcome, event = made.step_to_event(1.0)
    if answers == "refuses":
        assert outcome == "cannot_set" and made.parameters() == dict(model.parameters) and made.changes()[1] == []
        return
    if answers == "breaks off":
        assert outcome == "interrupted" and made.motion()[0] < asked[0][1] and made.changes()[1] == []
        outcome, event = made.step_to_event(1.0)
        assert asked[0] == asked[1]
    assert outcome == "done" and event.indicator == 0 and event.kind == (5 if answers == "ends" else CROSSES)
    run = simulate(model, until=1.0, on_event={"level": lambda event: {"ball.mass": 2.5}})
    (expected,) = (one for one in run.events if one.name == "level")
    told, changes, values = made.changes()
    assert told == "done" and [(one.indicator, one.gate) for one in changes] == [(0, -1)]
    assert changes[0].t == event.t == expected.t == pytest.approx(0.15, abs=1e-12)
    assert changes[0].energy == pytest.approx(0.5 * 0.5 * 4**2, abs=1e-12) == expected.energy  # 0.5 kg at 4 m/s
    behind = dict(zip(names, values[0], strict=True))
    assert behind == made.parameters() == {**model.parameters, **expected.parameters}
    assert made.rows()[0][changes[0].row] == made.rows()[0][changes[0].row - 1] == event.t
    assert made.forget() == "done" and made.changes()[1] == []


def test_changes_of_joints_are_told(library: Library, workshop: Workshop) -> None:
    """As a run in Python tells them: a hold with how far it drew its points, and what its impulse broke."""
    text = HOOK.format(more='within = "2 mm"\n[[release]]\njoint = "grip"\nimpulse = 0.1', height=-1.5)
    model = workshop.model(text.replace("[start]", '[start]\nopen = ["grip"]'))
    made, run = begun(library, model), simulate(model)
    while made.motion()[0] < model.duration:
        assert made.step_to_event(model.duration)[0] == "done"
    told, changes, values = made.changes()
    gate = [*model.settable].index("grip.held")
    assert told == "done" and len(changes) == len(run.changes) == 2
    assert [(one.t, one.indicator, one.gate) for one in changes] == [(one.t, one.number, gate) for one in run.changes]
    assert [bool(one[gate]) for one in values] == [one.kind == "hold" for one in run.changes]
    assert [one.gap for one in changes] == [one.gap for one in run.changes]
    assert [one.energy for one in changes] == pytest.approx([one.energy for one in run.changes], abs=1e-14)
    outcome, told_only = library.create(model, events=1)
    assert outcome == "done" and told_only.reset(*model.start()) == "done" and told_only.changes()[0] == "bad_settings"


@pytest.mark.parametrize("forgets", [False, True])
@pytest.mark.parametrize(
    "floor", ["", '[[ground]]\npoint = [0, -50]\nrestitution = 0.5\ncontacts = ["rod.A", "rod.B", "hook.C"]\n']
)
def test_a_program_that_breaks_off_behind_a_change_goes_on_as_if_it_had_not(
    floor: str, forgets: bool, library: Library, workshop: Workshop
) -> None:
    """A hold makes an angle jump over what an event watches, at the same instant: what was told before stays."""
    model = workshop.model(CAUGHT + SET + floor)
    call = ctypes.CFUNCTYPE(
        ctypes.c_int, ctypes.c_void_p, ctypes.POINTER(Crossing), *[ctypes.POINTER(ctypes.c_double)] * 3
    )

    def met(breaks_off: bool) -> tuple[list[tuple[float, int, int]], Any]:
        asked, found = 0, []

        def on_event(_: object, event: Any, q: Any, u: Any, parameters: Any) -> int:
            nonlocal asked
            asked += 1
            return -1 if breaks_off and asked == 3 else GO_ON

        function = call(on_event)
        made = begun(library, model, on_event=ctypes.cast(function, ctypes.c_void_p))
        while made.motion()[0] < 6.0:
            outcome, event = made.step_to_event(6.0)
            if outcome == "interrupted":
                assert (event.kind, event.indicator, event.t) == (0, -1, made.motion()[0])
                continue
            assert outcome == "done"
            found.append((event.t, event.kind, event.indicator))
            assert made.motion()[0] >= max(t for t, _, _ in found)
            if forgets and event.t == 2.2:
                assert made.forget() == "done"
        return found, made

    (whole, made), (again, other) = met(False), met(True)
    assert [t for t, *_ in whole].count(2.2) == 2  # the hold and the event
    assert again == whole and other.parameters() == made.parameters()
    assert other.motion()[1] == pytest.approx(made.motion()[1], abs=1e-12)
    assert np.all(np.diff(other.rows()[0]) >= 0.0) and other.rows()[0][0] == made.rows()[0][0]


def test_a_function_that_is_never_asked_is_refused(library: Library, workshop: Workshop) -> None:
    model = workshop.model(CAUGHT + SET)
    function = ctypes.CFUNCTYPE(ctypes.c_int)(lambda: 0)
    for events, outcome in ((0, "bad_settings"), (1, "bad_settings"), (2, "bad_settings"), (ACT, "done")):
        assert library.create(model, events=events, on_event=ctypes.cast(function, ctypes.c_void_p))[0] == outcome
