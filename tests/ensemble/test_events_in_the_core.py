"""Ensembles of scenes whose events set, switch and end: against closed forms, and against runs one by one."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np
import pytest

from ccgen.generator.derive.gated import APART
from ccgen.runtime import ensemble, simulate
from ccgen.runtime.ensemble import compiled, stacked

from ..runs.test_effects_on_and_off import OSCILLATOR
from ..runs.test_user_events import BALL
from ..support.workshop import Workshop

EVERYTHING = """
name = "bat-and-ball"
[ground_link]
points = { O = [0, 0], A = [3, 0] }
[[link]]
name = "ball"
mass = 1
inertia = 0.1
com = [0, 0]
points = { P = [0, 0] }
[[link]]
name = "bat"
mass = 2
inertia = 0.5
com = [0, 0]
points = { O = [0, 0], T = [1, 0] }
[[joint]]
name = "fall"
type = "prismatic"
between = ["ground.O", "ball.P"]
axis = [0, 1]
[[joint]]
name = "pin"
between = ["ground.A", "bat.O"]
[[spring]]
name = "coil"
between = ["ball.P", "bat.T"]
stiffness = 8
length = 1
[[damper]]
name = "oil"
between = ["ball.P", "bat.T"]
damping = 0.1
[[ground]]
point = [0, -0.5]
restitution = 0.5
contacts = ["ball.P"]
[[drag]]
name = "air"
point = "ball.P"
quadratic = 0.1
[[rope]]
name = "cord"
between = ["ball.P", "bat.T"]
length = 4.5
restitution = 0.3
[gravity]
[start]
slides = { fall = 1 }
angles = { bat = 0.5 }
off = ["cord"]
[run]
until = 3
"""
EVENTS = """
[[event]]
name = "top"
when = "rate(y(ball.P))"
direction = "falling"
set = { "coil.stiffness" = "8 + 2*y(ball.P)", "coil.length" = 1.1 }
[[event]]
name = "slow"
when = "rate(angle(pin)) - 0.5"
off = ["oil"]
[[event]]
name = "again"
when = "sin(3*t)"
direction = "rising"
on = ["oil", "cord"]
off = ["air"]
[[event]]
name = "gone"
when = "sin(3*t)"
direction = "falling"
on = ["air"]
off = ["ground_0"]
[[event]]
when = "y(ball.P) + 0.5"
[[event]]
name = "back"
when = "y(ball.P) + 0.2"
direction = "rising"
on = ["ground_0"]
[[event]]
name = "end"
when = "angle(pin) - 0.3"
stop = true
times = 2
"""


def one_by_one(monkeypatch: pytest.MonkeyPatch, *asked: Any, **options: Any) -> Any:
    with monkeypatch.context() as changed:
        changed.setattr(import_module("ccgen.runtime.ensemble.ensemble"), "can", lambda *_: False)
        return ensemble(*asked, **options)


def test_springs_that_are_cut_and_come_again(workshop: Workshop) -> None:
    text = OSCILLATOR + '[[event]]\nwhen = "t - 0.5"\noff = ["coil"]\n'
    text += '[[event]]\nwhen = "slide(rail) - 0.5"\ndirection = "falling"\non = ["coil"]\n'
    text += 'set = { "coil.stiffness" = "32*slide(rail)" }\n'
    k = np.linspace(4.0, 12.0, 7)
    found = ensemble(
        workshop.model(text), {"coil.stiffness": k}, observe=["q", "cart.A.x", "coil.force"], at=[0.5, 1.0], rtol=1e-12
    )
    assert list(found.status) == ["done"] * 7
    w = np.sqrt(k / 2.0)
    x, v = 1.0 + 0.5 * np.cos(0.5 * w), -0.5 * w * np.sin(0.5 * w)
    assert found["cart.A.x"] == pytest.approx(np.stack([x, x + 0.5 * v], axis=1), abs=1e-11)
    assert np.all(found["coil.force"] == 0.0)  # at an event all is as after it
    left = 4.0 - (0.5 + (0.5 - x) / v)
    w = np.sqrt(8.0)
    assert found["q"][:, 0] == pytest.approx(1.0 - 0.5 * np.cos(w * left) + v / w * np.sin(w * left), abs=1e-10)


@pytest.mark.parametrize("method", ["gauss", "dop853", "dopri5", "radau"])
@pytest.mark.parametrize("varied", [False, True])
def test_the_core_does_what_runs_one_by_one_do(
    method: str, varied: bool, workshop: Workshop, monkeypatch: pytest.MonkeyPatch
) -> None:
    model: Any = workshop.model(EVERYTHING + EVENTS)
    rng = np.random.default_rng(3)
    q, u = model.start()
    starts = np.tile(q, (12, 1))
    starts[:, list(model.q_of).index("fall.slide")] = rng.uniform(0.2, 1.5, 12)
    params = {"coil.stiffness": rng.uniform(5.0, 12.0, 12), "oil.on": rng.integers(0, 2, 12)} if varied else None
    observe = ["q", "u", "impacts", "impact_times(2)", "ball.P.y", "bat.angle", "coil.force", "energy"]
    asked = {"observe": [*observe, "ground_0.ball.P.gap"], "at": np.linspace(0.0, 3.0, 31)}
    asked |= {"rtol": 1e-12, "method": method}
    made = ensemble(model, params, starts, u, **asked)
    alone = one_by_one(monkeypatch, model, params, starts, u, **asked)
    assert list(made.status) == list(alone.status) and made.reason == alone.reason
    assert np.sum(made.status == "done") > 6 and any("needs cord to be longer" in one for one in made.reason)
    assert made.t == pytest.approx(alone.t, abs=1e-8)
    for name, values in made.columns.items():
        assert np.array_equal(np.isnan(values), np.isnan(alone[name])), name
        np.testing.assert_allclose(values, alone[name], rtol=1e-6, atol=1e-6, err_msg=name)
    gaps = made["ground_0.ball.P.gap"]
    assert np.isnan(gaps).any() and (made["impacts"] > 0).any() and np.nanmax(gaps) < 10.0


def test_what_hangs_on_parameters_that_events_set_is_made_one_by_one(workshop: Workshop) -> None:
    """And is right: the acceleration of a point, whose name tells no more than where it is."""
    model: Any = workshop.model(EVERYTHING + EVENTS)
    found = ensemble(model, observe=["ball.P.ay"], at=[0.9, 2.5])
    run = simulate(model, until=3.0)
    assert found["ball.P.ay"][0] == pytest.approx(run.values("ball.P.ay", t=[0.9, 2.5])["ball.P.ay"], rel=1e-6)


def test_gaps_of_contacts_that_are_off_are_those_of_the_equations() -> None:
    assert stacked.APART == APART


def test_several_starts_with_a_function_for_events(workshop: Workshop) -> None:
    model: Any = workshop.model(BALL + '[[event]]\nname = "low"\nwhen = "y(ball.P) - 0.5"\nset = { "gravity.g" = 5 }\n')
    q, u = model.start()
    starts = np.array([q, q, q])
    starts[:, 1] += [0.0, 0.5, 1.0]
    met = []
    runs = simulate(model, starts, u, on_event={"low": lambda event: met.append(event.t)})
    for start, run in zip(starts, runs, strict=True):
        alone = simulate(model, start, u, on_event={"low": lambda _: None})
        assert np.array_equal(run.t, alone.t) and np.array_equal(run.q, alone.q) and run.events
    assert sorted(met) == sorted(event.t for run in runs for event in run.events)


def test_which_ensembles_the_core_makes(workshop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without this the tests above would compare runs one by one with themselves."""
    made = []
    monkeypatch.setattr(
        compiled.CompiledRuns,
        "make",
        lambda self, *rest, own=compiled.CompiledRuns.make: made.append(1) or own(self, *rest),
    )
    model: Any = workshop.model(EVERYTHING + EVENTS)
    ensemble(model, observe=["q", "ball.P.y", "coil.force", "energy"], at=[1.0])
    assert len(made) == 1
    ensemble(model, observe=["ball.P.ay"], at=[1.0])
    assert len(made) == 1
