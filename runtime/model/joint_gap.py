"""How far the two points of a joint that does not hold are from where it would hold them, and the impact by which it
takes hold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray


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

    def _line(self, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
        return self.direction(poses), _angle(velocities, self.links[0])


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
