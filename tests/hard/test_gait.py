"""The simplest walker (M. Garcia, A. Chatterjee, A. Ruina, M. Coleman, Journal of Biomechanical Engineering 120, 1998):
two straight legs on a slope of 0.009, a mass at the hip, feet whose mass goes to zero, g = l = 1.

The strike is an event, phi = 2 theta: straight legs scuff the ground in mid-stance, where a ground would stop them.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import brentq

from ccgen.runtime import simulate

from ..oracles.maximal import Array
from ..support.reach import Reach
from ..support.workshop import Workshop

SLOPE = 0.009
GAIT = np.array([0.20031090054419, -0.19983247300490])
PERIOD = 3.88246375285
FEET = (8e-4, 4e-4, 2e-4, 1e-4)
"""Masses of the feet, whose gaits are continued to feet without mass."""

STANCE = """
name = "stance"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "stance"
mass = 1.0
inertia = 0.0
com = [1.0, 0.0]
points = { foot = [0, 0], hip = [1, 0] }
[[link]]
name = "swing"
mass = 0.001
inertia = 0.0
com = [1.0, 0.0]
points = { hip = [0, 0], foot = [1, 0] }
[[joint]]
between = ["ground.O", "stance.foot"]
[[joint]]
between = ["stance.hip", "swing.hip"]
[start]
angles = { stance = 1.7, swing = -1.3 }
[gravity]
g = 1.0
"""
STRIKE = f"""
name = "strike"
[[link]]
name = "trailing"
mass = 1.001
inertia = 0.000999000999000999
com = [0.999000999000999, 0.0]
points = {{ foot = [0, 0], hip = [1, 0] }}
[[link]]
name = "leading"
mass = 0.001
inertia = 0.0
com = [1.0, 0.0]
points = {{ hip = [0, 0], foot = [1, 0] }}
[[joint]]
between = ["trailing.hip", "leading.hip"]
[gravity]
g = 1.0
[[ground]]
normal = [{math.sin(SLOPE)!r}, {math.cos(SLOPE)!r}]
restitution = 0.0
friction = 1000.0
contacts = ["trailing.foot", "leading.foot"]
"""


def legs(theta: float, phi: float, rates: tuple[float, float]) -> tuple[Array, Array]:
    """Angles of the stance leg, foot to hip, and of the swing leg, hip to foot, counter-clockwise, and their rates."""
    stance = np.pi / 2 + theta - SLOPE
    return np.array([stance, stance - np.pi - phi]), np.array([rates[0], rates[0] - rates[1]])


def step(stance: Any, strike: Any, theta: float, rate: float) -> tuple[Array, float]:
    """One step from just after a strike to just after the next, (theta, its rate) and its time."""
    q, u = legs(theta, 2 * theta, (rate, (1 - np.cos(2 * theta)) * rate))
    # no sweeps, so that the end is smooth in the start: differences are taken of it
    run = simulate(stance, q, u, until=5.0, rtol=1e-13, method="dop853")
    assert run.success, run.message

    def apart(t: float) -> float:
        angles = run.at(t)[0]
        return float(2 * (angles[0] - np.pi / 2 + SLOPE) - (angles[0] - np.pi - angles[1]))

    late = run.t[run.t > 2.5]  # after mid-stance, where the angles agree too
    signs = np.array([apart(float(t)) for t in late])
    first = int(np.flatnonzero(signs[:-1] * signs[1:] < 0)[0])
    t = float(brentq(apart, late[first], late[first + 1], xtol=1e-15, rtol=1e-15))
    angles, rates = run.at(t)
    poses = np.array([[0.0, 0.0, angles[0]], [np.cos(angles[0]), np.sin(angles[0]), angles[1]]])
    hip = rates[0] * np.array([-np.sin(angles[0]), np.cos(angles[0])])
    q, u = strike.state_from_poses(poses, np.array([[0.0, 0.0, rates[0]], [*hip, rates[1]]]))
    ground = strike.grounds[0]
    after, impulses = strike.impact(q, u, [("trailing.foot", ground), ("leading.foot", ground)])
    assert impulses[1] > 0.0
    assert impulses[0] == 0.0, "the trailing foot leaves"
    spins = strike.velocities(q, after)[:, 2]
    return np.array([angles[1] - np.pi / 2 + np.pi + SLOPE, spins[1]]), t


def gait(stance: Any, strike: Any) -> tuple[Array, float]:
    """The period-one gait (theta, its rate) and its time, by Newton's method."""
    found = GAIT.copy()
    for _ in range(5):
        after, _ = step(stance, strike, *found)
        shift = 1e-6
        slopes = [(step(stance, strike, *(found + shift * e))[0] - after) / shift for e in np.eye(2)]
        found = found + np.linalg.solve(np.eye(2) - np.column_stack(slopes), after - found)
    return found, step(stance, strike, *found)[1]


def vanishing(values: list[Array]) -> Array:
    """The limit of values at FEET, each half of the one before, as the feet's mass goes to zero (L. F. Richardson)."""
    for order in range(1, len(values)):
        values = [(2**order * fine - coarse) / (2**order - 1) for coarse, fine in pairwise(values)]
    return values[0]


def test_the_simplest_walker(workshop: Workshop, reach: Reach) -> None:
    """Its gait through the model's own impact, the feet rough, one foot striking and the other leaving."""
    hinged, floating = workshop.model(STANCE), workshop.model(STRIKE)
    found = []
    for mass in FEET:
        stance = hinged.with_parameters({"swing.mass": mass})
        whole = 1.0 + mass
        values = {"trailing.mass": whole, "trailing.com.x": 1 / whole, "trailing.inertia": mass / whole}
        strike = floating.with_parameters(values | {"leading.mass": mass})
        state, time = gait(stance, strike)
        found.append(np.array([*state, time]))
    theta, rate, time = vanishing(found)
    reach("simplest walker: angle of the gait, rad", abs(theta - GAIT[0]), 1e-9)
    reach("simplest walker: its rate, rad/s", abs(rate - GAIT[1]), 1e-9)
    reach("simplest walker: time of a step, s", abs(time - PERIOD), 1e-9)
