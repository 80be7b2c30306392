"""Large mechanisms that planners are judged on, and the operations that a plan for them takes."""

from __future__ import annotations

from typing import Any

import numpy as np

from ccgen.generator import load_scene
from ccgen.generator.pipeline import derive_scene
from ccgen.generator.program.program import lower
from ccgen.generator.scene.scene import Scene

from ..oracles.graphs import Edges
from ..oracles.mechanisms import Drawing


def walking(legs: int) -> Edges:
    """A body, a shaft on it, and legs of three dyads each: two on the crank and the body, the third between those."""
    edges: Edges = [(0, 1)]
    for leg in range(legs):
        j, b, k, c, f, g = range(2 + 6 * leg, 8 + 6 * leg)
        edges += [(1, j), (j, b), (0, b), (1, k), (k, c), (0, c), (b, f), (c, g), (f, g)]
    return edges


def near_chain(links: int, loops: int, seed: int) -> Edges:
    """A row of links, and joints between random links of it that are at least three apart."""
    rng = np.random.default_rng(seed)
    edges = [(k, k + 1) for k in range(links - 1)]
    while len(edges) < links - 1 + loops:
        a, b = sorted(int(x) for x in rng.integers(links, size=2))
        if 3 <= b - a <= 8 and (a, b) not in edges:
            edges.append((a, b))
    return edges


def scene_of(drawing: Drawing, tmp_path: Any) -> Scene:
    path = tmp_path / "mechanism.toml"
    path.write_text(drawing.toml())
    return load_scene(path)


def operations(scene: Scene, plan: str | None = None) -> int:
    return lower(derive_scene(scene, plan=plan)[1]).function("acceleration").counts().total
