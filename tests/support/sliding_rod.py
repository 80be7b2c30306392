"""A rod that slides on its lower end, the other one ahead: Painleve's. It jams, then falls over onto both ends."""

ROD = """\
name = "rod"
[chain]
links = 1
length = 1.0
mass = 1.0
[start]
position = [0.0, 0.0]
angles = ["58 deg"]
velocity = [-2.0, 0.0]
[gravity]
[[ground]]
restitution = 0.0
friction = 1.5
[run]
until = 2.0
"""
