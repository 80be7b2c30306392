"""Sections behind the impact of a contact, wherever that stands among the contacts of a model."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import continue_orbit, find_orbit

from ..support.folders import ROOT
from ..support.workshop import Workshop

BALL = """
name = "ball"
[[link]]
name = "ball"
mass = 1
inertia = 1
com = [0, 0]
points = { C = [0, 0] }
[start]
velocity = [0, 2]
[gravity]
g = 10
[run]
until = 1.0
rtol = 1e-12
"""
FLOOR = '[[ground]]\nname = "floor"\nrestitution = 1\ncontacts = ["ball.C"]\n'
WALL = '[[ground]]\nname = "wall"\npoint = [-5, 0]\nnormal = [1, 0]\nrestitution = 1\ncontacts = ["ball.C"]\n'

SWING = """
name = "swing"
[ground_link]
points = { O = [0, 0], W = [-1, 0] }
[[link]]
name = "mass"
mass = 2.0
inertia = 1.0
com = [0, 0]
points = { C = [0, 0] }
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "mass.C"]
axis = [1, 0]
[[spring]]
between = ["ground.W", "mass.C"]
stiffness = 8.0
length = 1.1
[start]
slides = { guide = -0.2 }
[run]
until = 20.0
rtol = 1e-12
"""
FAR = '[[ground]]\nname = "far"\npoint = [-30, 0]\nnormal = [1, 0]\nrestitution = 1\ncontacts = ["mass.C"]\n'
STOP = '[[stop]]\njoint = "guide"\nhighest = 0.1\nrestitution = 1\n'


@pytest.fixture
def woodpecker(workshop: Workshop) -> Any:
    return workshop.model(load_scene(ROOT / "scenes" / "gallery" / "woodpecker.toml"), derivatives=True)


def test_each_contact_is_closed_or_open_by_itself(woodpecker: Any) -> None:
    """Of configurations in which one edge of the sleeve, or the beak, touches the pole."""
    model = woodpecker
    q = model.start()[0]
    gaps, sleeve, bird = model.gaps(q), model.q_of.index("sleeve.angle"), model.q_of.index("bird.angle")
    states = np.tile(q, (3, 1))
    for row, (contact, coordinate) in zip(states, ((0, sleeve), (1, sleeve), (2, bird)), strict=True):
        for _ in range(50):  # Newton's method by differences, on one gap
            h = 1e-7
            slope = (model.gaps(row + h * np.eye(len(q))[coordinate]) - model.gaps(row))[contact] / h
            row[coordinate] -= model.gaps(row)[contact] / slope
    assert np.all(gaps > 0.0)
    found = model.kernels.closed(np.vstack([q[None], states]))
    assert found.shape == (4, 3)
    assert found[0].tolist() == [False, False, False]
    assert found[3].tolist() == [False, False, True]
    assert found[1, 0] and found[2, 1] and not found[1:3, 2].any()


@pytest.mark.parametrize("first", [FLOOR, WALL])
def test_a_ball_beside_a_wall_that_it_never_touches(first: str, workshop: Workshop) -> None:
    """Behind the impact on the floor all but the height is free: five multipliers of 1, and in a period of 2 v / g the
    place and the angle move on by it with their rates."""
    text = BALL + first + (WALL if first is FLOOR else FLOOR)
    model = workshop.model(text, derivatives=True)
    found = find_orbit(model, section=("ball.C", "floor"))
    assert found.period == pytest.approx(0.4, abs=1e-12)
    assert found.basis.shape == (6, 5)
    assert np.abs(found.multipliers - 1.0).max() <= 1e-7  # of double roots: the root of 1e-14
    x, angle = (model.q_of.index(f"ball.{name}") for name in ("x", "angle"))
    moved = found.basis @ found.matrix @ np.linalg.pinv(found.basis)
    assert moved[[x, angle], [6 // 2 + x, 6 // 2 + angle]] == pytest.approx([0.4, 0.4], abs=1e-10)


@pytest.mark.parametrize("parts", [STOP + FAR, FAR + STOP])
def test_a_stop_beside_a_ground(parts: str, workshop: Workshop) -> None:
    """On a spring without a damper, thrown back where the spring is slack: half a period of the free motion, whatever
    the speed, so that the multiplier is 1."""
    model = workshop.model(SWING + parts, derivatives=True)
    section = next(contact for contact in model.contacts if contact[1] != "far")
    found = find_orbit(model, section=section)
    assert found.period == pytest.approx(math.pi / 2.0, abs=1e-9)
    assert found.multipliers == pytest.approx([1.0], abs=1e-9)


def test_the_woodpecker_is_as_stable_behind_its_peck_as_anywhere(woodpecker: Any) -> None:
    """Multipliers are those of the motion, not of the section: the beak's impact, and an angle on the way."""
    pecks = find_orbit(woodpecker, section=("bird.beak", "peck"), advances=["pole.slide"])
    turns = find_orbit(woodpecker, section=("bird.angle", -0.2), advances=["pole.slide"])
    assert pecks.period == pytest.approx(turns.period, rel=1e-9)
    assert pecks.multipliers[0] == pytest.approx(turns.multipliers[0], rel=1e-7)
    assert np.abs(pecks.multipliers[1:]).max() < 1e-9
    # nothing is held shut there but the beak: the sleeve hangs free between the pole's sides
    assert pecks.basis.shape == (6, 4)
    assert pecks.return_map.at(pecks.q, pecks.u).kept.gaps == (2,)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_the_woodpecker_is_found_from_beside_its_motion(way: float, woodpecker: Any) -> None:
    found = find_orbit(woodpecker, section=("bird.beak", "peck"), advances=["pole.slide"])
    model = woodpecker
    bird, q, u = model.q_of.index("bird.angle"), found.q.copy(), found.u.copy()
    q[bird] -= 1e-4  # the beak away from the pole
    u[bird] *= 1.0 + 1e-4 * way
    assert model.gaps(q)[2] > 1e-6
    again = find_orbit(model, q, u, section=("bird.beak", "peck"), advances=["pole.slide"])
    assert again.period == pytest.approx(found.period, rel=1e-9)


@pytest.mark.hard
def test_the_woodpecker_is_followed_along_its_friction(woodpecker: Any) -> None:
    """To another coefficient, where a search of its own finds the same motion."""
    found = find_orbit(woodpecker, section=("bird.beak", "peck"), advances=["pole.slide"])
    branch = continue_orbit(found, "peck.friction", (0.29, 0.31))
    assert len(branch.values) > 2 and branch.values.min() < 0.295 and branch.values.max() > 0.305
    for value, period in zip(branch.values, (orbit.period for orbit in branch.orbits), strict=True):
        other = find_orbit(
            woodpecker,
            section=("bird.beak", "peck"),
            advances=["pole.slide"],
            params={"peck.friction": float(value)},
        )
        assert other.period == pytest.approx(period, rel=1e-8)
