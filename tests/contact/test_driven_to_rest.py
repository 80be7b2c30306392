"""Bodies that driven joints hold where they touch a ground: no force there does anything, and the motion goes on."""

from __future__ import annotations

import re

import numpy as np
import pytest

from ccgen.runtime import simulate

from ..support.workshop import Workshop

METHODS = ("gauss", "dop853", "dopri5", "radau")

RAM = """
name = "ram"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "ram"
mass = 2
inertia = 0.1
com = [0, 0]
points = { C = [0, 0], P = [-0.1, 0], Q = [0.1, 0] }
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "ram.C"]
axis = [0, 1]
[[drive]]
joint = "guide"
position = { rows = [ROWS], order = 5 }
[[ground]]
contacts = ["ram.P", "ram.Q"]
restitution = 0.3
FRICTION
[gravity]
[run]
until = 2
"""


def ram(rows: str, begin: float, friction: float | None) -> str:
    text = RAM.replace("ROWS", rows).replace("FRICTION", "" if friction is None else f"friction = {friction}")
    return f"{text}[start]\nslides = {{ guide = {begin} }}\n"


def rise(t: np.ndarray, begin: float, end: float, way: float) -> np.ndarray:
    """The polynomial of degree 5 with neither speed nor acceleration at its ends."""
    part = np.clip((t - begin) / (end - begin), 0.0, 1.0)
    return way * part**3 * (10.0 - 15.0 * part + 6.0 * part**2)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("friction", [None, 0.4])
def test_what_rests_is_lifted_as_prescribed(method: str, friction: float | None, workshop: Workshop) -> None:
    """At rest on the ground it is carried, to the end of a step in which it rises as the polynomial has it; put down to
    rest, it stays."""
    up = simulate(workshop.model(ram("[0.5, 0], [1.5, 0.3]", 0.0, friction)), method=method)
    assert up.success and not up.impacts, up.message
    assert up.q[:, 0] == pytest.approx(rise(up.t, 0.5, 1.5, 0.3), abs=1e-9)
    assert up.phases[0].contacts == (("ram.P", "ground_0"), ("ram.Q", "ground_0"))
    assert up.phases[0].how == ("carried", "carried")
    assert 0.5 < up.phases[0].end < 1.0 and not up.phases[-1].contacts
    down = simulate(workshop.model(ram("[0.5, 0.4], [1.5, 0]", 0.4, friction)), method=method)
    assert down.success and not down.impacts, down.message
    assert down.q[:, 0] == pytest.approx(0.4 - rise(down.t, 0.5, 1.5, 0.4), abs=1e-9)


@pytest.mark.parametrize("friction", [None, 0.4])
def test_what_is_pressed_or_driven_into_the_ground_is_told(friction: float | None, workshop: Workshop) -> None:
    """From rest as soon as it moves, h = 10 w (t - 0.5)³ to the first order; else where it strikes."""
    for rows, begin, when in (("[0.5, 0], [1.5, -0.3]", 0.0, 0.5), ("[0.5, 0.3], [1.5, -0.3]", 0.3, 1.0)):
        run = simulate(workshop.model(ram(rows, begin, friction)))
        assert not run.success and "ram.P is driven into ground_0 by guide" in run.message
        said = re.match(r"stopped at t = (\S+) s: ", run.message)
        assert said and when - 1e-9 <= float(said[1]) < when + 1e-3


GRIPPER = """
name = "gripper"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "carriage"
mass = 2
inertia = 0.01
com = [0, 0]
points = { C = [0, 0] }
[[link]]
name = "left"
rod = { mass = 0.3 }
points = { A = [0, 0], T = [0, -0.2] }
[[link]]
name = "right"
rod = { mass = 0.3 }
points = { A = [0, 0], T = [0, -0.2] }
[[link]]
name = "box"
free = true
plate = { mass = 1, corners = ["P", "Q", "S", "T"] }
points = { P = [-0.05, -0.05], Q = [0.05, -0.05], S = [0.05, 0.05], T = [-0.05, 0.05], L = [-0.05, 0], R = [0.05, 0] }
[[joint]]
name = "lift"
type = "prismatic"
between = ["ground.O", "carriage.C"]
axis = [0, 1]
[[joint]]
name = "slide_left"
type = "prismatic"
between = ["carriage.C", "left.A"]
axis = [1, 0]
[[joint]]
name = "slide_right"
type = "prismatic"
between = ["carriage.C", "right.A"]
axis = [1, 0]
[[joint]]
name = "grip_left"
between = ["left.T", "box.L"]
[[joint]]
name = "grip_right"
type = "pin-in-slot"
axis = [1, 0]
between = ["right.T", "box.R"]
[[hold]]
joint = "grip_left"
within = 1e-5
at = 0.5
[[hold]]
joint = "grip_right"
within = 1e-5
at = 0.5
[[release]]
joint = "grip_left"
at = 2
[[release]]
joint = "grip_right"
at = 2
[[drive]]
joint = "slide_left"
position = { rows = [[0, -0.07], [0.5, -0.05]], order = 5 }
[[drive]]
joint = "slide_right"
position = { rows = [[0, 0.07], [0.5, 0.05]], order = 5 }
[[drive]]
joint = "lift"
position = { rows = [[0.6, 0.25], [1.6, 0.75]], order = 5 }
[[ground]]
contacts = ["box.P", "box.Q"]
restitution = 0.2
friction = 0.5
[gravity]
[start]
open = ["grip_left", "grip_right"]
slides = { lift = 0.25, slide_left = -0.07, slide_right = 0.07 }
poses = { box = [0, 0.05, 0] }
[run]
until = 3
"""


def test_a_gripper_takes_a_box_off_a_rough_floor(workshop: Workshop) -> None:
    """It stands by its weight, is carried where the jaws hold it, rises with them, and falls when let go."""
    run = simulate(workshop.model(GRIPPER))
    assert run.success, run.message
    held = (run.t > 0.5) & (run.t < 2.0)
    height = run.point("box.P").position[:, 1]
    assert height[held] == pytest.approx(rise(run.t[held], 0.6, 1.6, 0.5), abs=1e-9)
    landed = next(impact for impact in run.impacts if impact.t > 1.0 and impact.contacts)
    assert landed.t == pytest.approx(2.0 + np.sqrt(2 * 0.5 / 9.81), abs=1e-8)
    assert abs(height[-1]) < 1e-10
