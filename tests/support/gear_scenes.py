"""Scenes with wheels: a pair on the ground, a planetary train, a cart on a wheel that rolls."""

from __future__ import annotations

import math


def disc(name: str, mass: float, inertia: float) -> str:
    """A link with its mass centre at its point C, and a point E beside that."""
    numbers = f"mass = {mass!r}\ninertia = {inertia!r}\ncom = [0, 0]\npoints = {{ C = [0, 0], E = [0.05, 0] }}\n"
    return f'[[link]]\nname = "{name}"\n{numbers}'


def joint(name: str, one: str, other: str) -> str:
    """A pin."""
    return f'[[joint]]\nname = "{name}"\nbetween = ["{one}", "{other}"]\n'


GROUND_PAIR = (
    'name = "pair"\n[ground_link]\npoints = { O = [0, 0], P = [0.35, 0] }\n'
    + disc("one", 1.0, 0.02)
    + disc("two", 1.0, 0.08)
    + joint("a", "ground.O", "one.C")
    + joint("b", "ground.P", "two.C")
)
"""Two wheels 0.35 m apart, without the gear."""

TEETH = 24, 60, 18
"""Of sun, ring and planets."""
ORBIT = 0.042

PLANETARY = (
    'name = "planetary"\n[ground_link]\npoints = { O = [0, 0] }\n'
    + '[[link]]\nname = "arm"\nmass = 0.5\ninertia = 1e-3\ncom = [0, 0]\npoints = { O = [0, 0], '
    + ", ".join(
        f"P{k} = [{ORBIT * math.cos(2 * math.pi * k / 3)!r}, {ORBIT * math.sin(2 * math.pi * k / 3)!r}]"
        for k in range(3)
    )
    + " }\n"
    + disc("sun", 0.3, 8e-5)
    + disc("ring", 0.6, 2e-3)
    + joint("arm_axle", "ground.O", "arm.O")
    + joint("sun_axle", "ground.O", "sun.C")
    + joint("ring_axle", "ground.O", "ring.C")
)
"""Arm, sun and ring on one axis, without planets."""


def planets(count: int) -> str:
    """Equal planets on the arm, each between sun and ring."""
    text = ""
    for k in range(count):
        text += disc(f"planet_{k}", 0.2, 3e-5) + joint(f"pin_{k}", f"arm.P{k}", f"planet_{k}.C")
        text += f'[[gear]]\nname = "sun_{k}"\njoints = ["sun_axle", "pin_{k}"]\nteeth = [{TEETH[0]}, {TEETH[2]}]\n'
        text += f'[[gear]]\nname = "ring_{k}"\njoints = ["ring_axle", "pin_{k}"]\nteeth = [{TEETH[1]}, {TEETH[2]}]\n'
        text += "internal = true\n"
    return text


CART = (
    'name = "cart"\n[ground_link]\npoints = { O = [0, 0.1] }\n'
    + disc("body", 2.0, 0.1)
    + disc("wheel", 1.0, 0.01)
    + '[[joint]]\nname = "road"\ntype = "prismatic"\naxis = 0\nbetween = ["ground.O", "body.C"]\n'
    + joint("axle", "body.C", "wheel.C")
    + "[gravity]\ndirection = [0.3420201433256687, -0.9396926207859084]\n"
    + '[[rack]]\npinion = "axle"\nslide = "road"\nradius = 0.1\n'
)
"""A wheel that rolls under a cart, gravity being inclined by 20°."""
