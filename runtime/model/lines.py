"""Lines of sliding joints: where the second link's point is along a line of the first, from poses of the links."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..arrays import FloatArray

Coordinates = Callable[[Sequence[Sequence[str | float]]], FloatArray]
"""Points of a model's data, whose coordinates are parameter paths or numbers, as numbers (k, 2) in m."""


class Lines:
    """Coordinates and quasi-velocities that poses and velocities of links (links, 3) stand for.

    A sliding joint's line is fixed in its first link: the length s (m) is the distance from that link's point to the
    second link's, along the line, and its rate (m/s) is seen in the first link's frame (theory, section 2).
    """

    def __init__(self, data: Mapping[str, Any], coordinates: Coordinates) -> None:
        self.data, self._coordinates = data["lines"], coordinates

    def coordinate(self, kind: str, of: int | str, poses: FloatArray) -> Any:
        """The coordinate of the given kind: x or y or angle of a link, or the length along a joint's line; a number of
        the poses' type."""
        if kind == "slide":
            along, distance = self._line(str(of), poses)
            return along @ distance
        return poses[int(of), ("x", "y", "angle").index(kind)]

    def lengths(self, joint: str, poses: FloatArray) -> FloatArray:
        """The length along the joint's line (...,), for poses (..., links, 3)."""
        found = [self.coordinate("slide", joint, one) for one in poses.reshape(-1, *poses.shape[-2:])]
        return np.array(found).reshape(poses.shape[:-2])

    def ends(self, joint: str, poses: FloatArray) -> FloatArray:
        """Where the first and the second link's points are (2, 2), in m, for poses (links, 3)."""
        places = [
            point if link < 0 else poses[link, :2] + _turn(poses[link], point)
            for link, point in zip(self.data[joint]["links"], self._points(joint), strict=True)
        ]
        return np.array(places)

    def direction(self, joint: str, poses: FloatArray) -> FloatArray:
        """The line's direction, of length 1 (2,), for poses (links, 3)."""
        return self._line(joint, poses)[0]

    def rate(self, kind: str, of: int | str, poses: FloatArray, velocities: FloatArray) -> Any:
        """The rate of the coordinate of the given kind, likewise."""
        if kind != "slide":
            return velocities[int(of), ("x", "y", "angle").index(kind)]
        along, distance = self._line(str(of), poses)
        ends, spins = [], []
        for link, point in zip(self.data[of]["links"], self._points(str(of)), strict=True):
            spins.append(0.0 if link < 0 else velocities[link, 2])
            ends.append(
                np.zeros(2) if link < 0 else velocities[link, :2] + spins[-1] * _perp(_turn(poses[link], point))
            )
        return along @ (ends[1] - ends[0] - spins[0] * _perp(distance))

    def _line(self, joint: str, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The line's direction, of length 1, and the way from the first point to the second (m)."""
        line, places = self.data[joint], self.ends(joint, poses)
        first = line["links"][0]
        angle = self._coordinates([[line["axis"], 0.0]])[0, 0] + (0.0 if first < 0 else poses[first, 2])
        return np.array([np.cos(angle), np.sin(angle)]), places[1] - places[0]

    def _points(self, joint: str) -> FloatArray:
        return self._coordinates(self.data[joint]["points"])


def _turn(pose: FloatArray, point: FloatArray) -> FloatArray:
    """A point of a link's frame in the directions of the plane."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.array([c * point[0] - s * point[1], s * point[0] + c * point[1]])


def _perp(v: FloatArray) -> FloatArray:
    return np.array([-v[1], v[0]])
