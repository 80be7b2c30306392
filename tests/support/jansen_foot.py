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


LENGTHS = {
    "a": 38.0, "b": 41.5, "c": 39.3, "d": 40.1, "e": 55.8, "f": 39.4, "g": 36.7, "h": 65.7, "i": 49.0, "j": 50.0,
    "k": 61.9, "l": 7.8, "m": 15.0,
}  # fmt: skip
"""His names and numbers: a and l place the pivot, m is the crank."""


def foot(crank: Array, **others: Array | float) -> Array:
    """Where the foot is at angles of the crank, x + iy; ``others`` are lengths by his names, in place of his."""
    s = LENGTHS | others
    pivot = -s["a"] - 1j * s["l"] + 0.0 * crank
    pin = s["m"] * np.exp(1j * crank)
    upper, knee = meet(pivot, s["b"], pin, s["j"], 1), meet(pivot, s["c"], pin, s["k"], -1)
    rear = meet(pivot, s["d"], upper, s["e"], 1)
    heel = meet(rear, s["f"], knee, s["g"], -1)
    return meet(knee, s["i"], heel, s["h"], 1)
