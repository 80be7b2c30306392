"""One start for given values of parameters, whichever way a model is run; it is the edited file's."""

from __future__ import annotations

import cmath
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator import SceneError, load_scene
from ccgen.generator.scene.with_values import with_values
from ccgen.runtime import ensemble, run_function, sensitivities, simulate

from ..support.command_line import ccgen
from ..support.folders import ROOT
from ..support.tiers import LARGE, all_hard_but
from ..support.workshop import Workshop

WHEELS = """
name = "wheels"
[ground_link]
points = { O = [0, 0], F = [0.3, 0] }
[[link]]
name = "a"
mass = 1.0
inertia = 0.01
com = [0, 0]
points = { C = [0, 0] }
[[link]]
name = "b"
mass = 1.0
inertia = 0.02
com = [0, 0]
points = { C = [0, 0] }
[[joint]]
name = "ja"
between = ["ground.O", "a.C"]
[[joint]]
name = "jb"
between = ["ground.F", "b.C"]
[run]
until = 0.1
"""
BELT = WHEELS + '[[belt]]\njoints = ["ja", "jb"]\nradii = [0.05, 0.03]\n'
GEAR = WHEELS + '[[gear]]\njoints = ["ja", "jb"]\nradii = [0.1, 0.2]\n'
GIVEN = "[start]\nangular_velocities = { a = 6.0 }\n"
DRIVEN = '[[drive]]\njoint = "ja"\nspeed = 6.0\n'

RACK = """
name = "rack"
[ground_link]
points = { O = [0, 0], G = [0, 0.05] }
[[link]]
name = "pinion"
mass = 1.0
inertia = 0.01
com = [0, 0]
points = { C = [0, 0] }
[[link]]
name = "bar"
mass = 1.0
inertia = 0.02
com = [0, 0]
points = { C = [0, 0] }
[[joint]]
name = "axle"
between = ["ground.O", "pinion.C"]
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.G", "bar.C"]
axis = [1, 0.5]
[[rack]]
pinion = "axle"
slide = "guide"
radius = 0.05
[start]
GIVEN
[run]
until = 0.1
"""

PIN = (0.5 + 0.1j) * cmath.exp(0.2j)
SLOT = """
name = "slot"
[ground_link]
points = { O = [0, 0], Q = PIVOT }
[[link]]
name = "arm"
rod = { mass = 1 }
points = { A = [0, 0], B = [0.5, 0.1] }
[[link]]
name = "lever"
rod = { mass = 1 }
points = { A = [0, 0], S = [0.4, 0.2] }
[[joint]]
name = "axle"
between = ["ground.O", "arm.A"]
[[joint]]
name = "pivot"
between = ["ground.Q", "lever.A"]
[[joint]]
name = "pin"
type = "pin-in-slot"
between = ["lever.S", "arm.B"]
axis = [0.8, 0.6]
[start]
angles = { arm = 0.2, lever = 0.7 }
angular_velocities = { arm = 2.0 }
[run]
until = 0.1
""".replace("PIVOT", str([(PIN - (0.4 + 0.2j) * cmath.exp(0.7j)).real, (PIN - (0.4 + 0.2j) * cmath.exp(0.7j)).imag]))
"""At its start the pin is at the origin of its slot: whichever way the slot goes, the loop is shut."""

SLIDE = """
name = "slide"
[ground_link]
points = { O = [0.1, 0.2] }
[[link]]
name = "block"
mass = 0.5
inertia = 0.001
com = [0.01, 0]
points = { C = [0.02, 0.03] }
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "block.C"]
axis = [1, 0.5]
[start]
slides = { guide = 0.2 }
sliding_velocities = { guide = 3.0 }
[run]
until = 0.1
"""

THROWN = """
name = "thrown"
LINKS
[[joint]]
between = ["l0.B", "l1.A"]
[[joint]]
between = ["l1.B", "l2.A"]
[start]
angles = [0.3, 1.0, -0.4]
position = [1.0, 2.0]
velocity = [0.5, -0.2]
angular_velocities = [3.0, -1.0, 2.0]
[run]
until = 0.1
""".replace(
    "LINKS",
    "".join(
        f'[[link]]\nname = "l{k}"\nrod = {{ mass = 1 }}\npoints = {{ A = [0.02, 0.01], B = [0.{3 + k}, 0.02] }}\n'
        for k in range(3)
    ),
)

FREE = """
name = "free"
[ground_link]
points = { O = [0, 0], Q = [0.8, 0] }
LINKS
[[joint]]
name = "o"
between = ["ground.O", "left.A"]
[[joint]]
between = ["left.B", "upper.A"]
[[joint]]
between = ["upper.B", "lower.B"]
[[joint]]
between = ["lower.A", "right.B"]
[[joint]]
between = ["ground.Q", "right.A"]
[start]
angles = ANGLES
angular_velocities = { right = -2 }
[run]
until = 0.1
""".replace(
    "LINKS",
    "".join(
        f'[[link]]\nname = "{name}"\nrod = {{ mass = 1 }}\npoints = {{ A = [0, 0], B = [{length}, 0] }}\n'
        for name, length in (("left", 0.4), ("upper", 0.6), ("lower", 0.6), ("right", 0.3))
    ),
)

SCENES = {
    "belt": BELT + GIVEN,
    "belt, both given": BELT + "[start]\nangular_velocities = { a = 6.0, b = 10.0 }\n",
    "belt, driven": BELT + DRIVEN,
    "gear": GEAR + GIVEN,
    "gear, driven": GEAR + DRIVEN,
    "rack": RACK.replace("GIVEN", "angular_velocities = { pinion = 4.0 }"),
    "rack, by its slide": RACK.replace("GIVEN", "sliding_velocities = { guide = 0.3 }"),
    "slide": SLIDE,
    "slot": SLOT,
    "thrown": THROWN,
    "two freedoms, one rate": FREE.replace("ANGLES", '{ left = "100 deg", right = "70 deg" }'),
    "two freedoms, a sketch": FREE.replace("ANGLES", "[1.6, 0.6, 2.2, 1.3]"),
}

MANY = 60
"""Parameters of one scene from which on every second is looked at, of twice as many every third, and so on; all with
``CCGEN_LARGE=1``. A file of that size takes 0.2 s to be read with each of its numbers."""

FOLLOWS = (".start_1", ".start_2")
"""Parameters that no file gives: at which angles wheels mesh."""

DRAWN = {
    "equal-length-slider-crank", "klann", "quick-return", "scissor-lift", "slider-crank", "three-rrr",
    "three-rrr-circle", "loose-slider-crank", "trebuchet",
}  # fmt: skip
"""Scenes whose [start] is a sketch with drawn joints, or with lengths that follow: with other lengths their models
begin at the nearest start to their own, and the file at what it assembles from its sketch (docs/model.md)."""


def told(model: Any) -> list[str]:
    """Parameters that can be another number, and that a file gives; of the slot, whose start is closed with what is
    given of two links, that which leaves it so."""
    if model.name == "slot":
        return ["pin.axis", "arm.mass"]
    known = [path for path in model.parameters if path not in model.data["rests_on"] and not path.endswith(FOLLOWS)]
    return [path for path in known if ".normal." not in path]  # it has the length 1 in a file


def some_of_each_kind(paths: list[str]) -> list[str]:
    """Of parameters whose names differ in numbers alone, as of the links of a chain, the first, the middle and the
    last."""
    kinds: dict[str, list[str]] = {}
    for path in paths:
        kinds.setdefault(re.sub(r"\d+", "#", path), []).append(path)
    return [path for kind in kinds.values() for path in sorted({kind[0], kind[len(kind) // 2], kind[-1]})]


def poses(model: Any, state: Any) -> Any:
    return np.hstack([model.poses(state[0]), model.velocities(*state)])


def survey(
    model: Any, scene: Any, paths: list[str], factors: tuple[float, ...], *, drawn: bool = False, within: float = 2e-9
) -> None:
    """Starts of all ways agree to the bit, and with that of the file to rounding."""
    surveyed = 0
    for path in paths:
        for factor in factors:
            value = model.parameters[path] * factor or factor - 1.0
            try:
                start = with_values(scene, {path: value}).start
            except (SceneError, ValueError):
                continue  # no file has that number
            surveyed += 1
            changed = model.with_parameters({path: value})
            state = changed.start()
            if not drawn:
                off = poses(changed, state) - np.hstack([start.poses, start.velocities])
                off[:, 2] -= 2.0 * np.pi * np.round(off[:, 2] / (2.0 * np.pi))
                size = 1.0 + np.abs(start.velocities).max()
                assert np.abs(off).max() <= within * size, (path, factor)
            run = simulate(model, params={path: value}, until=1e-9)
            again = simulate(changed, *state, until=1e-9)
            if run.q.shape[1] == len(state[0]):
                assert run.q[0] == pytest.approx(state[0], rel=1e-15, abs=1e-15), (path, factor)
                assert run.u[0] == pytest.approx(state[1], rel=1e-14, abs=1e-14), (path, factor)
            else:  # joints that let go have coordinates in runs
                assert poses(run.model, (run.q[0], run.u[0])) == pytest.approx(
                    poses(changed, state), rel=1e-14, abs=1e-14
                )
            assert np.array_equal(run.q[-1], simulate(changed, until=1e-9).q[-1])
            assert again.q[-1] == pytest.approx(run.q[-1], rel=1e-14, abs=1e-14)
            seen = [f"{link}.{of}" for link in model.links[:3] for of in ("angle", "angular_velocity")]
            many = ensemble(model, {path: [value, value]}, observe=seen, until=1e-9)
            for name in seen:
                assert many[name][1] == run[name][-1], (path, factor, name)
    assert surveyed >= len(paths)  # of two numbers each


@pytest.mark.parametrize("name", SCENES)
def test_small_scenes_begin_as_their_files_with_every_number(name: str, workshop: Workshop) -> None:
    scene = workshop.scene(SCENES[name])
    model = workshop.model(scene, derivatives=True)
    survey(model, scene, told(model), (1.1, 0.93, 1.0 + 1e-7))


@pytest.mark.parametrize(("kind", "right"), [("belt", (6.0, 11.0)), ("gear", (6.0, -3.3))])
def test_wheels_turn_as_their_radii_say(kind: str, right: tuple[float, float], workshop: Workshop) -> None:
    """The rate that is given stays, and the other wheel's is by the ratio of the radii, in closed form."""
    model = workshop.model(SCENES[kind], derivatives=True)
    path = f"{kind}_0.radius_1"
    value = 1.1 * model.parameters[path]
    assert model.with_parameters({path: value}).start()[1] == pytest.approx(right, rel=1e-14)
    assert simulate(model, params={path: value}).u[0] == pytest.approx(right, rel=1e-14)
    ends = ensemble(model, {path: [value, value]}, observe=["a.angular_velocity", "b.angular_velocity"])
    assert [ends[f"{name}.angular_velocity"][0] for name in "ab"] == pytest.approx(right, rel=1e-9)
    outputs = ["a.angular_velocity", "b.angular_velocity"]
    slope = (right[1] - model.start()[1][1]) / (0.1 * model.parameters[path])
    found = sensitivities(model, [path], outputs).jacobian.ravel()
    assert found == pytest.approx([0.0, slope], rel=1e-9, abs=1e-9)
    function = run_function(model, [path], outputs)
    assert function.value([value]) == pytest.approx(right, rel=1e-9)
    assert function.jacobian([model.parameters[path]]).ravel() == pytest.approx([0.0, slope], rel=1e-9, abs=1e-9)


def test_a_set_radius_begins_as_the_edited_file(tmp_path: Path) -> None:
    """``--set`` by the command line, against the file with that number."""
    for name, radius, options in (("set", "0.05", ["--set", "belt_0.radius_1=0.055"]), ("file", "0.055", [])):
        (tmp_path / f"{name}.toml").write_text(SCENES["belt"].replace("0.05,", f"{radius},"))
        assert ccgen("run", f"{name}.toml", "--out", name, *options, at=tmp_path).returncode == 0
    one, other = (np.load(tmp_path / name / "result.npz") for name in ("set", "file"))
    assert np.array_equal(one["q"][0], other["q"][0])
    assert np.array_equal(one["u"][0], other["u"][0])
    assert other["u"][0] == pytest.approx([6.0, 11.0], rel=1e-14)


@pytest.mark.parametrize("name", SCENES)
def test_small_starts_move_as_differences_of_their_files(name: str, workshop: Workshop) -> None:
    """Derivatives of the start by every parameter, against differences of what the generator assembles."""
    scene = workshop.scene(SCENES[name])
    model = workshop.model(scene, derivatives=True)
    moved(model, scene, told(model), 2e-6)


def moved(model: Any, scene: Any, paths: list[str], within: float) -> None:
    found = sensitivities(model, paths, ["q", "u"], until=1e-12)
    slopes = np.vstack([found["q"], found["u"]])
    from ccgen.runtime.model.poses import read_off, read_rates

    for k, path in enumerate(paths):
        value, ends = model.parameters[path], []
        h = 1e-5 * max(abs(value), 1e-2)
        try:
            for step in (h, -h):
                start = with_values(scene, {path: value + step}).start
                other = model.with_parameters({path: value + step})
                rows = np.array(start.poses), np.array(start.velocities)
                ends.append(np.append(read_off(other, rows[0]), read_rates(other, *rows)))
        except SceneError:
            continue  # at the end of what it can be
        wanted = (ends[0] - ends[1]) / (2.0 * h)
        assert slopes[:, k] == pytest.approx(wanted, rel=within, abs=within * (1.0 + np.abs(wanted).max())), path


def shipped() -> list[str]:
    every = [*(ROOT / "scenes").glob("*.toml"), *(ROOT / "scenes" / "gallery").glob("*.toml")]
    return sorted(str(file.relative_to(ROOT / "scenes")) for file in every)


@pytest.mark.large(10)
@pytest.mark.parametrize("file", all_hard_but("four-bar.toml", "open-chain.toml", "parallelogram.toml", of=shipped()))
def test_shipped_scenes_begin_as_their_files_with_every_number(file: str, workshop: Workshop) -> None:
    scene = load_scene(ROOT / "scenes" / file)
    model = workshop.model(scene)
    paths, within = told(model), 2e-9
    if "strandbeest" in file:
        # each start is assembled of fifty links; the least change is one to the root of rounding
        paths, within = paths[:: max(1, len(paths) // 12)], 1e-4
    paths = some_of_each_kind(paths)
    paths = paths[:: 1 if LARGE else 1 + len(paths) // MANY]
    survey(model, scene, paths, (1.03, 1.0 + 1e-7), drawn=Path(file).stem in DRAWN, within=within)
