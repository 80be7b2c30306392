"""What [start] gives a driven joint is exact as far as the loops close; the other angles are guesses."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ..support.command_line import ccgen
from ..support.workshop import Workshop

CRANK = """
name = "crank-and-rocker"
[ground_link]
points = { O = [0, 0], Q = [0.14, 0] }
[[link]]
name = "crank"
rod = { mass = 1 }
points = { A = [0, 0], B = [0.05, 0] }
[[link]]
name = "coupler"
rod = { mass = 1 }
points = { A = [0, 0], B = [COUPLER, 0] }
[[link]]
name = "rocker"
rod = { mass = 1 }
points = { A = [0, 0], B = [0.08, 0] }
[[joint]]
name = "motor"
between = ["ground.O", "crank.A"]
[[joint]]
between = ["crank.B", "coupler.A"]
[[joint]]
between = ["coupler.B", "rocker.B"]
[[joint]]
between = ["ground.Q", "rocker.A"]
[start]
angles = { crank = "CRANK deg", coupler = "10 deg", rocker = "80 deg" }
[run]
until = 0.01
"""
SLIDE = """
name = "lift"
[ground_link]
points = { O = [0, 0], G = [0.3, 0] }
[[link]]
name = "table"
mass = 1
inertia = 0.1
com = [0, 0]
points = { C = [0, 0] }
[[link]]
name = "arm"
rod = { mass = 1 }
points = { A = [0, 0], B = [0.5, 0] }
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.G", "table.C"]
axis = [0, 1]
[[joint]]
name = "foot"
type = "pin-in-slot"
between = ["ground.O", "arm.A"]
axis = [1, 0]
[[joint]]
between = ["arm.B", "table.C"]
[[drive]]
joint = "guide"
speed = 0.1
[start]
slides = { guide = 0.2, foot = 0.1 }
angles = { arm = "40 deg" }
"""
SPEED = '[[drive]]\njoint = "motor"\nspeed = 10\n'
PLACE = '[[drive]]\njoint = "motor"\nangle = "0.3 + 10*t"\n'


def crank(angle: float, drive: str = SPEED, coupler: float = 0.15) -> str:
    return CRANK.replace("CRANK", str(angle)).replace("COUPLER", str(coupler)) + drive


def angles(scene: Any) -> Any:
    return np.degrees([pose[2] for pose in scene.start.poses])


def closed(scene: Any, coupler: float = 0.15) -> float:
    """By how much the loop misses, by hand."""
    one, two, three = np.exp(1j * np.radians(angles(scene)))
    return float(abs(0.05 * one + coupler * two - 0.08 * three - 0.14))


@pytest.mark.parametrize("angle", [60.0, 0.0, -30.0, 200.0, 359.0])
def test_a_driven_crank_starts_at_the_angle_that_it_is_given(angle: float, workshop: Workshop) -> None:
    scene = workshop.scene(crank(angle))
    assert angles(scene)[0] == pytest.approx(angle, abs=1e-10)
    assert closed(scene) < 1e-14
    assert scene.start.moved == ()


def test_without_a_drive_all_angles_are_guesses_alike(workshop: Workshop) -> None:
    """The nearest closed configuration: the sum of squares of all changes is stationary along the loop's motion."""
    scene = workshop.scene(crank(60.0, drive=""))
    change = np.radians(angles(scene) - [60.0, 10.0, 80.0])
    arms = [0.05, 0.15, -0.08] * np.exp(1j * np.radians(angles(scene)))
    motion = np.linalg.svd(np.array([arms.real, arms.imag]))[2][-1]
    assert abs(change[0]) > 1e-3
    assert change @ motion == pytest.approx(0.0, abs=1e-9)


def test_a_driven_slide_starts_at_the_length_that_it_is_given(workshop: Workshop) -> None:
    scene = workshop.scene(SLIDE)
    (_, table, _), (foot, low, arm) = scene.start.poses
    assert table == pytest.approx(0.2, abs=1e-14)
    assert [low, foot + 0.5 * np.cos(arm), low + 0.5 * np.sin(arm)] == pytest.approx([0.0, 0.3, 0.2], abs=1e-13)
    loose = workshop.scene(SLIDE.replace('[[drive]]\njoint = "guide"\nspeed = 0.1\n', ""))
    assert abs(loose.start.poses[0][1] - 0.2) > 1e-3


def test_between_two_links_their_angle_is_kept(workshop: Workshop) -> None:
    """The coupler is driven against the crank: 50 degrees less, as both are given, wherever the crank gets."""
    drive = '[[drive]]\njoint = "joint_1"\nspeed = -1\n'
    scene = workshop.scene(crank(60.0, drive))
    one, two, _ = angles(scene)
    assert two - one == pytest.approx(-50.0, abs=1e-10)
    assert closed(scene) < 1e-14


def test_what_could_not_stay_is_named(workshop: Workshop) -> None:
    short = workshop.scene(crank(150.0, coupler=0.1))
    assert closed(short, 0.1) < 1e-12
    (moved,) = short.start.moved
    assert (moved.joint, moved.key, moved.of, moved.placed) == ("motor", "angles", "crank", False)
    assert np.degrees([moved.given, moved.got]) == pytest.approx([150.0, angles(short)[0]])
    placed = workshop.scene(crank(60.0, PLACE))
    (moved,) = placed.start.moved
    assert moved.placed and moved.got == pytest.approx(0.3, abs=1e-12)


@pytest.mark.parametrize(
    ("scene", "why"),
    [
        (crank(150.0, coupler=0.1), "the nearest at which its loops close; [start] angles gives 150 deg"),
        (crank(60.0, PLACE), "where its drive has motor at t = 0; [start] angles gives 60 deg"),
    ],
)
def test_the_command_says_what_moved_it(scene: str, why: str, tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(scene)
    done = ccgen("show", "scene.toml", at=tmp_path)
    (line,) = [one for one in done.stderr.splitlines() if "crank starts at" in one]
    assert line.startswith("crank-and-rocker: crank starts at ") and line.endswith(why)
    assert "crank starts at" not in ccgen("show", "scene.toml", "--quiet", at=tmp_path).stderr


def test_a_model_keeps_it_with_other_lengths(workshop: Workshop) -> None:
    """As the file with that number does."""
    model = workshop.model(crank(60.0))
    assert model.data["start"]["kept_drives"] == [0]
    other = model.with_parameters({"coupler.points.B.x": 0.16})
    file = workshop.scene(crank(60.0, coupler=0.16))
    assert other.poses(other.start()[0]) == pytest.approx(np.array(file.start.poses), abs=1e-9)
    assert other.start()[0][model.q_of.index("crank.angle")] == pytest.approx(np.pi / 3.0, abs=1e-13)
