"""A rod that is hinged above smooth ground and comes to lean on it."""

from __future__ import annotations

G = 9.81
LEANING = """
name = "leaning"
[ground_link]
points = { O = [0, 0.5] }
[[link]]
name = "rod"
mass = 2
inertia = 0.1667
com = [0.5, 0]
points = { A = [0, 0], T = [1, 0] }
[[joint]]
name = "hinge"
between = ["ground.O", "rod.A"]
[gravity]
[[ground]]
restitution = 0
contacts = ["rod.T"]
[run]
until = 2
"""
