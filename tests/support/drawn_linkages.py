"""Linkages whose start is drawn: rods, a four-bar, cranks side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ccgen.generator.scene import Scene, read_tables

CRANK, COUPLER, ROCKER, BASE = 0.2, 0.5, 0.45, 0.6


def rod(name: str, length: float) -> dict[str, Any]:
    points = {"A": [0.0, 0.0], "B": [length, 0.0]}
    return {"name": name, "mass": 1.0, "inertia": 0.1, "com": [length / 2, 0.0], "points": points}


def four_bar(start: Mapping[str, Any], crank: float = CRANK) -> Scene:
    tables = {
        "ground_link": {"points": {"O": [0.0, 0.0], "Q": [BASE, 0.0]}},
        "link": [rod("crank", crank), rod("coupler", COUPLER), rod("rocker", ROCKER)],
        "joint": [
            {"name": "motor", "between": ["ground.O", "crank.A"]},
            {"name": "knee", "between": ["crank.B", "coupler.A"]},
            {"name": "elbow", "between": ["coupler.B", "rocker.B"]},
            {"name": "pivot", "between": ["ground.Q", "rocker.A"]},
        ],
        "start": dict(start),
    }
    return read_tables(tables, "four-bar", "four-bar")


def cranks(lengths: Sequence[float], angles: Sequence[float]) -> Scene:
    """Cranks one metre apart on the ground that share a bar."""
    count = len(lengths)
    bar = rod("bar", 1.0) | {"points": {f"P{k}": [float(k), 0.0] for k in range(count)}}
    joints = [{"name": f"foot_{k}", "between": [f"ground.O{k}", f"crank_{k}.A"]} for k in range(count)]
    joints += [{"name": f"head_{k}", "between": [f"crank_{k}.B", f"bar.P{k}"]} for k in range(count)]
    tables = {
        "ground_link": {"points": {f"O{k}": [float(k), 0.0] for k in range(count)}},
        "link": [*(rod(f"crank_{k}", length) for k, length in enumerate(lengths)), bar],
        "joint": joints,
        "start": {"angles": list(angles)},
    }
    return read_tables(tables, "cranks", "cranks")
