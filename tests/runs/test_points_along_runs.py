"""Points, accelerations and joint angles along runs: through impacts and contact, where contacts push."""

from __future__ import annotations

import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import Run, simulate

from ..support.folders import SCENES
from ..support.leaning_rod import LEANING
from ..support.workshop import Workshop

BLOCK = """
name = "block"
[[link]]
name = "block"
mass = 2.0
inertia = 0.05
com = [0, 0]
points = { L = [-0.3, 0], R = [0.3, 0] }
[start]
position = [0, 0]
velocity = [3.0, 0.0]
[gravity]
[[ground]]
restitution = 0
friction = 0.25
contacts = ["block.L", "block.R"]
[run]
until = 1.0
"""
"""It slides on its two feet, and comes to rest after 3/(0.25 g) = 1.22 s."""


def differences(run: Run, name: str, t: float, h: float = 2e-3) -> tuple[Any, Any]:
    """Velocity and acceleration from places at nine times in one phase, to h⁸."""
    weights = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
    q, u = run.at(t + h * np.arange(-4, 5))
    return weights @ run.model.point(name, q) / h, weights @ run.model.point_velocity(name, q, u) / h


@pytest.fixture(scope="module")
def hexagon(workshop: Workshop) -> Run:
    return simulate(workshop.model(load_scene(SCENES / "falling-hexagon.toml")))


@pytest.fixture(scope="module")
def leaning(workshop: Workshop) -> Run:
    return simulate(workshop.model(LEANING))


def test_points_between_impacts_against_differences(hexagon: Run) -> None:
    for t in (0.3, hexagon.impacts[1].t + 0.012):
        for name in ("joint_0", "joint_3", "link_2.A"):
            found = hexagon.point(name, t)
            velocity, acceleration = differences(hexagon, name, t)
            assert found.t == t and found.position.shape == (2,)
            assert found.velocity == pytest.approx(velocity, abs=1e-8)
            assert found.acceleration == pytest.approx(acceleration, abs=1e-6)
    many = hexagon.point("joint_3", [0.3, 0.31])
    assert many.acceleration.shape == (2, 2)
    assert many.velocity[0] == pytest.approx(hexagon.point("joint_3", 0.3).velocity, abs=1e-13)


def test_rows_of_an_impact_are_before_and_after(hexagon: Run) -> None:
    """What falls has its mass centre fall by g until the first impact, and again after it."""
    found = hexagon.point("joint_3")
    assert found.t is not None and found.position.shape == found.acceleration.shape == (len(hexagon.t), 2)
    first = int(np.flatnonzero(hexagon.t[:-1] == hexagon.t[1:])[0])
    impact, model = hexagon.impacts[0], hexagon.model
    for row, u in ((first, impact.u_minus), (first + 1, impact.u_plus)):
        assert found.velocity[row] == pytest.approx(model.point_velocity("joint_3", hexagon.q[row], u), abs=1e-12)
    assert found.acceleration[first] == pytest.approx([0.0, -9.81], abs=1e-9)
    wanted = model.point_acceleration("joint_3", hexagon.q[first + 1], impact.u_plus, contacts=())
    assert found.acceleration[first + 1] == pytest.approx(wanted, abs=1e-9)


def test_a_rod_that_leans_stays(leaning: Run) -> None:
    """At rest on the ground nothing accelerates, though it would fall without; before it fell by (3/2) g cos."""
    rest = leaning.point("rod.T", 1.9)
    assert np.max(np.abs(rest.acceleration)) <= 1e-12 and np.max(np.abs(rest.velocity)) <= 1e-12
    q, u = leaning.at(1.9)
    assert leaning.model.point_acceleration("rod.T", q, u, contacts=())[1] < -5.0
    assert leaning.accelerations(1.9) == pytest.approx([0.0], abs=1e-12)
    last = int(np.flatnonzero(leaning.t[:-1] == leaning.t[1:])[0])
    angle, rate = leaning.q[last, 0], leaning.u[last, 0]
    turning = -2.0 * 9.81 * 0.5 * np.cos(angle) / (0.1667 + 2.0 * 0.25)
    wanted = turning * np.array([-np.sin(angle), np.cos(angle)]) - rate**2 * np.array([np.cos(angle), np.sin(angle)])
    assert leaning.point("rod.T").acceleration[last] == pytest.approx(wanted, rel=1e-9)


def test_a_block_that_slides_is_braked(workshop: Workshop) -> None:
    run = simulate(workshop.model(BLOCK))
    for t in (0.0, 0.4, 0.9):
        found = run.point("block.R", t)
        assert found.position == pytest.approx([0.3 + 3.0 * t - 0.25 * 9.81 * t**2 / 2, 0.0], abs=1e-9)
        assert found.velocity == pytest.approx([3.0 - 0.25 * 9.81 * t, 0.0], abs=1e-9)
        assert found.acceleration == pytest.approx([-0.25 * 9.81, 0.0], abs=1e-9)


def test_in_steps_of_time_nothing_is_known_of_accelerations(workshop: Workshop) -> None:
    run = simulate(workshop.model(BLOCK), method="moreau", step=0.01)
    found = run.point("block.R", [0.2, 0.5])
    assert np.all(np.isnan(found.acceleration)) and np.all(np.isfinite(found.velocity))
    assert np.all(np.isnan(run.accelerations(0.5)))


def test_joint_angles_count_turns(workshop: Workshop) -> None:
    run = simulate(workshop.model(load_scene(SCENES / "slider-crank.toml")), until=3.0)
    found = run.joint_angles()
    assert set(found) == {"motor", "crank_pin", "wrist_pin"} and found["motor"].shape == run.t.shape
    assert np.array_equal(found["motor"], run.q[:, 0]) and found["motor"][-1] > 4.0 * np.pi
    even = run.joint_angles(np.linspace(0.0, 3.0, 301))
    assert np.max(np.abs(np.diff(even["crank_pin"]))) < 1.0
    assert sum(angle[150] for angle in even.values()) == pytest.approx(0.0, abs=1e-12)  # around the loop
    assert run.joint_angles(1.0)["motor"] == run.at(1.0)[0][0]


def test_motions_of_points_can_be_kept(leaning: Run) -> None:
    found = leaning.point("rod.T")
    again = pickle.loads(pickle.dumps(found))
    assert again.name == "rod.T" and np.array_equal(again.acceleration, found.acceleration)
    for one in (found, again):
        with pytest.raises(ValueError, match="read-only"):
            one.acceleration[0] = 0.0


def test_the_end_of_a_run_that_stopped_has_no_acceleration(leaning: Run) -> None:
    """There may be none, as where friction jams."""
    found = replace(leaning, success=False, message="stopped").point("rod.T")
    assert np.all(np.isnan(found.acceleration[-1])) and np.all(np.isfinite(found.velocity))
    assert np.array_equal(found.acceleration[:-1], leaning.point("rod.T").acceleration[:-1])
    with pytest.raises(ValueError, match="this run knows no accelerations: it was not made by simulate"):
        replace(leaning, motion=None).point("rod.T")


def test_wrong_points_and_times_are_refused(leaning: Run) -> None:
    with pytest.raises(ValueError, match=r"found point 'rod\.S', expected one of: hinge, rod\.A, rod\.T"):
        leaning.point("rod.S", 1.0)
    for ask in (leaning.joint_angles, leaning.accelerations, lambda t: leaning.point("rod.T", t)):
        with pytest.raises(ValueError, match=r"t: found 3 s, expected times within the run"):
            ask(3.0)
