"""Mass centres by name, ``link.com``: where a point of the link at the same place is, and by momentum's theorem."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import ensemble, reach, simulate

from ..support.command_line import ccgen
from ..support.folders import ROOT
from ..support.workshop import Workshop

THROWN = """
name = "thrown"
[[link]]
name = "hull"
mass = 2.0
inertia = 0.3
com = [0.3, -0.2]
points = { A = [0, 0], B = [1, 0], G = [0.3, -0.2] }
[[link]]
name = "fin"
mass = 0.5
inertia = 0.02
com = [0, 0]
points = { A = [0, 0], com = [0.4, 0.1] }
[[link]]
name = "dot"
mass = 1e-3
inertia = 1e-4
com = [0, 0]
points = { A = [0, 0], B = [1, 0] }
[[joint]]
name = "hinge"
between = ["hull.B", "fin.A"]
[[joint]]
name = "tail"
between = ["hull.A", "dot.A"]
[gravity]
[start]
angles = { hull = 0.3, fin = 2.0 }
velocity = [1.0, 2.0]
angular_velocities = { hull = 3.0 }
[run]
until = 0.5
"""


@pytest.fixture(scope="module")
def model(workshop: Workshop) -> Any:
    return workshop.model(THROWN)


def test_a_mass_centre_is_where_a_point_there_is(model: Any) -> None:
    """Place, velocity, acceleration and Jacobian, of one state and of many, and along a run."""
    q, u = model.start()
    many = np.array([q, q + 0.1, q - 0.3])
    for states in (q, many):
        assert model.point("hull.com", states) == pytest.approx(model.point("hull.G", states), abs=1e-15)
        assert model.point_jacobian("hull.com", states) == pytest.approx(
            model.point_jacobian("hull.G", states), abs=1e-14
        )
    assert model.point_velocity("hull.com", q, u) == pytest.approx(model.point_velocity("hull.G", q, u), abs=1e-14)
    run = simulate(model)
    one, other = run.point("hull.com", [0.0, 0.2, 0.5]), run.point("hull.G", [0.0, 0.2, 0.5])
    assert one.position == pytest.approx(other.position, abs=1e-14)
    assert one.velocity == pytest.approx(other.velocity, abs=1e-13)
    assert one.acceleration == pytest.approx(other.acceleration, abs=1e-11)
    for asked in ("x", "y", "vx", "vy", "ax", "ay", "speed"):
        assert run[f"hull.com.{asked}"] == pytest.approx(run[f"hull.G.{asked}"], abs=1e-11), asked


def test_they_fall_together(model: Any) -> None:
    """Σ m r of all mass centres is thrown: a parabola; with a com of [0, 0] and another value of a parameter too."""
    for params in ({}, {"hull.com.x": -0.4}):
        run = simulate(model, params=params, rtol=1e-11)
        masses = {name: run.model.parameters[f"{name}.mass"] for name in model.links}
        along = {
            "hull": run["hull.com.ay"],
            "dot": run["dot.com.ay"],
            "fin": run["hinge.ay"],  # whose own mass centre is where its hinge is
        }
        total = sum(masses[name] * along[name] for name in model.links)
        assert total == pytest.approx(np.full(len(run.t), -9.81 * sum(masses.values())), rel=1e-9)


def test_a_point_of_that_name_comes_first(model: Any) -> None:
    """``fin.com`` is the point that the scene calls so, not where its mass is."""
    q, _ = model.start()
    assert np.hypot(*(model.point("fin.com", q) - model.point("hinge", q))) == pytest.approx(np.hypot(0.4, 0.1))


def test_other_questions_know_them(model: Any) -> None:
    q, _ = model.start()
    found = reach(model, q, {"hull.com": (0.7, -0.1)})
    assert model.point("hull.com", found) == pytest.approx([0.7, -0.1], abs=1e-10)
    ends = ensemble(model, {"hull.com.x": [0.3, -0.4]}, observe=["hull.com.y"], until=0.2)["hull.com.y"]
    for value, end in zip([0.3, -0.4], ends, strict=True):
        assert end == simulate(model, params={"hull.com.x": value}, until=0.2)["hull.com.y"][-1]


def test_links_without_mass_have_none(workshop: Workshop) -> None:
    model = workshop.model((ROOT / "scenes" / "massless-coupler.toml").read_text(encoding="utf-8"))
    without = [link for link in model.links if not model.parameters.get(f"{link}.mass")]
    assert without
    run = simulate(model, until=0.01)
    for link in model.links:
        assert (f"{link}.com.x" in run.outputs) == (link not in without)
    with pytest.raises(ValueError, match=f"found point '{without[0]}.com', expected one of"):
        model.point(f"{without[0]}.com", model.start()[0])


def test_the_command_draws_and_writes_them(tmp_path: Path) -> None:
    text = (ROOT / "scenes" / "trebuchet.toml").read_text(encoding="utf-8")
    (tmp_path / "t.toml").write_text(
        text + '[output]\nplot = ["beam.com", "beam.com.speed"]\ntable = ["beam.com.x", "beam.com.speed"]\n'
    )
    done = ccgen("run", "t.toml", "--until", "0.1", "--out", "r", at=tmp_path)
    assert done.returncode == 0, done.stderr
    head, *_ = (tmp_path / "r" / "outputs.csv").read_text().splitlines()
    assert "beam.com.x [m]" in head and "beam.com.speed [m/s]" in head
    assert ccgen("plot", "r", "beam.com.ay", at=tmp_path).returncode == 0
    shown = ccgen("show", "t.toml", "--outputs", at=tmp_path)
    assert "beam.com: x [m], y [m]" in shown.stdout


def test_asking_for_outputs_looks_for_no_names_that_may_be_meant(
    workshop: Workshop, monkeypatch: pytest.MonkeyPatch
) -> None:
    """That takes a hundred times as long as a mapping's answer, for each number that a link does not have."""
    model = workshop.model(THROWN)
    run = simulate(model, until=0.01)
    monkeypatch.setattr(type(model.parameters), "_near", lambda *_: pytest.fail("looked for names near one"))
    assert "hull.com.z" not in model.parameters and model.parameters.get("hull.com.z") is None
    assert run["hull.com.x"].shape == run.t.shape
