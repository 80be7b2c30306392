"""Periodic motions: against closed forms of the orbit and of its multipliers, and against differences of runs."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import find_orbit, simulate

from ..support.shaken_table import RADIUS, SHAKEN, TABLE
from ..support.workshop import Workshop

SWING = """
name = "shaken"
[let]
w = 3.0
[ground_link]
points = {{ O = [0, 0], W = [-1, 0] }}
[[link]]
name = "mass"
mass = 2.0
inertia = 1.0
com = [0, 0]
points = {{ C = [0, 0] }}
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "mass.C"]
axis = [1, 0]
[[spring]]
between = ["ground.W", "mass.C"]
stiffness = 8.0
length = 1.0
[[damper]]
between = ["ground.W", "mass.C"]
damping = 1.2
[[force]]
point = "mass.C"
vector = ["5*cos(w*t)", 0]
{more}
[run]
until = 20.0
rtol = 1e-12
"""
PERIOD = 2.0 * math.pi / 3.0


def test_a_shaken_mass_on_a_spring(workshop: Workshop) -> None:
    """m x'' + c x' + k x = F cos(w t): its motion and multipliers, exp of the roots times the period."""
    model = workshop.model(SWING.format(more=""), derivatives=True)
    found = find_orbit(model, [0.3], [-1.0], section=PERIOD)
    response = 5.0 / (8.0 - 2.0 * 9.0 + 1.2j * 3.0)
    assert found.q[0] == pytest.approx(response.real, abs=1e-10)
    assert found.u[0] == pytest.approx((3.0j * response).real, abs=1e-10)
    roots = np.exp(np.roots([2.0, 1.2, 8.0]) * PERIOD)
    assert np.sort_complex(found.multipliers) == pytest.approx(np.sort_complex(roots), abs=1e-10)
    assert found.stable and found.missed <= 1e-11 and found.period == PERIOD
    assert found.runs <= 4  # the map is linear


def test_half_a_period_with_its_mirror_image(workshop: Workshop) -> None:
    """The shaken mass is after half a period where its mirror image was: the same motion, by a map of half the time."""
    model = workshop.model(SWING.format(more=""), derivatives=True)
    response = 5.0 / (8.0 - 2.0 * 9.0 + 1.2j * 3.0)
    found = find_orbit(model, [0.3], [-1.0], section=PERIOD / 2.0, relabel=(-np.eye(2), np.zeros(2)))
    assert found.q[0] == pytest.approx(response.real, abs=1e-10)
    roots = -np.exp(np.roots([2.0, 1.2, 8.0]) * PERIOD / 2.0)
    assert np.sort_complex(found.multipliers) == pytest.approx(np.sort_complex(roots), abs=1e-10)


@pytest.mark.parametrize("phase", ["stable", "unstable"])
def test_a_ball_on_a_shaken_table(phase: str, workshop: Workshop) -> None:
    """Once a period: its phase, and the matrix of its impacts, by hand; the unstable one too.

    At the impact the table's speed is (1 - e) / (1 + e) g T / 2, and the matrix of (time, speed) has the determinant
    e^2 and the trace 1 + e^2 + (1 + e)^2 a / g, a being the table's acceleration.
    """
    e, g, A, w = TABLE.restitution, TABLE.gravity, TABLE.amplitude, TABLE.frequency
    T = 2.0 * math.pi / w
    speed = (1.0 - e) / (1.0 + e) * g * T / 2.0
    angle = math.acos(speed / (A * w)) * (1.0 if phase == "stable" else -1.0)
    struck = angle / w % T
    model = workshop.model(SHAKEN, derivatives=True)
    rate = g * T / 2.0  # behind the impact, over a table at the height it has there
    since = (T - struck) % T
    height = A * math.sin(angle) + rate * since - g * since**2 / 2.0
    slide = [model.q_of.index(name) for name in ("shaker.slide", "fall.slide")]
    q, u = np.zeros(2), np.zeros(2)
    q[slide[1]], u[slide] = height + 1.1 * RADIUS, (A * w, rate - g * since + 0.01)  # not quite there
    found = find_orbit(model, q, u, section=T, rtol=1e-12)
    assert found.q[slide[1]] == pytest.approx(height + RADIUS, abs=1e-10)
    assert found.u[slide[1]] == pytest.approx(rate - g * since, abs=1e-9)
    assert found.run.impacts[0].t == pytest.approx(struck, abs=1e-10)
    trace = 1.0 + e**2 - (1.0 + e) ** 2 * A * w**2 * math.sin(angle) / g
    assert np.sort_complex(found.multipliers) == pytest.approx(np.sort_complex(np.roots([1.0, -trace, e**2])), abs=1e-8)
    assert found.stable == (phase == "stable")


def test_a_mass_against_a_stop_beside_differences(workshop: Workshop) -> None:
    """The shaken mass strikes a wall once a period: multipliers of differences of runs from beside it."""
    stop = '[[ground]]\npoint = [0.2, 0]\nnormal = [-1, 0]\nrestitution = 0.6\ncontacts = ["mass.C"]\n'
    model = workshop.model(SWING.format(more=stop), derivatives=True)
    begun = simulate(model, [0.0], [0.0], until=40 * PERIOD)
    assert begun.success
    found = find_orbit(model, begun.q[-1], begun.u[-1], section=PERIOD)
    assert len(found.run.impacts) == 1 and found.stable
    columns, h = [], 1e-5
    for k in range(2):
        ends = []
        for sign in (1.0, -1.0):
            x = np.array([found.q[0], found.u[0]])
            x[k] += sign * h
            run = simulate(model, x[:1], x[1:], until=PERIOD)
            ends.append(np.array([run.q[-1, 0], run.u[-1, 0]]))
        columns.append((ends[0] - ends[1]) / (2.0 * h))
    wanted = np.linalg.eigvals(np.array(columns).T)
    assert np.sort_complex(found.multipliers) == pytest.approx(np.sort_complex(wanted), abs=1e-6)
    # what an impact does to an area in (x, v) is e^2, whatever comes before
    area = 0.6**2 * math.exp(-1.2 / 2.0 * PERIOD)
    assert np.prod(found.multipliers) == pytest.approx(area, abs=1e-9)


def test_a_ball_that_bounces_for_ever_is_one_of_a_family(workshop: Workshop) -> None:
    """Behind its impact, with e = 1: period 2 v / g, and the multiplier of the speed is 1. It goes on to the side."""
    ball = '[[link]]\nname = "ball"\nmass = 1\ninertia = 1\ncom = [0, 0]\npoints = { C = [0, 0] }\n'
    text = 'name = "ball"\n' + ball + "[start]\nvelocity = [1, 2]\n[gravity]\ng = 10\n"
    text += '[[ground]]\nrestitution = 1\ncontacts = ["ball.C"]\n[run]\nuntil = 1.0\nrtol = 1e-12\n'
    model = workshop.model(text, derivatives=True)
    section = model.contacts[0]
    found = find_orbit(model, section=section, advances=["ball.x"])
    assert found.period == pytest.approx(0.4, abs=1e-12)
    rates = found.basis[len(found.q) :]
    assert np.abs(found.multipliers - 1.0).max() <= 1e-9 and rates.shape[1] == found.matrix.shape[0]
    assert not found.stable


@pytest.mark.parametrize("start", [-0.7, -0.2, 0.05])
def test_a_mass_that_bounces_off_a_wall_from_any_start(start: float, workshop: Workshop) -> None:
    """On a spring without a damper, e = 1: half a period of the free motion between impacts, whatever the speed, where
    the wall is at the place of rest. The start need not be on the section."""
    bare = SWING.replace('[[force]]\npoint = "mass.C"\nvector = ["5*cos(w*t)", 0]\n', "")
    bare = bare.replace('[[damper]]\nbetween = ["ground.W", "mass.C"]\ndamping = 1.2\n', "")
    wall = '[[ground]]\npoint = [0.1, 0]\nnormal = [-1, 0]\nrestitution = 1\ncontacts = ["mass.C"]\n'
    model = workshop.model(bare.format(more=wall).replace("length = 1.0", "length = 1.1"), derivatives=True)
    found = find_orbit(model, [start], [0.0], section=model.contacts[0])
    assert found.period == pytest.approx(math.pi / math.sqrt(8.0 / 2.0), abs=1e-9)
    assert found.multipliers == pytest.approx([1.0], abs=1e-9)
    assert abs(found.u[0]) == pytest.approx(2.0 * (0.1 - start), abs=1e-9)


STRUCK = SWING.format(
    more="[[ground]]\nname = 'anvil'\npoint = [0.05, 0]\nnormal = [-1, 0]\nrestitution = 0.7\ncontacts = ['mass.C']"
)
"""With a wall 5 cm ahead of where the mass rests."""


def test_a_state_of_the_search_is_not_the_users(workshop: Workshop) -> None:
    """A step of Newton's method that leads into the wall tells the guess, where it led, and by how much that is
    inside; the guess itself may well be outside."""
    model = workshop.model(STRUCK, derivatives=True)
    guess = [-0.38], [-2.1]
    with pytest.raises(ValueError, match=r"from the guess guide\.slide = -0\.38 m, ") as caught:
        find_orbit(model, *guess, section=PERIOD)
    text = str(caught.value)
    led = re.search(r"step (\d+) of Newton's method led to guide.slide = (\S+) m, guide.slide_rate", text)
    inside = re.search(r"the start has mass.C inside anvil by (\S+) m; begin nearer to the motion", text)
    assert led and inside and int(led[1]) >= 1
    assert float(led[2]) - 0.05 == pytest.approx(float(inside[1]), rel=1e-4)
    assert "move the start" not in text
    with pytest.raises(ValueError, match="raise or move the start"):  # this one is the user's
        find_orbit(model, [0.06], [0.0], section=PERIOD)


def test_a_contact_section_needs_a_model_without_time(workshop: Workshop) -> None:
    wall = '[[ground]]\npoint = [0.2, 0]\nnormal = [-1, 0]\nrestitution = 0.6\ncontacts = ["mass.C"]\n'
    model = workshop.model(SWING.format(more=wall), derivatives=True)
    with pytest.raises(ValueError, match="found a contact in a model that depends on time, expected the period"):
        find_orbit(model, section=model.contacts[0])


def test_all_that_is_wrong_is_told_at_once(workshop: Workshop) -> None:
    model = workshop.model(SWING.format(more=""), derivatives=True)
    wrong: dict[str, Any] = {"section": ("mass.C", "ground_0"), "crossings": 0, "advances": ["mass.y"], "most": 0}
    with pytest.raises(ValueError) as caught:
        find_orbit(model, relabel=(np.eye(3), np.zeros(3)), **wrong)
    for part in (
        "expected a time, or one of the contacts there are none",
        "crossings: found 0",
        "mass.y",
        "most: found",
    ):
        assert part in str(caught.value), str(caught.value)
    assert "relabel: found shapes (3, 3) and (3,), expected finite numbers (2, 2) and (2,)" in str(caught.value)
    with pytest.raises(ValueError, match=r"section: found -1\.0, expected a time in s above 0"):
        find_orbit(model, section=-1.0)
    with pytest.raises(ValueError, match="found a model without derivatives"):
        find_orbit(workshop.model(SWING.format(more="")), section=PERIOD)
