"""Cranks of a parallelogram on pivots half a metre apart; what begins its ``[start]`` is to be put behind it."""

TWO_CRANKS = """
name = "two-cranks"
[ground_link]
points = { O = [0, 0], Q = [0.5, 0] }
[[link]]
name = "crank"
rod = { mass = 1 }
points = { A = [0, 0], B = [0.2, 0] }
[[link]]
name = "coupler"
rod = { mass = 2 }
points = { A = [0, 0], B = [0.5, 0] }
[[link]]
name = "rocker"
rod = { mass = 1 }
points = { A = [0, 0], B = [0.2, 0] }
[[joint]]
name = "axle"
between = ["ground.O", "crank.A"]
[[joint]]
between = ["crank.B", "coupler.A"]
[[joint]]
between = ["coupler.B", "rocker.B"]
[[joint]]
name = "pivot"
between = ["ground.Q", "rocker.A"]
[gravity]
[start]
"""
