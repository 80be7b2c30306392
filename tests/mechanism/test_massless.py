"""Links without mass, point masses, and motions that nothing resists."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ccgen.runtime import simulate

from ..support.joint_texts import faults, line_of
from ..support.workshop import Workshop

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


BEAD = """\
name = "bead"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "bead"
mass = 1.0
inertia = 0
com = [0, 0]
points = { C = [0, 0] }
[[joint]]
name = "slot"
type = "pin-in-slot"
axis = [0, -1]
between = ["bead.C", "ground.O"]
[gravity]
g = 9.81
"""
"""A point mass whose slot a pin of the ground runs in: polar coordinates, which have no angle at their pole."""


def test_a_point_mass_on_a_pin_is_in_a_slot_that_does_not_turn(tmp_path: Path) -> None:
    """Nothing resists its turning; a prismatic joint has no turning."""
    text = BEAD.replace('["bead.C", "ground.O"]', '["ground.O", "bead.C"]')
    ((_, key, message),) = faults(text, tmp_path)
    assert key == "link[0].inertia" and "make its slot a prismatic joint" in message


def test_a_point_mass_does_not_start_on_the_pin_of_its_own_slot(workshop: Workshop, tmp_path: Path) -> None:
    ((line, key, message),) = faults(BEAD, tmp_path)
    assert (line, key) == (line_of(BEAD, "inertia = 0"), "link[0].inertia")
    assert "a start with a mass on its own pin" in message and "start elsewhere" in message
    model = workshop.model(BEAD + "[start]\nslides = { slot = 0.3 }\nangles = [0.4]\nangular_velocities = [2.0]\n")
    run = simulate(model, until=0.5)
    mass = model.poses(run.q)[-1, 0, :2]
    # it flies freely: 0.3 m above the pin, turned by 0.4, and its speed is across
    out, across = np.array([-np.sin(0.4), np.cos(0.4)]), np.array([-np.cos(0.4), -np.sin(0.4)])
    wanted = 0.3 * out + 0.5 * 0.3 * 2.0 * across - np.array([0.0, 0.5 * 9.81 * 0.25])
    assert run.success and mass == pytest.approx(wanted, abs=1e-8)


def test_rods_without_mass_do_not_start_in_line(workshop: Workshop, tmp_path: Path) -> None:
    """A point mass at the end of two rods without mass has nothing that holds it along the line of both."""
    rods = ARM.replace(HEAVY, NOTHING, 1).replace(HEAVY, "mass = 1.0\ninertia = 0\ncom = [1, 0]", 1)
    straight = faults(rods, tmp_path)
    assert {key for _, key, _ in straight} == {"link[0].mass", "link[1].inertia"}
    assert all("links in line" in message for _, _, message in straight)
    model = workshop.model(rods + "[start]\nangles = [0.3, 1.2]\n")
    # nothing but gravity acts on the mass
    q, u = model.start()
    u_dot = model.acceleration(q, u)
    hand = sum(np.array([-np.sin(a), np.cos(a)]) * w for a, w in zip(q, u_dot, strict=True))
    assert hand == pytest.approx([0.0, -9.81], abs=1e-13)


def test_inertia_without_mass_is_refused(tmp_path: Path) -> None:
    ((_, key, message),) = faults(second(ARM, "mass = 1.0\n", "mass = 0\n"), tmp_path)
    assert key == "link[1].inertia" and "expected 0 for a link without mass" in message
