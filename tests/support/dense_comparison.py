"""States of a model and of the dense reference beside it, and how close their figures are."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..oracles import maximal
from ..oracles.maximal import Array, System
from ..oracles.mechanisms import Drawing

SINGULAR = 3e3
"""States whose ``G M^-1 G^T`` has a larger condition number are near singular ones and are left out."""
STATES = 12
"""Random states per model."""


def allowed(system: System) -> float:
    """Relative error that a model of this size may have."""
    return 1e-12 if system.size <= 24 else 1e-11


@dataclass(frozen=True)
class State:
    q: Array
    u: Array
    poses: Array
    velocities: Array


def states(model: Any, drawing: Drawing, count: int = STATES) -> Iterator[State]:
    """Random consistent states: bent angles, assembled; random velocities, projected; near-singular ones left out."""
    rng = np.random.default_rng([7, drawing.system.size, len(drawing.system.pins)])
    q0, _ = model.state_from_poses(drawing.poses, np.zeros_like(drawing.poses))
    angles = [k for k, name in enumerate(model.q_names) if name.startswith("theta_")]
    found = 0
    for _ in range(4 * count):
        bent = q0.copy()
        bent[angles] += rng.uniform(-0.35, 0.35, len(angles))
        q, u = model.project(model.assemble(bent), rng.normal(size=len(model.u_names)))
        poses = model.poses(q)
        if maximal.conditioning(drawing.system, poses) > SINGULAR:
            continue
        yield State(q, u, poses, model.velocities(q, u))
        found += 1
        if found == count:
            return
    raise AssertionError(f"only {found} of {4 * count} random states are away from singular ones")


def quasi_accelerations(model: Any, motion: maximal.Motion) -> Array:
    """The reference's accelerations in the order of the model's ``u_names``."""
    column = {"vx": 0, "vy": 1, "w": 2}
    names = (name.rsplit("_", 1) for name in model.u_names)
    return np.array([motion.frames[int(link), column[kind]] for kind, link in names], dtype=float)


def close(found: Array, wanted: Array, tolerance: float, least: float = 0.0) -> bool:
    """Largest difference against the largest entry (or ``least``, for what must vanish)."""
    wanted = np.asarray(wanted, dtype=float)
    return bool(np.max(np.abs(found - wanted), initial=0.0) <= tolerance * np.max(np.abs(wanted), initial=least))
