"""Scenes become records; starts are consistent and nearest to what was asked."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from dataclasses import FrozenInstanceError
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize  # type: ignore[import-untyped]

from ccgen.generator.effects.gravity import Gravity
from ccgen.generator.effects.ground import Ground
from ccgen.generator.mechanism.assembly import CannotClose, Contradiction, nearest, rates
from ccgen.generator.mechanism.joints import Joint, PointRef
from ccgen.generator.mechanism.layout import lay_out
from ccgen.generator.mechanism.links import GROUND
from ccgen.generator.scene import Scene, SceneError, chain, load_scene, loop, pinned, read_tables
from ccgen.generator.scene.locate import locate

from ..support.folders import SCENES


def points(scene: Scene, name: str = "A") -> np.ndarray:
    """Where the point ``name`` of every link is at the start, complex."""
    poses = np.array(scene.start.poses)
    local = np.array([complex(*link.points[name].values()) for link in scene.mechanism.links])
    return np.asarray(poses[:, 0] + 1j * poses[:, 1] + local * np.exp(1j * poses[:, 2]))


def pose(scene: Scene, link: int) -> tuple[float, float, float]:
    return (0.0, 0.0, 0.0) if link == GROUND else scene.start.poses[link]


def at(scene: Scene, ref: PointRef) -> complex:
    """Where a point is at the start."""
    x, y, angle = pose(scene, ref.link)
    return complex(complex(x, y) + complex(*scene.mechanism.point(ref).values()) * np.exp(1j * angle))


def speed(scene: Scene, ref: PointRef) -> complex:
    """How fast a point moves at the start."""
    if ref.link == GROUND:
        return 0j
    (x, y, _), (vx, vy, spin) = scene.start.poses[ref.link], scene.start.velocities[ref.link]
    return complex(vx, vy) + 1j * spin * (at(scene, ref) - complex(x, y))


def across(scene: Scene, joint: Joint, vector: complex) -> float:
    """The part of a vector that a joint holds: all of it, or that across the line on which it slides."""
    if not joint.slides:
        return abs(vector)
    angle = pose(scene, joint.first.link)[2] + (joint.axis.value if joint.axis else 0.0)
    return abs((vector * np.exp(-1j * angle)).imag)


def joint_gaps(scene: Scene) -> np.ndarray:
    """How far the two sides of every joint miss each other at the start, from the poses alone."""
    joints = scene.mechanism.joints
    return np.array([across(scene, j, at(scene, j.second) - at(scene, j.first)) for j in joints])


def joint_speeds(scene: Scene) -> np.ndarray:
    """Speed at which the two sides of every joint part at the start."""
    found = []
    for j in scene.mechanism.joints:
        apart = at(scene, j.second) - at(scene, j.first)
        spin = 0.0 if j.first.link == GROUND else scene.start.velocities[j.first.link][2]
        carried = 1j * spin * apart if j.slides else 0j
        found.append(across(scene, j, speed(scene, j.second) - speed(scene, j.first) - carried))
    return np.array(found)


# The files in scenes/


@pytest.mark.parametrize("path", sorted(SCENES.glob("*.toml")), ids=lambda path: path.stem)
def test_every_scene_is_consistent(path: Path) -> None:
    scene = load_scene(path)
    assert scene.name == path.stem
    assert scene.package.isidentifier()
    size = max(
        1.0, *(abs(v) for link in scene.mechanism.links for point in link.points.values() for v in point.values())
    )
    assert joint_gaps(scene).max() <= 1e-14 * size
    assert joint_speeds(scene).max() <= 1e-13 * size


def test_falling_hexagon() -> None:
    scene = load_scene(SCENES / "falling-hexagon.toml")
    gravity, ground = scene.effects
    assert isinstance(gravity, Gravity) and gravity.g.value == 9.81 and gravity.g.symbol == "g"
    assert isinstance(ground, Ground)
    assert [p.path for p in ground.parameters()] == ["ground_0.normal.y", "ground_0.restitution"]
    assert [name for name, _ in ground.contacts] == [f"joint_{k}" for k in range(6)]
    assert points(scene)[0] == 1j
    assert points(scene).imag.min() == 1.0
    assert (scene.run.until, scene.run.rtol, scene.run.atol) == (1.2, 1e-10, None)
    with pytest.raises(FrozenInstanceError):
        scene.name = "other"  # type: ignore[misc]


def test_four_bar_turns() -> None:
    scene = load_scene(SCENES / "four-bar.toml")
    assert scene.start.velocities[0] == (0.0, 0.0, 10.0)
    assert 0.0 < scene.start.assembled_by < 0.2


# Shorthand


@pytest.mark.parametrize("n", [3, 4, 6, 12, 97])
@pytest.mark.parametrize("tilt", [0.0, 0.3])
def test_loop_is_a_regular_polygon(n: int, tilt: float) -> None:
    scene = loop(n, start={"tilt": tilt, "position": [0.5, -0.25]})
    radius = 0.5 / math.sin(math.pi / n)
    corners = radius * np.exp(2j * math.pi * np.arange(n) / n - 0.5j * math.pi)
    expected = (corners - corners[0]) * np.exp(1j * tilt) + 0.5 - 0.25j
    assert np.abs(points(scene) - expected).max() < 1e-13 * radius
    assert np.abs(np.roll(points(scene, "B"), 1) - expected).max() < 1e-13 * radius
    assert scene.start.assembled_by == 0.0


def test_loop_records() -> None:
    scene = loop(6)
    assert scene.name == scene.package == "loop6"
    assert scene.effects == ()
    joint = scene.mechanism.joints[0]
    assert (joint.name, joint.first, joint.second) == ("joint_0", PointRef(5, "B"), PointRef(0, "A"))
    link = scene.mechanism.links[2]
    assert [(p.path, p.symbol, p.value) for p in link.parameters()] == [
        ("link_2.mass", "m_2", 1.0),
        ("link_2.inertia", "I_2", 1.0 / 12.0),
        ("link_2.com.x", "c_2_x", 0.5),
        ("link_2.length", "l_2", 1.0),
    ]
    assert isinstance(loop(6, gravity=True).effects[0], Gravity)


@pytest.mark.parametrize("n", [2, 3, 5, 8])
def test_pinned_hangs_as_a_polygon(n: int) -> None:
    scene = pinned(n)
    assert scene.name == f"pinned{n}"
    assert len(scene.mechanism.joints) == n + 1
    joints = np.append(points(scene), points(scene, "B")[-1])
    centre = 0.5 - 0.5j / math.tan(math.pi / (n + 1))
    assert np.abs(np.abs(joints - centre) - 0.5 / math.sin(math.pi / (n + 1))).max() < 1e-14 * n
    assert abs(joints[0]) == 0.0 and abs(joints[-1] - 1.0) < 1e-14 * n
    turns = np.angle((joints[1:] - centre) / (joints[:-1] - centre))
    assert np.allclose(turns, 2.0 * math.pi / (n + 1)), "counter-clockwise"


def test_chains() -> None:
    free, hinged = chain(4), chain(4, hinged=True)
    assert (free.name, hinged.name) == ("chain4", "hinged4")
    assert [joint.name for joint in free.mechanism.joints] == ["joint_1", "joint_2", "joint_3"]
    assert [joint.name for joint in hinged.mechanism.joints] == ["joint_0", "joint_1", "joint_2", "joint_3"]
    assert np.array_equal(points(free), np.arange(4))
    single = chain(1, ground=[{"restitution": 0.5}])
    ground = single.effects[0]
    assert isinstance(ground, Ground) and [name for name, _ in ground.contacts] == ["link_0.A", "link_0.B"]


def test_values_per_link() -> None:
    tables = {"length": [1.0, 2.0, 1.5], "mass": [1, 2, 3], "com": [0.3, [0.5, 0.1], 0.2], "inertia": 0.4}
    links = chain(3, chain=tables).mechanism.links
    assert [link.points["B"].values()[0] for link in links] == [1.0, 2.0, 1.5]
    assert [link.mass.value for link in links] == [1.0, 2.0, 3.0]
    assert [link.com.values() for link in links] == [(0.3, 0.0), (0.5, 0.1), (0.2, 0.0)]
    assert [link.inertia.value for link in links] == [0.4] * 3
    assert chain(3, chain={"com": [0.2, 0.1]}).mechanism.links[1].com.values() == (0.2, 0.1)
    assert chain(2, chain={"length": [2.0, 1.0]}).mechanism.links[0].inertia.value == pytest.approx(4.0 / 12.0)


def test_zero_coordinates_are_structure() -> None:
    link = chain(1, chain={"com": [0.0, 0.2]}).mechanism.links[0]
    assert link.com.x is None and link.com.y is not None and link.com.y.path == "link_0.com.y"


def test_tilt_reads_degrees() -> None:
    plain = loop(5).start.poses
    for tilt in ("10 deg", "0.17453292519943295 rad", math.radians(10.0)):
        turned = loop(5, start={"tilt": tilt}).start.poses
        assert np.allclose(np.array(turned)[:, 2] - np.array(plain)[:, 2], math.radians(10.0), atol=1e-15)


def test_height_is_measured_along_the_first_ground() -> None:
    grounds = [{"point": [1.0, 2.0], "normal": [-3.0, 4.0], "restitution": 0.0}]
    scene = loop(6, start={"height": 0.7}, ground=grounds)
    heights = ((points(scene) - (1 + 2j)) * (-0.6 - 0.8j)).real
    assert heights.min() == pytest.approx(0.7, abs=1e-14)
    assert points(loop(6, start={"height": 0.7, "tilt": 1.0})).imag.min() == pytest.approx(0.7, abs=1e-14)


def test_contacts_share_a_pin_once() -> None:
    rod = {"mass": 1.0, "inertia": 0.1, "com": [0.5, 0.0], "points": {"A": [0, 0], "B": [1, 0]}}
    tables = {
        "link": [{"name": name, **rod} for name in "abc"],
        "joint": [{"between": ["a.A", "b.A"]}, {"between": ["b.A", "c.A"]}],
        "ground": [{"restitution": 0.5}, {"name": "wall", "normal": [1, 0], "restitution": 1, "contacts": ["a.B"]}],
        "start": {"angles": {"a": 0.0, "b": 1.0, "c": 2.0}},
    }
    scene = read_tables(tables, "test", "star")
    floor, wall = scene.effects
    assert isinstance(floor, Ground) and floor.contacts == (("joint_0", PointRef(0, "A")),)
    assert isinstance(wall, Ground) and wall.contacts == (("a.B", PointRef(0, "B")),)
    assert [p.path for p in wall.parameters()] == ["wall.normal.x", "wall.restitution"]


# Assembly


def random_loop(seed: int) -> tuple[Scene, np.ndarray]:
    """A loop of unequal links, and a sketch of it that does not close."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(4, 9))
    lengths = rng.uniform(0.6, 1.4, n).tolist()
    sketch = 2.0 * math.pi * (np.arange(n) + 0.5) / n + rng.normal(0.0, 0.25, n)
    return loop(n, loop={"length": lengths}), sketch


@pytest.mark.parametrize("seed", range(12))
def test_nearest_closed_configuration(seed: int) -> None:
    scene, sketch = random_loop(seed)
    layout = lay_out(scene.mechanism)
    angles = nearest(layout, sketch)
    assert np.abs(layout.closure(angles)).max() <= 1e-14 * layout.reach.max()
    reference = minimize(
        lambda theta: 0.5 * np.sum((theta - sketch) ** 2),
        sketch,
        jac=lambda theta: theta - sketch,
        constraints={"type": "eq", "fun": layout.closure, "jac": layout.jacobian},
        method="SLSQP",
        options={"ftol": 1e-15, "maxiter": 500},
    )
    assert np.sum((angles - sketch) ** 2) <= np.sum((reference.x - sketch) ** 2) + 1e-9
    multipliers = np.linalg.lstsq(layout.jacobian(angles).T, sketch - angles, rcond=None)[0]
    assert np.abs(angles - sketch + layout.jacobian(angles).T @ multipliers).max() < 1e-9, "stationary"


def test_jacobian_is_the_derivative() -> None:
    scene, sketch = random_loop(3)
    layout = lay_out(scene.mechanism)
    for k in range(len(sketch)):
        step = np.zeros(len(sketch))
        step[k] = 1e-6
        slope = (layout.closure(sketch + step) - layout.closure(sketch - step)) / 2e-6
        assert np.abs(slope - layout.jacobian(sketch)[:, k]).max() < 1e-9


def test_closed_sketch_stays() -> None:
    layout = lay_out(loop(6).mechanism)
    angles = np.array(loop(6).start.poses)[:, 2]
    assert nearest(layout, angles) is angles


def test_flattened_loop_closes() -> None:
    scene = loop(3, loop={"length": [1.0, 1.0, 2.0]})
    assert joint_gaps(scene).max() <= 1e-14 * 4.0


def test_stretched_pinned_chain_closes() -> None:
    assert joint_gaps(pinned(3, pinned={"span": 2.999})).max() <= 1e-14 * 6.0
    assert pinned(3, pinned={"span": 2.999}).start.assembled_by > 0.1


def test_sketch_in_one_line_is_left() -> None:
    scene = loop(4, start={"angles": [0.0, 0.0, 0.0, 0.0]})
    assert joint_gaps(scene).max() <= 1e-14 * 4.0


def test_ladder_of_two_loops() -> None:
    scene = read_tables(ladder(2), "test", "ladder")
    assert joint_gaps(scene).max() <= 1e-14 * 6.0
    assert len(lay_out(scene.mechanism).gaps) == 2
    rate = scene.start.velocities[0][2]
    assert [velocity[2] for velocity in scene.start.velocities[:3]] == pytest.approx([rate] * 3, abs=1e-14)


def ladder(loops: int) -> dict[str, object]:
    """Upright links in a row, joined by rungs, the first turning at -1 rad/s, as tables."""
    rod = {"mass": 1.0, "inertia": 1.0 / 12.0, "com": [0.5, 0.0], "points": {"A": [0, 0], "B": [1, 0]}}
    uprights = [f"upright_{i}" for i in range(loops + 1)]
    rungs = [f"rung_{i}" for i in range(loops)]
    joints = [[f"ground.P{i}", f"{name}.A"] for i, name in enumerate(uprights)]
    for i, rung in enumerate(rungs):
        joints += [[f"{uprights[i]}.B", f"{rung}.A"], [f"{rung}.B", f"{uprights[i + 1]}.B"]]
    return {
        "link": [{"name": name, **rod} for name in uprights + rungs],
        "joint": [{"type": "revolute", "between": pair} for pair in joints],
        "ground_link": {"points": {f"P{i}": [float(i), 0.0] for i in range(loops + 1)}},
        "start": {
            "angles": dict.fromkeys(uprights, "80 deg"),
            "angular_velocities": {"upright_0": -1.0},
        },
    }


def test_impossible_closure_says_by_how_much() -> None:
    layout = lay_out(loop(3).mechanism)
    long = lay_out(chain(2, hinged=True).mechanism)
    assert long.gaps == ()
    stretched = type(layout)(
        layout.floating, layout.base, layout.arms, layout.gaps, layout.gap_base + 5.0, layout.gap_arms, layout.apart
    )
    with pytest.raises(CannotClose) as caught:
        nearest(stretched, np.array([0.1, 2.0, 4.0]))
    assert caught.value.miss == pytest.approx(2.0, rel=1e-3)


# Velocities


@pytest.mark.parametrize("seed", range(6))
def test_open_rates_are_the_smallest(seed: int) -> None:
    scene, _ = random_loop(seed)
    layout = lay_out(scene.mechanism)
    angles = np.array(scene.start.poses)[:, 2]
    found = rates(layout, angles, {0: 1.5})
    jacobian = layout.jacobian(angles)
    assert found[0] == 1.5
    assert np.abs(jacobian @ found).max() < 1e-13
    assert np.allclose(found[1:], -np.linalg.pinv(jacobian[:, 1:]) @ jacobian[:, 0] * 1.5, atol=1e-12)


def test_all_rates_given() -> None:
    scene, _ = random_loop(1)
    layout = lay_out(scene.mechanism)
    angles = np.array(scene.start.poses)[:, 2]
    motion = np.linalg.svd(layout.jacobian(angles))[2][-1]
    assert np.allclose(rates(layout, angles, dict(enumerate(motion))), motion, atol=1e-14)
    motion[0] += 1e-5
    with pytest.raises(Contradiction) as caught:
        rates(layout, angles, dict(enumerate(motion)))
    assert 0.5e-5 < caught.value.speed < 2e-5


def test_velocity_of_the_whole() -> None:
    scene = loop(5, start={"velocity": [1.0, -2.0], "angular_velocities": [3.0] * 5})
    assert scene.start.velocities[0] == (1.0, -2.0, 3.0)
    poses, moving = np.array(scene.start.poses), np.array(scene.start.velocities)
    assert np.allclose(moving[:, 0], 1.0 - 3.0 * poses[:, 1], atol=1e-13)
    assert np.allclose(moving[:, 1], -2.0 + 3.0 * poses[:, 0], atol=1e-13)


def test_contradicting_rates_are_refused() -> None:
    with pytest.raises(SceneError, match=r"angular_velocities: found angular velocities of link_0, link_1 .*expected"):
        pinned(2, start={"angular_velocities": {"link_0": 1.0, "link_1": 0.0}})


# Canonical text, places in files, start-up


def test_canonical_text() -> None:
    text = loop(6).canonical()
    assert json.loads(text)["name"] == "loop6"
    assert text == read_tables({"loop": {"links": 6, "length": 1, "mass": [1.0] * 6}}, "x", "loop6").canonical()
    assert text == loop(6, start={"position": [-0.0, 0.0]}).canonical()
    for other in (
        loop(6, gravity=True),
        loop(6, loop={"mass": 2.0}),
        loop(6, start={"tilt": 0.1}),
        loop(6, run={"until": 3.0}),
        loop(6, name="other"),
    ):
        assert other.canonical() != text


def test_locate() -> None:
    text = '''# first line
name = "x" # = [not] a key
"quoted key".inner = 1

[loop]
length = [  # a comment, with ]
  1.0,
  2.0, ]
text = """
[fake]
"""
[[link]]
points = { A = [0, 0], "B" = [1,
  2] }

[[link]]
name = 'y'
[link.more]
z = 1
'''
    lines = locate(text)
    assert lines["name",] == 2
    assert lines["quoted key", "inner"] == 3
    assert lines["loop",] == 5
    assert lines["loop", "length"] == 6
    assert (lines["loop", "length", 0], lines["loop", "length", 1]) == (7, 8)
    assert ("fake",) not in lines
    assert lines["loop", "text"] == 9
    assert lines["link", 0] == 12
    assert lines["link", 0, "points", "B", 1] == 14
    assert lines["link", 1, "name"] == 17
    assert lines["link", 1, "more", "z"] == 19
    assert locate(text.replace("\n", "\r\n")) == lines


def test_scenes_need_no_symbols() -> None:
    code = (
        "import sys, ccgen.generator.cli; from ccgen.generator.scene import loop; loop(6, gravity=True).canonical();"
        "print([m for m in ('sympy', 'scipy', 'networkx', 'matplotlib', 'rich', 'Cython') if m in sys.modules])"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"


@pytest.mark.parametrize(("gravity", "g"), [(True, 9.81), (3.7, 3.7), ({"g": 1.6}, 1.6)], ids=str)
def test_gravity_of_a_standard_mechanism(gravity: object, g: float) -> None:
    """``True`` is the usual value, a number is g, a table is that of a scene file; ``False`` is none."""
    effects = loop(3, gravity=gravity).effects  # type: ignore[arg-type]
    assert [p.value for effect in effects for p in effect.parameters()] == [g]
    assert loop(3, gravity=False).effects == ()


def test_a_keyword_is_no_name(tmp_path: Path) -> None:
    file = tmp_path / "class.toml"
    file.write_text('name = "class"\n[loop]\nlinks = 3\n')
    with pytest.raises(SceneError, match="a word of Python's own"):
        load_scene(file)
