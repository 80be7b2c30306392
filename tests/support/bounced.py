"""A ball that is pushed along a smooth floor and bounces once: its run in closed form, as a function of numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

BOUNCED = """
name = "bounced"
[[link]]
name = "ball"
mass = 2.0
inertia = 1.0
com = [0.0, 0.0]
points = { C = [0.0, 0.0] }
[start]
position = [0.0, 1.0]
velocity = [1.5, 0.5]
angular_velocities = [0.3]
[gravity]
g = 9.81
[[ground]]
restitution = 0.7
contacts = ["ball.C"]
[[input]]
name = "push"
point = "ball.C"
direction = [1, 0]
[run]
until = 0.9
rtol = 1e-12
"""

WRT = ("u0", "ball.mass", "gravity.g", "ground_0.restitution", "push")
OUTPUTS = ("ball.x", "ball.y")
AT = (0.2, 0.9)
"""Before the bounce and behind it."""

X = np.array([1.5, 0.5, 0.3, 2.0, 9.81, 0.7, 0.8])
"""Of ``WRT``: what it is in the scene, and a push."""


def bounced(x: Any) -> Any:
    """``OUTPUTS`` at ``AT``, of numbers that may be complex: x_C = v t + F t²/2m; y is thrown anew at t1."""
    vx, vy, _, m, g, e, push = x
    sped = np.sqrt(vy**2 + 2.0 * g)
    t1 = (vy + sped) / g

    def height(t: float) -> Any:
        if t < t1.real:
            return 1.0 + vy * t - g * t**2 / 2.0
        return e * sped * (t - t1) - g * (t - t1) ** 2 / 2.0

    return np.array([vx * t + push * t**2 / (2.0 * m) for t in AT] + [height(t) for t in AT])


def bounced_jacobian(x: Any) -> Any:
    """By complex steps, to rounding (W. Squire, G. Trapp, SIAM Review 40, 1998)."""
    h = 1e-30
    return np.array([bounced(x + 1j * h * one).imag / h for one in np.eye(len(x))]).T
