"""Joints that let go and take hold, as the command tells them."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from ccgen.generator.cli.app import app

GRIPPER = """
name = "gripper"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "arm"
rod = { mass = 2 }
points = { A = [0, 0], hand = [1, 0] }
[[link]]
name = "stone"
mass = 0.5
inertia = 0.01
com = [0, 0]
points = { C = [0, 0] }
[[joint]]
name = "shoulder"
between = ["ground.O", "arm.A"]
[[joint]]
name = "grip"
TYPE
between = ["arm.hand", "stone.C"]
[[hold]]
joint = "grip"
WHEN
[start]
angles = { arm = 0 }
poses = { stone = [0, -1.001, 0] }
[gravity]
[run]
until = 0.7
"""
MEETS = GRIPPER.replace("TYPE\n", "").replace("WHEN", 'within = "2 mm"')


def command(tmp_path: Path, text: str, *words: str) -> str:
    scene = tmp_path / "scene.toml"
    scene.write_text(text)
    found = CliRunner().invoke(app, [words[0], str(scene), *words[1:]])
    assert found.exception is None or isinstance(found.exception, SystemExit), found.exception
    return " ".join(found.output.split())


HELD = """
[[ground]]
point = [0, -1.001]
contacts = ["stone.C"]
restitution = 0
"""


def test_a_hold_is_told_with_how_fast_points_came_and_what_drew_them_together(tmp_path: Path) -> None:
    """A stone that lies is caught by the hand of a rod after K(sin 45°) (2 l/3 g)^½; lifting it by 1 mm takes
    0.5 · 9.81 · 0.001 J, and no energy is missed."""
    told = command(tmp_path, MEETS + HELD, "run", "--out", str(tmp_path / "run"))
    assert "grip takes hold at t = 0.48333" in told
    assert "its points meet, drawn together by 0.001 m, by which the energy jumps by 0.00491 J" in told
    assert "grip takes hold" in told and "energy drifts" not in told and "dense solution" not in told


def test_an_open_joint_counts_as_open(tmp_path: Path) -> None:
    told = command(tmp_path, MEETS, "show")
    assert "4, no closure 4 by Grübler's count: 3 x 3 links - 2 x 2 joints - 1 pin in a slot" in told
    told = command(tmp_path, MEETS, "show", "--set", "grip.held=1")
    assert "2 = 4 quasi-velocities - rank 2 of the 2 closure rows at the start" in told


def test_a_joint_may_be_asked_to_hold_from_the_start(tmp_path: Path) -> None:
    text = MEETS.replace("[0, -1.001, 0]", "[1, 0, 0]")
    told = command(tmp_path, text, "run", "--set", "grip.held=1", "--out", str(tmp_path / "run"))
    assert "takes hold" not in told and "t = 0.7 s" in told


@pytest.mark.parametrize("turned", [False, True])
def test_a_weld_does_not_hold_half_a_turn_off(turned: bool, tmp_path: Path) -> None:
    text = GRIPPER.replace("TYPE", 'type = "weld"').replace("WHEN", "at = 0\nwithin = 0.1").replace("[gravity]\n", "")
    text = text.replace("[0, -1.001, 0]", '[1, 0, "180 deg"]' if turned else '[1, 0, "360 deg"]')
    told = command(tmp_path, text, "run", "--out", str(tmp_path / "run"))
    assert ("its points are 3.14 m from where it holds" in told) is turned


SNAP = """
name = "snap"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "bracket"
mass = 2
inertia = 0.02
com = [0, 0]
points = { O = [0, 0] }
[[link]]
name = "weight"
mass = 50
inertia = 1
com = [0, 0]
points = { C = [0, 0] }
free = true
[[joint]]
name = "seat"
type = "weld"
between = ["ground.O", "bracket.O"]
[[spring]]
name = "cord"
between = ["bracket.O", "weight.C"]
stiffness = 2000
length = 1
acts = "pull"
[start]
poses = { weight = [0, -0.5, 0] }
[gravity]
[[release]]
joint = "seat"
force = "1.5 kN"
[run]
until = 0.7
"""


def test_forces_are_told_where_all_rows_belong_to_joints_that_have_let_go(tmp_path: Path) -> None:
    """The largest is the limit by which the joint broke."""
    told = command(tmp_path, SNAP, "run", "--out", str(tmp_path / "run"))
    assert "seat lets go at t = " in told and "it carries its limit, 1500 N" in told
    assert "largest forces: seat 1500 N at t = 0.567" in told
    assert (tmp_path / "run" / "forces.png").exists()


def test_a_joint_that_is_no_joint_is_told_with_the_welds_that_are(tmp_path: Path) -> None:
    told = command(tmp_path, SNAP.replace('joint = "seat"', 'joint = "saet"'), "show")
    assert 'found "saet", expected a joint; the joints are seat' in told
