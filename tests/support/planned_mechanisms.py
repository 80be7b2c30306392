"""Mechanisms for tests of plans: with dyads, with rows of links long enough for segments, and rings."""

from __future__ import annotations

from typing import Any

from ccgen.generator.scene import read_tables
from ccgen.generator.scene.scene import Scene

from ..oracles import graphs
from ..oracles.graphs import Edges
from ..oracles.maximal import GROUND
from .large_mechanisms import near_chain, walking

MECHANISMS: dict[str, Edges] = {
    "four-bar": [(GROUND, 0), (0, 1), (1, 2), (2, GROUND)],
    "one leg": walking(1),
    "four legs": walking(4),
    "grounded ladder": graphs.ladder(5, grounded=True),
    "theta": graphs.theta((2, 3, 2)),
    "grounded theta": graphs.theta((1, 2, 2), grounded=True),
    "near chain": near_chain(24, 6, 1),
    "grounded near chain": [(GROUND, 0), *near_chain(20, 5, 2)],
    "a link with two cut pins": [(GROUND, 0), (GROUND, 1), (0, 2), (1, 3), (1, 4), (2, 3), (2, 4)],
    "a triangle under a rocker": [(GROUND, 0), (0, 1), (0, 3), (3, 1), (1, 2), (2, 4), (4, GROUND)],
    "a loop beside dyads": [
        *[(GROUND, 0), (GROUND, 1), (GROUND, 2), (0, 3), (3, 4), (1, 5), (5, 6), (3, 7), (7, 8), (8, 9), (2, 4)],
        *[(0, 8), (GROUND, 9)],
    ],
    "loops in a ring": [(0, 1), (1, 2), (0, 3), (3, 4), (4, 5), (3, 6), (0, 5), (4, 6)],
}


ROWS: dict[str, Edges] = {
    "ring": graphs.ring(25),
    "hinged ring": graphs.ring(23, grounded=True),
    "pinned at both ends": [*((k - 1, k) for k in range(20)), (19, GROUND)],
    "ring with a handle": graphs.nested(28, 2, 0, 2),
    "two rings": [*graphs.ring(24), (3, 24), (24, 25), (25, 26), (26, 3)],
    "ring that is drawn the other way": [(b, a) for a, b in graphs.ring(25)],
}
"""Mechanisms with a row of links in a loop that is long enough for segments."""


def ring_of(links: int, **table: Any) -> Scene:
    return read_tables({"loop": {"links": links, **table}, "gravity": {}}, "ring", "ring")
