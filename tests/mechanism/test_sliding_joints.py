"""Joints that slide: rings of them, a slider-crank, what pushes along lines, lengths read off poses."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import driving_torque, inverse_dynamics, simulate

from ..oracles.maximal import Array
from ..support.joint_texts import FLOOR, faults, scene
from ..support.workshop import Workshop

RING = """\
name = "wedges"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "low"
mass = 1.0
inertia = 0.1
com = [0, 0]
points = { A = [0, 0] }
[[link]]
name = "high"
mass = 2.0
inertia = 0.1
com = [0, 0]
points = { A = [0, 0] }
[[joint]]
name = "one"
type = "prismatic"
axis = "30 deg"
between = ["ground.O", "low.A"]
[[joint]]
name = "two"
type = "prismatic"
axis = [0, 1]
between = ["low.A", "high.A"]
[[joint]]
name = "three"
type = "prismatic"
axis = "150 deg"
between = ["ground.O", "high.A"]
[start]
slides = { one = 1.0, two = -1.0, three = -1.0 }
[gravity]
g = 9.81
"""
"""Two blocks on lines at 30 and 150 degrees, one above or below the other: a ring of joints that only slide."""


def test_a_ring_of_sliders_has_one_row_and_one_freedom(workshop: Workshop) -> None:
    """low is at s (cos 30°, sin 30°); high above it on the other line, at −s cos 30° tan 30° = −s/2 in height."""
    model = workshop.model(RING)
    assert (len(model.cuts), len(model.rows), len(model.u_names), model.dof) == (1, 1, 2, 1)
    q, u = model.project(model.start()[0], [1.0, 0.3])
    low, high = model.poses(q)
    assert low == pytest.approx([np.cos(np.pi / 6.0), 0.5, 0.0], abs=1e-12)
    assert high == pytest.approx([np.cos(np.pi / 6.0), -0.5, 0.0], abs=1e-12)
    motion = dict(zip(model.u_names, model.acceleration(q, u), strict=True))
    # T = ½ (1 + 2) s'², V = g (s/2 − 2 s/2): s'' = g/6
    assert motion["sliding_0"] == pytest.approx(9.81 / 6.0, rel=1e-12)
    run = simulate(model, until=1.0)
    assert run.success and run.energy_drift <= 1e-9


def test_a_ring_whose_held_angles_disagree_is_refused(tmp_path: Path) -> None:
    text = RING.replace('axis = "150 deg"', 'axis = "150 deg"\nangle = 0.3')
    ((line, key, message),) = faults(text, tmp_path)
    assert key.startswith("joint[") and line is not None
    assert "by 0.1 rad" in message and "expected 0" in message


def test_slider_crank_accelerates_as_its_closed_form(workshop: Workshop) -> None:
    """θ'' = −(½ J' θ'² + V')/J, with the derivatives of the closed form J(θ) taken exactly."""
    import sympy as sp

    model = workshop.model(scene("slider-crank"))
    theta, r, length = sp.symbols("theta r l")
    rod = sp.asin(-r / length * sp.sin(theta))
    middle = sp.Matrix([r * sp.cos(theta) + length / 2 * sp.cos(rod), r * sp.sin(theta) + length / 2 * sp.sin(rod)])
    slide = r * sp.cos(theta) + length * sp.cos(rod)
    speed = middle.diff(theta)
    felt = 0.4 * r**2 / 3 + 0.6 * speed.dot(speed) + 0.018 * rod.diff(theta) ** 2 + slide.diff(theta) ** 2
    potential = 9.81 * (0.4 * r / 2 * sp.sin(theta) + 0.6 * middle[1])
    values = sp.lambdify(
        (theta, r, length),
        [felt, felt.diff(theta), potential.diff(theta), slide, slide.diff(theta), slide.diff(theta, 2)],
    )
    for angle in (0.4, 1.9, 3.3, -1.0):
        inertia, slope, moment, place, first, curve = values(angle, 0.2, 0.6)
        q = model.assemble([angle, math.asin(-np.sin(angle) / 3.0), place])
        q, u = model.project(q, np.array([12.0, 0.0, 0.0]))
        assert q[0] == pytest.approx(angle, abs=1e-14) and u[2] == pytest.approx(first * u[0], rel=1e-12)
        wanted = -(0.5 * slope * u[0] ** 2 + moment) / inertia
        found = model.acceleration(q, u)
        assert found[0] == pytest.approx(wanted, rel=1e-11)
        assert found[2] == pytest.approx(first * wanted + curve * u[0] ** 2, rel=1e-11)


def test_a_motor_pushes_along_a_line(workshop: Workshop) -> None:
    """A block on a slope: the motor's force less its weight along the line, whatever the block's angle."""
    text = """
name = "hoist"
[ground_link]
points = { O = [0.3, 0.2] }
[[link]]
name = "block"
mass = 2.5
inertia = 0.4
com = [0.2, 0.3]
points = { A = [0.1, 0] }
[[joint]]
name = "rail"
type = "prismatic"
axis = [3, 4]
angle = "25 deg"
between = ["ground.O", "block.A"]
[[motor]]
joint = "rail"
force = "30 + 2*t"
[gravity]
g = 9.81
"""
    model = workshop.model(text)
    assert list(model.q_names) == ["slide_0"] and list(model.u_names) == ["sliding_0"]
    assert model.acceleration([0.7], [1.0], t=2.0) == pytest.approx([34.0 / 2.5 - 9.81 * 0.8], rel=1e-14)
    assert model.poses([0.7])[0] == pytest.approx(
        [
            0.3 + 0.7 * 0.6 - 0.1 * np.cos(np.radians(25)),
            0.2 + 0.7 * 0.8 - 0.1 * np.sin(np.radians(25)),
            np.radians(25),
        ],
        abs=1e-15,
    )
    assert inverse_dynamics(model, [0.7], [1.0], [2.0], ["rail"]) == pytest.approx(
        [2.5 * 2.0 - 30.0 + 2.5 * 9.81 * 0.8]
    )


def test_a_servo_holds_a_slide_where_it_is_wanted(workshop: Workshop) -> None:
    motor = '[[motor]]\njoint = "guide"\nposition = 0.7\nstiffness = 5000\ndamping = 300\n[gravity]'
    model = workshop.model(scene("slider-crank", ("[gravity]", motor), ("crank = 12.0", "crank = 0.0")))
    run = simulate(model, until=6.0)
    slide = run.q[-1, model.q_names.index("slide_3")]
    torque = inverse_dynamics(model, run.q[-1], np.zeros(3), np.zeros(3), ["motor"])
    assert abs(run.u[-1]).max() <= 1e-6 and abs(slide - 0.7) <= 2e-3
    assert torque == pytest.approx([0.0], abs=1e-6)


def test_torque_over_a_turn_asks_for_a_joint_that_can_be_turned(workshop: Workshop) -> None:
    model = workshop.model(scene("quick-return"))
    turn = driving_torque(model, "axle", 10.0)
    assert abs(turn.mean) <= 1e-9 * abs(turn.peak)
    for name in ("guide", "slot"):
        with pytest.raises(ValueError, match=f"{name}.* name another"):
            driving_torque(model, name, 10.0)


def test_lengths_along_lines_are_read_off_the_poses(workshop: Workshop) -> None:
    """state_from_poses gives back lengths along lines, and poses lengths back."""
    model = workshop.model(scene("quick-return"))
    q, u = model.start()
    back: tuple[Array, Array] = model.state_from_poses(model.poses(q), model.velocities(q, u))
    assert np.max(np.abs(back[0] - q)) <= 1e-14 and np.max(np.abs(back[1] - u)) <= 1e-12
    place = model.point("ram.E", q)
    assert place == pytest.approx([q[model.q_names.index("slide_5")], 0.45], abs=1e-14)


def test_the_point_on_a_line_of_the_ground_can_touch(tmp_path: Path) -> None:
    """A guide between the ground and a slider is where the slider's point is."""
    path = tmp_path / "scene.toml"
    path.write_text(scene("slider-crank") + FLOOR)
    read = load_scene(path)
    ((name, ref),) = read.effects[-1].contacts  # type: ignore[attr-defined]
    assert (name, read.mechanism.link_name(ref.link), ref.point) == ("guide", "slider", "C")


def test_rows_of_a_table_along_a_line_are_forces(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(scene("slider-crank") + '[[motor]]\njoint = "guide"\ntable = [[0, 1], [1, 2]]\n')
    motor = load_scene(path).effects[-1]
    assert [p.path for p in motor.parameters()][1::2] == ["motor_0.table.0.force", "motor_0.table.1.force"]
