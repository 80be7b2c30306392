"""Rods in a row, unequal, in a random consistent motion, and their exact accelerations.

Two families: `chain`, n rods from a hinge on the ground (an n-fold pendulum), and `loop`, n rods closed on themselves
that float in the plane. The accelerations come from the dense system in maximal coordinates, three for each rod and two
equations for each joint; it shares no code with the formulations that it judges.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FEWEST = {"chain": 2, "loop": 3}
"""The smallest number of rods of each family that is worth deriving."""

GRAVITY = 9.81


@dataclass(frozen=True)
class Rods:
    """n rods and one state of them.

    Masses (kg), inertias about the mass centres (kg m²), lengths and distances of the mass centres from the rods'
    beginnings (m), absolute angles and their rates, all (n,); ``accelerations`` (n, 3): of each rod's beginning, x and
    y (m/s²), and of its angle (rad/s²).
    """

    family: str
    masses: Array
    inertias: Array
    lengths: Array
    centres: Array
    angles: Array
    rates: Array
    accelerations: Array


def rods(family: str, n: int) -> Rods:
    """The rods of a family and size, always the same ones."""
    random = np.random.default_rng([n, len(family)])
    masses, lengths = random.uniform(0.5, 1.5, n), random.uniform(0.8, 1.2, n)
    inertias, centres = masses * lengths**2 / 12.0, lengths * random.uniform(0.4, 0.6, n)
    angles, rates = random.uniform(-np.pi, np.pi, n), random.uniform(-1.0, 1.0, n)
    if family == "loop":
        angles = 2.0 * np.pi * np.arange(n) / n + random.uniform(-0.3, 0.3, n)
        angles, rates = _closed(lengths, angles, rates)
    found = _accelerations(family, masses, inertias, lengths, centres, angles, rates)
    return Rods(family, masses, inertias, lengths, centres, angles, rates, found.reshape(n, 3))


def _closed(lengths: Array, angles: Array, rates: Array) -> tuple[Array, Array]:
    """Angles and rates of a closed loop, brought there by smallest steps."""
    for _ in range(30):
        gap = np.array([lengths @ np.cos(angles), lengths @ np.sin(angles)])
        jacobian = lengths * np.array([-np.sin(angles), np.cos(angles)])
        angles = angles - np.linalg.lstsq(jacobian, gap, rcond=None)[0]
    jacobian = lengths * np.array([-np.sin(angles), np.cos(angles)])
    return angles, rates - np.linalg.lstsq(jacobian, jacobian @ rates, rcond=None)[0]


def _accelerations(
    family: str, masses: Array, inertias: Array, lengths: Array, centres: Array, angles: Array, rates: Array
) -> Array:
    """Accelerations of every rod's beginning and angle, x, y, angle of rod 0, then of rod 1, ..."""
    n = len(masses)
    along = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)

    jacobian, right = np.zeros((2 * n, 3 * n)), np.zeros(2 * n)
    for k in range(n):  # the beginning of rod k lies on the end of the rod before it, or on the ground
        rows, before = slice(2 * k, 2 * k + 2), (k - 1) % n
        jacobian[rows, 3 * k : 3 * k + 2] = np.eye(2)
        if k > 0 or family == "loop":
            jacobian[rows, 3 * before : 3 * before + 2] -= np.eye(2)
            jacobian[rows, 3 * before + 2] -= lengths[before] * across[before]
            right[rows] = -lengths[before] * rates[before] ** 2 * along[before]
    mass, force = np.zeros((3 * n, 3 * n)), np.zeros(3 * n)
    for k in range(n):
        to_centre = np.column_stack([np.eye(2), centres[k] * across[k]])
        here = slice(3 * k, 3 * k + 3)
        mass[here, here] = masses[k] * to_centre.T @ to_centre + np.diag([0.0, 0.0, inertias[k]])
        pull = np.array([0.0, -GRAVITY]) + centres[k] * rates[k] ** 2 * along[k]
        force[here] = masses[k] * to_centre.T @ pull
    system = np.block([[mass, jacobian.T], [jacobian, np.zeros((2 * n, 2 * n))]])
    return np.linalg.solve(system, np.concatenate([force, right]))[: 3 * n]
