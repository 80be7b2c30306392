"""A leg as a part of a scene, and two places where it stands."""

LEG = """\
name = "legs"

[let]
l = "40 cm"
rho = 2

[ground_link]
points = { O = [0, 0] }

[[part]]
name = "leg"
ports = ["hip"]
let = { l = 0.5, w = "l/4" }

[[part.link]]
name = "thigh"
mass = "rho*l"
inertia = 0.01
com = ["l/2", "w"]
points = { A = [0, 0], B = ["l", "w"] }

[[part.link]]
name = "shin"
rod = { mass = "300 g", between = ["A", [0.1, 0.2]] }
points = { A = [0, 0], F = [0.3, 0.1] }

[[part.joint]]
name = "top"
between = ["hip", "thigh.A"]

[[part.joint]]
name = "knee"
between = ["thigh.B", "shin.A"]

[[part.torsion]]
name = "tendon"
joint = "knee"
stiffness = 4
angle = "30 deg"

[[part.stop]]
joint = "knee"
lowest = "-20 deg"
highest = "1 + w"
restitution = 0.3

[[part.torsion]]
joint = "top"
stiffness = 5
angle = 0.2

[[part.spring]]
between = ["top", "shin.F"]
stiffness = "100*w"

[part.start]
angles = { thigh = "-80 deg", shin = -1.2 }
angular_velocities = { thigh = 2 }
"""
PLACES = """
[[place]]
part = "leg"
name = "left"
ports = { hip = "ground.O" }

[[place]]
part = "leg"
name = "right"
mirror = true
angle = "90 deg"
let = { l = "2*l" }
ports = { hip = "thigh_left.B" }
start = { angles = { shin = -1.1 } }
"""
