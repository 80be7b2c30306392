"""A chain with a slider and three wheels that names no effect, and a table of every effect for it."""

from __future__ import annotations

SCENE = """
name = "plain"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "link_0"
rod = { mass = 1 }
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "link_1"
rod = { mass = 1 }
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "link_2"
rod = { mass = 1 }
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "slider"
rod = { mass = 1, between = ["A", "B"] }
points = { A = [0, 0], B = [0.2, 0], M = [0.4, 0.1], N = [0.7, 0.1] }
[[link]]
name = "wheel_0"
disc = { mass = 1, radius = 0.1 }
points = { C = [0, 0] }
[[link]]
name = "wheel_1"
disc = { mass = 1, radius = 0.1 }
points = { C = [0, 0] }
[[link]]
name = "wheel_2"
disc = { mass = 1, radius = 0.1 }
points = { C = [0, 0] }
[[joint]]
between = ["ground.O", "link_0.A"]
[[joint]]
between = ["link_0.B", "link_1.A"]
[[joint]]
between = ["link_1.B", "link_2.A"]
[[joint]]
name = "guide"
type = "prismatic"
axis = 0.3
between = ["link_0.A", "slider.A"]
[[joint]]
name = "axle_0"
between = ["slider.M", "wheel_0.C"]
[[joint]]
name = "axle_1"
between = ["slider.N", "wheel_1.C"]
[[joint]]
name = "axle_2"
between = ["slider.B", "wheel_2.C"]
[start]
angles = { link_0 = -0.9, link_1 = 0.4, link_2 = 1.1, wheel_1 = 0.3 }
"""
EXAMPLES: dict[str, str] = {
    "law": '[[law]]\nname = "law_0"\nvalue = "3*sin(t) - k*angle(joint_1)"\nparameters = { k = 2 }\n',
    "gravity": "[gravity]\ndirection = [1, -3]\n",
    "ground": "[[ground]]\nnormal = [0.3, 1]\npoint = [0, -9]\nrestitution = 0.2\n",
    "compliant_ground": "[[compliant_ground]]\npoint = [0, -9]\nload = 30\nrestitution = 0.2\nfriction = 0.4\n",
    "spring": '[[spring]]\nbetween = ["ground.O", "link_2.B"]\nstiffness = 3\nlength = 0.4\n',
    "damper": '[[damper]]\nbetween = ["ground.O", "link_2.B"]\ndamping = 3\n',
    "stop": '[[stop]]\njoint = "joint_1"\nlowest = "-3 deg"\nhighest = 2\nrestitution = 0.2\n',
    "touch": '[[touch]]\nbetween = ["link_2.B", "link_0"]\nradius = 0.01\nrestitution = 0.2\nfriction = 0.3\n',
    "journal": '[[journal]]\nbetween = ["link_2.B", ["link_0.A", "link_0.B"]]\nradius = 0.01\nclearance = 2.5\n'
    "restitution = 0.2\nfriction = 0.3\n",
    "cam": '[[cam]]\ncentre = "link_0.A"\nfollower = "link_2.B"\nbase = 0.2\nradius = 0.01\nrestitution = 0.2\n'
    "friction = 0.3\nclockwise = true\nangle = 0.4\n"
    'lift = [{ to = "120 deg", lift = 0.02 }, { to = "150 deg" }, { to = "360 deg", lift = 0, law = "3-4-5" }]\n',
    "rope": '[[rope]]\nbetween = ["ground.O", "link_2.B"]\nover = ["link_1.B"]\nlength = 4\nrestitution = 0.2\n',
    "compliant_touch": '[[compliant_touch]]\nbetween = ["link_2.B", "link_0"]\nradius = 0.01\nload = 3\ndepth = 0.1\n'
    "damping = 0.2\nfriction = 0.4\n",
    "torsion": '[[torsion]]\njoint = "joint_1"\nstiffness = 3\nangle = "30 deg"\ndamping = 0.3\nplay = 0.1\n',
    "joint_friction": '[[joint_friction]]\njoints = ["joint_0", "joint_2"]\nviscous = 0.2\ndry = 0.1\n',
    "brake": '[[brake]]\njoint = "joint_2"\ntorque = "1 + sin(t)"\nrate = 0.2\nbegins = 0.1\nends = 0.9\n',
    "drag": '[[drag]]\npoint = "link_2.B"\nlinear = 0.3\nquadratic = 0.2\n',
    "motor": '[[motor]]\njoint = "joint_0"\nangle = "sin(2*t)"\nstiffness = 3\ndamping = 0.2\n',
    "drive": '[[drive]]\njoint = "joint_1"\nangle = "sin(3*t)"\n',
    "gear": '[[gear]]\njoints = ["axle_0", "axle_1"]\nratio = 2\n',
    "rack": '[[rack]]\npinion = "axle_1"\nslide = "guide"\nradius = 0.1\n',
    "belt": '[[belt]]\njoints = ["axle_0", "axle_2"]\nradii = [0.1, 0.2]\n',
    "force": '[[force]]\npoint = "link_2.B"\nvector = ["2*cos(t)", 1]\nframe = "link"\n',
    "torque": '[[torque]]\nlink = "link_1"\ntorque = "exp(-t)"\n',
    "input": '[[input]]\nname = "input_0"\njoint = "joint_1"\n',
}
"""A table of every effect, for the scene above."""
CONTACTS = ("ground", "stop", "touch", "journal", "cam", "rope")
"""Effects that are contacts: they have gaps, and no loads."""
MESHES = ("gear", "rack", "belt")
"""Effects that are closure rows: they have forces of constraint, and no loads."""
LOADS = {key: text for key, text in EXAMPLES.items() if key not in (*CONTACTS, *MESHES, "gravity", "drive", "law")}
"""Those that have loads."""
