"""A rimless wheel whose spokes weigh next to nothing."""

from __future__ import annotations

import numpy as np

SPOKES = """
name = "rim"
[[link]]
name = "w"
mass = 1.0
inertia = {inertia}
com = [0, 0]
points = {{ {points} }}
[gravity]
g = 1.0
direction = [0.0799146939691727, -0.9968017063026194]
[[ground]]
restitution = 0.0
friction = 2.0
contacts = [{contacts}]
[start]
position = [0.0, 0.9238795325112867]
angles = {{ w = -1.1780972450961724 }}
velocity = [0.3440468199614556, 0.14250885891936937]
angular_velocities = {{ w = -0.372393594461681 }}
[run]
until = 6.0
"""


def spokes(inertia: float) -> str:
    """A rimless wheel of eight spokes of 1 m that rolls down a slope, its mass in the middle"""
    turns = np.arange(8) * np.pi / 4
    points = ", ".join(f"P{i} = [{float(np.cos(a))!r}, {float(np.sin(a))!r}]" for i, a in enumerate(turns))
    return SPOKES.format(inertia=inertia, points=points, contacts=", ".join(f'"w.P{i}"' for i in range(8)))
