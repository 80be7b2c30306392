"""Each row of an ensemble is to the bit what ``simulate`` gives with its numbers, whatever the threads."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import Model, ensemble, simulate
from ccgen.runtime.record.outputs import outputs_of

from ..hard.fuzz import scene as toss_scene
from ..support.folders import SCENES
from ..support.workshop import Workshop

KINDS = ("time", "link", "joint", "point", "contact", "mechanism", "effect", "mesh")


def outputs(model: Model) -> list[str]:
    """All outputs that states tell."""
    return [name for name in outputs_of(model) if "impulse" not in name and name != "t"]


def varied(model: Model, count: int, words: tuple[str, ...], part: float = 0.1) -> dict[str, Any]:
    """Parameters whose paths hold one of the words, each varied by that part of it."""
    rng = np.random.default_rng(3)
    paths = [path for path in model.parameters if any(word in path for word in words)]
    free = [path for path in paths if path not in model.data["rests_on"]]
    return {path: model.parameters[path] * rng.uniform(1.0 - part, 1.0 + part, count) for path in free}


def check(model: Model, made: Any, names: list[str], at: Any, runs: Any, exact: bool) -> None:
    """Statuses, ends, impacts, and outputs: these to the bit, or to the rounding of how points' speeds are summed."""
    for row, run in enumerate(runs):
        if isinstance(run, ValueError):
            assert (made.status[row], made.reason[row]) == ("refused", str(run))
            continue
        assert made.status[row] == ("done" if run.success else "stopped")
        assert made.reason[row] == ("" if run.success else run.message)
        assert made.t[row] == run.t[-1]
        assert np.array_equal(made["q"][row], run.q[-1]) and np.array_equal(made["u"][row], run.u[-1])
        assert (made.impacts[row], made.steps[row]) == (len(run.impacts), run.t.size - 1)
        times = [impact.t for impact in run.impacts][:4]
        assert np.array_equal(made["impact_times(4)"][row][: len(times)], times)
        assert np.isnan(made["impact_times(4)"][row][len(times) :]).all()
        inside = at <= run.t[-1]
        values = run.values(*names, t=at[inside])
        for name in names:
            found, wanted = made[name][row], values[name]
            assert np.isnan(found[~inside]).all()
            if exact:
                assert np.array_equal(found[inside], wanted, equal_nan=True), name
            else:
                np.testing.assert_allclose(found[inside], wanted, rtol=1e-12, atol=1e-12, err_msg=name)


def alone(model: Model, **asked: Any) -> Any:
    try:
        return simulate(model, **asked)
    except ValueError as refusal:
        return refusal


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("method", ["gauss", "dop853"])
def test_starts(workshop: Workshop, method: str, threads: int) -> None:
    """Through impacts; one start is inside the ground."""
    model = workshop.model(load_scene(SCENES / "falling-hexagon.toml"))
    rng, (q, u) = np.random.default_rng(8), model.start()
    qs, us = np.tile(q, (9, 1)), np.tile(u, (9, 1)) + rng.normal(size=(9, u.size))
    qs[:, 1] += rng.uniform(0.0, 0.4, 9)
    qs[4, 1] -= 5.0
    names, at = outputs(model), np.linspace(0.0, 1.1, 6)
    made = ensemble(
        model,
        q0=qs,
        u0=us,
        observe=["q", "u", "impact_times(4)", *names],
        at=at,
        until=1.1,
        method=method,
        threads=threads,
    )
    runs = [alone(model, q0=a, u0=b, until=1.1, method=method) for a, b in zip(qs, us, strict=True)]
    check(model, made, names, at, runs, exact=True)
    assert list(made.status).count("refused") == 1 and made.impacts.max() > made.impacts.min()


@pytest.mark.sample(3)
@pytest.mark.parametrize(
    ("scene", "words", "until"),
    [
        ("falling-hexagon", ("mass", "restitution", ".g"), 1.1),
        ("falling-hexagon", ("length",), 1.1),  # the loop is closed anew
        ("slider-crank", ("mass", "crank.length", "rod"), 0.5),
        ("jansen-leg", ("mass", "knee", "hip"), 0.3),
        ("planetary", ("mass", "inertia"), 0.5),
        ("jansen-driven", ("mass", "crank"), 0.3),
        ("simplest-walker", ("mass", "length"), 2.0),
        ("trebuchet", ("mass",), 1.0),  # its stone leaves at 0.8 s
        ("three-rrr", ("mass",), 0.2),
    ],
)
def test_parameters(workshop: Workshop, scene: str, words: tuple[str, ...], until: float) -> None:
    model = workshop.model(load_scene(SCENES / f"{scene}.toml"))
    params = varied(model, 5, words, 0.01)
    assert params
    names = [name for name in outputs(model) if name not in params]  # rod.com.x is a parameter and a place
    at = np.linspace(0.0, until, 4)
    made = ensemble(model, params, observe=["q", "u", "impact_times(4)", *names], at=at, until=until)
    rows = [{path: values[row].item() for path, values in params.items()} for row in range(5)]
    check(model, made, names, at, [alone(model, params=row, until=until) for row in rows], exact=False)
    assert "done" in made.status


@pytest.mark.hard
def test_rough_tosses_whatever_happens(workshop: Workshop) -> None:
    """Rings thrown onto rough ground: sticking, sliding, rest, and forces of contacts at times between rows."""
    model = workshop.model(toss_scene(5, rough=True))
    rng, (q, u) = np.random.default_rng(4), model.start()
    qs = np.tile(q, (12, 1))
    qs[:, 1] += rng.uniform(0.5, 1.5, 12)
    qs[:, 2:] += rng.uniform(-3.0, 3.0, (12, 1))
    us = np.tile(u, (12, 1)) + rng.normal(size=(12, u.size))
    names, at = outputs(model), np.linspace(0.0, 3.0, 31)
    observe = ["q", "u", "impact_times(4)", *names]
    made = ensemble(model, q0=qs, u0=us, observe=observe, at=at, until=3.0, rtol=1e-10)
    runs = [alone(model, q0=a, u0=b, until=3.0, rtol=1e-10) for a, b in zip(qs, us, strict=True)]
    check(model, made, names, at, runs, exact=True)
    pushes = [name for name in names if name.endswith(".normal")]
    assert any(np.nanmax(made[name]) > 0.0 for name in pushes)


def test_steps_in_time_and_damped_loops(workshop: Workshop) -> None:
    """Fixed steps over impacts, whose rows have lines between them; loops that Baumgarte's method keeps."""
    model = workshop.model(load_scene(SCENES / "falling-hexagon.toml"))
    heights = np.array([0.0, 0.1, 0.2])
    q, _ = model.start()
    qs = np.tile(q, (3, 1))
    qs[:, 1] += heights
    at = np.linspace(0.0, 0.9, 8)
    names = ["link_0.angle", "joint_3.vx", "joint_1.force"]
    for asked in ({"method": "moreau", "step": 1e-3}, {"drift": "damped"}, {"method": "radau"}, {"drift": "left"}):
        made = ensemble(model, q0=qs, observe=["q", "u", "impact_times(4)", *names], at=at, until=0.9, **asked)
        runs = [alone(model, q0=one, until=0.9, **asked) for one in qs]
        check(model, made, names, at, runs, exact=True)


def test_free_loops_past_lines(workshop: Workshop) -> None:
    """States beside a line come from the row on the right side of it."""
    model = workshop.model(load_scene(SCENES / "n-four-bar.toml"))
    _, u = model.start()
    us = np.array([u, 1.1 * u, 0.9 * u])
    at = np.linspace(0.0, 5.0, 101)
    names = ["upright_0.B.x", "upright_0.B.vy"]
    made = ensemble(model, u0=us, observe=["q", "u", "impact_times(4)", *names], at=at, until=5.0)
    check(model, made, names, at, [alone(model, u0=one, until=5.0) for one in us], exact=True)


INPUTS = """
name = "pushed"
[chain]
links = 1
hinged = true
[[input]]
name = "torque"
joint = "joint_0"
"""


def test_inputs(workshop: Workshop) -> None:
    """Constants of each run, a table for all, and a controller, whose runs Python makes."""
    model = workshop.model(INPUTS)
    values = np.array([0.0, 1.0, -2.0])
    made = ensemble(model, inputs={"torque": values}, observe=["q"], until=0.7)
    for row, value in enumerate(values.tolist()):
        assert np.array_equal(made["q"][row], simulate(model, inputs={"torque": value}, until=0.7).q[-1])
    table = {"t": [0.0, 0.2, 0.7], "torque": [0.0, 3.0, -1.0]}
    starts = np.array([[0.1], [0.2]])
    made = ensemble(model, q0=starts, inputs=table, observe=["q"], until=0.7)
    other = ensemble(model, q0=starts, inputs=lambda t, q, u: -3.0 * q[0], observe=["q"], until=0.7)
    for row, start in enumerate(starts):
        assert np.array_equal(made["q"][row], simulate(model, start, inputs=table, until=0.7).q[-1])
        run = simulate(model, start, inputs=lambda t, q, u: -3.0 * q[0], until=0.7)
        assert np.array_equal(other["q"][row], run.q[-1])


def test_other_numbers(workshop: Workshop) -> None:
    """In wide numbers, to their bits."""
    model = workshop.model(load_scene(SCENES / "falling-hexagon.toml"), precision="wide")
    q, _ = model.start()
    qs = np.array([q, q])
    qs[1, 1] += model.core.REAL.type("0.1")
    made = ensemble(model, q0=qs, observe=["q", "joint_1.force"], at=[0.3, 0.6], until=0.9, rtol=1e-14)
    for row, one in enumerate(qs):
        run = simulate(model, one, until=0.9, rtol=1e-14)
        assert np.array_equal(made["q"][row], run.q[-1])
        assert np.array_equal(made["joint_1.force"][row], run.values("joint_1.force", t=[0.3, 0.6])["joint_1.force"])
