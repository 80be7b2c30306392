"""Sample states of the planner: closed, on a whole turn of the machine, and what they say of its dyads."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene, loop
from ccgen.generator.mechanism.links import GROUND
from ccgen.generator.mechanism.topology import span
from ccgen.generator.pipeline import plan_scene
from ccgen.generator.planning import dead_centres
from ccgen.generator.planning.choose import DYADS, TIP_TO_ROOT
from ccgen.generator.planning.dead_centres import SOUND, lasting_dyads, sound_dyads
from ccgen.generator.planning.samples import STEPS, sample_poses
from ccgen.generator.scene.scene import Scene

from ..support.folders import ROOT


def pin_misses(scene: Scene, poses: Any) -> float:
    """The largest distance (m) between the two points of a pin, from the poses alone."""

    def place(ref: Any) -> complex:
        x, y = scene.mechanism.point(ref).values()
        if ref.link == GROUND:
            return complex(x, y)
        x0, y0, angle = poses[ref.link]
        return complex(x0, y0) + complex(x, y) * complex(math.cos(angle), math.sin(angle))

    pins = [joint for joint in scene.mechanism.joints if not joint.slides]
    return max(abs(place(pin.first) - place(pin.second)) for pin in pins)


@pytest.mark.parametrize("name", ["strandbeest", "four-bar", "jansen-leg", "falling-hexagon", "slider-crank"])
def test_samples_are_closed_and_go_once_around(name: str) -> None:
    """Pins meet to rounding; what goes around goes around, and nothing stays where it was."""
    scene = load_scene(ROOT / "scenes" / f"{name}.toml")
    samples = sample_poses(scene.mechanism, scene.start.poses)
    assert len(samples) == 1 + 2 * STEPS
    size = max(math.hypot(x, y) for poses in samples for x, y, _ in poses) + 1.0
    assert max(pin_misses(scene, poses) for poses in samples) <= 1e-13 * size
    angles = np.array(samples)[:, :, 2]
    assert samples[0] == scene.start.poses
    if name != "falling-hexagon":  # of more than one degree of freedom
        assert np.ptp(angles, axis=0).max() >= 0.85 * 2.0 * math.pi
    assert np.abs(np.diff(angles[:9], axis=0)).max(axis=1).min() > 0.1


def test_a_structure_stays_where_it_is() -> None:
    """Three links in a ring form a triangle: it has one configuration, and no sample beside."""
    scene = loop(3)
    assert sample_poses(scene.mechanism, scene.start.poses) == (scene.start.poses,)


@pytest.mark.parametrize(("base", "lasts"), [(0.6, True), (0.85, False)])
def test_dyads_are_judged_along_the_motion(base: float, lasts: bool, tmp_path: Any) -> None:
    """Sines by the law of cosines: a crank of 0.2 m goes around on a base of 0.6 m; on one of 0.85 m it swings, and
    coupler and rocker, 0.5 m each, stretch at the ends."""
    text = (ROOT / "scenes" / "four-bar.toml").read_text()
    path = tmp_path / "bar.toml"
    path.write_text(text.replace("Q = [0.6, 0]", f"Q = [{base}, 0]"))
    scene = load_scene(path)
    topology, samples = span(scene.mechanism), sample_poses(scene.mechanism, scene.start.poses)
    for poses in samples:
        tip = 0.2 * np.array([math.cos(poses[0][2]), math.sin(poses[0][2])])
        reach = math.hypot(base - tip[0], tip[1])
        sine = math.sqrt(max(0.0, 1.0 - (1.0 - reach**2 / 0.5) ** 2))
        assert bool(sound_dyads(scene.mechanism, topology, poses)) == (sine > SOUND)
    assert sound_dyads(scene.mechanism, topology, samples[0])
    assert bool(lasting_dyads(scene.mechanism, topology, samples)) == lasts


def test_dyads_that_do_not_last_stay_open(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is chosen for a walking machine leaves out a dyad that a sample finds near its dead centre."""
    scene = load_scene(ROOT / "scenes" / "strandbeest.toml")
    whole = plan_scene(scene)[1]
    sines, near = dead_centres.sound_dyads, next(cut.joint for cut in whole.topology.cuts if cut.kind == "revolute")
    monkeypatch.setattr(
        dead_centres,
        "sound_dyads",
        lambda mechanism, topology, poses: tuple(
            joint for joint in sines(mechanism, topology, poses) if poses == scene.start.poses or joint != near
        ),
    )
    part = plan_scene(scene)[1]
    assert whole.plan.name == part.plan.name == DYADS
    assert dict(part.costs)[DYADS] > dict(whole.costs)[DYADS]
    assert dict(part.costs)[TIP_TO_ROOT] == dict(whole.costs)[TIP_TO_ROOT]
