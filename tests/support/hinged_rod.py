"""A hinged rod, and ground below one of its points that strikes it."""

from __future__ import annotations

HINGED = """
name = "hinged-rod"
[ground_link]
points = { O = [0.0, 0.3] }
[[link]]
name = "rod"
mass = 1.0
inertia = 0.08
com = [0.5, 0.0]
points = { A = [0.0, 0.0], B = [1.0, 0.0] }
[[joint]]
name = "pin"
between = ["ground.O", "rod.A"]
"""
STRUCK = """
[gravity]
g = 9.81
[[ground]]
point = [0.0, {y}]
restitution = 0.0
friction = 0.3
law = "stronge"
contacts = ["{point}"]
"""
