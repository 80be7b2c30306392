"""Lengths that ``[start]`` gives: they hold where the loops allow it, and what had to change is said."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from ccgen.generator import Scene, load_scene

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
    assert (scene.start.slid_by > 0.05, scene.start.farthest) == (True, "guide")
    told = [f"lengths changed by up to {scene.start.slid_by:.3g} m (guide)"]
    if angle is not None:
        turned = abs(scene.start.poses[0][2] - angle)
        told.insert(0, f"angles changed by up to {turned:.3g} rad (crank)")
    shown = ccgen("show", "slider-crank.toml", at=tmp_path)
    assert shown.stderr == f"slider-crank: 1 loop closed, {', '.join(told)}; -v for its branch\n"
    assert "by up to 0 rad" not in shown.stderr
