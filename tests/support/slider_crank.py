"""A slider-crank without a start: its rod has a LENGTH (m), to be put in."""

SLIDER_CRANK = """
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "crank"
mass = 0.8
inertia = 0.003
com = [0.1, 0]
points = { A = [0, 0], B = [0.2, 0] }
[[link]]
name = "con"
mass = 1.2
inertia = 0.02
com = [0.25, 0]
points = { A = [0, 0], B = [LENGTH, 0] }
[[link]]
name = "slider"
mass = 2
inertia = 0.01
com = "C"
points = { C = [0, 0] }
[[joint]]
name = "axle"
between = ["ground.O", "crank.A"]
[[joint]]
name = "pin"
between = ["crank.B", "con.A"]
[[joint]]
name = "wrist"
between = ["con.B", "slider.C"]
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "slider.C"]
axis = [1, 0]
"""
