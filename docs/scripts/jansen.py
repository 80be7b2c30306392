"""Writes scenes/jansen-leg.toml: bodies of one leg from the lengths of its bars, one kilogram per metre of bar."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np

from ccgen.generator.mechanism.totals import total

BARS = {
    "a": 38.0,
    "b": 41.5,
    "c": 39.3,
    "d": 40.1,
    "e": 55.8,
    "f": 39.4,
    "g": 36.7,
    "h": 65.7,
    "i": 49.0,
    "j": 50.0,
    "k": 61.9,
    "l": 7.8,
    "m": 15.0,
}
"""Theo Jansen's numbers; a and l place the fixed pivot P = (-a, -l) from the crank's axle O = (0, 0)."""
LINKS = {
    "crank": {"O": 0, "A": "m"},
    "upper_bar": {"A": 0, "B": "j"},
    "lower_bar": {"A": 0, "C": "k"},
    "hip": {"P": 0, "B": "b", "D": ("d", "e")},
    "strut": {"P": 0, "C": "c"},
    "tie": {"D": 0, "E": "f"},
    "shin": {"C": 0, "E": "g", "F": ("i", "h")},
}
"""Points of each link: the frame's origin, the end of a bar on the x axis, a corner at two distances to its left."""
JOINTS = {
    "axle": ("ground.O", "crank.O"),
    "pin_upper": ("crank.A", "upper_bar.A"),
    "pin_lower": ("crank.A", "lower_bar.A"),
    "shoulder": ("upper_bar.B", "hip.B"),
    "pivot_hip": ("ground.P", "hip.P"),
    "pivot_strut": ("ground.P", "strut.P"),
    "knee_strut": ("lower_bar.C", "strut.C"),
    "knee_shin": ("lower_bar.C", "shin.C"),
    "rear": ("hip.D", "tie.D"),
    "heel": ("tie.E", "shin.E"),
}
SKETCH = {"crank": 0, "upper_bar": 141, "lower_bar": 227, "hip": 70, "strut": 286, "tie": 293, "shin": 152}
"""Angles in degrees from which the leg is assembled: the shoulder above the line P-A, the knee below, the foot down."""


def corners(points: dict[str, object]) -> dict[str, complex]:
    """Points of a link in its frame."""
    found: dict[str, complex] = {}
    for name, where in points.items():
        if isinstance(where, tuple):
            near, far = (BARS[key] for key in where)
            base = list(found.values())[1].real
            x = (near**2 - far**2 + base**2) / (2.0 * base)
            found[name] = complex(x, np.sqrt(near**2 - x**2))
        else:
            found[name] = complex(BARS[where] if isinstance(where, str) else 0.0)
    return found


def body(points: dict[str, complex]) -> tuple[float, complex, float]:
    """Mass, mass centre and inertia about it, of one bar, or of the three bars of a triangle."""
    places = list(points.values())
    bars = list(pairwise(places if len(places) == 2 else [*places, places[0]]))
    masses = [abs(b - a) for a, b in bars]
    middles = [(a + b) / 2.0 for a, b in bars]
    mass = total(masses)
    com = total(m * z for m, z in zip(masses, middles, strict=True)) / mass
    inertia = total(m * (m * m / 12.0 + abs(z - com) ** 2) for m, z in zip(masses, middles, strict=True))
    return mass, com, inertia


def pair(z: complex) -> str:
    x, y = ("0" if part == 0.0 else repr(float(part)) for part in (z.real, z.imag))
    return f"[{x}, {y}]"


def text(driven: bool = False) -> str:
    """The scene: the leg let go with its crank turning, or with its crank ``driven`` at one turn a second."""
    lines = [
        "# One leg of Theo Jansen's beach animals. Lengths are his numbers, in metres; every bar has one kilogram per",
        "# metre, the triangles hip (P, B, D) and shin (C, E, F) are three bars each. F is the foot.",
        *(["# The crank is driven at one turn a second."] if driven else []),
        "# Written by docs/scripts/jansen.py.",
        f'name = "jansen-{"driven" if driven else "leg"}"',
        "",
        "[ground_link]",
        f"points = {{ O = [0, 0], P = {pair(complex(-BARS['a'], -BARS['l']))} }}",
    ]
    for name, points in LINKS.items():
        places = corners(dict(points))
        mass, com, inertia = body(places)
        lines += ["", "[[link]]", f'name = "{name}"', f"mass = {float(mass)!r}", f"inertia = {float(inertia)!r}"]
        lines += [f"com = {pair(com)}"]
        lines += ["points = { " + ", ".join(f"{key} = {pair(z)}" for key, z in places.items()) + " }"]
    for name, ends in JOINTS.items():
        lines += ["", "[[joint]]", f'name = "{name}"', f'between = ["{ends[0]}", "{ends[1]}"]']
    angles = ", ".join(f'{name} = "{angle} deg"' for name, angle in SKETCH.items())
    lines += ["", "[start]", f"angles = {{ {angles} }}   # a sketch: the loops are closed from here"]
    if driven:
        lines += ["", "[[drive]]", 'joint = "axle"', f"speed = {2.0 * np.pi!r}"]
    else:
        lines += ["angular_velocities = { crank = 6.0 }"]
    lines += ["", "[gravity]", "g = 9.81", "", "[run]", f"until = {1.0 if driven else 5.0}"]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    scenes = Path(__file__).parents[2] / "scenes"
    (scenes / "jansen-leg.toml").write_text(text())
    (scenes / "jansen-driven.toml").write_text(text(driven=True))
