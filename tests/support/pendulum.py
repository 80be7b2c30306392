"""A rod that swings from level, and its motion in closed form."""

from __future__ import annotations

import numpy as np
from scipy.special import ellipj, ellipk

from ..oracles.maximal import Array

PENDULUM = """
name = "method-pendulum"
[chain]
links = 1
hinged = true
[start]
angles = [0.0]
[gravity]
g = 9.81
"""
OMEGA = np.sqrt(1.5 * 9.81)
"""Small swings of a uniform rod of 1 m about its end, rad/s."""
MODULUS = 0.5
"""sin² of half the largest deflection: released level."""


def exact_pendulum(t: Array) -> Array:
    """Angle of the rod, released level (0) at t = 0; it swings down through −π/2."""
    sn, *_ = ellipj(OMEGA * t + ellipk(MODULUS), MODULUS)
    return 2.0 * np.arcsin(np.sqrt(MODULUS) * sn) - np.pi / 2
