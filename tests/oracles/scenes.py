"""What a scene file describes, read with ``tomllib`` alone, as a system of the dense reference."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from .maximal import GROUND, Pin, System


def read_system(path: Path) -> System:
    """Links and revolute joints of the general form, and gravity down the y axis."""
    tables = tomllib.loads(path.read_text())
    if "four_bars" in tables:
        return row_of_four_bars(tables["four_bars"]["count"], tables["gravity"]["g"])
    links: list[dict[str, Any]] = tables["link"]
    number = {link["name"]: k for k, link in enumerate(links)}
    points = {link["name"]: link["points"] for link in links} | {"ground": tables.get("ground_link", {}).get("points")}

    def end(text: str) -> tuple[int, tuple[float, float]]:
        link, point = text.split(".")
        x, y = points[link][point]
        return number.get(link, GROUND), (float(x), float(y))

    pins = tuple(Pin(*end(joint["between"][0]), *end(joint["between"][1])) for joint in tables["joint"])
    mass, inertia = (np.array([float(link[key]) for link in links]) for key in ("mass", "inertia"))
    com = np.array([link["com"] for link in links], dtype=float)
    return System(mass, inertia, com, pins, float(tables["gravity"]["g"]))


def row_of_four_bars(count: int, gravity: float) -> System:
    """Unit rods: uprights 0 … count, then the bars between the heads of neighbours."""
    n = 2 * count + 1
    pins = [Pin(GROUND, (float(k), 0.0), k, (0.0, 0.0)) for k in range(count + 1)]
    for k in range(count):
        bar = count + 1 + k
        pins += [Pin(k, (1.0, 0.0), bar, (0.0, 0.0)), Pin(k + 1, (1.0, 0.0), bar, (1.0, 0.0))]
    return System(np.ones(n), np.ones(n) / 12.0, np.tile((0.5, 0.0), (n, 1)), tuple(pins), gravity)
