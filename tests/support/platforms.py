"""Mechanisms whose inverse kinematics has a closed form: an arm, a five-bar, a platform on three legs (3-RRR)."""

from __future__ import annotations

import numpy as np

UPPER, FORE = 0.6, 0.4
"""Lengths (m) of the arm's links."""
ROD = """[[link]]
name = "{name}"
mass = {mass}
inertia = 0.002
com = [{half}, 0]
points = {{ A = [0, 0], {end} = [{length}, 0] }}
"""
JOINT = '[[joint]]\nname = "{}"\nbetween = ["{}", "{}"]\n'


def rod(name: str, length: float, end: str = "B", mass: float = 0.4) -> str:
    return ROD.format(name=name, length=length, half=length / 2, end=end, mass=mass)


ARM = (
    'name = "arm"\n[ground_link]\npoints = { O = [0, 0] }\n[start]\nangles = { upper = 0.3, fore = 0.9 }\n'
    + rod("upper", UPPER)
    + rod("fore", FORE, "T")
    + JOINT.format("shoulder", "ground.O", "upper.A")
    + JOINT.format("elbow", "upper.B", "fore.A")
)

STOPPED = ARM + '[[stop]]\njoint = "elbow"\nlowest = "-100 deg"\nhighest = "60 deg"\nrestitution = 0\n'
"""Its elbow bends back further than forward."""

FIVE_BAR = (
    'name = "five-bar"\n[ground_link]\npoints = { O = [0, 0], Q = [0.2, 0] }\n'
    '[start]\nangles = { left = "130 deg", right = "50 deg", rise = "50 deg", fall = "130 deg" }\n'
    + rod("left", 0.2)
    + rod("right", 0.2)
    + rod("rise", 0.3)
    + rod("fall", 0.3)
    + JOINT.format("motor_left", "ground.O", "left.A")
    + JOINT.format("motor_right", "ground.Q", "right.A")
    + JOINT.format("elbow_left", "left.B", "rise.A")
    + JOINT.format("elbow_right", "right.B", "fall.A")
    + JOINT.format("tip", "rise.B", "fall.B")
)
"""Cranks of 0.2 m on the ground, 0.2 m apart, and rods of 0.3 m that meet at the tip."""

BASE, RIM, CRANK, LEG = 0.5, 0.12, 0.25, 0.3
FEET = np.radians([-90.0, 30.0, 150.0])


def three_legs() -> str:
    """A platform with motors at three places of the ground, 0.5 m from the middle."""
    places = [(radius * np.cos(FEET), radius * np.sin(FEET)) for radius in (BASE, RIM)]
    grounds, rims = (
        ", ".join(f"{name}{k} = [{x[k]!r}, {y[k]!r}]" for k in range(3))
        for name, (x, y) in zip("GP", [(x.tolist(), y.tolist()) for x, y in places], strict=True)
    )
    text = f'name = "three-legs"\n[ground_link]\npoints = {{ {grounds} }}\n[start]\n'
    text += 'poses = { platform = [0, 0, 0] }\nangles = { arm0 = "20 deg", arm1 = "140 deg", arm2 = "260 deg" }\n'
    text += '[[link]]\nname = "platform"\nmass = 1.0\ninertia = 0.01\ncom = [0, 0]\n'
    text += f"points = {{ C = [0, 0], {rims} }}\n[gravity]\n"
    for k in range(3):
        text += rod(f"arm{k}", CRANK) + rod(f"leg{k}", LEG, mass=0.3)
        text += JOINT.format(f"motor{k}", f"ground.G{k}", f"arm{k}.A")
        text += JOINT.format(f"elbow{k}", f"arm{k}.B", f"leg{k}.A")
        text += JOINT.format(f"pin{k}", f"leg{k}.B", f"platform.P{k}")
    return text
