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

CENTIMETRES = 100.0
"""How many of Jansen's units are a metre: so the legs are as long as his numbers in centimetres."""
PHASES = (0.0, math.pi)
"""Angles of the cranks on the shaft (rad); each moves a leg on the left and its mirror image on the right."""
PUMP, ROD, PISTON = math.pi / 2.0, 30.0, 8.0
"""Angle of the pumps' crank on the shaft (rad), lengths of the pumps' rods and pistons in Jansen's units."""
SPEED = 6.0
"""Angular velocity of the shaft at the start, rad/s."""
LEG = tuple(name for name in LINKS if name != "crank")
JOINTS = {
    "pin_upper": ("pin", "upper_bar.A"),
    "pin_lower": ("pin", "lower_bar.A"),
    "shoulder": ("upper_bar.B", "hip.B"),
    "pivot_hip": ("pivot", "hip.P"),
    "pivot_strut": ("pivot", "strut.P"),
    "knee_strut": ("lower_bar.C", "strut.C"),
    "knee_shin": ("lower_bar.C", "shin.C"),
    "rear": ("hip.D", "tie.D"),
    "heel": ("tie.E", "shin.E"),
}
"""Joints of a leg, whose pin is on a crank and whose pivot on the body."""


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


def link(name: str, points: dict[str, complex], part: bool = False) -> list[str]:
    """The table of a bar or a triangle of bars, of the scene or of its ``part``."""
    mass, com, inertia = body(points)
    return table(name, mass, com, inertia, points, part)


def table(
    name: str, mass: float, com: complex, inertia: float, points: dict[str, complex], part: bool = False
) -> list[str]:
    header = "[[part.link]]" if part else "[[link]]"
    lines = ["", header, f'name = "{name}"', f"mass = {float(mass)!r}", f"inertia = {float(inertia)!r}"]
    lines += [f"com = {pair(com)}"]
    return [*lines, "points = { " + ", ".join(f"{key} = {pair(z)}" for key, z in points.items()) + " }"]


def joint(name: str, first: str, second: str, part: bool = False, slides: bool = False) -> list[str]:
    kind = ['type = "prismatic"', "axis = [1, 0]"] if slides else []
    header = "[[part.joint]]" if part else "[[joint]]"
    return ["", header, f'name = "{name}"', f'between = ["{first}", "{second}"]', *kind]


def in_metres(points: dict[str, complex], per_metre: float) -> dict[str, complex]:
    return {key: complex(z.real / per_metre, z.imag / per_metre) for key, z in points.items()}


def leg(per_metre: float) -> list[str]:
    """One leg, its hips to the left of the shaft."""
    lines = ["", "[[part]]", 'name = "leg"', 'ports = ["pin", "pivot"]']
    for name in LEG:
        lines += link(name, in_metres(corners(dict(LINKS[name])), per_metre), part=True)
    for name, ends in JOINTS.items():
        lines += joint(name, *ends, part=True)
    return lines


def pump(per_metre: float) -> list[str]:
    """A pump's rod and piston; ``side`` is -1 to the left and 1 to the right."""
    lines = ["", "[[part]]", 'name = "pump"', 'ports = ["pin", "guide"]', "let = { side = 1 }"]
    lines += link("rod", in_metres({"A": 0j, "B": complex(ROD)}, per_metre), part=True)
    piston = in_metres({"B": 0j, "E": complex(PISTON)}, per_metre)
    mass, com, inertia = body(piston)
    lines += ["", "[[part.link]]", 'name = "piston"', f"mass = {mass!r}", f"inertia = {inertia!r}"]
    lines += [f'com = ["{com.real}*side", 0]', f'points = {{ B = [0, 0], E = ["{piston["E"].real}*side", 0] }}']
    lines += joint("crank", "pin", "rod.A", part=True)
    lines += joint("wrist", "rod.B", "piston.B", part=True)
    return lines + joint("cylinder", "guide", "piston.B", part=True, slides=True)


def place(part: str, name: str, ports: dict[str, str], *keys: str) -> list[str]:
    given = ", ".join(f'{port} = "{point}"' for port, point in ports.items())
    return ["", "[[place]]", f'part = "{part}"', f'name = "{name}"', *keys, f"ports = {{ {given} }}"]


def shaft(phases: Sequence[float], per_metre: float) -> list[str]:
    """The body's triangle, and the cranks as one link: three bars that meet at the axle."""
    low, crank = BARS["l"], BARS["m"] / per_metre
    hips = {"P_left": complex(-BARS["a"], -low), "O": 0j, "P_right": complex(BARS["a"], -low)}
    lines = link("body", in_metres(hips, per_metre))
    pins = {f"A{number}": cmath.rect(crank, phase) for number, phase in enumerate((*phases, PUMP))}
    pins = {key: complex(round(z.real, 9), round(z.imag, 9)) for key, z in pins.items()}
    com = sum(pins.values()) / (2 * len(pins))
    mass = len(pins) * crank
    return lines + table("shaft", mass, com, mass * (crank**2 / 3.0 - abs(com) ** 2), {"O": 0j, **pins})


def text(phases: Sequence[float] | None = None, pumps: bool = True, per_metre: float = CENTIMETRES) -> str:
    """The scene, with a pair of legs on a crank at each of ``phases`` (rad), and air pumps or none."""
    phases = PHASES if phases is None else phases
    lines = [
        "# A beach animal after Theo Jansen, in flight: a body, a shaft of three cranks, four legs in mirrored pairs",
        "# on two of them, two air pumps on the third. Lengths of the legs are his numbers, in centimetres; every bar",
        "# has one kilogram per metre, and triangles are three bars each. Written by docs/scripts/strandbeest.py.",
        'name = "strandbeest"',
        *shaft(phases, per_metre),
    ]
    lines += [*joint("axle", "body.O", "shaft.O"), *leg(per_metre), *(pump(per_metre) if pumps else [])]
    for crank, phase in enumerate(phases):
        for side in ("left", "right"):
            mirrored = side == "right"
            sketch = angles(math.pi - phase if mirrored else phase)
            ways = ", ".join(f'{name} = "{angle:.1f} deg"' for name, angle in sketch.items())
            keys = [*(["mirror = true"] if mirrored else []), f"start.angles = {{ {ways} }}"]
            lines += place("leg", f"{side[0]}{crank}", {"pin": f"shaft.A{crank}", "pivot": f"body.P_{side}"}, *keys)
    reach = math.sqrt(ROD**2 - BARS["m"] ** 2)
    for sign, side in ((-1, "left"), (1, "right")) if pumps else ():
        angle = math.degrees(cmath.phase(complex(sign * reach, -BARS["m"])))
        slide = f"{sign * reach / per_metre:.3g}"
        start = f'start = {{ angles = {{ rod = "{angle:.1f} deg" }}, slides = {{ cylinder = {slide} }} }}'
        ports = {"pin": f"shaft.A{len(phases)}", "guide": "body.O"}
        lines += place("pump", side, ports, f"let = {{ side = {sign} }}", start)
    lines += ["", "[start.angles]   # roughly: the loops are closed from here", "body = 0.0", "shaft = 0.0"]
    return "\n".join([*lines, *_end()]) + "\n"


def plain(phases: Sequence[float], per_metre: float = CENTIMETRES) -> str:
    """The scene without pumps, every leg with tables of its own, for versions of ccgen that know of no parts."""
    lines, joints = ['name = "strandbeest"', *shaft(phases, per_metre)], joint("axle", "body.O", "shaft.O")
    sketch = {"body": 0.0, "shaft": 0.0}
    for crank, phase in enumerate(phases):
        for side in ("left", "right"):
            leg, mirrored = f"{side[0]}{crank}", side == "right"
            for name in LEG:
                points = in_metres(corners(dict(LINKS[name])), per_metre)
                mass, com, inertia = body(points)
                if mirrored:
                    points, com = {key: z.conjugate() for key, z in points.items()}, com.conjugate()
                lines += table(f"{name}_{leg}", mass, com, inertia, points)
            for name, angle in angles(math.pi - phase if mirrored else phase).items():
                sketch[f"{name}_{leg}"] = 180.0 - angle if mirrored else angle
            outside = {"pin": f"shaft.A{crank}", "pivot": f"body.P_{side}"}
            for name, ends in JOINTS.items():
                found = [outside.get(end) or end.replace(".", f"_{leg}.") for end in ends]
                joints += joint(f"{name}_{leg}", *found)
    lines += [*joints, "", "[start.angles]"]
    lines += [f'{name} = "{(angle + 180.0) % 360.0 - 180.0:.1f} deg"' for name, angle in sketch.items()]
    return "\n".join([*lines, *_end()]) + "\n"


def _end() -> list[str]:
    """How fast it begins, and how long it flies."""
    lines = ["", "[start.angular_velocities]", "body = 0.0", f"shaft = {SPEED!r}"]
    return [*lines, "", "[gravity]", "g = 9.81", "", "[run]", "until = 2.0"]


if __name__ == "__main__":
    (Path(__file__).parents[2] / "scenes" / "strandbeest.toml").write_text(text())
