"""Regular rings of equal uniform rods, and the closed-form answers for their impacts.

Rod k runs from joint k to joint k+1 with its frame on joint k; joint 0 is the lowest at ``tilt`` 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .maximal import Array, Contact, Pin, System, project


def ring(n: int, length: float = 1.0, mass: float = 1.0, gravity: float = 0.0) -> System:
    """A free ring of n uniform rods."""
    pins = tuple(Pin((k - 1) % n, (length, 0.0), k, (0.0, 0.0)) for k in range(n))
    one = np.ones(n)
    return System(mass * one, mass * length**2 / 12 * one, np.tile([length / 2, 0.0], (n, 1)), pins, gravity)


def regular(n: int, length: float = 1.0, tilt: float = 0.0, height: float = 0.0) -> Array:
    """Link poses, (n, 3), of the regular ring with joint 0 at (0, height)."""
    angles = 2 * np.pi * (np.arange(n) + 0.5) / n + tilt
    sides = length * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    places = np.array([0.0, height]) + np.concatenate([np.zeros((1, 2)), np.cumsum(sides[:-1], axis=0)])
    return np.column_stack([places, angles])


def perturbed(n: int, height: float = 0.0) -> tuple[Array, Array]:
    """Link poses and frame velocities, (n, 3) each, of a unit ring bent out of the regular shape and moving."""
    k = np.arange(n)
    angles = 2 * np.pi * k / n + 0.1 * np.sin(1.7 * k + 0.3)
    for _ in range(20):
        sides = np.stack([np.cos(angles), np.sin(angles)])
        rows = np.stack([-np.sin(angles), np.cos(angles)])
        angles = angles - rows.T @ np.linalg.solve(rows @ rows.T, sides.sum(axis=1))
    sides = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    places = np.concatenate([np.zeros((1, 2)), np.cumsum(sides[:-1], axis=0)])
    places += (0.1, height - places[:, 1].min())
    poses = np.column_stack([places, angles])
    spins = 0.2 + 0.5 * np.cos(2.3 * k + 0.7)
    velocities = np.zeros((n, 3))
    velocities[:, 2] = spins
    normal = np.stack([-np.sin(angles), np.cos(angles)], axis=1)
    velocities[1:, :2] = np.cumsum(spins[:, None] * normal, axis=0)[:-1]
    velocities[:, :2] += (0.3, -0.1)
    return poses, project(ring(n), poses, velocities).astype(float)


def corner(n: int, joint: int) -> Contact:
    """Contact of a joint with the ground y = 0, as a point of the link whose frame sits on it."""
    return Contact(joint % n, (0.0, 0.0))


@dataclass(frozen=True)
class Landing:
    """Closed-form impact of a ring that falls without turning.

    W m; impulse / ((1+e) m v); gain of v_cm / ((1+e) v); angular velocities / ((1+e) v/l).
    """

    name: str
    n: int
    tilt: float
    joints: tuple[int, ...]
    inverse: tuple[tuple[float, ...], ...]
    impulse: float
    lift: float
    spins: tuple[float, ...]
    loss: float
    """Energy lost, in (1 - e^2) m v^2 / 2."""


LANDINGS = (
    Landing(
        "square on a vertex", 4, 0.0, (0,), ((5 / 8,),), 8 / 5, 2 / 5,
        tuple(3 * np.sqrt(2) / 5 * np.array([-1, 1, -1, 1])), 8 / 5,
    ),
    Landing(
        "square on an edge", 4, -np.pi / 4, (0, 1), ((5 / 8, -1 / 8), (-1 / 8, 5 / 8)), 2.0, 1.0, (0.0,) * 4, 4.0,
    ),
    Landing(
        "hexagon on a vertex", 6, 0.0, (0,), ((10 / 11,),), 11 / 10, 11 / 60,
        tuple(np.sqrt(3) * np.array([-2 / 3, 11 / 30, -1 / 15, 1 / 15, -11 / 30, 2 / 3])), 11 / 10,
    ),
    Landing(
        "hexagon on an edge", 6, -np.pi / 6, (0, 1),
        ((259 / 330, -59 / 330), (-59 / 330, 259 / 330)), 33 / 20, 11 / 20,
        (0.0, -9 / 10, 9 / 10, 0.0, -9 / 10, 9 / 10), 33 / 10,
    ),
    Landing("triangle on a vertex", 3, 0.0, (0,), ((1 / 3,),), 3.0, 1.0, (0.0,) * 3, 3.0),
)  # fmt: skip
