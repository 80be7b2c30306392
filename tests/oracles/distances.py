"""Ropes, journals in bearings and slots, and what touches, in maximal coordinates: gaps as true distances, their rows
by differences.

A gap is a function of the places and angles of the links (the coordinates of their centres of mass), in wide numbers.
Its row is its gradient, by central differences of order 8; what it accelerates at while no link does is its second
derivative along a straight line in these coordinates. Nothing here knows the squares and products that the generator
writes for them. Friction acts on the material points of both links at the place where they touch.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from . import maximal, sliding
from .maximal import GROUND, WIDE, Array, System, turned

STEP = 3e-4
FIRST = (
    1 / WIDE(280),
    -4 / WIDE(105),
    1 / WIDE(5),
    -4 / WIDE(5),
    0,
    4 / WIDE(5),
    -1 / WIDE(5),
    4 / WIDE(105),
    -1 / WIDE(280),
)
SECOND = (
    *(-1 / WIDE(560), 8 / WIDE(315), -1 / WIDE(5), 8 / WIDE(5), -205 / WIDE(72)),
    *(8 / WIDE(5), -1 / WIDE(5), 8 / WIDE(315), -1 / WIDE(560)),
)

Place = tuple[int, tuple[float, float]]
"""A link and a point in its frame."""


@dataclass(frozen=True)
class Rope:
    """No longer than ``length`` along these points."""

    points: tuple[Place, ...]
    length: float

    def gap(self, system: System, centres: Array) -> Any:
        way = [place(system, centres, point) for point in self.points]
        return self.length - sum(np.sqrt((b - a) @ (b - a)) for a, b in pairwise(way))

    def slip(self, system: System, centres: Array, rates: Array) -> Any:
        """Ropes do not rub."""
        return WIDE(0)


@dataclass(frozen=True)
class Journal:
    """A disc of ``radius`` about ``pin``, within ``clearance`` of the segment between two points of another link."""

    pin: Place
    ends: tuple[Place, Place]
    radius: float
    clearance: float

    def off(self, system: System, centres: Array) -> Array:
        """From the nearest point of the segment to the pin."""
        return _from_segment(system, centres, self.pin, self.ends)

    def gap(self, system: System, centres: Array) -> Any:
        off = self.off(system, centres)
        return self.clearance - np.sqrt(off @ off)

    def slip(self, system: System, centres: Array, rates: Array) -> Any:
        """Of the pin's material point that touches the wall against the wall's, to the left of the way outwards."""
        off = self.off(system, centres)
        outwards = off / np.sqrt(off @ off)
        touching = place(system, centres, self.pin) + self.radius * outwards
        moving = carried(system, centres, rates, self.pin[0], touching)
        still = carried(system, centres, rates, self.ends[0][0], touching)
        return (moving - still) @ np.array([-outwards[1], outwards[0]])


@dataclass(frozen=True)
class Above:
    """A disc of ``radius`` about ``centre`` above the half-plane through ``foot`` with this ``normal``."""

    centre: Place
    radius: float
    foot: tuple[float, float]
    normal: tuple[float, float]

    def gap(self, system: System, centres: Array) -> Any:
        return np.asarray(self.normal, WIDE) @ (place(system, centres, self.centre) - self.foot) - self.radius

    def slip(self, system: System, centres: Array, rates: Array) -> Any:
        """Of the disc's material point that touches, to the right of the normal."""
        normal = np.asarray(self.normal, WIDE)
        touching = place(system, centres, self.centre) - self.radius * normal
        return carried(system, centres, rates, self.centre[0], touching) @ np.array([normal[1], -normal[0]])


@dataclass(frozen=True)
class Beside:
    """A disc of ``radius`` about ``centre`` beside the segment between two points of another link, which has an
    ``other`` radius."""

    centre: Place
    ends: tuple[Place, Place]
    radius: float
    other: float

    def gap(self, system: System, centres: Array) -> Any:
        off = _from_segment(system, centres, self.centre, self.ends)
        return np.sqrt(off @ off) - self.radius - self.other

    def slip(self, system: System, centres: Array, rates: Array) -> Any:
        """Of the disc's material point that touches against the other's, to the right of the way to the disc."""
        off = _from_segment(system, centres, self.centre, self.ends)
        normal = off / np.sqrt(off @ off)
        touching = place(system, centres, self.centre) - self.radius * normal
        moving = carried(system, centres, rates, self.centre[0], touching)
        still = carried(system, centres, rates, self.ends[0][0], touching)
        return (moving - still) @ np.array([normal[1], -normal[0]])


@dataclass(frozen=True)
class Limit:
    """The angle of link ``b`` against ``a`` above (``sign`` 1) or below (-1) a ``limit`` (rad)."""

    a: int
    b: int
    sign: int
    limit: float

    def gap(self, system: System, centres: Array) -> Any:
        one, other = (WIDE(0) if link == GROUND else centres[link, 2] for link in (self.a, self.b))
        return self.sign * (other - one - self.limit)

    def slip(self, system: System, centres: Array, rates: Array) -> Any:
        """Stops do not rub."""
        return WIDE(0)


@dataclass(frozen=True)
class SlideEnd:
    """How far the point ``on_b`` is along a line through ``on_a`` in the direction ``axis`` (rad) of its link, above
    (``sign`` 1) or below (-1) a ``limit`` (m)."""

    on_a: Place
    on_b: Place
    axis: float
    sign: int
    limit: float

    def gap(self, system: System, centres: Array) -> Any:
        a = self.on_a[0]
        angle = WIDE(0) if a == GROUND else centres[a, 2]
        line = turned(np.asarray(angle + WIDE(self.axis)), (1.0, 0.0))
        way = place(system, centres, self.on_b) - place(system, centres, self.on_a)
        return self.sign * (way @ line - self.limit)

    def slip(self, system: System, centres: Array, rates: Array) -> Any:
        """Ends of slides do not rub."""
        return WIDE(0)


def _from_segment(system: System, centres: Array, point: Place, ends: tuple[Place, Place]) -> Array:
    """From the nearest point of a segment to a point."""
    there, start, end = (place(system, centres, one) for one in (point, *ends))
    along = end - start
    share = (there - start) @ along / (along @ along) if along @ along else WIDE(0)
    return np.asarray(there - start - min(max(share, WIDE(0)), WIDE(1)) * along)


def place(system: System, centres: Array, point: Place) -> Array:
    link, on = point
    if link == GROUND:
        return np.asarray(on, WIDE)
    return centres[link, :2] + turned(centres[link, 2], np.asarray(on, WIDE) - np.asarray(system.com[link], WIDE))


def carried(system: System, centres: Array, rates: Array, link: int, there: Array) -> Array:
    """Velocity of the material point of a link that is at a place."""
    if link == GROUND:
        return np.zeros(2, WIDE)
    x, y = there - centres[link, :2]
    return rates[link, :2] + rates[link, 2] * np.array([-y, x])


def along(function: Callable[[Any], Any], weights: Sequence[Any], power: int) -> Any:
    """A derivative at zero."""
    return sum(w * function(WIDE(STEP) * (k - 4)) for k, w in enumerate(weights)) / WIDE(STEP) ** power


@dataclass(frozen=True)
class Rows:
    """Of some gaps and slips: rows by the velocities of the centres of mass (k, 3 links), and what they accelerate at
    while no link does (k,)."""

    rows: Array
    bias: Array


def rows_of(system: System, parts: Sequence[Any], sticking: Sequence[bool], poses: Array, velocities: Array) -> Rows:
    """Rows of the gaps of all parts, then of the slips of those that stick."""
    centres = centres_of(system, poses)
    rates = maximal.centre_velocities(system, poses, velocities)
    unit = np.eye(3 * system.size, dtype=WIDE).reshape(-1, system.size, 3)
    rows, bias = [], []
    for part in parts:
        rows.append([along(lambda s, p=part, d=d: p.gap(system, centres + s * d), FIRST, 1) for d in unit])
        bias.append(along(lambda s, p=part: p.gap(system, centres + s * rates), SECOND, 2))
    for part in (part for part, sticks in zip(parts, sticking, strict=True) if sticks):
        rows.append([part.slip(system, centres, d) for d in unit])
        bias.append(along(lambda s, p=part: p.slip(system, centres + s * rates, rates), FIRST, 1))
    return Rows(np.array(rows, WIDE), np.array(bias, WIDE))


def centres_of(system: System, poses: Array) -> Array:
    """Centres of mass and angles (links, 3)."""
    centres = np.array(poses, WIDE)
    centres[:, :2] += turned(centres[:, 2], np.asarray(system.com, WIDE))
    return centres


@dataclass(frozen=True)
class Held:
    """The motion with parts held, their forces (parts, 2), along the normal and along the tangent, and the sign of the
    determinant of their matrix: where friction jams it is not positive."""

    motion: sliding.Motion
    forces: Array
    sign: float


def accelerate(
    sketch: Any,
    poses: Array,
    velocities: Array,
    wrenches: Array,
    parts: Sequence[Any],
    ways: Sequence[float | None],
    friction: Sequence[float],
) -> Held:
    """The motion with all ``parts`` held.

    ``ways``: ``None`` where a part sticks, else the sign of its sliding, which friction is against; 0 where smooth.
    """
    system, count, poses, velocities = sketch.system, 3 * len(poses), poses.astype(WIDE), velocities.astype(WIDE)
    joints = sliding._rows(system, sketch.slots, poses, velocities, sketch.prescribed)
    sticking, own = [way is None for way in ways], len(joints.right)
    held = rows_of(system, parts, sticking, poses, velocities)
    shut = np.vstack([joints.jacobian.reshape(-1, count), held.rows])
    pull, tangents = shut.copy(), rows_of(system, parts, [True] * len(parts), poses, velocities).rows[len(parts) :]
    rubs = [WIDE(-mu * (way or 0.0)) for way, mu in zip(ways, friction, strict=True)]
    pull[own : own + len(parts)] += np.array(rubs)[:, None] * tangents
    inertias = np.stack([system.mass, system.mass, system.inertia], axis=1).astype(WIDE).ravel()
    force = np.array(wrenches, WIDE)
    force[:, 1] -= np.asarray(system.mass, WIDE) * WIDE(system.gravity)
    none = np.zeros((len(shut), len(shut)), WIDE)
    right = np.concatenate([force.ravel(), joints.right, -held.bias])
    x = maximal.solve(np.block([[np.diag(inertias), -pull.T], [shut, none]]), right)
    frames = maximal.frame_velocities(system, poses, x[:count].reshape(-1, 3))
    frames[:, :2] += velocities[:, 2, None] ** 2 * turned(poses[:, 2], system.com)
    multipliers = x[count:]
    forces = np.zeros((len(parts), 2), WIDE)
    forces[:, 0] = multipliers[own : own + len(parts)]
    forces[:, 1] = np.array(rubs) * forces[:, 0]
    forces[sticking, 1] = multipliers[own + len(parts) :]
    pins = multipliers[: 2 * len(system.pins)].reshape(-1, 2)
    pushes = sliding._pushes(system, sketch.slots, poses, x)
    motion = sliding.Motion(frames, pins, pushes, multipliers[own - len(sketch.prescribed) : own])
    sign, _ = np.linalg.slogdet(((shut / inertias) @ pull.T).astype(float))
    return Held(motion, forces, float(sign))


def strike(sketch: Any, poses: Array, velocities: Array, part: Any, restitution: float) -> tuple[Array, Any]:
    """Velocities of the frames after an impact of one part, smooth, by Newton's law, and its impulse (N s)."""
    system, count = sketch.system, 3 * sketch.system.size
    still = np.zeros_like(np.asarray(poses, WIDE))
    joints = sliding._rows(system, sketch.slots, np.asarray(poses, WIDE), still, sketch.prescribed)
    own = rows_of(system, [part], [False], np.asarray(poses, WIDE), still).rows
    shut = np.vstack([joints.jacobian.reshape(-1, count), own])
    inertias = np.stack([system.mass, system.mass, system.inertia], axis=1).astype(WIDE).ravel()
    before = maximal.centre_velocities(system, poses, velocities).ravel()
    right = np.zeros(len(shut), WIDE)
    right[-1] = -(1 + WIDE(restitution)) * (own[0] @ before)
    none = np.zeros((len(shut), len(shut)), WIDE)
    x = maximal.solve(
        np.block([[np.diag(inertias), -shut.T], [shut, none]]), np.concatenate([np.zeros(count, WIDE), right])
    )
    return velocities + maximal.frame_velocities(system, poses, x[:count].reshape(-1, 3)), x[-1]
