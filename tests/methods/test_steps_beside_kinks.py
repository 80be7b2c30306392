"""Steps of models with kinks: as many as the motion asks for, and not fewer."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ccgen.runtime import simulate

from ..oracles.maximal import Array
from ..support.workshop import Workshop

DOUBLE_PENDULUM = """
name = "double"
[gravity]
[ground_link]
points = { O = [0, 0], S = [0, 2] }
[[link]]
name = "rod"
points = { A = [0, 0], B = [1, 0] }
rod = { mass = 1 }
[[link]]
name = "fore"
points = { A = [0, 0], B = [0.7, 0] }
rod = { mass = 0.6 }
[[joint]]
name = "pin"
between = ["ground.O", "rod.A"]
[[joint]]
name = "elbow"
between = ["rod.B", "fore.A"]
[start]
angles = { rod = 0, fore = 0 }
angular_velocities = { rod = 1 }
[run]
until = 6
"""
SLACK = """
[[spring]]
name = "rope"
between = ["ground.S", "fore.B"]
stiffness = 50
length = 9
acts = "pull"
"""
ARM = """
name = "arm"
[gravity]
[ground_link]
points = {{ O = [0, 0] }}
[[link]]
name = "arm"
points = {{ A = [0, 0], B = [1, 0] }}
rod = {{ mass = 1 }}
[[joint]]
name = "pin"
between = ["ground.O", "arm.A"]
[[compliant_ground]]
point = [0, -0.5]
load = {load}
depth = 0.02
restitution = 1
contacts = ["arm.B"]
[start]
angles = {{ arm = 0.3 }}
[run]
until = 3
"""
G, INERTIA, DEPTH, FLOOR, UNTIL = 9.81, 1.0 / 3.0, 0.02, -0.5, 3.0


@pytest.mark.parametrize("rtol", [1e-6, 1e-9, 1e-12])
def test_a_kink_that_is_never_reached_costs_few_steps(rtol: float, workshop: Workshop) -> None:
    """A rope that stays slack: a little more than half as many steps again, not three times as many."""
    plain, slack = (workshop.model(text) for text in (DOUBLE_PENDULUM, DOUBLE_PENDULUM + SLACK))
    runs = [simulate(model, rtol=rtol, method="gauss") for model in (plain, slack)]
    assert len(runs[1].t) <= 1.6 * len(runs[0].t)
    finer = simulate(plain, rtol=1e-13, method="dop853")
    assert np.max(np.abs(runs[1].q[-1] - finer.q[-1])) <= 1e3 * rtol


def depth(_: float, y: Array) -> float:
    """How deep the end of the arm is in its ground (m)."""
    return float(FLOOR - np.sin(y[0]))


def bouncing(load: float) -> list[tuple[float, float, Any]]:
    """The arm on its ground by SciPy, from each touch and each leaving to the next: begin, end, dense output."""
    parts, t, y, touch = list[tuple[float, float, Any]](), 0.0, np.array([0.3, 0.0]), cast(Any, depth)
    stiffness, touch.terminal = 0.0, True
    while t < UNTIL:
        touch.direction = -1 if stiffness else 1

        def rate(t: float, y: Array, stiffness: float = stiffness) -> list[float]:
            force = stiffness * max(depth(t, y), 0.0) ** 1.5
            return [y[1], (force - 0.5 * G) * float(np.cos(y[0])) / INERTIA]

        found: Any = solve_ivp(
            rate, (t, UNTIL), y, "DOP853", rtol=1e-13, atol=1e-15, max_step=5e-3, events=touch, dense_output=True
        )
        parts.append((t, float(found.t[-1]), found.sol))
        t, y, stiffness = float(found.t[-1]), found.y[:, -1], 0.0 if stiffness else load / DEPTH**1.5
    return parts


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("load", [30, 100, 1000])
def test_a_load_that_begins_as_a_root_is_seen(load: float, rtol: float, workshop: Workshop) -> None:
    """Four bounces of an arm on a ground that gives way by Hertz's law, against SciPy from bounce to bounce."""
    parts = bouncing(load)
    assert len(parts) == 9
    run = simulate(workshop.model(ARM.format(load=load)), rtol=rtol, method="gauss")
    at = np.linspace(0.1, 2.9, 29)
    wanted = [next(sol(t)[0] for begin, end, sol in parts if begin <= t <= end) for t in at]
    assert np.max(np.abs(np.array([run.at(t)[0][0] for t in at]) - wanted)) <= 10.0 * rtol


ROTOR = """
name = "rotor"
[ground_link]
points = {{ O = [0, 0] }}
[[link]]
name = "rod"
mass = 1
inertia = 1
com = [0, 0]
points = {{ A = [0, 0] }}
[[joint]]
name = "pin"
between = ["ground.O", "rod.A"]
[start]
angles = {{ rod = 0 }}
[[torque]]
link = "rod"
torque = "max(0, sin({turns}*2*pi*t) - 0.5 + 0*angle(pin))"
[run]
until = 16
"""


@pytest.mark.parametrize("turns", [4, 8])
def test_pulses_in_step_with_the_steps_are_seen(turns: int, workshop: Workshop) -> None:
    """Pulses that come back in each eighth of a step, in the same phase: the rotor has their sum, as an integral."""
    run = simulate(workshop.model(ROTOR.format(turns=turns)), step=1.0)
    mean = (np.sqrt(3.0) - np.pi / 3.0) / (2.0 * np.pi)
    assert run.u[-1][0] == pytest.approx(16.0 * mean, rel=1e-6)
