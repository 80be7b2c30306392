"""Newton's and Euler's laws for each link by itself, and for all together, from where the links are and how they move.

Nothing here knows coordinates: it takes places and velocities of the links' frames, masses, and forces that are given.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .maximal import GROUND, Array, turned


def masses(model: Any) -> tuple[Array, Array, Array]:
    """Mass, inertia about the mass centre and mass centre in the link's frame of every link."""
    value = model.parameters.get
    links = model.links
    mass = np.array([value(f"{link}.mass", 0.0) for link in links])
    inertia = np.array([value(f"{link}.inertia", 0.0) for link in links])
    com = np.array([[value(f"{link}.com.x", 0.0), value(f"{link}.com.y", 0.0)] for link in links])
    return mass, inertia, com


def momenta(model: Any, q: Array, u: Array) -> Array:
    """Per link its momentum (x, y) and its angular momentum about its own mass centre, (links, 3)."""
    mass, inertia, com = masses(model)
    poses, velocities = model.poses(q), model.velocities(q, u)
    arm = turned(poses[:, 2], com)
    across = np.stack([-arm[:, 1], arm[:, 0]], axis=1)
    centre = velocities[:, :2] + velocities[:, 2:] * across
    return np.column_stack([mass[:, None] * centre, inertia * velocities[:, 2]])


def centres(model: Any, q: Array) -> Array:
    """Mass centres, (links, 2)."""
    poses = model.poses(q)
    found: Array = poses[:, :2] + turned(poses[:, 2], masses(model)[2])
    return found


def whole(model: Any, q: Array, u: Array) -> Array:
    """Momentum (x, y) of all links together, and their angular momentum about the origin."""
    parts, places = momenta(model, q, u), centres(model, q)
    turning = places[:, 0] * parts[:, 1] - places[:, 1] * parts[:, 0] + parts[:, 2]
    return np.array([*parts[:, :2].sum(axis=0), turning.sum()])


def rate(along: Callable[[Array, Array], Array], q: Array, u: Array, u_dot: Array) -> Array:
    """Rate of a function of the state along a motion, by differences of order four."""
    h = 2e-3

    def at(s: float) -> Array:
        return along(q + s * u + 0.5 * s * s * u_dot, u + s * u_dot)

    found: Array = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h)
    return found


def by_joints(model: Any, q: Array, reactions: Array) -> Array:
    """What pins (not slides) do to each link, about its mass centre, (links, 3)."""
    found, places = np.zeros((len(model.links), 3)), centres(model, q)
    for j, name in enumerate(model.joints):
        for link, sign in zip(model.data["between"][j], (-1.0, 1.0), strict=True):
            if link != GROUND:
                x, y = model.point(name, q) - places[link]
                force = sign * reactions[j]
                found[link] += [force[0], force[1], x * force[1] - y * force[0] + force[2]]
    return found


def push(model: Any, q: Array, link: int, place: Array, force: Array) -> Array:
    """What a force at a place does to each link, about its mass centre, (links, 3)."""
    found = np.zeros((len(model.links), 3))
    x, y = place - centres(model, q)[link]
    found[link] = [force[0], force[1], x * force[1] - y * force[0]]
    return found
