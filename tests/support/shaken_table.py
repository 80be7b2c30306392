"""A ball on a table that is shaken: the scene, and the exact map of its impacts."""

from __future__ import annotations

import math

from ..oracles.bouncing_table import BouncingTable

G = 9.81
TABLE = BouncingTable(gravity=G, amplitude=0.013, frequency=10.0 * math.pi, restitution=0.5)
RADIUS = 0.01
SHAKEN = f"""
name = "bouncing-table"
[ground_link]
points = {{ O = [0, 0] }}
[[link]]
name = "table"
mass = 1.0
inertia = 1.0
com = [0, 0]
points = {{ C = [0, 0], L = [-0.1, 0], R = [0.1, 0] }}
[[link]]
name = "ball"
mass = 0.01
inertia = 1e-6
com = [0, 0]
points = {{ C = [0, 0] }}
[[joint]]
name = "shaker"
type = "prismatic"
between = ["ground.O", "table.C"]
axis = [0, 1]
[[joint]]
name = "fall"
type = "prismatic"
between = ["ground.O", "ball.C"]
axis = [0, 1]
[[drive]]
joint = "shaker"
position = "{TABLE.amplitude}*sin({TABLE.frequency}*t)"
[[touch]]
name = "bounce"
between = ["ball.C", ["table.L", "table.R"]]
radius = {RADIUS}
restitution = {TABLE.restitution}
[start]
slides = {{ shaker = 0.0, fall = 0.05 }}
[gravity]
g = {G}
[run]
until = {20 * TABLE.period}
"""
