"""A wheel on a slope, and what decides whether it rolls."""

from __future__ import annotations

import numpy as np

G, MASS, INERTIA, RADIUS = 9.81, 2.0, 0.03, 0.2
SLOPE = np.radians(30)
NORMAL = np.array([np.sin(SLOPE), np.cos(SLOPE)])
TANGENT = np.array([NORMAL[1], -NORMAL[0]])


def wheel(friction: str, place: str = "", restitution: float = 0.0) -> str:
    """A wheel about its mass centre, on a slope of 30 degrees that falls to the right."""
    position = (RADIUS * NORMAL).tolist()
    return (
        f'[[link]]\nname = "wheel"\nmass = {MASS}\ninertia = {INERTIA}\ncom = [0, 0]\npoints = {{ C = [0, 0] }}\n'
        f"[gravity]\ng = {G}\n[start]\n{place or f'position = {position}'}\n"
        f"[[ground]]\nnormal = {NORMAL.tolist()}\nrestitution = {restitution}\n{friction}\n"
        f'contacts = ["wheel.C"]\nradius = {RADIUS}\n'
    )
