"""The workload W(n): a floating loop of n equal uniform rods (1 m, 1 kg) under gravity, in motion.

The states are regular n-gons, perturbed and brought back onto the closure. The exact accelerations come from the dense
system in maximal coordinates,

    | M  A^T | | a      |   | f          |
    | A   0  | | lambda | = | -(dA/dt) v |

formed and refined in the widest floating point that NumPy has. It shares no code with ccgen nor with its peers.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve

Array = NDArray[np.float64]
Wide = NDArray[np.longdouble]

LENGTH, MASS, INERTIA, GRAVITY = 1.0, 1.0, 1.0 / 12.0, 9.81
STATES = 32


@dataclass(frozen=True)
class Workload:
    """States of W(n) by link frame: x, y of the link's first joint and the link's angle; arrays (states, n, 3)."""

    links: int
    poses: Array
    velocities: Array
    accelerations: Array

    def coordinates(self, root: int) -> tuple[Array, Array, Array]:
        """q, u and the exact du/dt, each (states, n + 2): the frame origin of link `root`, then all angles."""
        q, u, u_dot = (
            np.ascontiguousarray(np.concatenate([frames[:, root, :2], frames[:, :, 2]], axis=1))
            for frames in (self.poses, self.velocities, self.accelerations)
        )
        return q, u, u_dot


def workload(n: int, states: int = STATES) -> Workload:
    """The states of W(n), the k-th one perturbed a little more than the one before."""
    frames = [_frames(n, 0.1 + 0.001 * k) for k in range(states)]
    poses, velocities = (np.array(part) for part in zip(*frames, strict=True))
    accelerations = np.array([_accelerations(*frame) for frame in frames])
    return Workload(n, poses, velocities, accelerations)


def _frames(n: int, amplitude: float) -> tuple[Array, Array]:
    """Poses and velocities of the link frames of one consistent state."""
    k = np.arange(n)
    angles = 2.0 * np.pi * k / n + amplitude * np.sin(1.7 * k + 0.3)
    for _ in range(20):  # Newton onto the closure, least change
        jacobian = np.array([-np.sin(angles), np.cos(angles)])
        gap = np.array([np.cos(angles).sum(), np.sin(angles).sum()])
        angles = angles - np.linalg.lstsq(jacobian, gap, rcond=None)[0]
    jacobian = np.array([-np.sin(angles), np.cos(angles)])
    rates = 0.2 + 0.5 * np.cos(2.3 * k + 0.7)
    rates = rates - np.linalg.lstsq(jacobian, jacobian @ rates, rcond=None)[0]
    sides = LENGTH * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    spins = LENGTH * rates[:, None] * jacobian.T
    origins = np.array([0.1, 0.2]) + np.cumsum(sides, axis=0) - sides
    speeds = np.array([0.3, -0.1]) + np.cumsum(spins, axis=0) - spins
    return np.column_stack([origins, angles]), np.column_stack([speeds, rates])


def _accelerations(poses: Array, velocities: Array) -> Array:
    """Exact accelerations of the link frames of one state."""
    n = len(poses)
    angles, rates = poses[:, 2].astype(np.longdouble), velocities[:, 2].astype(np.longdouble)
    arm = LENGTH / 2 * np.stack([np.cos(angles), np.sin(angles)], axis=1)  # first joint to centre of mass
    turned = np.stack([-arm[:, 1], arm[:, 0]], axis=1)
    before = np.roll(np.arange(n), 1)
    a = np.zeros((n, 2, n, 3), dtype=np.longdouble)  # rows: end of the link before minus start of this link
    for k, p in enumerate(before):
        a[k, 0, p, 0] = a[k, 1, p, 1] = 1
        a[k, 0, k, 0] = a[k, 1, k, 1] = -1
        a[k, :, p, 2] = turned[p]
        a[k, :, k, 2] = turned[k]
    centripetal = rates[:, None] ** 2 * arm
    jacobian = a.reshape(2 * n, 3 * n)
    masses = np.tile(np.array([MASS, MASS, INERTIA], dtype=np.longdouble), n)
    matrix = np.block([[np.diag(masses), jacobian.T], [jacobian, np.zeros((2 * n, 2 * n), dtype=np.longdouble)]])
    weights = np.tile(np.array([0.0, -MASS * GRAVITY, 0.0], dtype=np.longdouble), n)
    right = np.concatenate([weights, (centripetal[before] + centripetal).ravel()])
    centres = _solve(matrix, right)[: 3 * n].reshape(n, 3)
    centres[:, :2] += centripetal - centres[:, 2:] * turned
    return centres.astype(np.float64)


def _solve(matrix: Wide, right: Wide) -> Wide:
    """Solution with residuals in wide arithmetic, corrected until the corrections no longer count."""
    factors = lu_factor(matrix.astype(np.float64))
    solution = np.zeros_like(right)
    for _ in range(10):
        correction = lu_solve(factors, (right - matrix @ solution).astype(np.float64))
        solution = solution + correction
        if np.abs(correction).max() < 1e-18 * np.abs(solution).max():
            break
    return solution
