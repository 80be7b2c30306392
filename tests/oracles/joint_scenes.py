"""Scenes with joints of every kind, read with ``tomllib`` alone, as systems of the dense reference.

Welded links stay links of their own: a weld is two slots across each other, the first of which holds the angle.
"""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from . import sliding
from .maximal import GROUND, Array, Pin, System, turned
from .sliding import Slot

LIGHT = 1e-3
"""Mass and inertia that stand for zero where only directions matter."""


@dataclass(frozen=True)
class Joined:
    """The system and its slots; ``ends`` says per joint of the scene which pin or slot it is (a weld: the two slots).

    ``names`` are those of all links; ``seats`` give links that are welded on: what to, and the pose there.
    """

    system: System
    slots: tuple[Slot, ...]
    names: tuple[str, ...]
    ends: dict[str, Pin | Slot]
    seats: dict[int, tuple[int, Array]] = field(default_factory=dict)

    def spread(self, links: list[str], poses: Array, velocities: Array) -> tuple[Array, Array]:
        """Poses and velocities of all links, from those of the ``links`` that are left after welding."""
        found, rates = np.zeros((len(self.names), 3)), np.zeros((len(self.names), 3))
        for row, name in enumerate(links):
            found[self.names.index(name)], rates[self.names.index(name)] = poses[row], velocities[row]
        for link, (to, seat) in self.seats.items():
            x, y = turned(found[to, 2], seat[:2])
            found[link] = found[to] + (x, y, seat[2])
            rates[link] = rates[to] + rates[to, 2] * np.array([-y, x, 0.0])
        return found, rates

    def conditioning(self, poses: Array) -> float:
        """How near to dependent the joints are, links without mass taken as light ones."""
        mass, inertia = (np.where(x > 0.0, x, LIGHT) for x in (self.system.mass, self.system.inertia))
        heavy = System(mass, inertia, self.system.com, self.system.pins, self.system.gravity)
        return sliding.conditioning(heavy, self.slots, poses)


def read(path: Path) -> Joined:
    """Links and joints of the general form, and gravity down the y axis; of a scene with parts its text by hand."""
    by_hand = Path(__file__).with_name(f"{path.stem}-by-hand.toml")
    tables = tomllib.loads((by_hand if by_hand.exists() else path).read_text())
    links: list[dict[str, Any]] = tables["link"]
    names = tuple(link["name"] for link in links)
    points = {link["name"]: link["points"] for link in links} | {"ground": tables.get("ground_link", {}).get("points")}

    def end(text: str) -> tuple[int, tuple[float, float]]:
        link, point = text.split(".")
        x, y = points[link][point]
        return (names.index(link) if link in names else GROUND), (float(x), float(y))

    pins: list[Pin] = []
    slots: list[Slot] = []
    ends: dict[str, Pin | Slot] = {}
    seats: dict[int, tuple[int, Array]] = {}
    for joint in tables["joint"]:
        (a, on_a), (b, on_b) = map(end, joint["between"])
        kind, angle = joint.get("type", "revolute"), _angle(joint.get("angle", 0.0))
        if kind == "revolute":
            pins.append(Pin(a, on_a, b, on_b))
            ends[joint["name"]] = pins[-1]
        elif kind == "weld":
            slots += [Slot(a, on_a, 0.0, b, on_b, angle), Slot(a, on_a, math.pi / 2.0, b, on_b)]
            seats[b] = a, np.array([*(on_a - turned(np.asarray(angle), on_b)), angle])
        else:
            x, y = joint["axis"]
            slots.append(Slot(a, on_a, math.atan2(y, x), b, on_b, angle if kind == "prismatic" else None))
            ends[joint["name"]] = slots[-1]
    mass, inertia = (np.array([float(link[key]) for link in links]) for key in ("mass", "inertia"))
    com = np.array([link["com"] for link in links], dtype=float)
    system = System(mass, inertia, com, tuple(pins), float(tables["gravity"]["g"]))
    return Joined(system, tuple(slots), names, ends, seats)


def _angle(value: float | str) -> float:
    """Radians, from a number or a text such as ``"30 deg"``."""
    return math.radians(float(value.removesuffix("deg"))) if isinstance(value, str) else float(value)
