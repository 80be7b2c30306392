"""A ball that bounces to rest."""

from __future__ import annotations

import numpy as np

G = 9.81
BALL = f"""
name = "ball"
[[link]]
name = "ball"
mass = 2.0
inertia = 1.0
com = [0.0, 0.0]
points = {{ C = [0.0, 0.0] }}
[start]
position = [0.0, 1.0]
[gravity]
g = {G}
[[ground]]
restitution = 0.5
contacts = ["ball.C"]
"""
FIRST = np.sqrt(2 / G)
"""Time of the first impact from 1 m."""
