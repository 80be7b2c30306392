"""What people try first, and what the command answers."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from ccgen.generator import SceneError, load_scene

from ..support.command_line import PENDULUM, ccgen
from ..support.folders import ROOT

LET = """
name = "let"
[let]
l = 0.5
w = 3
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "arm"
rod = { mass = 1, between = ["A", "B"] }
points = { A = [0, 0], B = ["l", 0], C = ["2*l", "0.1*l"] }
[[joint]]
name = "axle"
between = ["ground.O", "arm.A"]
[[torque]]
link = "arm"
torque = "2*cos(w*t)"
[start]
angles = { arm = "l" }
[run]
until = 0.3
"""
FOUR_BAR = ROOT / "scenes" / "four-bar.toml"


@pytest.mark.parametrize(("name", "value"), [("l", "0.7"), ("w", "5")])
def test_a_name_of_let_is_set_as_in_the_file(name: str, value: str, tmp_path: Path) -> None:
    """Of lengths, of what is worked out from them, of the start and of loads over time: every number is the file's."""
    (tmp_path / "set.toml").write_text(LET)
    (tmp_path / "file.toml").write_text(re.sub(rf"(?m)^{name} = .*$", f"{name} = {value}", LET))
    for scene, options in (("set", ["--set", f"{name}={value}"]), ("file", [])):
        done = ccgen("run", f"{scene}.toml", "--out", scene, *options, at=tmp_path)
        assert done.returncode == 0, done.stderr
    one, other, own = (np.load(tmp_path / of / "result.npz") for of in ("set", "file", "set"))
    for key in ("t", "q", "u"):
        assert np.array_equal(one[key], other[key]), key
    assert not np.array_equal(own["q"][-1], np.zeros_like(own["q"][-1]))


def test_load_scene_takes_values_of_let() -> None:
    tables = {"let": {"l": 0.5}, "chain": {"links": 1, "hinged": True, "length": "2*l"}}
    one, other = load_scene(tables, let={"l": 0.7}), load_scene({**tables, "let": {"l": 0.7}})
    assert one.canonical() == other.canonical() != load_scene(tables).canonical()
    assert tables["let"] == {"l": 0.5}


@pytest.mark.parametrize("form", ["dict", "file"])
def test_load_scene_takes_no_other_names_for_let(form: str, tmp_path: Path) -> None:
    """A name that is misspelt would leave the number of the file in place without a word."""
    (tmp_path / "my.toml").write_text('[let]\nlength = 0.5\nrho = 2\n[chain]\nlinks = 1\nlength = "length"\n')
    tables = {"let": {"length": 0.5, "rho": 2}, "chain": {"links": 1, "length": "length"}}
    scene = tables if form == "dict" else tmp_path / "my.toml"
    with pytest.raises(
        ValueError, match=r"^let: found 'lenght', expected names of \[let\] in .*: length, rho; write \"l"
    ):
        load_scene(scene, let={"lenght": 9.0, "rho": 1.0})
    with pytest.raises(ValueError, match=r"found 'mass', 'size', expected .*: length, rho; leave it out$"):
        load_scene(scene, let={"mass": 9.0, "size": 1.0})
    with pytest.raises(TypeError, match=r"^let: found 3, expected numbers by names of \[let\] as a dict"):
        load_scene(scene, let=3)  # type: ignore[arg-type]
    with pytest.raises(SceneError, match=r"let.length: found true, expected a number"):
        load_scene(scene, let={"length": True})
    one, other = load_scene(scene, let={"length": np.float32(0.25)}), load_scene({**tables, "let": {"length": 0.25}})
    assert one.mechanism == other.mechanism != load_scene(scene).mechanism


def test_a_scene_without_let_takes_no_names_for_it() -> None:
    with pytest.raises(ValueError, match=r"^let: found 'l', expected none, for scene has no \[let\]; leave it out$"):
        load_scene({"chain": {"links": 1}}, let={"l": 0.7})


def test_a_scene_without_a_command_is_told_which(tmp_path: Path) -> None:
    (tmp_path / "my.toml").write_text(PENDULUM)
    done = ccgen("my.toml", "--until", "0.1", at=tmp_path)
    assert done.returncode == 2
    assert "write ccgen run my.toml --until 0.1" in done.stderr


def test_a_run_of_no_time_has_the_row_of_the_start(tmp_path: Path) -> None:
    """All files are written: tables have one row, and pictures a dot where a curve would be."""
    (tmp_path / "my.toml").write_text(PENDULUM)
    names = ["--plot", "kinetic_energy", "--csv", "--gif"]
    done = ccgen("run", "my.toml", "--until", "0", "--out", "r", *names, at=tmp_path)
    assert done.returncode == 0 and "t = 0 s, impacts: 0, steps: 0" in done.stdout, done.stderr
    for name in ("plot.png", "player.html", "animation.gif", "outputs.png", "forces.png", "forces.csv"):
        assert (tmp_path / "r" / name).stat().st_size > 0, name
    assert len((tmp_path / "r" / "outputs.csv").read_text().splitlines()) == 2
    with np.load(tmp_path / "r" / "result.npz") as found:
        assert found["t"].tolist() == [0.0] and found["q"].shape[0] == 1
    again = ccgen("plot", "r", "kinetic_energy", "--csv", at=tmp_path)
    assert again.returncode == 0, again.stderr


def test_a_time_before_the_start_is_refused(tmp_path: Path) -> None:
    (tmp_path / "my.toml").write_text(PENDULUM)
    done = ccgen("run", "my.toml", "--until", "-1", at=tmp_path)
    assert done.returncode == 2
    assert "--until: found -1.0, expected a positive number of seconds" in done.stderr


def test_a_unit_in_an_expression_of_time_is_worked_out() -> None:
    text = FOUR_BAR.read_text(encoding="utf-8") + '[[drive]]\njoint = "motor"\nangle = "61.86 deg/s * t"\n'
    import tomllib

    with pytest.raises(SceneError, match=r'write "1\.07966068\*t", in SI units'):
        load_scene(tomllib.loads(text))


def test_full_detail_tells_every_joint_and_every_branch(tmp_path: Path) -> None:
    """The branch of a drawing that closes as it stands, and the largest forces of all four joints."""
    closed = FOUR_BAR.read_text(encoding="utf-8")
    poses = [pose[2] for pose in load_scene(FOUR_BAR).start.poses]
    angles = f"angles = {{ crank = {poses[0]!r}, coupler = {poses[1]!r}, rocker = {poses[2]!r} }}"
    closed, count = re.subn(r"(?m)^angles = .*$", angles, closed)
    assert count == 1
    (tmp_path / "closed.toml").write_text(closed)
    usual = ccgen("run", "closed.toml", "--until", "0.1", at=tmp_path)
    full = ccgen("run", "closed.toml", "--until", "0.1", "-v", at=tmp_path)
    assert usual.returncode == full.returncode == 0
    assert "branch" not in usual.stderr and "closed-" not in usual.stderr
    assert re.search(r"branch .*: open|branch .*: crossed", full.stderr)
    shown = [set(re.findall(r"(?m)^  (\w+) +[-\d.e+]+ N +at t", done.stdout)) for done in (usual, full)]
    assert len(shown[0]) == 3 and len(shown[1]) == 4 and shown[0] < shown[1]
