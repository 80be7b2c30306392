"""How far the two points of a joint that does not hold are from where it would hold them, and the impact by which it
takes hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import FloatArray
from .drives import drive_rows
from .masses import mass_matrix
from .model import Model


@dataclass(frozen=True)
class Ends:
    """The two ends of a joint: ``links`` (-1: the ground), and ``points`` (2, 2) in their frames (m).

    Of one that slides ``axis`` is the direction of its line in the first link's frame, and ``angle`` that of the second
    link against the first, which a prismatic joint holds (rad).
    """

    kind: str
    links: tuple[int, int]
    points: FloatArray
    axis: float = 0.0
    angle: float = 0.0

    @classmethod
    def of(cls, model: Model, said: Mapping[str, Any]) -> Ends:
        """Those that a model's data describes."""
        first, second = said["links"]
        return cls(said["kind"], (first, second), model._coordinates(said["points"]), said["axis"], said["angle"])

    def apart(self, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The way from the first point to the second and its rate, (..., 2) both, for links' (..., links, 3)."""
        (one, its), (other, others) = (
            _point(poses, velocities, link, point) for link, point in zip(self.links, self.points, strict=True)
        )
        return other - one, others - its

    def along(self, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The length along the line and its rate (...,)."""
        way, rate = self.apart(poses, velocities)
        line, spin = self._line(poses, velocities)
        return _dot(line, way), _dot(line, rate) + spin * _dot(_perp(line), way)

    def direction(self, poses: FloatArray) -> FloatArray:
        """That of the line in the plane (..., 2), a unit vector."""
        angle = _angle(poses, self.links[0]) + self.axis
        return np.stack([np.cos(angle), np.sin(angle)], axis=-1)

    def misses(self, poses: FloatArray, velocities: FloatArray, length: float) -> tuple[FloatArray, FloatArray]:
        """What misses for the joint to hold (..., rows) in m, an angle times ``length`` (m), and its rates."""
        way, rate = self.apart(poses, velocities)
        if self.kind == "revolute":
            return way, rate
        line, spin = self._line(poses, velocities)
        across = _perp(line)
        rows = [(_dot(across, way), _dot(across, rate) - spin * _dot(line, way))]
        if self.kind == "prismatic":
            angles, spins = (_angle(of, self.links[1]) - _angle(of, self.links[0]) for of in (poses, velocities))
            rows.append((length * _wrapped(angles - self.angle), length * spins))
        values, rates = (np.stack(one, axis=-1) for one in zip(*rows, strict=True))
        return values, rates

    def _line(self, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
        return self.direction(poses), _angle(velocities, self.links[0])


@dataclass(frozen=True)
class TakenHold:
    """Velocities ``u`` (nu,) after a joint has taken hold, and the energy that went, ``loss`` (J).

    ``impulses`` (rows,) are those of what it holds, on its second link, in N s; of an angle N m s over the mechanism's
    length.
    """

    u: FloatArray
    impulses: FloatArray
    loss: float


def take_hold(model: Model, ends: Ends, q: FloatArray, u: FloatArray) -> TakenHold:
    """The plastic impact by which a joint takes hold of a mechanism that does not have it yet, its loops staying shut
    and its drives going on (docs/theory.md, eq. 5.26).

    The change Δu makes Δuᵀ M Δu least among those after which the joint's rates vanish. ``q`` and ``u`` are (nu,).
    """
    nu = len(u)
    tiled, units = np.tile(q, (nu, 1)), np.eye(nu, dtype=model.core.REAL)
    rows = ends.misses(model.poses(tiled), model.velocities(tiled, units), model.length)[1].T
    kept = np.vstack([model.jacobian(q), model.length * drive_rows(model)])
    every = np.asarray(np.vstack([rows, kept]), dtype=float)
    M = np.asarray(mass_matrix(model, q), dtype=float)
    scale = float(np.abs(M).max())
    system = np.block([[M / scale, every.T], [every, np.zeros((len(every), len(every)))]])
    wanted = np.concatenate([np.zeros(nu), -rows @ u, np.zeros(len(kept))])
    found = np.linalg.lstsq(system, np.asarray(wanted, dtype=float), rcond=1e-13)[0]
    left = np.asarray(wanted, dtype=float) - system @ found
    found = found + np.linalg.lstsq(system, left, rcond=1e-13)[0]
    change = found[:nu]
    after = np.asarray(u + change)
    return TakenHold(after, -scale * found[nu : nu + len(rows)], float(-change @ M @ (u + 0.5 * change)))


def _point(poses: FloatArray, velocities: FloatArray, link: int, point: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where a point of a link is and how fast it moves, (..., 2) both."""
    if link < 0:
        still = np.zeros((*poses.shape[:-2], 2), dtype=poses.dtype)
        return still + point, still
    pose, velocity = poses[..., link, :], velocities[..., link, :]
    c, s = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    arm = np.stack([c * point[0] - s * point[1], s * point[0] + c * point[1]], axis=-1)
    return pose[..., :2] + arm, velocity[..., :2] + velocity[..., 2, None] * _perp(arm)


def _angle(of_links: FloatArray, link: int) -> FloatArray:
    """The angle (or spin) of a link, of the ground zero, (...,)."""
    return np.zeros(of_links.shape[:-2], dtype=of_links.dtype) if link < 0 else of_links[..., link, 2]


def _dot(one: FloatArray, other: FloatArray) -> FloatArray:
    return np.asarray(np.sum(one * other, axis=-1))


def _perp(v: FloatArray) -> FloatArray:
    return np.stack([-v[..., 1], v[..., 0]], axis=-1)


def _wrapped(angle: FloatArray) -> FloatArray:
    return np.asarray(np.remainder(angle + np.pi, 2.0 * np.pi) - np.pi)
