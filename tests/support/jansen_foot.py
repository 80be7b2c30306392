"""The foot of Jansen's leg in closed form: circles that meet, from his eleven lengths."""

from __future__ import annotations

import numpy as np

from ..oracles.maximal import Array


def meet(p: Array, r: float, q: Array, s: float, side: int) -> Array:
    """Where the circles of radius r about p and s about q meet, on the ``side`` of the way from p to q (1: left)."""
    way = q - p
    far = np.abs(way)
    along = (r**2 - s**2 + far**2) / (2.0 * far)
    return p + way / far * (along + side * 1j * np.sqrt(r**2 - along**2))


def foot(crank: Array) -> Array:
    a, b, c, d, e, f, g, h, i, j, k, low, m = (
        38.0, 41.5, 39.3, 40.1, 55.8, 39.4, 36.7, 65.7, 49.0, 50.0, 61.9, 7.8, 15.0
    )  # fmt: skip
    pivot = np.full(np.shape(crank), complex(-a, -low))
    pin = m * np.exp(1j * crank)
    upper, knee = meet(pivot, b, pin, j, 1), meet(pivot, c, pin, k, -1)
    rear = meet(pivot, d, upper, e, 1)
    heel = meet(rear, f, knee, g, -1)
    return meet(knee, i, heel, h, 1)
