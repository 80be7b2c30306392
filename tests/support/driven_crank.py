"""A slider-crank whose joints are driven."""

from __future__ import annotations

R, L = 0.4, 1.1
CRANK = f"""
name = "driven"
[gravity]
[ground_link]
points = {{ O = [0, 0] }}
[[link]]
name = "crank"
mass = 1.0
inertia = 0.1
com = [0.1, 0.0]
points = {{ A = [0, 0], B = [{R}, 0] }}
[[link]]
name = "rod"
mass = 2.0
inertia = 0.3
com = [0.5, 0.1]
points = {{ A = [0, 0], B = [{L}, 0] }}
[[link]]
name = "slider"
mass = 1.5
inertia = 0.2
com = [0.0, 0.0]
points = {{ P = [0, 0] }}
[[joint]]
name = "axle"
between = ["ground.O", "crank.A"]
[[joint]]
name = "pin"
between = ["crank.B", "rod.A"]
[[joint]]
name = "wrist"
between = ["rod.B", "slider.P"]
[[joint]]
name = "guide"
type = "prismatic"
axis = [1, 0]
between = ["ground.O", "slider.P"]
[start]
angles = {{ crank = 0.7, rod = -0.24 }}
"""
