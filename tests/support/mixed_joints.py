"""A few random mechanisms with joints of every kind, drawn closed, and a state of each."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..oracles import random_mechanisms
from ..oracles.maximal import GROUND, Array
from .workshop import Workshop

KINDS = (
    (["revolute", "prismatic", "pin-in-slot"], [GROUND, 0, 1], [("revolute", GROUND, 2)], 3),
    (["pin-in-slot", "revolute", "revolute", "prismatic"], [GROUND, 0, 1, 1], [("pin-in-slot", 0, 3)], 5),
    (["revolute", "revolute", "prismatic", "revolute"], [-2, 0, 1, 2], [("pin-in-slot", 3, 0)], 8),
    (["prismatic", "pin-in-slot", "revolute"], [GROUND, 0, 1], [("prismatic", GROUND, 2)], 2),
)
"""Kinds of joints and parents of links, more joints, and a seed."""


def mixed(workshop: Workshop, number: int) -> tuple[Any, Array, Array]:
    """The model of one of them, and a state with loops shut."""
    kinds, parents, extra, seed = KINDS[number]
    sketch = random_mechanisms.draw(kinds, parents, extra, [], seed, False)
    model = workshop.model(sketch.toml("random-mechanism"))
    q, _ = model.state_from_poses(sketch.poses, np.zeros_like(sketch.poses))
    return model, *model.project(q, np.random.default_rng(3).normal(size=len(q)))
