"""What touches a ground that names no contacts, while joints at one place hold or are open."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import simulate

from ..support.workshop import Workshop

GROUND = "[[ground]]\npoint = [0, 0]\nrestitution = 0.2\nCONTACTS[gravity]\n[run]\nuntil = 0.5\n"
SOFT = GROUND.replace("[[ground]]", "[[compliant_ground]]").replace(
    "restitution = 0.2", "load = 10\ndepth = 0.001\nexponent = 1\ndamping = 0"
)


def scene(joints: str, links: Sequence[str] = "abc", ground: str = GROUND, contacts: str = "") -> str:
    each = "".join(
        f'[[link]]\nname = "{name}"\nrod = {{ mass = 1 }}\npoints = {{ A = [0, 0], B = [1, 0] }}\n' for name in links
    )
    angles = ", ".join(f"{name} = {angle}" for name, angle in zip(links, (0, 0.3, 0.5, 0.7), strict=False))
    return (
        f'name = "ends"\n[ground_link]\npoints = {{ O = [0, 0.5] }}\n{each}{joints}'
        f"[start]\nangles = {{ {angles} }}\n{ground.replace('CONTACTS', contacts)}"
    )


def joint(name: str, one: str, other: str, more: str = "") -> str:
    return f'[[joint]]\nname = "{name}"\nbetween = ["{one}", "{other}"]\n{more}'


def late(name: str) -> str:
    return f'[[release]]\njoint = "{name}"\nat = 5\n'


HELD = joint("p", "ground.O", "a.A")
SHARED = HELD + joint("k", "a.B", "b.A") + joint("j", "a.B", "c.A")
WELD = HELD + joint("k", "a.B", "b.A") + joint("w", "b.A", "c.A", 'type = "weld"\n')
ROW = HELD + joint("k", "a.B", "b.B") + joint("j", "b.B", "c.B")
OWN = joint("p", "ground.O", "a.A") + joint("k", "a.A", "b.A")
BESIDE = joint("hung", "ground.O", "y.A") + joint("elbow", "y.B", "z.A")  # touches whatever changes
# by whether each joint holds, what touches: one point of those that are held together, and each that is not
CASES: list[tuple[str, str, Sequence[str], dict[tuple[int, ...], set[str]]]] = [
    ("lasting and changing", SHARED + late("j"), "j", {(1,): {"k"}, (0,): {"k", "c.A"}}),
    (
        "two that change",
        SHARED + late("k") + late("j"),
        "kj",
        {(1, 1): {"k"}, (1, 0): {"k", "c.A"}, (0, 1): {"k", "b.A"}, (0, 0): {"k", "b.A", "c.A"}},
    ),
    (
        "in a row",
        ROW + late("k") + late("j"),
        "kj",
        {(1, 1): {"k"}, (1, 0): {"k", "c.B"}, (0, 1): {"k", "j"}, (0, 0): {"k", "j", "c.B"}},
    ),
    (
        "a weld on a pin",
        WELD + late("k") + late("w"),
        "kw",
        {(1, 1): {"k"}, (1, 0): {"k", "c.A"}, (0, 1): {"k", "b.A"}, (0, 0): {"k", "b.A", "c.A"}},
    ),
    (
        "on a pin of the ground",
        OWN + BESIDE + late("p") + late("k"),
        "pk",
        {(1, 1): {"elbow"}, (1, 0): {"elbow", "b.A"}, (0, 1): {"elbow", "k"}, (0, 0): {"elbow", "k", "b.A"}},
    ),
]


@pytest.mark.parametrize(("name", "joints", "changing", "expected"), CASES)
def test_what_is_held_together_touches_once(
    name: str, joints: str, changing: str, expected: dict[tuple[int, ...], set[str]], workshop: Workshop
) -> None:
    links = "abyz" if name.endswith("the ground") else "abc"
    model = workshop.model(scene(joints, links))
    for states in product((1, 0), repeat=len(changing)):
        at = model.with_parameters({f"{one}.held": float(held) for one, held in zip(changing, states, strict=True)})
        there = {point for point, _ in at.contacts if (point, "ground_0") not in at.off_contacts}
        assert there == expected[states], (name, states)


def test_a_joint_that_never_lets_go_changes_no_contact(workshop: Workshop) -> None:
    def low(contacts: str, more: str) -> Any:
        run = simulate(workshop.model(scene(SHARED + more, contacts=contacts)))
        assert run.success
        return run.point("a.B").position[:, 1].min()

    assert low("", late("j")) == pytest.approx(low('contacts = ["a.B"]\n', ""), abs=1e-9)
    assert low("", late("j") + late("k")) > -1e-9


def test_a_compliant_ground_presses_once_on_what_is_held_together(workshop: Workshop) -> None:
    joints = HELD + joint("k", "a.B", "b.A")
    plain = simulate(workshop.model(scene(joints, "ab", SOFT)), rtol=1e-10)
    gated = simulate(workshop.model(scene(joints + late("k"), "ab", SOFT)), rtol=1e-10)
    assert gated.success
    ends = [run.point("b.B", [0.45]).position[0] for run in (gated, plain)]
    assert ends[0] == pytest.approx(ends[1], abs=1e-8)
    parted = simulate(workshop.model(scene(joints + late("k").replace("5", "0.1"), "ab", SOFT)), rtol=1e-10)
    times = np.linspace(0.12, 0.5, 39)
    for name, end in (("k", "a.B"), ("b.A", "b.A")):
        told = parted.values(f"compliant_ground_0.{name}.depth", f"compliant_ground_0.{name}.normal", t=times)
        depth, normal = told.values()
        assert depth == pytest.approx(-parted.point(end, times).position[:, 1], abs=1e-9)
        assert np.array_equal(normal > 0.0, depth > 0.0) and (depth > 0.0).any()
    assert abs(parted.energy_drift) < 1e-6


@pytest.mark.parametrize("ends", [("ground.O", "a.A"), ("a.A", "ground.O")])
def test_a_driven_pin_on_the_ground_touches_once_it_is_open(ends: tuple[str, str], workshop: Workshop) -> None:
    text = scene(joint("s", *ends) + BESIDE + late("s"), "ayz") + '[[drive]]\njoint = "s"\nspeed = 1\n'
    model = workshop.model(text)
    assert ("s", "ground_0") not in model.contacts and ("a.A", "ground_0") in model.off_contacts
    assert ("a.A", "ground_0") not in model.with_parameters({"s.held": 0.0}).off_contacts


@pytest.mark.parametrize("ends", [("a.B", "b.B"), ("b.B", "a.B")])
def test_ends_of_a_driven_slide_touch_once_it_is_open(ends: tuple[str, str], workshop: Workshop) -> None:
    slide = joint("s", *ends, 'type = "prismatic"\naxis = [1, 0]\n')
    text = scene(HELD + slide + BESIDE + late("s"), "abyz").replace(", b = 0.3", "")
    model = workshop.model(text + '[[drive]]\njoint = "s"\nspeed = 1\n')
    both = {("a.B", "ground_0"), ("b.B", "ground_0")}
    assert both <= set(model.off_contacts) and not both & set(model.with_parameters({"s.held": 0.0}).off_contacts)


@pytest.mark.parametrize("ends", [("ground.O", "a.A"), ("a.A", "ground.O")])
def test_the_place_of_a_driven_slide_that_has_let_go_moves_as_its_velocity_says(
    ends: tuple[str, str], workshop: Workshop
) -> None:
    slide = joint("s", *ends, 'type = "prismatic"\naxis = [1, 0.3]\n')
    text = scene(slide + late("s").replace("5", "0.1"), "a", "[gravity]\n[run]\nuntil = 0.5\n")
    text = text.replace("[start]\nangles = { a = 0 }\n", "") + '[[drive]]\njoint = "s"\nspeed = "1 + sin(3*t)"\n'
    run = simulate(workshop.model(text), rtol=1e-12)
    t, step = 0.4, 1e-4
    moved = run.values("s.x", "s.y", "s.vx", "s.vy", t=[t - step, t, t + step])
    for axis in "xy":
        slope = (moved[f"s.{axis}"][2] - moved[f"s.{axis}"][0]) / (2 * step)
        assert slope == pytest.approx(moved[f"s.v{axis}"][1], abs=1e-6)
