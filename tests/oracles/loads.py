"""Dense accelerations under forces and moments, and what springs, dampers, friction and drag exert, from poses."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import maximal
from .maximal import GROUND, Array, System, turned

Place = tuple[int, tuple[float, float]]
"""A point: its link (-1: the ground) and where it is in the link's frame."""


def accelerate(system: System, poses: ArrayLike, velocities: ArrayLike, wrenches: Array, along: ArrayLike) -> Any:
    """As ``maximal.accelerate``, with forces and moments about the centres of mass (links, 3).

    ``along`` is the direction of gravity, of length 1.
    """
    angles = np.asarray(poses, system.dtype)[:, 2]
    spins = np.asarray(velocities, system.dtype)[:, 2]
    force = np.array(wrenches, system.dtype)
    mass = np.asarray(system.mass, system.dtype)[:, None]
    force[:, :2] += mass * system.dtype(system.gravity) * np.asarray(along, system.dtype)
    rows = maximal.jacobian(system, angles)
    inertias = np.stack([system.mass, system.mass, system.inertia], axis=1).astype(system.dtype).ravel()
    none = np.zeros((len(rows), len(rows)), system.dtype)
    right = np.zeros(2 * len(system.pins), system.dtype)
    for k, pin in enumerate(system.pins):
        for sign, link, on in ((-1, pin.a, pin.on_a), (1, pin.b, pin.on_b)):
            if link != GROUND:
                arm = np.asarray(on, system.dtype) - np.asarray(system.com[link], system.dtype)
                right[2 * k : 2 * k + 2] += sign * spins[link] ** 2 * turned(angles[link], arm)
    saddle = np.block([[np.diag(inertias), rows.T], [rows, none]])
    x = maximal.solve(saddle, np.concatenate([force.ravel(), right]))
    frames = maximal.frame_velocities(system, np.asarray(poses), x[: 3 * system.size].reshape(-1, 3))
    frames[:, :2] += spins[:, None] ** 2 * turned(angles, system.com)
    return maximal.Motion(frames, -x[3 * system.size :].reshape(-1, 2))


@dataclass
class Acting:
    """Wrenches about the centres of mass (links, 3), potential energy and power, summed up effect by effect."""

    system: System
    poses: Array
    velocities: Array
    wrenches: Array = field(init=False)
    potential: Any = 0.0
    power: Any = 0.0

    def __post_init__(self) -> None:
        self.poses = np.asarray(self.poses, self.system.dtype)
        self.velocities = np.asarray(self.velocities, self.system.dtype)
        self.wrenches = np.zeros((self.system.size, 3), self.system.dtype)

    def at(self, place: Place) -> tuple[Array, Array]:
        """Position and velocity of a point."""
        link, on = place
        if link == GROUND:
            return np.asarray(on, self.system.dtype), np.zeros(2, self.system.dtype)
        arm = turned(self.poses[link, 2], on)
        spin = self.velocities[link, 2]
        return self.poses[link, :2] + arm, self.velocities[link, :2] + spin * np.array([-arm[1], arm[0]])

    def push(self, place: Place, force: Array) -> None:
        link, on = place
        if link != GROUND:
            x, y = turned(self.poses[link, 2], np.subtract(on, self.system.com[link]))
            self.wrenches[link] += (*force, x * force[1] - y * force[0])

    def carried(self, link: int, place: Array) -> Array:
        """The velocity of the material point of a link that is at a place."""
        if link == GROUND:
            return np.zeros(2, self.system.dtype)
        x, y = place - self.poses[link, :2]
        return np.asarray(self.velocities[link, :2] + self.velocities[link, 2] * np.array([-y, x]))

    def push_there(self, link: int, place: Array, force: Array) -> None:
        """A force on a link at a place."""
        if link != GROUND:
            x, y = place - self.poses[link, :2] - turned(self.poses[link, 2], self.system.com[link])
            self.wrenches[link] += (*force, x * force[1] - y * force[0])

    def twist(self, first: int, second: int, moment: Any) -> None:
        """A moment on the second link, the opposite on the first."""
        for link, sign in ((first, -1), (second, 1)):
            if link != GROUND:
                self.wrenches[link, 2] += sign * moment

    def spring(self, one: Place, other: Place, stiffness: float, length: float) -> None:
        reach = self.at(other)[0] - self.at(one)[0]
        long = np.sqrt(reach @ reach)
        pull = stiffness * (long - length) * reach / long
        self.push(one, pull)
        self.push(other, -pull)
        self.potential += stiffness * (long - length) ** 2 / 2

    def damper(self, one: Place, other: Place, damping: float) -> None:
        (p, v), (p2, v2) = self.at(one), self.at(other)
        line = (p2 - p) / np.sqrt((p2 - p) @ (p2 - p))
        tension = damping * ((v2 - v) @ line)
        self.push(one, tension * line)
        self.push(other, -tension * line)
        self.power -= tension**2 / damping

    def torsion(self, first: int, second: int, stiffness: float, angle: float, damping: float) -> None:
        turn, rate = self.turn(first, second)
        self.twist(first, second, -stiffness * (turn - angle) - damping * rate)
        self.potential += stiffness * (turn - angle) ** 2 / 2
        self.power -= damping * rate**2

    def friction(self, first: int, second: int, viscous: float, dry: float, about: float) -> None:
        rate = self.turn(first, second)[1]
        moment = -viscous * rate - dry * np.tanh(rate / about)
        self.twist(first, second, moment)
        self.power += moment * rate

    def drag(self, point: Place, linear: float, quadratic: float, speed: float) -> None:
        v = self.at(point)[1]
        force = -(linear + quadratic * np.sqrt(v @ v + self.system.dtype(speed) ** 2)) * v
        self.push(point, force)
        self.power += force @ v

    def turn(self, first: int, second: int) -> tuple[Any, Any]:
        """The angle of the second link against the first, and its rate."""
        sides = [(0.0, 0.0) if k == GROUND else (self.poses[k, 2], self.velocities[k, 2]) for k in (first, second)]
        return sides[1][0] - sides[0][0], sides[1][1] - sides[0][1]
