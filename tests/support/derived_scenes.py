"""Small scenes that strike, stick, slide and let go, whose runs are differentiated."""

from __future__ import annotations

BODY = """
[[link]]
name = "body"
mass = 1.3
inertia = INERTIA
com = COM
points = { A = [0, 0], B = [0.4, 0] }
[start]
position = POSITION
velocity = VELOCITY
angles = [ANGLE]
angular_velocities = [SPIN]
[gravity]
[[ground]]
normal = [0.05, 1.0]
restitution = RESTITUTION
friction = FRICTION
"""


def body(text: str, **values: object) -> str:
    usual = {
        "inertia": 0.02,
        "com": "[0.2, 0.15]",
        "position": "[0, 0.02]",
        "velocity": "[2, 0]",
        "angle": 0.1,
        "spin": 0,
        "restitution": 0,
        "friction": 0.3,
    }
    scene = BODY + text
    for name, value in (usual | values).items():
        scene = scene.replace(name.upper(), str(value))
    return scene


HINGED = """
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "thigh"
rod = { mass = 1 }
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "shank"
rod = { mass = 0.7 }
points = { A = [0, 0], B = [0.8, 0] }
[[joint]]
between = ["ground.O", "thigh.A"]
[[joint]]
name = "knee"
between = ["thigh.B", "shank.A"]
[gravity]
"""

FOUR_BAR = """
[ground_link]
points = { O = [0, 0], Q = [2, 0] }
[[link]]
name = "crank"
rod = { mass = 1 }
points = { A = [0, 0], B = [0.7, 0] }
[[link]]
name = "coupler"
rod = { mass = 1.5 }
points = { A = [0, 0], B = [2.1, 0] }
[[link]]
name = "rocker"
rod = { mass = 0.8 }
points = { A = [0, 0], B = [1.4, 0] }
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
[start]
angles = { crank = 1.0 }
angular_velocities = { crank = 2.0 }
[gravity]
"""

LIFTER = """
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "shaft"
mass = 2
inertia = 0.001
com = [0, 0]
points = { O = [0, 0], E = [0.01, 0] }
[[link]]
name = "lifter"
mass = 0.3
inertia = 0.01
com = [0, 0.1]
points = { A = [-0.05, 0], B = [0.05, 0] }
[[joint]]
name = "axle"
between = ["ground.O", "shaft.O"]
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "lifter.A"]
axis = [0, 1]
[[touch]]
between = ["shaft.E", ["lifter.A", "lifter.B"]]
radius = [0.03, 0]
restitution = 0.3
friction = 0.2
[[drive]]
joint = "axle"
speed = 50
[gravity]
[start]
slides = { guide = 0.05 }
"""

BALL_AND_ROD = HINGED.replace(
    "[[joint]]\nname",
    '[[touch]]\nbetween = ["shank.B", "thigh"]\nradius = 0.05\nrestitution = 0.4\nfriction = 0.2\n[[joint]]\nname',
)

DERIVED: dict[str, tuple[str, float, tuple[str, ...]]] = {
    "a ball that lands, slides and rolls": (
        body(
            'contacts = ["body.A"]\nradius = 0.1\n',
            com="[0, 0]",
            position="[0, 0.5]",
            velocity="[1, 0]",
            spin=-30,
            angle=0,
            friction=0.1,
        ),
        1.6,
        ("impact", "sliding ends"),
    ),
    "a ball that bounces": (
        body(
            'contacts = ["body.A"]\nradius = 0.1\n',
            com="[0, 0]",
            position="[0, 1]",
            velocity="[1, 0]",
            spin=-10,
            restitution=0.6,
            friction=0.2,
        ),
        1.0,
        ("impact", "impact"),
    ),
    "a box that falls flat, slides and stops": (
        body('contacts = ["body.A", "body.B"]\n'),
        1.2,
        ("impact", "impact", "sliding ends"),
    ),
    "a rod that leans, sticks, slides and is let go": (
        body('contacts = ["body.A"]\n', com="[0.5, 0]", inertia=0.11, position="[0, 0]", velocity="[0, 0]", angle=1.2),
        0.6,
        ("force ends", "sliding ends"),
    ),
    "a knee with a stop": (
        HINGED + '[start]\nangles = ["0 deg", "30 deg"]\n[[stop]]\njoint = "knee"\nlowest = "-20 deg"\n'
        'highest = "100 deg"\nrestitution = 0.3\n',
        0.8,
        ("impact",),
    ),
    "a shank that touches a thigh": (
        BALL_AND_ROD + '[start]\nangles = ["0 deg", "170 deg"]\n',
        1.0,
        ("impact",),
    ),
    "a ball on a rope": (
        '[ground_link]\npoints = { O = [0, 0] }\n[[link]]\nname = "ball"\nmass = 2.0\ninertia = 0.01\ncom = [0, 0]\n'
        'points = { C = [0, 0] }\n[[rope]]\nbetween = ["ground.O", "ball.C"]\nlength = 1\nrestitution = '
        "0.6\n[gravity]\n"
        "[start]\nposition = [0.5, 0.1]\nvelocity = [0.3, 1.2]\n",
        0.85,
        ("impact", "impact"),
    ),
    "a four-bar against a stop": (
        FOUR_BAR + '[[stop]]\njoint = "pivot"\nlowest = 1.3\nhighest = 1.45\nrestitution = 0.5\n',
        0.5,
        ("impact",),
    ),
    "a lifter on an eccentric": (LIFTER, 0.082, ("impact", "impact")),
}
"""Scenes by what they do, how long they run (s), and what is passed at least."""
