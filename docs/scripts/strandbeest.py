"""Writes scenes/strandbeest.toml: a body with four of Theo Jansen's legs, in mirrored pairs on cranks of one shaft.

A third crank of the shaft drives two air pumps. The bodies of a leg are those of docs/scripts/jansen.py. Angles of the
start follow from the lengths, circle by circle.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from pathlib import Path

from jansen import BARS, LINKS, body, corners, pair

PHASES = (0.0, math.pi)
"""Angles of the cranks on the shaft (rad); each moves a leg on the left and its mirror image on the right."""
PUMP, ROD, PISTON = math.pi / 2.0, 30.0, 8.0
"""Angle of the pumps' crank on the shaft (rad), lengths of the pumps' rods and pistons."""
SPEED = 6.0
"""Angular velocity of the shaft at the start, rad/s."""
LEG = tuple(name for name in LINKS if name != "crank")
JOINTS = {
    "pin_upper": ("shaft.A{crank}", "upper_bar.A"),
    "pin_lower": ("shaft.A{crank}", "lower_bar.A"),
    "shoulder": ("upper_bar.B", "hip.B"),
    "pivot_hip": ("body.P_{side}", "hip.P"),
    "pivot_strut": ("body.P_{side}", "strut.P"),
    "knee_strut": ("lower_bar.C", "strut.C"),
    "knee_shin": ("lower_bar.C", "shin.C"),
    "rear": ("hip.D", "tie.D"),
    "heel": ("tie.E", "shin.E"),
}
"""Joints of a leg; {crank} is the number of its crank, {side} its side."""


def meet(p: complex, r: float, q: complex, s: float, side: int) -> complex:
    """Where the circles of radius r about p and s about q meet, on the ``side`` of the way from p to q (1: left)."""
    way = q - p
    along = (r**2 - s**2 + abs(way) ** 2) / (2.0 * abs(way))
    return p + way / abs(way) * complex(along, side * math.sqrt(r**2 - along**2))


def angles(crank: float) -> dict[str, float]:
    """Angles (degrees) of a leg's links, whose hips are to the left of the shaft, at an angle of its crank (rad)."""
    pivot, pin = complex(-BARS["a"], -BARS["l"]), cmath.rect(BARS["m"], crank)
    upper, knee = meet(pivot, BARS["b"], pin, BARS["j"], 1), meet(pivot, BARS["c"], pin, BARS["k"], -1)
    rear = meet(pivot, BARS["d"], upper, BARS["e"], 1)
    heel = meet(rear, BARS["f"], knee, BARS["g"], -1)
    ways = {
        "upper_bar": upper - pin,
        "lower_bar": knee - pin,
        "hip": upper - pivot,
        "strut": knee - pivot,
        "tie": heel - rear,
        "shin": heel - knee,
    }
    return {name: math.degrees(cmath.phase(way)) for name, way in ways.items()}


def link(name: str, points: dict[str, complex], mirrored: bool = False) -> list[str]:
    """The table of a bar or a triangle of bars."""
    mass, com, inertia = body(points)
    if mirrored:
        points, com = {key: z.conjugate() for key, z in points.items()}, com.conjugate()
    return table(name, mass, com, inertia, points)


def table(name: str, mass: float, com: complex, inertia: float, points: dict[str, complex]) -> list[str]:
    lines = ["", "[[link]]", f'name = "{name}"', f"mass = {float(mass)!r}", f"inertia = {float(inertia)!r}"]
    lines += [f"com = {pair(com)}"]
    return [*lines, "points = { " + ", ".join(f"{key} = {pair(z)}" for key, z in points.items()) + " }"]


def joint(name: str, first: str, second: str, slides: bool = False) -> list[str]:
    kind = ['type = "prismatic"', "axis = [1, 0]"] if slides else []
    return ["", "[[joint]]", f'name = "{name}"', f'between = ["{first}", "{second}"]', *kind]


def shaft(phases: Sequence[float]) -> list[str]:
    """The body's triangle, and the cranks as one link: three bars that meet at the axle."""
    low = BARS["l"]
    lines = link("body", {"P_left": complex(-BARS["a"], -low), "O": 0j, "P_right": complex(BARS["a"], -low)})
    pins = {f"A{number}": cmath.rect(BARS["m"], phase) for number, phase in enumerate((*phases, PUMP))}
    pins = {key: complex(round(z.real, 9), round(z.imag, 9)) for key, z in pins.items()}
    com = sum(pins.values()) / (2 * len(pins))
    mass = len(pins) * BARS["m"]
    return lines + table("shaft", mass, com, mass * (BARS["m"] ** 2 / 3.0 - abs(com) ** 2), {"O": 0j, **pins})


def text(phases: Sequence[float] | None = None, pumps: bool = True) -> str:
    """The scene, with a pair of legs on a crank at each of ``phases`` (rad), and air pumps or none."""
    phases = PHASES if phases is None else phases
    lines = [
        "# A beach animal after Theo Jansen, in flight: a body, a shaft of three cranks, four legs in mirrored pairs",
        "# on two of them, two air pumps on the third. Lengths of the legs are his numbers, in metres; every bar has",
        "# one kilogram per metre, and triangles are three bars each. Written by docs/scripts/strandbeest.py.",
        'name = "strandbeest"',
        *shaft(phases),
    ]
    sketch, joints = {"body": 0.0, "shaft": 0.0}, joint("axle", "body.O", "shaft.O")
    for crank, phase in enumerate(phases):
        for side in ("left", "right"):
            suffix, mirrored = f"{side[0]}{crank}", side == "right"
            for name in LEG:
                lines += link(f"{name}_{suffix}", corners(dict(LINKS[name])), mirrored)
            for name, angle in angles(math.pi - phase if mirrored else phase).items():
                sketch[f"{name}_{suffix}"] = 180.0 - angle if mirrored else angle
            for name, ends in JOINTS.items():
                joints += joint(f"{name}_{suffix}", *(_end(end, suffix, crank, side) for end in ends))
    reach = math.sqrt(ROD**2 - BARS["m"] ** 2)
    at = f"cylinder_left = {-reach:.1f}", f"cylinder_right = {reach:.1f}"
    for sign, side in ((-1, "left"), (1, "right")) if pumps else ():
        lines += link(f"rod_{side}", {"A": 0j, "B": complex(ROD)})
        lines += link(f"piston_{side}", {"B": 0j, "E": complex(sign * PISTON)})
        sketch[f"rod_{side}"] = math.degrees(cmath.phase(complex(sign * reach, -BARS["m"])))
        joints += joint(f"crank_{side}", f"shaft.A{len(phases)}", f"rod_{side}.A")
        joints += joint(f"wrist_{side}", f"rod_{side}.B", f"piston_{side}.B")
        joints += joint(f"cylinder_{side}", "body.O", f"piston_{side}.B", slides=True)
    lines += [*joints, "", "[start.angles]   # a sketch: the loops are closed from here"]
    lines += [f'{name} = "{(angle + 180.0) % 360.0 - 180.0:.1f} deg"' for name, angle in sketch.items()]
    lines += ["", "[start.slides]", *at] if pumps else []
    lines += ["", "[start.angular_velocities]", "body = 0.0", f"shaft = {SPEED!r}"]
    lines += ["", "[gravity]", "g = 9.81", "", "[run]", "until = 2.0"]
    return "\n".join(lines) + "\n"


def _end(end: str, suffix: str, crank: int, side: str) -> str:
    """A joint's side with the names of the leg's own links."""
    owner, point = end.format(crank=crank, side=side).split(".")
    return f"{owner}_{suffix}.{point}" if owner in LEG else f"{owner}.{point}"


if __name__ == "__main__":
    (Path(__file__).parents[2] / "scenes" / "strandbeest.toml").write_text(text())
