"""Cranks that share a coupler, more of them than it needs."""

from __future__ import annotations

import numpy as np

from ..oracles.maximal import GROUND
from ..oracles.mechanisms import Drawing, draw


def parallel_cranks(angle: float, cranks: int = 3) -> Drawing:
    """Parallel cranks that share a coupler: all but two are redundant."""
    feet = [[float(k), 0.0] for k in range(cranks)]
    tops = [[k + np.cos(angle), np.sin(angle)] for k in range(cranks)]
    bodies = [(k, cranks + k) for k in range(cranks)] + [tuple(range(cranks, 2 * cranks))]
    joints = [(k, GROUND, k) for k in range(cranks)] + [(cranks + k, k, cranks) for k in range(cranks)]
    return draw(f"cranks_{cranks}", np.array(feet + tops), bodies, joints, np.random.default_rng(4))
