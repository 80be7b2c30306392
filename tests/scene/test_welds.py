"""Welds: links in one piece, names in it, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ccgen.generator import load_scene

from ..support.joint_texts import FLOOR, faults, line_of, scene
from ..support.workshop import Workshop

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


def test_a_name_that_welding_makes_twice_is_refused(tmp_path: Path) -> None:
    text = scene("massless-coupler", ("B = [0.2, 0] }", "B = [0.2, 0], counterweight_E = [1, 1] }"))
    ((_, key, message),) = faults(text, tmp_path)
    assert key == "link[1].points.E" and "counterweight_E" in message and "rename it" in message
