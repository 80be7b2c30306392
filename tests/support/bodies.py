"""Scenes and audits that several hard cases share."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..oracles import polygons

G = 9.81


def rod(friction: float, angle: float, velocity: tuple[float, float], spin: float = 0.0) -> str:
    """A uniform rod of 1 m and 1 kg whose point A stands on rough ground."""
    return f"""
name = "rod"
[[link]]
name = "rod"
mass = 1.0
inertia = {1 / 12}
com = [0.5, 0.0]
points = {{ A = [0.0, 0.0], B = [1.0, 0.0] }}
[start]
angles = {{ rod = {angle} }}
velocity = [{velocity[0]}, {velocity[1]}]
angular_velocities = {{ rod = {spin} }}
[gravity]
g = {G}
[[ground]]
restitution = 0.0
friction = {friction}
contacts = ["rod.A", "rod.B"]
"""


def block(
    width: float,
    height: float,
    friction: float,
    slope: float = 0.0,
    tilt: float = 0.0,
    speed: float = 0.0,
) -> str:
    """A uniform block with its lower corners A, B on a slope; tilted about A, moving up the slope with ``speed``."""
    c, s = float(np.cos(slope)), float(np.sin(slope))
    turned = float(slope + tilt)
    along = (float(np.cos(turned)), float(np.sin(turned)))
    up = (-along[1], along[0])
    centre = [0.5 * width * along[i] + 0.5 * height * up[i] for i in (0, 1)]
    return f"""
name = "block"
[[link]]
name = "block"
mass = 2.0
inertia = {2.0 * (width**2 + height**2) / 12}
com = [0.0, 0.0]
points = {{ A = [{-width / 2}, {-height / 2}], B = [{width / 2}, {-height / 2}] }}
[start]
position = [{centre[0]!r}, {centre[1]!r}]
angles = {{ block = {turned!r} }}
velocity = [{speed * c!r}, {speed * s!r}]
[gravity]
g = {G}
[[ground]]
normal = [{-s!r}, {c!r}]
restitution = 0.0
friction = {friction}
contacts = ["block.A", "block.B"]
"""


def penetration(run: Any) -> float:
    """The deepest that any contact gets behind its surface (m), over all rows."""
    return max(0.0, -float(run.model.gaps(run.q).min()))


def rise(run: Any) -> float:
    """The largest rise of energy from one row to a later one, relative to the energy at the start."""
    energy = np.sum(run.model.energy(run.q, run.u), axis=0)
    return float(np.max(energy - np.minimum.accumulate(energy))) / abs(float(energy[0]))


def speed(run: Any) -> float:
    """The largest velocity component of any link at the end."""
    return float(np.max(np.abs(run.model.velocities(run.q[-1], run.u[-1]))))


def tossed_hexagon(model: Any) -> Any:
    """q, u of a ring of six half a metre above the ground, bent and spinning, drifting with (0.3, -0.1) m/s."""
    poses, _ = polygons.perturbed(6, height=0.5)
    turns = np.stack([-np.sin(poses[:, 2]), np.cos(poses[:, 2])])
    spins = 0.2 + 0.5 * np.cos(2.3 * np.arange(6) + 0.7)
    spins -= turns.T @ np.linalg.solve(turns @ turns.T, turns @ spins)
    swings = np.cumsum(spins[:, None] * turns.T, axis=0)
    drift = np.vstack([np.zeros(2), swings[:-1]]) + np.array([0.3, -0.1])
    return model.state_from_poses(poses, np.column_stack([drift, spins]))
