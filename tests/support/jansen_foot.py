"""Jansen's leg in closed form, its foot and the torque at its crank: circles that meet, from his eleven lengths."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

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
    return points(crank, **others)["F"]


def points(crank: Array, **others: Array | float) -> dict[str, Array]:
    """Where all joints and the foot are, x + iy, by their names in scenes/jansen-driven.toml."""
    s = LENGTHS | others
    pivot = -s["a"] - 1j * s["l"] + 0.0 * crank
    pin = s["m"] * np.exp(1j * crank)
    upper, knee = meet(pivot, s["b"], pin, s["j"], 1), meet(pivot, s["c"], pin, s["k"], -1)
    rear = meet(pivot, s["d"], upper, s["e"], 1)
    heel = meet(rear, s["f"], knee, s["g"], -1)
    sole = meet(knee, s["i"], heel, s["h"], 1)
    return {"O": 0.0 * pin, "A": pin, "P": pivot, "B": upper, "C": knee, "D": rear, "E": heel, "F": sole}


def torque(crank: Array, links: Sequence[Mapping[str, Any]], speed: float, g: float, **others: Array | float) -> Array:
    """The torque (N m) that turns the crank at a constant ``speed`` (rad/s): the derivative of the leg's energy by its
    angle, since it does the work.

    At n even angles of a whole turn, the last axis of ``crank``. ``links`` are tables of a scene with ``mass``,
    ``inertia``, ``com`` and ``points``, of which the second lies on the x axis through the first, the origin. All is
    periodic, so derivatives are those of Fourier series."""
    places, energy = points(crank, **others), 0.0 * crank
    for link in links:
        first, second = (places[name] for name in list(link["points"])[:2])
        along = (second - first) / np.abs(second - first)
        centre = first + along * complex(*link["com"])
        turning = (slope(along) / along).imag
        square = link["mass"] * np.abs(slope(centre)) ** 2 + link["inertia"] * turning**2
        energy = energy + square * speed**2 / 2.0 + link["mass"] * g * centre.imag
    return slope(energy).real


def slope(values: Array) -> Array:
    """The derivative by the angle of what is periodic over n even angles of a turn, the last axis."""
    n = values.shape[-1]
    orders = np.fft.fftfreq(n, 1.0 / n)
    orders[n // 2] = 0.0  # of even n the highest order has a sine that no sample sees
    return np.fft.ifft(1j * orders * np.fft.fft(values, axis=-1), axis=-1)
