"""Discs and straight edges by which links, and the ground, touch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray

SPOKED = np.append(np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 61)), 0.0)
"""The rim of a disc of radius 1 as complex numbers, and a spoke, by which one sees it roll."""

HALF = np.exp(1j * np.linspace(0.0, np.pi, 16))
"""Half of a rim, counter-clockwise."""


@dataclass(frozen=True)
class Disc:
    """A disc of a link about a point of it: `centre` (2,) in the link's frame and `radius`, in m.

    With an `end` (2,) it is a straight edge from the centre to there, with round ends; with corners `around` (m, 2) the
    centre, the profile of a cam. `link` is -1 for the ground.
    """

    link: int
    centre: FloatArray
    radius: float
    end: FloatArray | None = None
    around: FloatArray | None = None

    @property
    def fixed(self) -> bool:
        """Whether it belongs to the ground."""
        return self.link < 0

    @property
    def round(self) -> bool:
        """Whether it is a disc."""
        return self.end is None and self.around is None

    @property
    def outline(self) -> FloatArray:
        """Its rim and a spoke, or the way round the edge or the profile, in the link's frame, (m, 2) in m."""
        if self.around is not None:
            return np.asarray(self.centre + self.around)
        if self.end is None:
            return self.centre + self.radius * np.column_stack([SPOKED.real, SPOKED.imag])
        start, end = complex(*self.centre), complex(*self.end)
        across = 1j * self.radius * np.exp(1j * np.angle(end - start))
        round_ = np.concatenate([start + across * HALF, end - across * HALF, [start + across]])
        return np.column_stack([round_.real, round_.imag])
