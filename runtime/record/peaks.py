"""Where quantities of a run are largest between the instants that are looked at."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray

SPIKE = 2.0
"""Times the lower of the sizes beside a peak as it is looked at: what is so much higher may be a pole, which is twice
as high at each half of the distance; what is smooth over several instants is not."""
Of = Callable[[FloatArray], FloatArray]
"""Sizes (n, quantities) at times (n,)."""

ROUNDS = 8
"""Parabolas laid through a peak. Their errors go to zero with the order 1.32: of a sine looked at ten times a
period the fourth is at the rounding of its height, and sharper peaks have four more."""
EXACT = 1e-10
"""Part of the largest that a parabola may add to a peak at most where none is laid: a tenth of what equal peaks may
differ by, as states are known to 1e-9 at the usual tolerance."""


def find_peaks(t: FloatArray, sizes: FloatArray, of: Of, known: NDArray[np.bool_]) -> Peaks:
    """Peaks of ``sizes`` (n, quantities) at times t (n,) that may be the largest of their quantity.

    ``of`` gives sizes (m, quantities) at any times (m,) between these. What is not ``known`` (n, quantities) to be
    smooth has no peaks beside it, nor have instants that are there twice.
    """
    found = _Peaks(t, sizes, known)
    beside = np.minimum(found.y[0], found.y[2])
    for _ in range(ROUNDS if len(found.column) else 0):
        times = found.vertices()
        found.put(times, of(times)[np.arange(len(times)), found.column])
    return Peaks(found.row, found.column, found.t[1], found.y[1] > SPIKE * beside)


@dataclass(frozen=True, eq=False)
class Peaks:
    """Peaks (p,): the ``row`` of the highest of the instants looked at, the ``column`` of the quantity, the instant
    ``t`` that was found, and which are ``spikes``: so much higher than what is beside that they may have no bound."""

    row: NDArray[np.intp]
    column: NDArray[np.intp]
    t: FloatArray
    spikes: NDArray[np.bool_]


class _Peaks:
    """Peaks (p,), each the middle of three instants ``t`` (3, p) with its sizes ``y`` (3, p), those of a ``column``.

    The vertex of a parabola is above its middle sample by less than an eighth of what that is above the lower of its
    neighbours where the samples are even: d intervals off, d <= 1/2, it is by d^2 / (1 + 2 d) of that. As much again is
    allowed for what is no parabola. What cannot be the largest so is left out, and so is what is as high as it will be.
    """

    def __init__(self, t: FloatArray, sizes: FloatArray, known: NDArray[np.bool_]) -> None:
        y = sizes[:-2], sizes[1:-1], sizes[2:]
        inside = (t[:-2] < t[1:-1]) & (t[1:-1] < t[2:])
        smooth = known[:-2] & known[1:-1] & known[2:]
        row, self.column = np.nonzero(inside[:, None] & smooth & (y[1] >= y[0]) & (y[1] >= y[2]))
        self.row = row + 1
        self.t = np.stack([t[row], t[row + 1], t[row + 2]])
        self.y = np.stack([one[row, self.column] for one in y])
        above = 2.0 * np.fmax((self.y[1] - np.minimum(self.y[0], self.y[2])) / 8.0, self._parabolas()[1])
        largest = np.max(sizes, axis=0, initial=0.0)[self.column]
        keep = (self.y[1] + above >= largest) & (above > EXACT * largest)
        self.t, self.y = self.t[:, keep], self.y[:, keep]
        self.row, self.column = self.row[keep], self.column[keep]

    def vertices(self) -> FloatArray:
        """Where the parabola through each of the three has its vertex; where that is none of the inside, or what is
        known already, the middle of the longer side."""
        a, m, b = self.t
        x, _ = self._parabolas()
        middle = np.where(b - m > m - a, 0.5 * (m + b), 0.5 * (a + m))
        return np.where((x > a) & (x < b) & (x != m), x, middle)

    def _parabolas(self) -> tuple[FloatArray, FloatArray]:
        """The vertex of each parabola, and how far it is above the middle of the three; not numbers where three sizes
        are equal or one is none."""
        (a, m, b), (fa, fm, fb) = self.t, self.y
        left, right = (m - a) * (fm - fb), (b - m) * (fm - fa)
        with np.errstate(divide="ignore", invalid="ignore"):
            off = 0.5 * ((b - m) * right - (m - a) * left) / (left + right)
            return m + off, off * off * (left + right) / ((m - a) * (b - m) * (b - a))

    def put(self, x: FloatArray, y: FloatArray) -> None:
        """Take in an instant each, and keep of the four the highest between its neighbours; sizes that are not numbers
        are never highest."""
        t, f = np.vstack([self.t, x]), np.vstack([self.y, np.where(np.isfinite(y), y, -np.inf)])
        order = np.argsort(t, axis=0, kind="stable")
        t, f = np.take_along_axis(t, order, 0), np.take_along_axis(f, order, 0)
        first = np.where(f[1] >= f[2], 0, 1) + np.arange(3)[:, None]
        self.t, self.y = np.take_along_axis(t, first, 0), np.take_along_axis(f, first, 0)
