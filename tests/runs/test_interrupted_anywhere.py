"""Ctrl-C at whatever instant: what a run has done is kept, row for row that of the run that was let be."""

from __future__ import annotations

import gc
import signal
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import numpy as np
import pytest

import ccgen.runtime
from ccgen.runtime import Run, simulate

from ..support.heeding import heeding_ctrl_c
from ..support.tiers import hard, many
from ..support.workshop import Workshop
from .test_release_and_hold import TREBUCHET
from .test_user_events import BALL, PENDULUM

OWN = str(Path(ccgen.runtime.__file__).parent)

SPINNING = """
name = "spinning"
[chain]
links = 2
hinged = true
[start]
angles = ["10 deg", "40 deg"]
[gravity]
[run]
until = 6
"""
LOW = '[[event]]\nname = "low"\nwhen = "rate(y(link_1.B))"\n'
SET = '[[event]]\nname = "level"\nwhen = "angle(pin) + pi/2"\nset = { "gravity.g" = "9.81 + 0.1*t" }\n'
CAUGHT = """
name = "caught"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "rod"
mass = 1
inertia = 1
com = [1, 0]
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "hook"
mass = 1
inertia = 1
com = [0, 0]
points = { C = [0, 0] }
[[joint]]
name = "pin"
between = ["ground.O", "rod.A"]
[[joint]]
name = "grip"
between = ["rod.B", "hook.C"]
[[release]]
joint = "grip"
at = 1.9
[[hold]]
joint = "grip"
within = 100
at = 2.2
[start]
angles = { rod = 0, hook = 0 }
[gravity]
[run]
until = 6
"""
BRAKED = SPINNING + '[[joint_friction]]\njoints = ["joint_0"]\ndry = 0.5\n'

SCENES: dict[str, tuple[str, dict[str, Any]]] = {
    "plain": (SPINNING, {}),
    "bounces": (BALL, {}),
    "told": (SPINNING + LOW, {}),
    "bounces told": (BALL + '[[event]]\nname = "top"\nwhen = "rate(y(ball.P))"\n', {}),
    "set": (PENDULUM + SET, {"until": 8.0}),
    "ended": (PENDULUM + '[[event]]\nname = "back"\nwhen = "x(rod.B)"\nstop = true\ntimes = 4\n', {"until": 8.0}),
    "released": (TREBUCHET, {}),
    "caught": (CAUGHT, {}),
    "caught and told": (CAUGHT + '[[event]]\nname = "low"\nwhen = "rate(y(hook.C))"\n', {}),
    "caught and set": (CAUGHT + SET, {}),
    "caught above a floor": (
        CAUGHT + SET + '[[ground]]\npoint = [0, -50]\nrestitution = 0.5\ncontacts = ["rod.A", "rod.B", "hook.C"]\n',
        {},
    ),
    "braked and told": (BRAKED + LOW, {}),
    "by steps": (BALL, {"method": "moreau", "step": 4e-3}),
    "by steps and told": (
        BALL + '[[event]]\nname = "half"\nwhen = "y(ball.P) - 0.4"\n',
        {"method": "moreau", "step": 4e-3},
    ),
    "by radau": (SPINNING + LOW, {"method": "radau", "until": 3.0}),
}
SHORT = 8
"""Rows that a run may go on for, behind a press, before the core hears of it."""
BY_THE_CLOCK = ("told", "check")
"""Calls of the core: whether Ctrl-C has been pressed."""
EVERY_TIER = ("told", "set")
PRESSES, EVERY = 200, many(8, 1)
"""Presses over a run of those that are hard; ``make hard`` makes every eighth of them, ``CCGEN_LARGE=1`` all."""


@pytest.fixture(autouse=True)
def nothing_is_tidied_up() -> Iterator[None]:
    """Python's collector would call what the runtime's objects of earlier tests do at their end, at any instant."""
    gc.collect()
    gc.disable()
    yield
    gc.enable()


set_for = sys.modules["_signal"].getsignal
"""That of ``signal`` looks for a name of what it finds, and is called at every call here."""


@cache
def is_own(code: CodeType) -> bool:
    """Whether a function is the runtime's."""
    return code.co_filename.startswith(OWN)


class Press:
    """Ctrl-C at the call number ``at`` that the runtime's own Python makes while a run is kept. Calls that the core
    makes by the clock differ from run to run: only a press ``by_the_clock`` counts them, and no others."""

    def __init__(self, at: int = 0, *, by_the_clock: bool = False) -> None:
        self.at, self.by_the_clock, self.count = at, by_the_clock, 0

    def __call__(self, frame: FrameType, what: str, _: object) -> None:
        if what != "call" or not is_own(frame.f_code):
            return
        if (frame.f_code.co_name in BY_THE_CLOCK) is not self.by_the_clock:
            return
        handler = set_for(signal.SIGINT)
        if handler is signal.default_int_handler or not callable(handler):
            return
        self.count += 1
        if self.count == self.at:
            handler(signal.SIGINT, frame)

    def during(self, model: Any, **options: Any) -> Run:
        with heeding_ctrl_c():
            sys.setprofile(self)
            try:
                run = simulate(model, keep_interrupted=True, **options)
            finally:
                sys.setprofile(None)
        assert isinstance(run, Run)
        return run


def pressed(calls: int) -> Any:
    """The numbers of the calls at which it is pressed, the first and the last among them."""
    every = np.linspace(1, calls, PRESSES)
    return every if EVERY == 1 else np.append(every[::EVERY], every[-1])


@pytest.mark.parametrize("name", [one if one in EVERY_TIER else hard(one) for one in SCENES])
def test_ctrl_c_at_any_call_keeps_what_is_done(name: str, workshop: Workshop) -> None:
    """Rows, impacts, events and changes are the first of those of the whole run; it says that it was interrupted, also
    where it was at its end already: else a loop of runs would go on."""
    text, options = SCENES[name]
    model = workshop.model(text)
    whole = simulate(model, **options)
    assert whole.success, whole.message
    assert_same_beginning(Press().during(model, **options), whole)
    counted = Press()  # of a second run: the first makes what later ones find
    counted.during(model, **options)
    kept, missed = [], 0
    instants = np.linspace(1, counted.count, 12) if name in EVERY_TIER else pressed(counted.count)
    places = np.unique(instants.astype(int)).tolist()
    for press in [Press(at) for at in places] + [Press(at, by_the_clock=True) for at in (1, 2, 5)]:
        run = press.during(model, **options)
        assert_same_beginning(run, whole)
        if press.count < press.at:  # the very last call: runs differ by a few, as by what Python tidies up meanwhile
            assert run.success
            missed += not press.by_the_clock
            continue
        assert not run.success and run.message == f"stopped at t = {run.t[-1]:.12g} s: interrupted", press.at
        if run.t[-1] < whole.t[-1] and not press.by_the_clock:
            kept.append(len(run.t))
            assert run.nfev > 0 or len(run.t) == 1
    most = np.maximum.accumulate([0, *kept])[1:]
    assert missed <= 1 and np.all(most - kept <= SHORT)  # heard by the clock, and so later than another press


def test_ctrl_c_at_the_end_of_many_runs_marks_the_last(workshop: Workshop) -> None:
    model = workshop.model(SPINNING)
    q, u = model.start()
    module = sys.modules["ccgen.runtime.simulate"]
    all_of_them = module._simulated

    def simulated(*given: Any) -> Any:
        made = all_of_them(*given)
        press()
        return made

    with heeding_ctrl_c(), pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "_simulated", simulated)
        runs = simulate(model, np.tile(q, (3, 1)), u, until=0.1, keep_interrupted=True)
    assert [run.message for run in runs] == ["reached t = 0.1 s"] * 2 + ["stopped at t = 0.1 s: interrupted"]
    assert [run.success for run in runs] == [True, True, False]


def press() -> None:
    """Ctrl-C as the runtime notes it, in no function of the caller's."""
    handler = signal.getsignal(signal.SIGINT)
    assert callable(handler)
    handler(signal.SIGINT, None)


def test_ctrl_c_before_an_error_is_raised(workshop: Workshop) -> None:
    """There is no run to keep; who looks for other starts after an error does not go on."""
    model = workshop.model(SPINNING)

    def simulated(*_: Any) -> Any:
        press()
        raise ValueError("refused")

    with heeding_ctrl_c(), pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys.modules["ccgen.runtime.simulate"], "_simulated", simulated)
        with pytest.raises(KeyboardInterrupt):
            simulate(model, keep_interrupted=True)


def assert_same_beginning(run: Run, whole: Run) -> None:
    rows = len(run.t)
    for found, expected in ((run.t, whole.t), (run.q, whole.q), (run.u, whole.u)):
        assert np.array_equal(found, expected[:rows])
    assert [one.t for one in run.impacts] == [one.t for one in whole.impacts[: len(run.impacts)]]
    assert [(one.t, one.name, one.number) for one in run.events] == [
        (one.t, one.name, one.number) for one in whole.events if one.t <= run.t[-1]
    ][: len(run.events)]
    assert len(run.events) >= sum(one.t < run.t[-1] for one in whole.events)
    assert [one.t for one in run.changes] == [one.t for one in whole.changes[: len(run.changes)]]


@pytest.mark.parametrize("name, until", [("told", 6.0), ("set", 300.0), hard("caught and told", 300.0)])
def test_an_interrupted_run_goes_on_to_the_same_end(name: str, until: float, workshop: Workshop) -> None:
    """From what was kept on, all that is left comes: the two runs joined are the whole one. A run is one call of the
    core, which hears by the clock."""
    model = workshop.model(SCENES[name][0])
    whole = simulate(model, until=until)
    assert whole.success, whole.message
    for at in (1, 3):
        first = Press(at, by_the_clock=True).during(model, until=until)
        assert not first.success and first.t[-1] < whole.t[-1]
        second = simulate(model, state=first.state, until=until)
        assert np.array_equal(np.concatenate([first.t[:-1], second.t])[-5:], whole.t[-5:])
        assert [one.t for one in first.events + second.events] == [one.t for one in whole.events]


@pytest.mark.parametrize("name", ["set", "caught and set", "caught above a floor"])
def test_ctrl_c_in_a_function_of_an_event_ends_the_run_before_it(name: str, workshop: Workshop) -> None:
    """The event has not come: who goes on from what is kept comes to it again."""
    model = workshop.model(SCENES[name][0])

    def breaks_off(at: int) -> Any:
        left = [at]

        def function(event: Any) -> dict[str, float] | None:
            left[0] -= 1
            if left[0] == 0:
                raise KeyboardInterrupt
            return {"gravity.g": 9.0 + 0.1 * event.t} if event.direction == "rising" else None

        return {"level": function}

    whole = simulate(model, until=6.0, on_event=breaks_off(0))
    for at in (1, 2, 3):
        first = simulate(model, until=6.0, on_event=breaks_off(at), keep_interrupted=True)
        assert not first.success and first.message.endswith("interrupted") and len(first.events) == at - 1
        assert first.t[-1] < whole.events[at - 1].t
        second = simulate(model, state=first.state, until=6.0, on_event=breaks_off(0))
        joined = [*first.events, *second.events]
        assert [one.t for one in joined] == [one.t for one in whole.events]
        assert [one.parameters for one in joined] == [one.parameters for one in whole.events]
        assert np.array_equal(second.q[-1], whole.q[-1])
        with pytest.raises(KeyboardInterrupt):
            simulate(model, until=6.0, on_event=breaks_off(at))
