"""Redundant joints, change points and structures, told apart: against counts that can be made by hand."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from ccgen.generator import Scene, chain, load_scene, loop, pinned
from ccgen.generator.cli.app import app
from ccgen.generator.documents.assembled import redundancy_lines
from ccgen.generator.mechanism.redundancy import JointEquations, mobility
from ccgen.generator.scene import read_tables

from ..support.drawn_linkages import cranks, four_bar, rod
from ..support.folders import SCENES


def groups(scene: Scene) -> list[tuple[set[str], int]]:
    found = mobility(scene.mechanism, scene.start.poses)
    names = [joint.name for joint in scene.mechanism.joints]
    return [({names[joint] for joint in group.joints}, group.surplus) for group in found.groups]


@pytest.mark.parametrize("angle", [0.4, 1.1, 2.0])
@pytest.mark.parametrize("count", [3, 4, 6])
def test_parallel_cranks_beyond_two_are_redundant(angle: float, count: int) -> None:
    """Each crank beyond the second adds three coordinates and four equations, and takes no freedom away."""
    scene = cranks([1.0] * count, [angle] * count + [0.0])
    found = mobility(scene.mechanism, scene.start.poses)
    assert (found.freedom, found.elsewhere, found.stuck, found.here) == (1, 1, False, ())
    everything = {f"{end}_{k}" for k in range(count) for end in ("foot", "head")}
    assert groups(scene) == [(everything, count - 2)]


@pytest.mark.parametrize("count", [3, 5, 6, 12])
def test_of_many_joints_the_first_are_named_and_the_others_counted(count: int) -> None:
    """Each crank has two pins. A line has all of up to eleven, ten of more; all again where every one is asked for."""
    scene = cranks([1.0] * count, [1.1] * count + [0.0])
    found = mobility(scene.mechanism, scene.start.poses)
    (line,), (whole,) = redundancy_lines(scene, found), redundancy_lines(scene, found, every=True)
    names = {joint.name for joint in scene.mechanism.joints}

    def named(text: str) -> list[str]:
        return [word for word in re.split(r"[ ,]+", text) if word in names]

    assert sorted(named(whole)) == sorted(names) and "more together" not in whole
    if count <= 5:
        assert line == whole
    else:
        assert named(line) == named(whole)[:10] and f" and {2 * count - 10} more together have" in line


def test_a_self_stress_is_one() -> None:
    """Forces along three parallel cranks, 1 : -2 : 1, balance on the bar; the equations say the same."""
    scene = cranks([1.0] * 3, [1.1] * 3 + [0.0])
    poses = np.array(scene.start.poses)
    joints = JointEquations(scene.mechanism, poses)
    stresses, freedom = joints.stresses(poses)
    along = np.array([math.cos(1.1), math.sin(1.1)])
    by_hand = np.concatenate([np.outer((1.0, -2.0, 1.0), along).ravel()] * 2)
    by_hand /= np.linalg.norm(by_hand)
    assert freedom == 1 and stresses.shape == (12, 1)
    assert abs(float(by_hand @ stresses[:, 0])) == pytest.approx(1.0, abs=1e-12)
    assert np.abs(joints.jacobian(poses).T @ by_hand).max() < 1e-14


def test_joints_that_are_needed_are_not_named() -> None:
    """A pendulum on the bar of three cranks: its pin is no part of the redundancy."""
    scene = cranks([1.0] * 3, [1.1] * 3 + [0.0])
    tables = {
        "ground_link": {"points": {f"O{k}": [float(k), 0.0] for k in range(3)}},
        "link": [
            *(rod(f"crank_{k}", 1.0) for k in range(3)),
            rod("bar", 1.0) | {"points": {f"P{k}": [float(k), 0.0] for k in range(3)}},
            rod("pendulum", 1.0),
        ],
        "joint": [
            *({"name": f"foot_{k}", "between": [f"ground.O{k}", f"crank_{k}.A"]} for k in range(3)),
            *({"name": f"head_{k}", "between": [f"crank_{k}.B", f"bar.P{k}"]} for k in range(3)),
            {"name": "pin", "between": ["bar.P1", "pendulum.A"]},
        ],
        "start": {"angles": [1.1, 1.1, 1.1, 0.0, -1.0]},
    }
    hanging = read_tables(tables, "hanging", "hanging")
    assert groups(hanging) == groups(scene)
    assert mobility(hanging.mechanism, hanging.start.poses).freedom == 2


@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_a_flat_parallelogram_is_a_change_point(turn: float) -> None:
    """Two motions where it lies flat, one everywhere else; nothing is redundant for good."""
    scene = loop(4, start={"angles": [turn, turn, math.pi + turn, math.pi + turn]})
    found = mobility(scene.mechanism, scene.start.poses)
    assert (found.freedom, found.elsewhere, found.stuck, found.structure) == (5, 4, False, False)
    assert found.groups == ()
    assert [group.surplus for group in found.here] == [1]
    (line,) = redundancy_lines(scene, found)
    assert "a change point, 4 degrees of freedom nearby" in line and "joint_3" in line


@pytest.mark.parametrize(
    ("scene", "stuck"),
    [(lambda: pinned(2), False), (lambda: loop(3), None), (lambda: pinned(2, pinned={"span": 2.0}), True)],
    ids=["triangle on the ground", "triangle that floats", "two bars in line"],
)
def test_structures(scene: Callable[[], Scene], stuck: bool | None) -> None:
    """A triangle is stiff; two bars in line have a small motion to first order, and none in truth."""
    built = scene()
    found = mobility(built.mechanism, built.start.poses)
    if stuck is None:
        assert (found.freedom, found.structure) == (3, False), "three motions of the whole"
        return
    assert found.structure and found.stuck == stuck
    assert found.freedom == int(stuck)
    assert "a structure" in redundancy_lines(built, found)[-1]


@pytest.mark.parametrize("path", sorted(SCENES.glob("*.toml")), ids=lambda path: path.stem)
def test_the_scenes_have_no_redundant_joints(path: Path) -> None:
    """Their freedom is Grübler's."""
    scene = load_scene(path)
    found = mobility(scene.mechanism, scene.start.poses)
    links, joints = len(scene.mechanism.links), len(scene.mechanism.joints)
    slots = sum(joint.kind == "pin-in-slot" for joint in scene.mechanism.joints)
    assert redundancy_lines(scene, found) == []
    assert found.freedom == 3 * links - 2 * joints + slots - len(scene.mechanism.meshes)


def test_the_freedom_of_random_rings_and_chains() -> None:
    """n + 2 less 2 for a ring, n + 2 for a chain that floats, one less for each coordinate of a hinge."""
    for n in (5, 9):
        for scene, expected in ((loop(n), n), (chain(n), n + 2), (chain(n, hinged=True), n), (pinned(n), n - 2)):
            assert mobility(scene.mechanism, scene.start.poses).freedom == expected


SCENE = """
[ground_link]
points = { O = [0, 0], Q = [2, 0] }
[[link]]
name = "a"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0], B = [1.5, 0] }
[[link]]
name = "b"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0], B = [1.5, 0] }
[[joint]]
between = ["ground.O", "a.A"]
[[joint]]
name = "top"
between = ["a.B", "b.B"]
[[joint]]
between = ["ground.Q", "b.A"]
[start]
joints = { top = [1.1, 1.2] }
[gravity]
[run]
until = 0.1
"""


def test_show_and_run_tell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A structure is not refused: it is said to be one, with its branch and how far the drawing was off."""
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "frame.toml"
    file.write_text(SCENE)
    shown = CliRunner().invoke(app, ["show", str(file)])
    assert shown.exit_code == 0, shown.output
    assert "a structure: nothing can move" in shown.stdout
    lines = [line for line in shown.stdout.splitlines() if line.startswith("branch")]
    assert len(lines) == 1 and "top" in lines[0] and "open" in lines[0]
    assert "1 loop closed, angles changed by " in shown.stderr
    off = math.hypot(1.1 - 1.0, 1.2 - math.sqrt(1.25))  # the top is midway between the feet
    assert f"drawn points lie up to {off:.3g} m off" in shown.stderr
    ran = CliRunner().invoke(app, ["run", str(file), "--out", str(tmp_path / "out")])
    assert "frame: a structure: nothing can move" in ran.stderr


def test_an_ordinary_mechanism_says_nothing_of_it() -> None:
    scene = four_bar({"angles": [1.0, 0.5, 1.5]})
    assert redundancy_lines(scene, mobility(scene.mechanism, scene.start.poses)) == []
