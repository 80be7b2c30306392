"""The simplest walker on stepping stones, so that its straight legs do not scuff: a scene for its return map, and the
step of massless feet by SciPy.

M. Garcia, A. Chatterjee, A. Ruina, M. Coleman, Journal of Biomechanical Engineering 120, 1998. The foot that swings
strikes a stone that begins 0.2 legs before the other foot: where it would scuff there is none.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

THICK = 1e-3
"""Half of what a stone is thick; its upper side is at the height of the ground."""

STONES = f"""
name = "walker-on-stones"
[let]
slope = 0.009
theta = 0.2
rate = -0.2
foot = 1e-5
[ground_link]
points = {{ A = [0.2, {-THICK}], B = [1.2, {-THICK}] }}
[[link]]
name = "stance"
points = {{ foot = [0, 0], hip = [1, 0] }}
point_mass = [{{ at = [0, 0], mass = "foot" }}, {{ at = [1, 0], mass = 1 }}]
[[link]]
name = "swing"
points = {{ foot = [0, 0], hip = [1, 0] }}
point_mass = {{ at = [0, 0], mass = "foot" }}
[[joint]]
name = "hip"
between = ["stance.hip", "swing.hip"]
[start]
position = [0, 0]
velocity = [0, 0]
angles = {{ stance = "pi/2 + theta", swing = "pi/2 - theta" }}
angular_velocities = {{ stance = "rate", swing = "cos(2*theta)*rate" }}
[gravity]
g = 1
direction = ["sin(slope)", "-cos(slope)"]
[[ground]]
restitution = 0
friction = 1
contacts = ["stance.foot"]
[[touch]]
name = "stone"
between = ["swing.foot", ["ground.A", "ground.B"]]
radius = [0, {THICK}]
restitution = 0
friction = 1
[run]
until = 6
"""

EXCHANGED = np.zeros((8, 8))
"""Legs exchanged in the state (x, y, stance, swing and their rates): the foot that has struck stands at the origin."""
EXCHANGED[2, 3] = EXCHANGED[3, 2] = EXCHANGED[6, 7] = EXCHANGED[7, 6] = 1.0

SEARCH: dict[str, Any] = {
    "section": ("swing.foot", "stone"),
    "relabel": (EXCHANGED, np.zeros(8)),
    "advances": ["stance.x"],
    "method": "dop853",
    "rtol": 1e-11,
}
"""What its gait is looked for with."""


def with_feet(model: Any, foot: float) -> Any:
    """The model with feet of another mass."""
    stance = {"stance.mass": 1 + foot, "stance.com.x": 1 / (1 + foot), "stance.inertia": foot / (1 + foot)}
    return model.with_parameters({**stance, "swing.mass": foot})


def massless_step(slope: float, theta: float, rate: float) -> tuple[float, float]:
    """Angle of the stance leg and its rate behind the next strike, of feet without mass: equations 1 to 5 of the
    paper."""

    def rates(_: float, x: Any) -> list[float]:
        pull = math.sin(x[0] - slope)
        swing = pull + x[1] ** 2 * math.sin(x[2]) - math.cos(x[0] - slope) * math.sin(x[2])
        return [x[1], pull, x[3], swing]

    def strike(t: float, x: Any) -> float:
        return float(x[2] - 2 * x[0]) if t > 2.0 else -1.0

    strike.terminal, strike.direction = True, 1.0  # type: ignore[attr-defined]
    start = [theta, rate, 2 * theta, (1 - math.cos(2 * theta)) * rate]
    found = solve_ivp(rates, (0, 8), start, "DOP853", events=strike, rtol=1e-12, atol=1e-13)
    end = found.y_events[0][0]
    return -float(end[0]), math.cos(2 * end[0]) * float(end[1])


def massless_gait(slope: float, guess: tuple[float, float]) -> tuple[Any, Any]:
    """Its gait (2,) and the derivatives of its step (2, 2), by central differences."""
    state, shift = np.array(guess), 1e-5
    for _ in range(6):
        columns = [
            (np.array(massless_step(slope, *(state + e))) - massless_step(slope, *(state - e))) / (2 * shift)
            for e in shift * np.eye(2)
        ]
        by = np.column_stack(columns)
        change = np.linalg.solve(np.eye(2) - by, np.array(massless_step(slope, *state)) - state)
        state = state + change
        if np.abs(change).max() < 1e-10:
            break
    return state, by
