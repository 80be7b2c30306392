"""Ropes, as they are drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray


@dataclass(frozen=True)
class Rope:
    """A rope through points (k, 2), in m, of the frames of its `links` in order; -1 is the ground.

    `length` is how long it is (m), `None` where that is not known.
    """

    name: str
    links: Sequence[int]
    points: FloatArray
    length: float | None = None

    def way(self, poses: FloatArray) -> FloatArray:
        """Where its points are (..., k, 2) when links have `poses` (..., links, 3)."""
        places = []
        for link, point in zip(self.links, self.points @ [1.0, 1.0j], strict=True):
            pose = np.zeros((*poses.shape[:-2], 3)) if link < 0 else poses[..., link, :]
            place = pose[..., 0] + 1j * pose[..., 1] + np.exp(1j * pose[..., 2]) * point
            places.append(np.stack([place.real, place.imag], axis=-1))
        return np.stack(places, axis=-2)
