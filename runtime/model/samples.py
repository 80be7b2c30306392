"""States at which the rounding of a model's accelerations is measured whenever its parameters are set."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import DTypeLike

from ..arrays import FloatArray

ROUNDING = 4096
"""Accelerations whose rounding at sample states is larger than this, in units of the numbers' own, are refined."""
SAMPLES = 8
"""States in a sample."""


def samples(names: tuple[str, ...], length: float, time: float, kind: DTypeLike) -> tuple[FloatArray, FloatArray]:
    """States (SAMPLES, nq) and (SAMPLES, nu), in numbers of this ``kind``, of a mechanism with coordinates of these
    ``names``, of this ``length`` (m) and characteristic ``time`` (s), spread over all angles, loops open; slides go as
    far as links."""
    q, u, slides = _spread(names)
    scale = np.where(slides, length, 1.0)
    return np.array(q * scale, dtype=kind), np.array(u * scale / time, dtype=kind)


@cache
def _spread(names: tuple[str, ...]) -> tuple[FloatArray, FloatArray, list[bool]]:
    """Sample states for coordinates of these names: angles over the circle, places at the origin, slides from -1 to 1,
    and which they are."""
    steps = np.arange(1.0, SAMPLES * len(names) + 1).reshape(SAMPLES, -1)
    q, u = 2.0 * np.pi * np.modf(steps * 0.6180339887498949)[0], 2.0 * np.modf(steps * 0.7548776662466927)[0] - 1.0
    slides = [name.startswith("slide_") for name in names]
    for k, name in enumerate(names):
        if not name.startswith("theta_"):
            q[:, k] = q[:, k] / np.pi - 1.0 if slides[k] else 0.0
            u[:, k] *= float(slides[k])
    return q, u, slides
