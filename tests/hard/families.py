"""Families of random mechanisms: open chains, trees, loops that share links, slides, stops, discs, boxes, sizes and
masses far apart, and some with springs, motors and dampers. ``test_families.py`` draws from here, and
``family_runs.py`` runs what is drawn.

A family has a few scenes, each compiled once, and draws numbers for them: places of joints, masses, grounds and
coefficients. Links are drawn where they lie at the start, with frames at the origin: every point is a place of the
drawing, so that loops are closed whatever the places are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..support.touching_scenes import free_body

RTOL = 1e-11
LAWS = ("newton", "poisson", "stronge")
Places = dict[str, tuple[float, float]]
Numbers = dict[str, float]


@dataclass(frozen=True)
class Throw:
    """One run: a scene's text, values of its parameters, how wildly it starts, and for how many seconds it goes on.

    Grounds and stops are put around the start, ``clear`` lengths away at most.
    """

    family: str
    number: int
    text: str
    values: Numbers
    law: str
    bend: float
    spin: float
    seconds: float
    clear: float
    rtol: float
    seed: int


@dataclass
class Drawing:
    """Links by the places that they have, on the ground or floating; links with a place in common are joined there."""

    places: Places
    links: dict[str, tuple[str, ...]]
    pivots: tuple[str, ...] = ()
    slides: dict[tuple[str, str], tuple[str, float]] = field(default_factory=dict)
    """Of pairs of links, the place at which the second slides along a line of the first, and its direction (rad)."""
    size: float = 1.0

    def scatter(self, rng: np.random.Generator, part: float = 0.25) -> Places:
        """Other places, moved by a part of a metre."""
        return {name: (x + rng.normal() * part, y + rng.normal() * part) for name, (x, y) in self.places.items()}

    def text(self) -> str:
        """The mechanism's tables."""
        told = ""
        for link, (mass, inertia, com) in self._bodies(self.places, dict.fromkeys(self.links, 1.0)).items():
            points = ", ".join(f"{name} = {list(self.places[name])}" for name in self.links[link])
            told += f'[[link]]\nname = "{link}"\nmass = {mass!r}\ninertia = {inertia!r}\ncom = {list(com)}\n'
            told += f"points = {{ {points} }}\n"
        fixed = {name: self.places[name] for name in self.pivots}
        fixed |= {name: self.places[name] for (a, _), (name, _) in self.slides.items() if a == "ground"}
        if fixed:
            told += f"[ground_link]\npoints = {{ {', '.join(f'{n} = {list(p)}' for n, p in fixed.items())} }}\n"
        for a, b, place in self.joints():
            told += f'[[joint]]\nname = "{a}_{b}"\nbetween = ["{a}.{place}", "{b}.{place}"]\n'
        for (a, b), (place, axis) in self.slides.items():
            told += f'[[joint]]\nname = "{a}_{b}"\ntype = "prismatic"\naxis = {axis!r}\n'
            told += f'between = ["{a}.{place}", "{b}.{place}"]\n'
        return told

    def joints(self) -> list[tuple[str, str, str]]:
        """Pairs of links that are pinned together, and where."""
        found = []
        sliding = {(pair, place) for pair, (place, _) in self.slides.items()}
        for place in self.places:
            there = [link for link, names in self.links.items() if place in names]
            if place in self.pivots:
                there = ["ground", *there]
            pairs = [(there[0], other) for other in there[1:]]
            found += [(a, b, place) for a, b in pairs if ((a, b), place) not in sliding and a != b]
        return found

    def numbers(self, places: Places, masses: Numbers) -> Numbers:
        """Parameters of the links with these places and masses."""
        values: Numbers = {}
        for link, (mass, inertia, com) in self._bodies(places, masses).items():
            values |= {
                f"{link}.mass": mass,
                f"{link}.inertia": inertia,
                f"{link}.com.x": com[0],
                f"{link}.com.y": com[1],
            }
            for name in self.links[link]:
                values |= {f"{link}.points.{name}.{axis}": places[name][k] for k, axis in enumerate("xy")}
        for name in (*self.pivots, *(name for (a, _), (name, _) in self.slides.items() if a == "ground")):
            values |= {f"ground.points.{name}.{axis}": places[name][k] for k, axis in enumerate("xy")}
        return values

    def _bodies(self, places: Places, masses: Numbers) -> dict[str, tuple[float, float, tuple[float, float]]]:
        """Mass, inertia and mass centre of each link: half its mass in its points, half between them."""
        found = {}
        for link, names in self.links.items():
            at = np.array([places[name] for name in names])
            centre = at.mean(axis=0)
            spread = 0.5 * float(np.mean(np.sum((at - centre) ** 2, axis=1)))
            found[link] = (masses[link], masses[link] * spread, (float(centre[0]), float(centre[1])))
        return found


# -- what acts ---------------------------------------------------------------------------------------------------------


def grounds(count: int, rough: Sequence[bool], contacts: Sequence[str] = (), radius: float = 0.0) -> str:
    """Half-planes: the first below, the next at the sides, the last above; some of them rough."""
    told = ""
    for k in range(count):
        angle = 0.5 * np.pi * (1 + k) + 0.02
        x, y = float(np.cos(angle)), float(np.sin(angle))
        told += f"[[ground]]\nrestitution = 0.5\nnormal = [{x!r}, {y!r}]\npoint = [{-9.0 * x!r}, {-9.0 * y!r}]\n"
        told += f"contacts = {list(contacts)}\n".replace("'", '"') if contacts else ""
        told += "friction = 0.5\n" if rough[k % len(rough)] else ""
        told += f"radius = {radius!r}\n" if radius else ""
    return told


def gravity(on: bool) -> str:
    return "[gravity]\ng = 9.81\n" if on else ""


def coefficients(text: str, rng: np.random.Generator) -> Numbers:
    """e from 0 to 1 and mu from nearly 0 to 2, for each surface or the same for all; tilts of the grounds."""
    values: Numbers = {}
    alike = rng.random() < 0.4
    e, mu = _e(rng), _mu(rng)
    counts = {kind: text.count(f"[[{kind}]]") for kind in ("ground", "touch", "stop")}
    for kind, count in counts.items():
        tables = text.split(f"[[{kind}]]")[1:]
        for k in range(count):
            values[f"{kind}_{k}.restitution"] = e if alike else _e(rng)
            if "friction =" in tables[k].split("[[")[0]:
                values[f"{kind}_{k}.friction"] = mu if alike else _mu(rng)
    tilted = rng.random() < 0.6
    for k in range(counts["ground"]):
        angle = 0.5 * np.pi * (1 + (k if counts["ground"] != 2 else 0)) + (rng.uniform(-0.5, 0.5) if tilted else 0.0)
        values |= {f"ground_{k}.normal.x": float(np.cos(angle)), f"ground_{k}.normal.y": float(np.sin(angle))}
    return values


def _e(rng: np.random.Generator) -> float:
    return float(rng.choice([0.0, 1.0, 0.5, rng.uniform(0.0, 1.0)]))


def _mu(rng: np.random.Generator) -> float:
    return float(rng.choice([1e-3, 0.1, 0.3, 0.7, 2.0, rng.uniform(0.0, 2.0) + 1e-9]))


def masses(drawing: Drawing, rng: np.random.Generator) -> Numbers:
    return {link: float(np.exp(rng.uniform(np.log(0.3), np.log(3.0)))) for link in drawing.links}


# -- drawings ----------------------------------------------------------------------------------------------------------


def row(n: int, pinned: bool = False) -> Drawing:
    """An open chain of n links; its first end may be on the ground."""
    places = {f"P{k}": (k + 0.01, 0.3 * (k % 2) + 0.01) for k in range(n + 1)}
    return Drawing(places, {f"l{k}": (f"P{k}", f"P{k + 1}") for k in range(n)}, ("P0",) if pinned else ())


TREE = Drawing(
    {
        "P0": (0.01, 0.01), "P1": (1.0, 0.1), "P2": (-0.8, 0.4),
        "P3": (-0.2, -1.0), "P4": (1.6, 0.9), "P5": (1.7, -0.8),
        "P6": (-1.5, 1.0), "P7": (-1.6, -0.4), "P8": (-0.4, -2.0),
    },
    {
        "trunk": ("P0", "P1", "P2", "P3"), "a": ("P1", "P4"), "b": ("P1", "P5"), "c": ("P2", "P6"), "d": ("P2", "P7"),
        "e": ("P3", "P8"),
    },
)  # fmt: skip
WATT = Drawing(
    {
        "J0": (0.01, 0.01), "J1": (1.0, 0.1), "J2": (0.6, -0.7),
        "J3": (-1.0, 0.1), "J4": (-0.6, -0.7), "J5": (0.02, 1.2),
        "J6": (0.03, -1.6),
    },
    {
        "s": ("J0", "J1", "J2"), "t": ("J0", "J3", "J4"), "a": ("J1", "J5"), "b": ("J5", "J3"), "c": ("J2", "J6"),
        "d": ("J6", "J4"),
    },
)  # fmt: skip
STEPHENSON = Drawing(
    {
        "J0": (1.0, 0.9), "J1": (1.1, 0.01), "J2": (1.0, -0.9),
        "J3": (-1.0, 0.9), "J4": (-1.1, 0.02), "J5": (-1.0, -0.9),
        "J6": (0.01, -2.0),
    },
    {
        "s": ("J0", "J1", "J2"), "t": ("J3", "J4", "J5"), "a": ("J0", "J3"), "b": ("J1", "J4"), "c": ("J2", "J6"),
        "d": ("J6", "J5"),
    },
)  # fmt: skip
TWO_LOOPS = Drawing(
    {
        "J0": (0.01, 0.6), "J1": (0.02, -0.6), "J2": (1.0, 0.9),
        "J3": (1.1, -0.8), "J4": (-1.0, 0.8), "J5": (-1.1, -0.9),
    },
    {
        "s": ("J0", "J1"), "a": ("J0", "J2"), "b": ("J2", "J3"),
        "c": ("J3", "J1"), "d": ("J0", "J4"), "e": ("J4", "J5"),
        "f": ("J5", "J1"),
    },
)  # fmt: skip
GROUNDED_WATT = Drawing(
    {
        "O": (0.01, 0.01), "Q": (1.8, 0.02), "J1": (0.1, 0.6), "J2": (1.6, 1.2), "J3": (2.4, 1.0), "J4": (3.0, 0.4),
        "R": (3.1, -0.6),
    },
    {"crank": ("O", "J1"), "bar": ("J1", "J2"), "rocker": ("Q", "J2", "J3"), "rod": ("J3", "J4"), "foot": ("J4", "R")},
    ("O", "Q", "R"),
)  # fmt: skip
TELESCOPE = Drawing(
    {"J0": (0.01, 0.01), "J1": (1.5, 0.1), "J2": (0.6, 1.3), "S": (1.0, 0.8), "E": (0.1, 1.9)},
    {"a": ("J0", "J1"), "b": ("J1", "S"), "c": ("S", "J2"), "d": ("J2", "J0", "E")},
    slides={("b", "c"): ("S", 2.1)},
)
CART = Drawing(
    {"S": (0.01, 0.02), "A": (0.4, -0.1), "B": (0.6, -1.1), "C": (0.1, -1.8), "D": (-0.5, -0.1), "E": (-0.6, -1.2)},
    {"cart": ("S", "A", "D"), "a": ("A", "B"), "b": ("B", "C"), "c": ("D", "E")},
    slides={("ground", "cart"): ("S", 0.05)},
)
CRANK = Drawing(
    {"O": (0.01, 0.02), "A": (0.3, 0.4), "S": (1.6, 0.1), "T": (1.9, 0.5), "E": (2.3, -0.8)},
    {"crank": ("O", "A"), "rod": ("A", "S"), "slider": ("S", "T"), "tail": ("T", "E")},
    ("O",),
)


def polygon(n: int) -> Drawing:
    """A loop of n links."""
    turn = 2.0 * np.pi / n
    places = {
        f"P{k}": (float(np.cos(k * turn + 0.1)) / turn * 1.0, float(np.sin(k * turn + 0.1)) / turn) for k in range(n)
    }
    return Drawing(places, {f"l{k}": (f"P{k}", f"P{(k + 1) % n}") for k in range(n)})


def ends(drawing: Drawing) -> list[str]:
    """Every place that is not fixed, by the first link that has it."""
    held = {*drawing.pivots, *(name for (a, _), (name, _) in drawing.slides.items() if a == "ground")}
    return [
        f"{next(link for link, names in drawing.links.items() if place in names)}.{place}"
        for place in drawing.places
        if place not in held and any(place in names for names in drawing.links.values())
    ]


# -- families ----------------------------------------------------------------------------------------------------------


def _thrown(
    drawing: Drawing,
    rng: np.random.Generator,
    *,
    planes: int = 1,
    rough: Sequence[bool] = (True,),
    falls: bool = True,
    more: str = "",
    part: float = 0.25,
    radius: float = 0.0,
    spin: float = 3.0,
    bend: float = 0.7,
) -> dict[str, Any]:
    text = drawing.text() + gravity(falls) + grounds(planes, rough, ends(drawing), radius) + more
    values = drawing.numbers(drawing.scatter(rng, part), masses(drawing, rng)) | coefficients(text, rng)
    if falls and rng.random() < 0.1:
        values["gravity.g"] = 1e-3
    if radius:
        values |= {f"ground_{k}.radius": float(rng.uniform(0.02, 0.2)) for k in range(planes)}
    return {"text": text, "values": values, "bend": bend, "spin": spin}


def chains(rng: np.random.Generator) -> dict[str, Any]:
    """Open chains, free in the plane, on one or two grounds."""
    drawing = row(int(rng.choice([1, 3, 6])))
    return _thrown(drawing, rng, planes=int(rng.choice([1, 2])), rough=(True, False))


def trees(rng: np.random.Generator) -> dict[str, Any]:
    """A trunk with five branches, on grounds that are rough or smooth."""
    return _thrown(TREE, rng, planes=2, rough=(bool(rng.integers(2)),))


def shared(rng: np.random.Generator) -> dict[str, Any]:
    """Loops that share links: six-bars of Watt and Stephenson, floating or on the ground, and two loops with a side."""
    drawing = (WATT, STEPHENSON, TWO_LOOPS, GROUNDED_WATT)[rng.integers(4)]
    return _thrown(drawing, rng, planes=2, rough=(True, False), part=0.12)


def slides(rng: np.random.Generator) -> dict[str, Any]:
    """A loop with a side that slides, and a cart on a rail with pendulums, between a floor and a wall."""
    drawing = (TELESCOPE, CART)[rng.integers(2)]
    return _thrown(drawing, rng, planes=2, rough=(bool(rng.integers(2)), False), part=0.12, bend=0.4)


def stops(rng: np.random.Generator) -> dict[str, Any]:
    """Joints with stops at both sides, of chains that hang and of loops that fall."""
    drawing = row(4, pinned=True) if rng.integers(2) else polygon(6)
    more = "".join(
        f'[[stop]]\njoint = "{a}_{b}"\nlowest = -1.0\nhighest = 1.0\nrestitution = 0.5\n'
        for a, b, _ in drawing.joints()[:4]
    )
    return _thrown(drawing, rng, planes=1, rough=(True,), more=more)


def _balls(count: int, rough: bool, law: str = "") -> str:
    names = [f"ball_{k}" for k in range(count)]
    places = [(0.6 * (k % 2) + 0.05 * k + 0.01, 0.6 * (k // 2) + 0.01) for k in range(count)]
    bodies = "".join(free_body(name, 1.0, 0.01, "C = [0, 0]") for name in names)
    touch = "restitution = 0.5\n" + ("friction = 0.5\n" if rough else "")
    pairs = "".join(
        f'[[touch]]\nbetween = ["{a}.C", "{b}.C"]\nradius = [0.12, 0.13]\n{touch}'
        for i, a in enumerate(names)
        for b in names[i + 1 :]
    )
    told = ", ".join(
        f"{axis}_{name} = {place[k]!r}"
        for name, place in zip(names, places, strict=True)
        for k, axis in enumerate("xy")
    )
    contacts = [f"{name}.C" for name in names]
    return (
        f"[ground_link]\npoints = {{ O = [0, 0] }}\n{bodies}{pairs}[start]\nslides = {{ {told} }}\n"
        + grounds(4, (rough, False), contacts, 0.1)
        + gravity(True)
    )


def discs(rng: np.random.Generator) -> dict[str, Any]:
    """Discs, each free in the plane, in a box of four walls; every one touches every other."""
    count, rough = int(rng.choice([2, 4])), bool(rng.integers(2))
    text = _balls(count, rough)
    values = coefficients(text, rng)
    for k in range(count):
        mass = float(np.exp(rng.uniform(np.log(0.1), np.log(10.0))))
        values |= {f"ball_{k}.mass": mass, f"ball_{k}.inertia": mass * 0.12**2 * float(rng.uniform(0.3, 1.0))}
    if rng.random() < 0.3:
        values["gravity.g"] = 1e-6
    return {"text": text, "values": values, "bend": 0.05, "spin": 3.0}


def edges(rng: np.random.Generator) -> dict[str, Any]:
    """A chain of links with discs at their ends above a seesaw, on which it lands, and a disc that rolls on its own."""
    rough = bool(rng.integers(2))
    touch = "restitution = 0.5\n" + ("friction = 0.5\n" if rough else "")
    drawing = Drawing(
        {"O": (0.01, 0.01), "A": (-1.5, 0.1), "B": (1.5, 0.2)},
        {"plank": ("A", "O", "B")},
        ("O",),
    )
    text = drawing.text() + free_body("ball", 1.0, 0.01, "C = [0, 0]")
    text += free_body("rod", 1.0, 0.05, "C = [0, 0], L = [-0.4, 0.01], R = [0.4, 0.02]")
    for centre in ("ball.C", "rod.L", "rod.R"):
        text += f'[[touch]]\nbetween = ["{centre}", ["plank.A", "plank.B"]]\nradius = [0.15, 0.02]\n{touch}'
    text += f'[[touch]]\nbetween = ["ball.C", ["rod.L", "rod.R"]]\nradius = [0.15, 0.03]\n{touch}'
    text += "[start]\nslides = { x_ball = -0.8, y_ball = 1.3, x_rod = 0.4, y_rod = 0.7 }\n"
    text += gravity(True) + grounds(1, (rough,), ["ball.C", "rod.L", "rod.R", "plank.A", "plank.B"], 0.15)
    values = coefficients(text, rng)
    values |= {f"{link}.mass": float(np.exp(rng.uniform(-1.5, 1.5))) for link in ("plank", "ball", "rod")}
    return {"text": text, "values": values, "bend": 0.1, "spin": 1.0, "clear": 0.5}


def boxes(rng: np.random.Generator) -> dict[str, Any]:
    """Loops and chains in boxes of four walls, with gravity or without, some at 100 rad/s."""
    drawing = (row(2), polygon(4), polygon(5))[rng.integers(3)]
    found = _thrown(drawing, rng, planes=4, rough=(bool(rng.integers(2)), True), spin=3.0)
    if rng.random() < 0.5:
        found["values"]["gravity.g"] = 1e-9
        found["spin"] = 30.0
    return found


def spins(rng: np.random.Generator) -> dict[str, Any]:
    """No gravity, a hundred radians a second, between two walls."""
    drawing = (row(3), polygon(5), WATT)[rng.integers(3)]
    found = _thrown(drawing, rng, planes=4, rough=(True, False), falls=False, spin=100.0, part=0.1)
    return found | {"seconds": 0.5}


def scales(rng: np.random.Generator) -> dict[str, Any]:
    """Lengths and masses from 1e-3 to 1e3 in one mechanism: chains of any lengths, loops whose two longest are alike.

    Accelerations are known to 1e-5 in some: with tighter tolerances steps would follow their rounding.
    """
    n = int(rng.choice([3, 5]))
    looped = bool(rng.integers(2))
    drawing = polygon(n) if looped else row(n)
    found = _thrown(drawing, rng, planes=1, rough=(True,), bend=0.3)
    lengths = np.exp(rng.uniform(np.log(1e-3), np.log(1e3), n))
    if looped:
        first, second = np.argsort(lengths)[::-1][:2]
        rest = lengths.sum() - lengths[first] - lengths[second]
        lengths[second] = lengths[first] - rest * rng.uniform(-0.7, 0.7)
        places = _closed(lengths, rng)
    else:
        at = np.vstack([np.zeros(2), np.cumsum(lengths[:, None] * _directions(rng.uniform(0.0, 6.28, n)), axis=0)])
        places = {f"P{k}": (float(x), float(y)) for k, (x, y) in enumerate(at)}
    heavy = {link: float(np.exp(rng.uniform(np.log(1e-3), np.log(1e3)))) for link in drawing.links}
    found["values"] |= drawing.numbers(places, heavy)
    largest = float(lengths.max())
    return found | {
        "seconds": float(rng.uniform(0.5, 1.0) * np.sqrt(largest)),
        "clear": 0.3,
        "spin": largest**-0.5,
        "rtol": 1e-9,
    }


def _directions(angles: Any) -> Any:
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)


def _closed(lengths: Any, rng: np.random.Generator) -> Places:
    """Corners of a polygon of these sides: on a circle, by bisection for its radius; its centre is inside or not."""
    longest = int(np.argmax(lengths))
    others = np.delete(lengths, longest)

    def half_angles(radius: float) -> Any:
        return np.arcsin(np.minimum(1.0, lengths / (2.0 * radius)))

    low, high = lengths[longest] / 2.0, lengths.sum() * 1e6
    inside = half_angles(low).sum() >= np.pi
    for _ in range(200):
        radius = np.sqrt(low * high)
        halves = half_angles(radius)
        rest = np.delete(halves, longest).sum()
        surplus = halves.sum() - np.pi if inside else halves[longest] - rest
        low, high = (radius, high) if (surplus > 0.0) else (low, radius)
    turns = 2.0 * half_angles(radius)
    if not inside:
        turns[longest] = -np.delete(turns, longest).sum()
    assert others.size
    angles = rng.uniform(0.0, 6.28) + np.concatenate([[0.0], np.cumsum(turns)[:-1]])
    at = radius * (_directions(angles) - _directions(angles[:1]))
    return {f"P{k}": (float(x), float(y)) for k, (x, y) in enumerate(at)}


def powered(rng: np.random.Generator) -> dict[str, Any]:
    """Springs, dampers, motors, torsion springs and dry joints, on chains and loops between two grounds."""
    drawing = row(4, pinned=True) if rng.integers(2) else polygon(5)
    first, second = drawing.joints()[:2]
    a, b = f"l0.{drawing.links['l0'][1]}", f"l3.{drawing.links['l3'][1]}"
    more = f'[[spring]]\nbetween = ["{a}", "{b}"]\nstiffness = 50.0\nlength = 0.7\n'
    more += f'[[damper]]\nbetween = ["{a}", "{b}"]\ndamping = 0.1\n'
    more += f'[[motor]]\njoint = "{first[0]}_{first[1]}"\ntorque = "5*sin(3*t)"\n'
    more += f'[[torsion]]\njoint = "{second[0]}_{second[1]}"\nstiffness = 5.0\nangle = 0.4\ndamping = 0.05\n'
    more += f'[[joint_friction]]\njoints = ["{second[0]}_{second[1]}"]\nviscous = 0.01\ndry = 0.1\n'
    found = _thrown(drawing, rng, planes=2, rough=(True, False), more=more)
    found["values"] |= {"spring_0.stiffness": float(np.exp(rng.uniform(np.log(1.0), np.log(1e4))))}
    return found


def wheels(rng: np.random.Generator) -> dict[str, Any]:
    """Links with round feet on grounds."""
    drawing = (row(1), row(3), polygon(4))[rng.integers(3)]
    return _thrown(drawing, rng, planes=2, rough=(True,), radius=0.1)


FAMILIES: dict[str, Callable[[np.random.Generator], dict[str, Any]]] = {
    "chains": chains,
    "trees": trees,
    "shared": shared,
    "slides": slides,
    "stops": stops,
    "discs": discs,
    "edges": edges,
    "boxes": boxes,
    "spins": spins,
    "scales": scales,
    "powered": powered,
    "wheels": wheels,
}


def throw(family: str, number: int, seed: int = 0) -> Throw:
    """The throw of a family with this number: the same on every machine."""
    rng = np.random.default_rng([seed, list(FAMILIES).index(family), number])
    drawn = FAMILIES[family](rng)
    return Throw(
        family,
        number,
        f'name = "{family}"\n' + drawn["text"],
        drawn["values"],
        LAWS[rng.integers(3)],
        drawn["bend"],
        drawn["spin"],
        drawn.get("seconds", float(rng.uniform(2.0, 5.0))),
        drawn.get("clear", 1.0),
        drawn.get("rtol", RTOL),
        int(rng.integers(2**31)),
    )


def throws(count: int, seed: int = 0) -> Iterator[Throw]:
    """The first throws, by turns of each family."""
    for number in range(count):
        yield throw(list(FAMILIES)[number % len(FAMILIES)], number // len(FAMILIES), seed)
