"""Scenes of links that touch each other, which unit tests and hard cases share."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

G = 9.81


def free_body(name: str, mass: float, inertia: float, points: str) -> str:
    """A body that moves freely in the plane, beside others: on a crosshead without mass that slides along y and x.

    Slides of its joints are ``x_NAME`` and ``y_NAME``: where the body's origin C is.
    """
    carrier = "mass = 0.0\ninertia = 0.0\ncom = [0, 0]\npoints = { P = [0, 0] }\n"
    slide = 'type = "prismatic"\nbetween'
    return (
        f'[[link]]\nname = "across_{name}"\n{carrier}[[link]]\nname = "up_{name}"\n{carrier}'
        f'[[link]]\nname = "{name}"\nmass = {mass!r}\ninertia = {inertia!r}\ncom = [0, 0]\npoints = {{ {points} }}\n'
        f'[[joint]]\nname = "x_{name}"\n{slide} = ["ground.O", "across_{name}.P"]\naxis = [1, 0]\n'
        f'[[joint]]\nname = "y_{name}"\n{slide} = ["across_{name}.P", "up_{name}.P"]\naxis = [0, 1]\n'
        f'[[joint]]\nname = "pin_{name}"\nbetween = ["up_{name}.P", "{name}.C"]\n'
    )


def free_discs(places: Sequence[tuple[float, float]], mass: float, radius: float, touch: str = "") -> str:
    """Uniform discs in a row of pairs that touch, ball_0 with ball_1 and so on, each free in the plane."""
    names = [f"ball_{k}" for k in range(len(places))]
    bodies = "".join(free_body(name, mass, 0.5 * mass * radius**2, "C = [0, 0]") for name in names)
    pairs = "".join(
        f'[[touch]]\nbetween = ["{a}.C", "{b}.C"]\nradius = {radius}\n{touch}\n' for a, b in pairwise(names)
    )
    slides = ", ".join(
        f"{axis}_{name} = {value!r}"
        for name, place in zip(names, places, strict=True)
        for axis, value in zip("xy", place, strict=True)
    )
    return f"[ground_link]\npoints = {{ O = [0, 0] }}\n{bodies}{pairs}[start]\nslides = {{ {slides} }}\n"


def cradle(
    count: int, gap: float, radius: float = 0.25, length: float = 1.0, swing: float = 0.5, touch: str = ""
) -> str:
    """Newton's cradle: balls on strings, each a pendulum about a point of its own; the first is drawn aside.

    The balls hang ``gap`` apart, except the first two, which touch.
    """
    places, links, joints, pairs = [], "", "", ""
    for k in range(count):
        places.append(2 * radius * k + gap * max(0, k - 1))
        links += (
            f'[[link]]\nname = "ball_{k}"\nmass = 1.0\ninertia = {0.5 * radius**2!r}\ncom = [0, {-length!r}]\n'
            f"points = {{ H = [0, 0], C = [0, {-length!r}] }}\n"
        )
        joints += f'[[joint]]\nname = "hook_{k}"\nbetween = ["ground.P{k}", "ball_{k}.H"]\n'
    for k in range(count - 1):
        pairs += (
            f'[[touch]]\nbetween = ["ball_{k}.C", "ball_{k + 1}.C"]\nradius = {radius!r}\nrestitution = 1.0\n{touch}\n'
        )
    points = ", ".join(f"P{k} = [{x!r}, 0]" for k, x in enumerate(places))
    angles = ", ".join(f"ball_{k} = {-swing if k == 0 else 0.0!r}" for k in range(count))
    return (
        f'name = "cradle"\n[ground_link]\npoints = {{ {points} }}\n{links}{joints}{pairs}'
        f"[gravity]\ng = {G}\n[start]\nangles = {{ {angles} }}\n"
    )


def disc_on_plank(
    slope: float,
    along: float,
    touch: str,
    radius: float = 0.1,
    thickness: float = 0.02,
    length: float = 1.0,
    mass: float = 2.0,
) -> str:
    """A uniform disc on the upper side of a plank of ``length`` that is held at both its ends, falling by ``slope``.

    The disc's centre is above the point of the plank ``along`` metres from its upper end A, which is at the origin.
    """
    c, s = math.cos(slope), math.sin(slope)
    height = radius + thickness
    place = (along * c + height * s, -along * s + height * c)
    return (
        f"[ground_link]\npoints = {{ O = [0, 0], Q = [{length * c!r}, {-length * s!r}] }}\n"
        f'[[link]]\nname = "plank"\nmass = 3.0\ninertia = 0.2\ncom = [{length / 2!r}, 0]\n'
        f"points = {{ A = [0, 0], B = [{length!r}, 0] }}\n"
        + free_body("disc", mass, 0.5 * mass * radius**2, "C = [0, 0]")
        + '[[joint]]\nname = "hook"\nbetween = ["ground.O", "plank.A"]\n'
        '[[joint]]\nname = "prop"\nbetween = ["ground.Q", "plank.B"]\n'
        f'[[touch]]\nbetween = ["disc.C", "plank"]\nradius = [{radius!r}, {thickness!r}]\n{touch}\n'
        f"[gravity]\ng = {G}\n[start]\nangles = {{ plank = {-slope!r} }}\n"
        f"slides = {{ x_disc = {place[0]!r}, y_disc = {place[1]!r} }}\n"
    )
