"""Welds, links without mass, rings of sliders, and what is said about joints that make no sense."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.generator.scene import SceneError
from ccgen.runtime import driving_torque, inverse_dynamics, simulate

from .conftest import Workshop
from .oracles.maximal import Array

SCENES = Path(__file__).parents[1] / "scenes"


def scene(name: str, *changes: tuple[str, str]) -> str:
    """The text of a scene with parts of it replaced, each once."""
    text = (SCENES / f"{name}.toml").read_text()
    for old, new in changes:
        assert text.count(old) >= 1, old
        text = text.replace(old, new, 1)
    return text


def faults(text: str, folder: Path) -> list[tuple[int | None, str, str]]:
    """Line, key and message of everything that is wrong with a scene."""
    path = folder / "scene.toml"
    path.write_text(text)
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    assert str(caught.value).startswith(f"{path}:")
    return [(fault.line, fault.key, fault.message) for fault in caught.value.faults]


def line_of(text: str, part: str) -> int:
    return text[: text.index(part)].count("\n") + 1


# -- welds -------------------------------------------------------------------------------------------------------------

PLATES = """\
name = "plates"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "one"
mass = 2.0
inertia = 0.3
com = [0.5, 0.1]
points = { O = [0, 0], A = [1, 0] }
[[link]]
name = "two"
mass = 3.0
inertia = 0.4
com = [0.2, -0.3]
points = { A = [0.1, 0.2], B = [1, 1] }
[[link]]
name = "three"
mass = 1.5
inertia = 0.2
com = [0.3, 0]
points = { B = [0, 0], C = [0.4, 0] }
[[joint]]
name = "hinge"
between = ["ground.O", "one.O"]
[[joint]]
name = "first"
type = "weld"
between = ["one.A", "two.A"]
angle = "30 deg"
[[joint]]
name = "second"
type = "weld"
between = ["three.B", "two.B"]
angle = "-100 deg"
[gravity]
g = 9.81
"""
"""Three links in one piece; the second weld names the outer link first."""


def composite() -> tuple[float, complex, float]:
    """Mass, mass centre and inertia of the plates in the frame of the first, by parallel axes."""
    turn = [1.0, np.exp(1j * np.pi / 6.0), np.exp(1j * np.pi * (1.0 / 6.0 + 5.0 / 9.0))]
    place = [0j, 1.0 - turn[1] * (0.1 + 0.2j), 0j]
    place[2] = place[1] + turn[1] * (1.0 + 1.0j)
    masses, inertias = (2.0, 3.0, 1.5), (0.3, 0.4, 0.2)
    centres = [p + t * c for p, t, c in zip(place, turn, (0.5 + 0.1j, 0.2 - 0.3j, 0.3), strict=True)]
    centre = sum(m * z for m, z in zip(masses, centres, strict=True)) / sum(masses)
    inertia = sum(i + m * abs(z - centre) ** 2 for i, m, z in zip(inertias, masses, centres, strict=True))
    return sum(masses), centre, inertia


def test_welded_links_are_one_body(workshop: Workshop) -> None:
    model = workshop.model(PLATES)
    mass, centre, inertia = composite()
    assert list(model.links) == ["one"] and list(model.joints) == ["hinge"]
    found = [model.parameters[f"one.{key}"] for key in ("mass", "com.x", "com.y", "inertia")]
    assert np.allclose(found, [mass, centre.real, centre.imag, inertia], rtol=1e-14, atol=0.0)
    about_hinge = inertia + mass * abs(centre) ** 2
    for angle in (0.0, 0.7, -2.5):
        moment = -mass * 9.81 * (centre * np.exp(1j * angle)).real
        assert model.acceleration([angle], [1.3]) == pytest.approx([moment / about_hinge], rel=1e-13)


def test_a_point_of_a_welded_link_keeps_its_name_in_effects(workshop: Workshop) -> None:
    """A force on three.C, whose place follows from both welds, turns the body about the hinge."""
    model = workshop.model(PLATES + '[[force]]\npoint = "three.C"\nvector = [0.0, 5.0]\n')
    mass, centre, inertia = composite()
    turn = np.exp(1j * np.pi / 6.0)
    place = 1.0 - turn * (0.1 + 0.2j) + turn * (1.0 + 1.0j) + 0.4 * turn * np.exp(1j * np.pi * 5.0 / 9.0)
    wanted = (5.0 * place.real - mass * 9.81 * centre.real) / (inertia + mass * abs(centre) ** 2)
    assert model.acceleration([0.0], [0.0]) == pytest.approx([wanted], rel=1e-13)


def test_what_is_welded_to_the_ground_does_not_move(workshop: Workshop) -> None:
    """A pendulum on a bracket that is welded to the ground at 30 degrees hangs from the bracket's end."""
    text = (
        PLATES.replace('name = "hinge"\nbetween', 'name = "hinge"\ntype = "weld"\nangle = "30 deg"\nbetween')
        .replace('name = "first"\ntype = "weld"', 'name = "first"')
        .replace('between = ["one.A", "two.A"]\nangle = "30 deg"', 'between = ["one.A", "two.A"]')
    )
    model = workshop.model(text)
    assert list(model.links) == ["two"] and list(model.joints) == ["first", "second"][:1]
    end = np.exp(1j * np.pi / 6.0)
    assert model.point("first", model.start()[0]) == pytest.approx([end.real, end.imag], abs=1e-15)


def test_a_ring_of_welds_may_agree_and_may_not_contradict_itself(tmp_path: Path) -> None:
    turn = np.exp(1j * np.pi / 6.0)
    place = 1.0 - turn * (0.1 + 0.2j) + turn * (1.0 + 1.0j)
    ring = PLATES.replace("A = [1, 0] }", f"A = [1, 0], B = [{float(place.real)!r}, {float(place.imag)!r}] }}")
    third = '[[joint]]\nname = "third"\ntype = "weld"\nbetween = ["one.B", "three.B"]\nangle = '
    (tmp_path / "good.toml").write_text(ring + third + '"130 deg"\n')
    assert len(load_scene(tmp_path / "good.toml").mechanism.links) == 1
    text = ring + third + '"131 deg"\n'
    ((line, key, message),) = faults(text, tmp_path)
    assert (line, key) == (line_of(text, third), "joint[3]")
    assert "misses by" in message and "0.0175 rad" in message and "remove it" in message


def test_all_links_welded_to_the_ground_are_refused(tmp_path: Path) -> None:
    text = PLATES.replace('name = "hinge"\nbetween', 'name = "hinge"\ntype = "weld"\nbetween')
    ((_, key, message),) = faults(text, tmp_path)
    assert key == "joint" and "all links welded to the ground" in message


# -- links without mass ------------------------------------------------------------------------------------------------

ARM = """\
name = "arm"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "upper"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { O = [0, 0], A = [1, 0] }
[[link]]
name = "lower"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0], B = [1, 0] }
[[joint]]
name = "shoulder"
between = ["ground.O", "upper.O"]
[[joint]]
name = "elbow"
between = ["upper.A", "lower.A"]
[gravity]
g = 9.81
"""
HEAVY = "mass = 1.0\ninertia = 0.1\ncom = [0.5, 0]"
NOTHING = "mass = 0\ninertia = 0\ncom = [0.5, 0]"


def second(text: str, old: str, new: str) -> str:
    """The second of two occurrences replaced."""
    head, tail = text.split(old, 1)
    return head + old + tail.replace(old, new, 1)


def test_a_rod_without_mass_carries_a_body(workshop: Workshop) -> None:
    """A massless upper arm with a point mass in its hand: a double pendulum of one rod, one length fixed."""
    text = ARM.replace(HEAVY, NOTHING, 1)
    model = workshop.model(text)
    q, u = np.array([-0.4, 0.9]), np.array([1.1, -0.7])
    c, s = np.cos(q[0] - q[1]), np.sin(q[0] - q[1])
    mass = np.array([[1.0, 0.5 * c], [0.5 * c, 0.1 + 0.25]])
    right = np.array([-0.5 * s * u[1] ** 2 - 9.81 * np.cos(q[0]), 0.5 * s * u[0] ** 2 - 9.81 * 0.5 * np.cos(q[1])])
    assert model.acceleration(q, u) == pytest.approx(np.linalg.solve(mass, right), rel=1e-13)
    assert "upper.mass" not in model.parameters


def test_a_point_mass_swings_as_a_mathematical_pendulum(workshop: Workshop) -> None:
    bob = '[[link]]\nname = "bob"\nmass = 2.0\ninertia = 0\ncom = [0.8, 0]\npoints = { O = [0, 0] }\n'
    text = 'name = "bob"\n[ground_link]\npoints = { O = [0, 0] }\n' + bob
    model = workshop.model(text + '[[joint]]\nbetween = ["ground.O", "bob.O"]\n[gravity]\ng = 9.81\n')
    assert model.acceleration([0.3], [2.0]) == pytest.approx([-9.81 / 0.8 * np.cos(0.3)], rel=1e-14)


@pytest.mark.parametrize(
    ("text", "key", "words"),
    [
        (second(ARM, HEAVY, NOTHING), "link[1].mass", "found a mass of 0"),
        (second(ARM, HEAVY, "mass = 1.0\ninertia = 0\ncom = [0, 0]"), "link[1].inertia", "inertia of 0"),
        (ARM.replace(HEAVY, NOTHING), "link[1].mass", "found a mass of 0"),
    ],
    ids=["tip without mass", "point mass on its own pin", "nothing has mass"],
)
def test_what_nothing_resists_is_refused(text: str, key: str, words: str, tmp_path: Path) -> None:
    found = faults(text, tmp_path)
    message = {at: message for _, at, message in found}[key]
    assert words in message
    assert "nothing else resists this link's motion" in message and "weld it to a neighbour" in message
    lines = {at: line for line, at, _ in found}
    assert lines[key] is not None and lines[key] > line_of(text, 'name = "lower"')


def test_inertia_without_mass_is_refused(tmp_path: Path) -> None:
    ((_, key, message),) = faults(second(ARM, "mass = 1.0\n", "mass = 0\n"), tmp_path)
    assert key == "link[1].inertia" and "expected 0 for a link without mass" in message


# -- prismatic joints --------------------------------------------------------------------------------------------------

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


# -- what is said ------------------------------------------------------------------------------------------------------

AXIS = "axis = [1, 0]\n\n[start]"
CRANK_PIN = 'between = ["crank.B", "rod.A"]\n'
FLOOR = '[[ground]]\npoint = [0, -1]\nrestitution = 0.5\ncontacts = ["guide"]\n'
SAID: dict[str, tuple[tuple[str, str], str, tuple[str, ...]]] = {
    "axis missing": ((AXIS, "[start]"), "joint[3].axis", ("missing", "[x, y] or an angle", "add it")),
    "axis zero": ((AXIS, AXIS.replace("1, 0", "0, 0")), "joint[3].axis", ("not both zero", "write [1, 0]")),
    "axis of three": ((AXIS, AXIS.replace("1, 0", "1, 0, 0")), "joint[3].axis", ("[1, 0, 0]", "write 2 values")),
    "axis no angle": ((AXIS, 'axis = "ten deg"\n[start]'), "joint[3].axis", ('found "ten deg"', '"30 deg"')),
    "axis at a pin": ((CRANK_PIN, CRANK_PIN + "axis = [1, 0]\n"), "joint[1].axis", ("at a revolute joint", "remove")),
    "angle at a pin": ((CRANK_PIN, CRANK_PIN + "angle = 0.3\n"), "joint[1].angle", ("at a revolute joint", "remove")),
    "axis at a weld": (
        (CRANK_PIN, CRANK_PIN + 'type = "weld"\naxis = [1, 0]\n'),
        "joint[1].axis",
        ("at a weld joint", "prismatic or pin-in-slot"),
    ),
    "angle at a slot": (
        ('type = "prismatic"', 'type = "pin-in-slot"\nangle = 0.1'),
        "joint[3].angle",
        ("at a pin-in-slot joint", "remove it"),
    ),
    "angle no angle": ((AXIS, 'angle = "wide"\n' + AXIS), "joint[3].angle", ('found "wide"', '"30 deg"')),
    "unknown type": (('"prismatic"', '"cylindrical"'), "joint[3].type", ('found "cylindrical"', '"pin-in-slot"')),
    "slide of nothing": (("{ guide = 0.68 }", "{ giude = 0.68 }"), "start.slides.giude", ("expected one of guide",)),
    "slide of a pin": (("{ guide = 0.68 }", "{ motor = 0.68 }"), "start.slides.motor", ("unknown sliding joint",)),
    "slide no number": (("{ guide = 0.68 }", '{ guide = "far" }'), "start.slides.guide", ('found "far"', "quotes")),
    "slide not finite": (("{ guide = 0.68 }", "{ guide = inf }"), "start.slides.guide", ("found inf", "finite")),
    "speeds disagree": (
        ("crank = 12.0 }", "crank = 12.0 }\nsliding_velocities = { guide = 1.0 }"),
        "start.sliding_velocities",
        ("crank, guide", "m/s", "give fewer"),
    ),
    "speed of a pin": (
        ("angular_velocities = { crank", "sliding_velocities = { motor"),
        "start.sliding_velocities.motor",
        ("expected one of guide",),
    ),
    "torque on a slide": (
        ("[gravity]", '[[motor]]\njoint = "guide"\ntorque = 1\n[gravity]'),
        "motor[0].torque",
        ("slides along a line", "write force"),
    ),
    "force on a pin": (
        ("[gravity]", '[[motor]]\njoint = "motor"\nforce = 1\n[gravity]'),
        "motor[0].force",
        ("at a joint that turns", "write torque"),
    ),
    "friction of both kinds": (
        ("[gravity]", "[[joint_friction]]\nviscous = 1\n[gravity]"),
        "joint_friction[0]",
        ("joints that turn and joints that slide", "a second table"),
    ),
    "ground under the ground's point": (
        ('["ground.O", "slider.C"]\naxis = [1, 0]\n', '["slider.C", "ground.O"]\naxis = [1, 0]\n' + FLOOR),
        "ground[0].contacts[0]",
        ("guide is the ground's point O", "as slider.C"),
    ),
    "torsion where nothing turns": (
        ("[gravity]", '[[torsion]]\njoint = "guide"\nstiffness = 1\n[gravity]'),
        "torsion[0].joint",
        ('found "guide"', "does not turn"),
    ),
}
"""A change to the slider-crank, the key that it is said about, words of the message."""


@pytest.mark.parametrize("case", SAID)
def test_what_makes_no_sense_is_said(case: str, tmp_path: Path) -> None:
    change, key, words = SAID[case]
    text = scene("slider-crank", change)
    ((line, found, message),) = faults(text, tmp_path)
    assert found == key
    assert line is not None and 1 <= line <= text.count("\n")
    for word in words:
        assert word in message


def test_a_pin_between_welded_links_is_refused(tmp_path: Path) -> None:
    text = scene("massless-coupler", ('["crank.B", "coupler.A"]', '["crank.B", "counterweight.E"]'))
    ((line, key, message),) = faults(text, tmp_path)
    assert (line, key) == (line_of(text, '["crank.B", "counterweight.E"]'), "joint[2].between")
    assert "welded together" in message and "remove the joint or a weld" in message


@pytest.mark.parametrize(
    ("table", "key", "words"),
    [
        ('[[motor]]\njoint = "seat"\ntorque = 1\n', "motor[0].joint", "it is a weld, whose links do not move"),
        (FLOOR.replace("guide", "seat"), "ground[0].contacts[0]", "it is a weld, which is no joint of the mechanism"),
    ],
)
def test_a_weld_is_no_joint_for_effects(table: str, key: str, words: str, tmp_path: Path) -> None:
    ((_, found, message),) = faults(scene("massless-coupler") + table, tmp_path)
    assert found == key and words in message


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


def test_a_name_that_welding_makes_twice_is_refused(tmp_path: Path) -> None:
    text = scene("massless-coupler", ("B = [0.2, 0] }", "B = [0.2, 0], counterweight_E = [1, 1] }"))
    ((_, key, message),) = faults(text, tmp_path)
    assert key == "link[1].points.E" and "counterweight_E" in message and "rename it" in message


def test_the_command_line_says_it_too(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(scene("slider-crank", (AXIS, "[start]")))
    call = [sys.executable, "-c", "from ccgen.generator.cli import main; main()", "--scene", str(path)]
    done = subprocess.run(call, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 2 and "joint[3].axis: missing" in done.stderr
    assert list(tmp_path.iterdir()) == [path]


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
