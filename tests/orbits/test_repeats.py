"""A state that comes back is not yet a periodic motion: forces of another period, and coordinates that matter."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import continue_orbit, find_orbit

from ..support.workshop import Workshop

SPEED = 3.0
PERIOD = 2.0 * math.pi / SPEED
TURNED = f"""
name = "turned"
[ground_link]
points = {{ O = [0, 0], W = [-5, 0] }}
[[link]]
name = "crank"
mass = 1.0
inertia = 1.0
com = [0, 0]
points = {{ O = [0, 0], A = [0.2, 0] }}
[[link]]
name = "mass"
mass = 2.0
inertia = 1.0
com = [0, 0]
points = {{ C = [0, 0] }}
[[joint]]
name = "pin"
between = ["ground.O", "crank.O"]
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "mass.C"]
axis = [1, 0]
[[drive]]
name = "motor"
joint = "pin"
speed = {SPEED}
[[spring]]
between = ["crank.A", "mass.C"]
stiffness = 8.0
length = 0.0
[[damper]]
between = ["ground.W", "mass.C"]
damping = 1.2
{{more}}
[start]
slides = {{ guide = 0.5 }}
[run]
until = 20.0
rtol = 1e-12
"""
"""A crank that turns at constant speed draws a mass on a guide along by a spring: m x'' + c x' + k x = k r cos(w t)."""
FORCE = """
[[force]]
point = "mass.C"
vector = ["5*cos(3*t)", 0]
"""


@pytest.fixture(scope="module")
def turned(workshop: Workshop) -> Any:
    return workshop.model(TURNED.replace("{more}", ""), derivatives=True)


def test_a_turn_of_what_turns(turned: Any) -> None:
    """After a turn the crank need not come back: its angle is the same but for the turn."""
    found = find_orbit(turned, section=PERIOD, advances=["crank.angle"])
    response = 8.0 * 0.2 / (8.0 - 2.0 * SPEED**2 + 1.2j * SPEED)
    angle = float(found.q[turned.q_of.index("crank.angle")])
    wanted = response * complex(math.cos(angle), math.sin(angle))
    assert found.q[turned.q_of.index("guide.slide")] == pytest.approx(wanted.real, abs=1e-9)


def test_part_of_a_turn(turned: Any) -> None:
    """After half a turn the mass can be where it was, with the same speed, and goes on otherwise."""
    with pytest.raises(ValueError, match=r"comes back but for crank\.angle, and misses by .* a period later"):
        find_orbit(turned, section=PERIOD / 2.0, advances=["crank.angle"])


def test_a_parameter_that_changes_the_period(turned: Any) -> None:
    """At another speed the time is no turn any more: the branch ends where it begins, and says why."""
    orbit = find_orbit(turned, section=PERIOD, advances=["crank.angle"])
    branch = continue_orbit(orbit, "motor.speed", (2.9, 3.1))
    assert np.ptp(branch.values) <= 1e-5
    assert all("comes back but for crank.angle" in end for end in branch.ends)


@pytest.mark.parametrize("time", [0.7 * PERIOD, PERIOD / 2.0, round(PERIOD, 4)])
def test_a_time_that_is_no_period(time: float, workshop: Workshop) -> None:
    """A state that comes back after it meets other forces there; a period is wanted to all its digits."""
    forced = workshop.model(TURNED.replace("{more}", FORCE), derivatives=True)
    with pytest.raises(ValueError, match=r"^section: found .* s, after which forces are not what they were: they"):
        find_orbit(forced, section=time, advances=["crank.angle"])
    assert find_orbit(forced, section=PERIOD, advances=["crank.angle"]).missed <= 1e-9
