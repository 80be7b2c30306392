"""Ensembles of scenes whose joints let go and take hold, by the core alone: against runs one by one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.runtime import ensemble, simulate
from ccgen.runtime.ensemble import compiled

from ..runs.test_release_and_hold import COUPLING, DRIVEN, GROUND, HOOK, PENDULUM, RAIL, TREBUCHET, WELDED
from ..support.folders import ROOT
from ..support.workshop import Workshop
from .test_events_in_the_core import one_by_one

TWO_BALLS = """
name = "two-balls"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "rod"
mass = 3
inertia = 0.7
com = [0, -0.5]
points = { A = [0, 0], B = [0, -1.5], C = [0, -1] }
[[link]]
name = "low"
mass = 2
inertia = 0.1
com = [0, 0]
points = { P = [0, 0] }
[[link]]
name = "high"
mass = 1
inertia = 0.1
com = [0, 0]
points = { P = [0, 0] }
[[joint]]
name = "hinge"
between = ["ground.O", "rod.A"]
[[joint]]
name = "grip"
between = ["rod.B", "low.P"]
[[joint]]
name = "hook"
between = ["rod.C", "high.P"]
[[hold]]
joint = "grip"
at = 0.5
within = 0.01
[[release]]
joint = "hinge"
at = 0.5
[[hold]]
joint = "hook"
at = 0.5
within = 0.01
[[release]]
joint = "grip"
impulse = {limit}
[start]
open = ["grip"]
poses = { low = [-2, -1.5, 0], high = [1.5, -1.003, 0] }
angles = { rod = 0 }
sliding_velocities = { low_x = 4, high_x = -3 }
[run]
until = 1
"""
METHODS = ("gauss", "dop853", "dopri5", "radau")
SCENES = {
    "sling": TREBUCHET,
    "hook": HOOK.format(more="", height=-1.5),
    "drawn": HOOK.format(more='within = "2 mm"', height=-1.501),
    "passes": HOOK.format(more="", height=-1.501),
    "far": HOOK.format(more="at = 0.4", height=-1.5),
    "force": PENDULUM.format(when='force = "40 N"'),
    "at-first": PENDULUM.format(when="force = 1"),
    "at-zero": PENDULUM.format(when="at = 0"),
    "impulse": PENDULUM.format(when="impulse = 0.5") + GROUND,
    "coupling": COUPLING,
    "weld": WELDED.format(change='[[release]]\njoint = "seam"\nat = 0.3'),
    "drive": DRIVEN,
    "rail": RAIL,
    "at-once": TWO_BALLS.replace("{limit}", "1e9"),
    "breaks-at-once": TWO_BALLS.replace("{limit}", "1"),
}
"""With what comes at a time, by a place, a force, an impulse or a meeting, and what acts at joints."""
RESTARTS = {"drive", "rail", "at-once", "breaks-at-once"}
"""There the start behind a change is put onto the closure twice in single runs, and once in the core."""


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many runs the core has made at a time: without this the tests would compare single runs with themselves."""
    counts: list[int] = []

    def make(self: Any, numbers: Any, *rest: Any, own: Any = compiled.CompiledRuns.make) -> Any:
        counts.append(numbers.count)
        return own(self, numbers, *rest)

    monkeypatch.setattr(compiled.CompiledRuns, "make", make)
    return counts


@pytest.mark.parametrize("name", SCENES)
def test_the_core_does_what_single_runs_do(name: str, workshop: Workshop, made: list[int]) -> None:
    """By every bit: impacts too, and what is told of times before and behind changes, as forces of open joints."""
    model = workshop.model(SCENES[name])
    joint = model.data["switching"]["changes"][0]["joint"]
    names = ["energy", *(f"{joint}.{axis}" for axis in ("fx", "fy", "moment"))]
    at = np.linspace(0.0, model.duration, 14)
    for method in METHODS:
        found = ensemble(model, observe=["q", "u", "impacts", "impact_times(3)", *names], at=at, method=method)
        run = simulate(model, method=method)
        assert found.status[0] == ("done" if run.success else "stopped")
        assert found.reason[0] == ("" if run.success else run.message)
        assert found["impacts"][0] == len(run.impacts)
        exact = {"rtol": 1e-8, "atol": 1e-8} if name in RESTARTS else {"rtol": 0.0, "atol": 0.0}
        np.testing.assert_allclose(found["q"][0], run.q[-1], **exact)
        np.testing.assert_allclose(found["u"][0], run.u[-1], **exact)
        times = [*(impact.t for impact in run.impacts), np.nan, np.nan, np.nan][:3]
        np.testing.assert_allclose(found["impact_times(3)"][0], times, **exact)
        if run.success:
            told = run.values(*names, t=at)
            for output in names:
                np.testing.assert_allclose(found[output][0], told[output], err_msg=output, **exact)
    assert made == [1] * len(METHODS)


@pytest.mark.parametrize("method", METHODS)
def test_starts_and_parameters_of_their_own(
    method: str, workshop: Workshop, made: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The trebuchet of the scenes, whose stone slides over the ground first, with an event that is counted beside."""
    text = (ROOT / "scenes" / "trebuchet.toml").read_text().replace('"trebuchet"', '"counted"')
    event = '[[event]]\nname = "high"\nwhen = "y(stone.C) - 8"\nset = { "gravity.g" = 9.0 }\n'
    model: Any = workshop.model(text + event)
    rng = np.random.default_rng(5)
    q, u = model.start()
    starts = np.tile(q, (10, 1))
    starts[:, 1] += rng.uniform(-0.2, 0.2, 10)
    params = {"counterweight.mass": rng.uniform(300.0, 700.0, 10), "pouch.held": np.repeat([1.0, 0.0], 5)}
    asked: dict[str, Any] = {"method": method, "at": np.linspace(0.0, 1.2, 7), "rtol": 1e-10}
    asked["observe"] = ["q", "u", "impacts", "impact_times(2)", "stone.C.x", "energy"]
    found = ensemble(model, params, starts, u, **asked)
    alone = one_by_one(monkeypatch, model, params, starts, u, **asked)
    assert made == [10] and list(found.status) == list(alone.status) == ["done"] * 10
    for name, values in found.columns.items():
        np.testing.assert_allclose(values, alone[name], rtol=1e-7, atol=1e-7, err_msg=name)
    assert np.ptp(found["stone.C.x"][:5, -1]) > 0.1
