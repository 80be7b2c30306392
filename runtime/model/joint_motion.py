"""How far joints are turned and slid, and how fast, by their names."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from .geometry import Geometry


def joint_angles(model: Geometry, q: ArrayLike) -> dict[str, FloatArray]:
    """Per joint that turns the angle of its second link against its first (rad), turns counted; (...) as ``q``."""
    angles = model.poses(q)[..., 2]
    return {name: _against(model, name, angles) for name in turning(model)}


def joint_rates(model: Geometry, q: ArrayLike, u: ArrayLike) -> dict[str, FloatArray]:
    """Their rates (rad/s)."""
    spins = model.velocities(q, u)[..., 2]
    return {name: _against(model, name, spins) for name in turning(model)}


def slide_rates(model: Geometry, q: ArrayLike, u: ArrayLike) -> dict[str, FloatArray]:
    """Per sliding joint how fast it goes along its line (m/s), as its first link sees it."""
    poses, velocities = model.poses(q), model.velocities(q, u)
    return {name: _rates(model, name, poses, velocities) for name in model.data["lines"]}


def turning(model: Geometry) -> list[str]:
    """Joints whose links turn against each other: all but prismatic ones."""
    lines = model.data["lines"]
    return [name for name in model.joints if name not in lines or lines[name]["angle"] is None]


def _against(model: Geometry, joint: str, of_links: FloatArray) -> FloatArray:
    """Of the joint's second link less of its first, the ground's being zero; (...) for numbers (..., links)."""
    first, second = model.data["between"][model.joints.index(joint)]
    zero = np.zeros(of_links.shape[:-1], dtype=of_links.dtype)
    sides = [zero if link < 0 else of_links[..., link] for link in (first, second)]
    return np.asarray(sides[1] - sides[0])


def _rates(model: Geometry, joint: str, poses: FloatArray, velocities: FloatArray) -> FloatArray:
    """That of one joint (...), for poses and velocities (..., links, 3)."""
    flat, lines = (-1, *poses.shape[-2:]), model.lines
    pairs = zip(poses.reshape(flat), velocities.reshape(flat), strict=True)
    return np.array([lines.rate("slide", joint, *pair) for pair in pairs]).reshape(poses.shape[:-2])
