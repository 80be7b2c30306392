"""Planar multibody dynamics in maximal coordinates, solved densely.

Every link keeps the three coordinates of its centre of mass (x, y, angle) and every pin joint is a two-row constraint
``(point on b) - (point on a) = 0`` with Jacobian ``G``:

    M v' = f + G^T lam,   G v' = -G' v              flight
    M dv = G^T Lam + N^T P,   G v+ = 0              impact, 0 <= P  perpendicular to  N v+ + e N v- >= 0

``lam`` is the force that a joint puts on its link ``b``. The systems are solved by LU factorisation in
``np.longdouble`` (64 bits of mantissa or more on Linux): a dense solve in double precision can lose more digits than
the tests allow. Links carry a frame with an arbitrary origin; ``poses`` and ``velocities`` are those of the frames,
(links, 3).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[Any]
GROUND = -1
WIDE: Any = np.longdouble


@dataclass(frozen=True)
class Pin:
    """The point ``on_a`` of link ``a`` lies on ``on_b`` of link ``b`` (-1: the ground, point in the plane)."""

    a: int
    on_a: tuple[float, float]
    b: int
    on_b: tuple[float, float]


@dataclass(frozen=True)
class Contact:
    """A point of a link that must stay on the side of a line to which ``normal`` points; ``foot`` lies on the line."""

    link: int
    on: tuple[float, float]
    normal: tuple[float, float] = (0.0, 1.0)
    foot: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class System:
    """Links (masses, inertias about the centre of mass, centres of mass in the link frames), pins and gravity."""

    mass: Array
    inertia: Array
    com: Array
    pins: tuple[Pin, ...] = ()
    gravity: float = 0.0
    dtype: Any = field(default=WIDE, compare=False)

    @property
    def size(self) -> int:
        return len(self.mass)

    def with_gravity(self, g: float) -> System:
        return replace(self, gravity=g)


@dataclass(frozen=True)
class Motion:
    """Accelerations of the link frames, (links, 3): x, y, angle; and force of each pin on its link ``b``, (pins, 2)."""

    frames: Array
    forces: Array


def turned(angle: Array, point: ArrayLike) -> Array:
    """``point`` (in link frames) in the directions of the plane."""
    x, y = np.moveaxis(np.asarray(point, dtype=angle.dtype), -1, 0)
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def solve(matrix: Array, right: Array) -> Array:
    """Solution of ``matrix @ x = right`` by LU with row scaling and pivoting, in the precision of ``matrix``."""
    n = len(matrix)
    scale = 1 / np.max(np.abs(matrix), axis=1)
    lu = np.concatenate([matrix * scale[:, None], right.reshape(n, -1) * scale[:, None]], axis=1)
    for k in range(n):
        pivot = k + int(np.argmax(np.abs(lu[k:, k])))
        if pivot != k:
            lu[[k, pivot]] = lu[[pivot, k]]
        rows = k + 1 + np.flatnonzero(lu[k + 1 :, k])
        factor = lu[rows, k] / lu[k, k]
        lu[rows, k + 1 :] -= factor[:, None] * lu[k, k + 1 :]
    x = lu[:, n:].copy()
    for k in range(n - 1, -1, -1):
        x[k] /= lu[k, k]
        x[:k] -= lu[:k, k, None] * x[k]
    return x.reshape(right.shape)


def _arm(system: System, angles: Array, link: int, on: tuple[float, float]) -> Array:
    """From the centre of mass of ``link`` to its point ``on``, in the plane."""
    point = np.asarray(on, system.dtype) - np.asarray(system.com[link], system.dtype)
    return turned(angles[link], point)


def jacobian(system: System, angles: ArrayLike) -> Array:
    """``G``: velocity of every pin's opening from the velocities of the centres of mass, (2 pins, 3 links)."""
    angles = np.asarray(angles, system.dtype)
    rows = np.zeros((2 * len(system.pins), 3 * system.size), system.dtype)
    for k, pin in enumerate(system.pins):
        for sign, link, on in ((-1, pin.a, pin.on_a), (1, pin.b, pin.on_b)):
            if link == GROUND:
                continue
            x, y = _arm(system, angles, link, on)
            rows[2 * k, 3 * link : 3 * link + 3] = sign, 0, -sign * y
            rows[2 * k + 1, 3 * link : 3 * link + 3] = 0, sign, sign * x
    return rows


def _centripetal(system: System, angles: Array, spins: Array) -> Array:
    """``-G' v``."""
    right = np.zeros(2 * len(system.pins), system.dtype)
    for k, pin in enumerate(system.pins):
        for sign, link, on in ((-1, pin.a, pin.on_a), (1, pin.b, pin.on_b)):
            if link != GROUND:
                right[2 * k : 2 * k + 2] += sign * spins[link] ** 2 * _arm(system, angles, link, on)
    return right


def _inertias(system: System) -> Array:
    """Diagonal of ``M``."""
    return np.stack([system.mass, system.mass, system.inertia], axis=1).astype(system.dtype).ravel()


def _saddle(system: System, angles: ArrayLike) -> Array:
    rows = jacobian(system, angles)
    none = np.zeros((len(rows), len(rows)), system.dtype)
    return np.block([[np.diag(_inertias(system)), rows.T], [rows, none]])


def centre_velocities(system: System, poses: ArrayLike, velocities: ArrayLike) -> Array:
    """Velocities of the centres of mass, (links, 3), from those of the frames."""
    poses, found = np.asarray(poses, system.dtype), np.array(velocities, system.dtype)
    arm = turned(poses[:, 2], system.com)
    found[:, 0] -= found[:, 2] * arm[:, 1]
    found[:, 1] += found[:, 2] * arm[:, 0]
    return found


def frame_velocities(system: System, poses: ArrayLike, velocities: ArrayLike) -> Array:
    """Velocities of the frames, (links, 3), from those of the centres of mass."""
    poses, found = np.asarray(poses, system.dtype), np.array(velocities, system.dtype)
    arm = turned(poses[:, 2], system.com)
    found[:, 0] += found[:, 2] * arm[:, 1]
    found[:, 1] -= found[:, 2] * arm[:, 0]
    return found


def accelerate(system: System, poses: ArrayLike, velocities: ArrayLike) -> Motion:
    """Accelerations and joint forces of the free motion under gravity."""
    angles = np.asarray(poses, system.dtype)[:, 2]
    spins = np.asarray(velocities, system.dtype)[:, 2]
    force = np.zeros((system.size, 3), system.dtype)
    force[:, 1] = -np.asarray(system.mass, system.dtype) * system.dtype(system.gravity)
    right = np.concatenate([force.ravel(), _centripetal(system, angles, spins)])
    x = solve(_saddle(system, angles), right)
    centres = x[: 3 * system.size].reshape(-1, 3)
    frames = frame_velocities(system, np.asarray(poses), centres)
    frames[:, :2] += spins[:, None] ** 2 * turned(angles, system.com)
    return Motion(frames, -x[3 * system.size :].reshape(-1, 2))


def project(system: System, poses: ArrayLike, velocities: ArrayLike) -> Array:
    """Frame velocities nearest to ``velocities`` in the mass matrix under which no pin opens."""
    v = centre_velocities(system, poses, velocities).ravel()
    angles = np.asarray(poses, system.dtype)[:, 2]
    rows = jacobian(system, angles)
    dv = solve(_saddle(system, angles), np.concatenate([np.zeros_like(v), -(rows @ v)]))[: v.size]
    return frame_velocities(system, poses, (v + dv).reshape(-1, 3))


def conditioning(system: System, poses: ArrayLike) -> float:
    """Condition number of ``G M^-1 G^T``: how near to singular the joints are, by masses and geometry alone."""
    angles = np.asarray(poses, float)[:, 2]
    rows = (jacobian(system, angles) / np.sqrt(_inertias(system))).astype(float)
    if not len(rows):
        return 1.0
    values = np.linalg.svd(rows, compute_uv=False)
    return float((values[0] / values[-1]) ** 2)


def opening(system: System, poses: ArrayLike) -> float:
    """Largest distance by which a pin's two points miss each other."""
    poses = np.asarray(poses, system.dtype)
    worst = system.dtype(0)
    for pin in system.pins:
        ends = [
            np.asarray(on, system.dtype) if link == GROUND else reach(poses, link, on)
            for link, on in ((pin.a, pin.on_a), (pin.b, pin.on_b))
        ]
        worst = max(worst, np.max(np.abs(ends[1] - ends[0])))
    return float(worst)


def reach(poses: Array, link: int, on: tuple[float, float]) -> Array:
    """Where the point ``on`` of ``link`` is."""
    return poses[link, :2] + turned(poses[link, 2], on)


# --- impact -----------------------------------------------------------------------------------------------------------


def contact_rows(system: System, angles: ArrayLike, contacts: Sequence[Contact]) -> Array:
    """``N``: normal velocities of the contact points from the velocities of the centres of mass."""
    angles = np.asarray(angles, system.dtype)
    rows = np.zeros((len(contacts), 3 * system.size), system.dtype)
    for k, contact in enumerate(contacts):
        x, y = _arm(system, angles, contact.link, contact.on)
        normal = np.asarray(contact.normal, system.dtype)
        nx, ny = normal / np.sqrt(normal @ normal)
        rows[k, 3 * contact.link : 3 * contact.link + 3] = nx, ny, ny * x - nx * y
    return rows


def complementary(matrix: Array, right: Array) -> Array:
    """``0 <= P`` perpendicular to ``matrix @ P + right >= 0``: every active set is tried, small ones first."""
    tolerance = 1e-12 * float(np.max(np.abs(right), initial=0.0))
    for count in range(len(right) + 1):
        for active in itertools.combinations(range(len(right)), count):
            p = np.zeros_like(right)
            block = matrix[np.ix_(active, active)]
            if count and np.linalg.cond(block.astype(float)) > 1e12:
                continue
            if count:
                p[list(active)] = solve(block, -right[list(active)])
            if np.all(p >= -tolerance) and np.all(matrix @ p + right >= -tolerance):
                return np.maximum(p, 0)
    raise ArithmeticError("no active set solves the impact")


@dataclass(frozen=True)
class Jump:
    """Outcome of an impact: frame velocities after it, impulses, contact-space inverse inertia, energy lost."""

    velocities: Array
    impulses: Array
    inverse: Array
    loss: float


def impact(
    system: System, poses: ArrayLike, velocities: ArrayLike, contacts: Sequence[Contact], restitution: ArrayLike
) -> Jump:
    """Simultaneous Newton impact of all ``contacts``, each with its restitution."""
    angles = np.asarray(poses, system.dtype)[:, 2]
    v = centre_velocities(system, poses, velocities).ravel()
    normals = contact_rows(system, angles, contacts)
    e = np.broadcast_to(np.asarray(restitution, system.dtype), (len(contacts),))
    right = np.concatenate([normals.T, np.zeros((2 * len(system.pins), len(contacts)), system.dtype)])
    response = solve(_saddle(system, angles), right)[: v.size]
    inverse = normals @ response
    impulses = complementary(inverse, (1 + e) * (normals @ v))
    after = v + response @ impulses
    inertias = _inertias(system)
    loss = float((inertias * (v**2 - after**2)).sum() / 2)
    return Jump(frame_velocities(system, poses, after.reshape(-1, 3)), impulses, inverse, loss)


# --- integrals of the motion ------------------------------------------------------------------------------------------


def energy(system: System, poses: ArrayLike, velocities: ArrayLike) -> tuple[float, float]:
    """Kinetic and potential energy; the potential is zero at y = 0."""
    poses = np.asarray(poses, system.dtype)
    v = centre_velocities(system, poses, velocities).ravel()
    heights = poses[:, 1] + turned(poses[:, 2], system.com)[:, 1]
    return float((_inertias(system) * v**2).sum() / 2), float(system.gravity * (system.mass * heights).sum())


def momenta(system: System, poses: ArrayLike, velocities: ArrayLike) -> Array:
    """Linear momentum (x, y) and angular momentum about the mass centre of the whole."""
    poses = np.asarray(poses, system.dtype)
    v = centre_velocities(system, poses, velocities)
    mass = np.asarray(system.mass, system.dtype)
    places = poses[:, :2] + turned(poses[:, 2], system.com)
    linear = mass @ v[:, :2]
    arm, relative = places - mass @ places / mass.sum(), v[:, :2] - linear / mass.sum()
    spin = (system.inertia * v[:, 2]).sum() + (mass * (arm[:, 0] * relative[:, 1] - arm[:, 1] * relative[:, 0])).sum()
    return np.array([*linear, spin], dtype=float)
