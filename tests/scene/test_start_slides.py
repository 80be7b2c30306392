"""Lengths that ``[start]`` gives: they hold where the loops allow it, and what had to change is said."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import pytest

from ccgen.generator import Scene, load_scene
from ccgen.generator.cli.detail import Detail
from ccgen.generator.cli.scene_file import tell_closing

from ..support.command_line import ccgen
from ..support.folders import ROOT

SCENE = (ROOT / "scenes" / "slider-crank.toml").read_text()
CRANK, ROD = 0.2, 0.6


def write(folder: Path, start: str) -> Path:
    """The slider-crank with another ``[start]``."""
    head, _, rest = SCENE.partition("[start]\n")
    file = folder / "slider-crank.toml"
    file.write_text(f"{head}[start]\n{start}\n\n[gravity]{rest.partition('[gravity]')[2]}")
    return file


def length(scene: Scene) -> float:
    """How far the slider is along its guide, which lies on the x axis."""
    return scene.start.poses[2][0]


@pytest.mark.parametrize("given", [0.45, 0.6, 0.75])
def test_a_length_alone_holds_and_the_links_follow(given: float, tmp_path: Path) -> None:
    """The crank's angle is that of the triangle with sides crank, rod and the length."""
    scene = load_scene(write(tmp_path, f"slides = {{ guide = {given} }}"))
    assert length(scene) == pytest.approx(given, abs=1e-14)
    angle = math.acos((CRANK**2 + given**2 - ROD**2) / (2 * CRANK * given))
    assert math.cos(scene.start.poses[0][2]) == pytest.approx(math.cos(angle), abs=1e-12)
    assert (scene.start.assembled_by, scene.start.slid_by) == (0.0, 0.0)
    shown = ccgen("show", "slider-crank.toml", at=tmp_path)
    assert (shown.returncode, shown.stderr) == (0, "")


@pytest.mark.parametrize(
    ("start", "angle"),
    [
        ('angles = { crank = "60 deg" }\nslides = { guide = 0.4 }', math.pi / 3),
        ("slides = { guide = 0.9 }", None),
    ],
)
def test_what_had_to_change_is_said(start: str, angle: float | None, tmp_path: Path) -> None:
    """An angle and a length that exclude each other, and a length out of reach: both give way, and say by how much."""
    scene = load_scene(write(tmp_path, start))
    given = float(start.rpartition("= ")[2].rstrip(" }"))
    assert scene.start.slid_by == pytest.approx(abs(length(scene) - given), rel=1e-12)
    assert (scene.start.slid_by > 0.05, scene.start.slid[0][0]) == (True, "guide")
    told = [f"lengths changed by {scene.start.slid_by:.3g} m (guide)"]
    if angle is not None:
        turned = abs(scene.start.poses[0][2] - angle)
        told.insert(0, f"angles changed by {turned:.3g} rad (crank)")
    shown = ccgen("show", "slider-crank.toml", at=tmp_path)
    assert shown.stderr == f"slider-crank: 1 loop closed, {', '.join(told)}; -v for its branch\n"
    assert "by up to 0 rad" not in shown.stderr


@pytest.mark.parametrize("scene", ["four-bar", "stiff-rocker", "jansen-leg"])
def test_all_angles_that_changed_are_said(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Each by how much the pose differs from what the file gives, the largest first: three, and how many more."""
    found = load_scene(ROOT / "scenes" / f"{scene}.toml")
    sketch, names = found.start.sketch, [link.name for link in found.mechanism.links]
    changes = {
        name: abs(pose[2] - angle)
        for number, (name, pose, angle) in enumerate(zip(names, found.start.poses, sketch.angles, strict=True))
        if number in sketch.given.angles and abs(pose[2] - angle) > 1e-9
    }
    assert len(changes) >= 3
    tell_closing(found, Detail.USUAL)
    shown = capsys.readouterr().err
    told = re.findall(r"([\d.e-]+)(?: rad)? \((\w+)\)", shown)
    assert [float(change) for change, _ in told] == [
        float(f"{change:.3g}") for change in sorted(changes.values(), reverse=True)[:3]
    ]
    assert all(float(change) == float(f"{changes[name]:.3g}") for change, name in told)
    more = len(changes) - 3
    assert (f" and {more} more" in shown) == (more > 0) == ("-v for the others and " in shown)
    tell_closing(found, Detail.ALL)
    named = re.findall(r"\((\w+)\)", capsys.readouterr().err.partition("\n")[0])
    assert sorted(named) == sorted(changes)


def test_a_change_that_is_nothing_beside_the_largest_is_not_said(capsys: pytest.CaptureFixture[str]) -> None:
    """Below the last of the three digits with which that is written, or below what is seen."""
    scene = load_scene(ROOT / "scenes" / "four-bar.toml")
    start = replace(scene.start, turned=(("crank", 0.5), ("rocker", 6e-4), ("coupler", 4e-4)), slid=())
    tell_closing(replace(scene, start=start), Detail.USUAL)
    assert "angles changed by 0.5 rad (crank), 0.0006 (rocker); " in capsys.readouterr().err
    start = replace(scene.start, turned=(("crank", 5e-9), ("rocker", 5e-10)), slid=(("guide", 2e-3),))
    tell_closing(replace(scene, start=start), Detail.USUAL)
    assert "angles changed by 5e-09 rad (crank), lengths changed by 0.002 m (guide); " in capsys.readouterr().err
