"""The dense reference for mechanisms whose links also slide: maximal coordinates, as in ``maximal``.

A slot constrains φ = n·(b − a) = 0, where n is across a line that turns with link a, and the points a and b are those
of the two links; a prismatic joint holds the angle θ_b − θ_a too. By the product rule, with ω of link a,

    φ' = ω n⊥·(b − a) + n·(b' − a'),    φ'' = α n⊥·(b − a) − ω² φ + 2 ω n⊥·(b' − a') + n·(b'' − a'') .
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import maximal
from .maximal import GROUND, Array, System, turned


@dataclass(frozen=True)
class Slot:
    """``on_b`` of link ``b`` slides along a line of link ``a``, through ``on_a`` in the direction ``axis`` (rad).

    With an ``angle`` (rad) the frame of ``b`` keeps it against that of ``a``.
    """

    a: int
    on_a: tuple[float, float]
    axis: float
    b: int
    on_b: tuple[float, float]
    angle: float | None = None


@dataclass(frozen=True)
class Given:
    """A prescribed acceleration: of link ``b`` against ``a`` (rad/s²), or along the line of ``slot`` (m/s²)."""

    a: int
    b: int
    acceleration: float
    slot: Slot | None = None


@dataclass(frozen=True)
class Meshed:
    """A sum of factors times what ``Given`` records name, whose second rate is zero: wheels that mesh."""

    parts: tuple[tuple[float, Given], ...]


Prescribed = Given | Meshed


@dataclass(frozen=True)
class Motion:
    """Accelerations of the link frames, (links, 3); force of each pin on its link ``b``, (pins, 2); of each slot on
    link ``b`` at its point, with the moment of a held angle, (slots, 3); what prescribed motion takes, (given,)."""

    frames: Array
    pins: Array
    slots: Array
    efforts: Array


@dataclass(frozen=True)
class _Rows:
    """Constraint rows: Jacobian by the velocities of the centres of mass, −(their rate)·velocity, and misses."""

    jacobian: Array
    right: Array
    miss: Array


def _cross(v: Array) -> Array:
    return np.array([-v[1], v[0]], v.dtype)


class _Body:
    """A point of a link: place, velocity, centripetal acceleration, and its columns of a Jacobian."""

    def __init__(self, system: System, poses: Array, velocities: Array, link: int, on: tuple[float, float]) -> None:
        kind = system.dtype
        self.columns = np.zeros((2, 3 * system.size), kind)
        self.turn = np.zeros(3 * system.size, kind)
        self.place, self.speed, self.spin = np.asarray(on, kind), np.zeros(2, kind), kind(0)
        self.centripetal, self.angle = np.zeros(2, kind), kind(0)
        if link == GROUND:
            return
        arm = turned(poses[link, 2], np.asarray(on, kind))
        from_centre = turned(poses[link, 2], np.asarray(on, kind) - np.asarray(system.com[link], kind))
        self.place, self.angle, self.spin = poses[link, :2] + arm, poses[link, 2], velocities[link, 2]
        self.speed = velocities[link, :2] + self.spin * _cross(arm)
        self.centripetal = -(self.spin**2) * from_centre
        self.columns[0, 3 * link], self.columns[1, 3 * link + 1] = 1, 1
        self.columns[:, 3 * link + 2] = _cross(from_centre)
        self.turn[3 * link + 2] = 1


def _line_row(direction: Array, a: _Body, b: _Body) -> tuple[Array, Any]:
    """Row of d·(b − a) for a direction that turns with link a, and −(its second rate without accelerations)."""
    apart, moving, turned_ = b.place - a.place, b.speed - a.speed, _cross(direction)
    bias = direction @ (b.centripetal - a.centripetal) + 2 * a.spin * (turned_ @ moving)
    bias -= a.spin**2 * (direction @ apart)
    return direction @ (b.columns - a.columns) + (turned_ @ apart) * a.turn, -bias


def _rows(
    system: System, slots: Sequence[Slot], poses: Array, velocities: Array, given: Sequence[Prescribed] = ()
) -> _Rows:
    lines, right, miss = [], [], []
    for pin in system.pins:
        a = _Body(system, poses, velocities, pin.a, pin.on_a)
        b = _Body(system, poses, velocities, pin.b, pin.on_b)
        lines += list(b.columns - a.columns)
        right += list(a.centripetal - b.centripetal)
        miss += list(b.place - a.place)
    for slot in slots:
        a = _Body(system, poses, velocities, slot.a, slot.on_a)
        b = _Body(system, poses, velocities, slot.b, slot.on_b)
        n = turned(np.asarray(a.angle + system.dtype(slot.axis)), (0.0, 1.0))
        row, rest = _line_row(n, a, b)
        lines.append(row)
        right.append(rest)
        miss.append(n @ (b.place - a.place))
        if slot.angle is not None:
            lines.append(b.turn - a.turn)
            right.append(system.dtype(0))
            turn = float(b.angle - a.angle - slot.angle)
            miss.append(system.dtype(np.remainder(turn + np.pi, 2 * np.pi) - np.pi))
    for one in given:
        parts = one.parts if isinstance(one, Meshed) else ((1.0, one),)
        found = [(factor, part, *_given_row(system, poses, velocities, part)) for factor, part in parts]
        lines.append(sum(factor * row for factor, _, row, _ in found))
        right.append(sum(factor * (rest + part.acceleration) for factor, part, _, rest in found))
    return _Rows(np.array(lines), np.array(right), np.array(miss))


def _given_row(system: System, poses: Array, velocities: Array, one: Given) -> tuple[Array, Any]:
    """Row of a joint's angle or length, and −(its second rate without accelerations)."""
    slot = one.slot or Slot(one.a, (0.0, 0.0), 0.0, one.b, (0.0, 0.0))
    a = _Body(system, poses, velocities, slot.a, slot.on_a)
    b = _Body(system, poses, velocities, slot.b, slot.on_b)
    along = turned(np.asarray(a.angle + system.dtype(slot.axis)), (1.0, 0.0))
    return _line_row(along, a, b) if one.slot else (b.turn - a.turn, system.dtype(0))


def accelerate(
    system: System,
    slots: Sequence[Slot],
    poses: ArrayLike,
    velocities: ArrayLike,
    wrenches: Array | None = None,
    given: Sequence[Prescribed] = (),
) -> Motion:
    """Accelerations and joint forces under gravity down y and ``wrenches`` about the centres of mass (links, 3)."""
    poses, velocities = np.asarray(poses, system.dtype), np.asarray(velocities, system.dtype)
    rows = _rows(system, slots, poses, velocities, given)
    count = 3 * system.size
    force = np.zeros((system.size, 3), system.dtype) if wrenches is None else np.array(wrenches, system.dtype)
    force[:, 1] -= np.asarray(system.mass, system.dtype) * system.dtype(system.gravity)
    x = maximal.solve(_saddle(system, rows), np.concatenate([force.ravel(), rows.right]))
    frames = maximal.frame_velocities(system, poses, x[:count].reshape(-1, 3))
    frames[:, :2] += velocities[:, 2, None] ** 2 * turned(poses[:, 2], system.com)
    pins = x[count : count + 2 * len(system.pins)].reshape(-1, 2)
    return Motion(frames, pins, _pushes(system, slots, poses, x), x[len(x) - len(given) :])


def _saddle(system: System, rows: _Rows) -> Array:
    inertias = np.stack([system.mass, system.mass, system.inertia], axis=1).astype(system.dtype).ravel()
    none = np.zeros((len(rows.right), len(rows.right)), system.dtype)
    return np.block([[np.diag(inertias), -rows.jacobian.T], [rows.jacobian, none]])


def strike(
    system: System, slots: Sequence[Slot], poses: ArrayLike, impulses: Array, given: Sequence[Prescribed] = ()
) -> Motion:
    """Velocity jumps in place of accelerations, impulses in place of forces: under ``impulses`` about the centres of
    mass (links, 3), no joint opening and no prescribed motion changing."""
    poses = np.asarray(poses, system.dtype)
    rows = _rows(system, slots, poses, np.zeros_like(poses), given)
    count, still = 3 * system.size, np.zeros(len(rows.right), system.dtype)
    x = maximal.solve(_saddle(system, rows), np.concatenate([np.asarray(impulses, system.dtype).ravel(), still]))
    frames = maximal.frame_velocities(system, poses, x[:count].reshape(-1, 3))
    pins = x[count : count + 2 * len(system.pins)].reshape(-1, 2)
    return Motion(frames, pins, _pushes(system, slots, poses, x), x[len(x) - len(given) :])


def jump(
    system: System, slots: Sequence[Slot], poses: ArrayLike, impulses: Array, given: Sequence[Prescribed] = ()
) -> tuple[Array, Array]:
    """The jumps of ``strike`` (links, 3), and the impulses that prescribed motion takes (given,)."""
    found = strike(system, slots, poses, impulses, given)
    return found.frames, found.efforts


def _pushes(system: System, slots: Sequence[Slot], poses: Array, x: Array) -> Array:
    """Force and moment of each slot on its link ``b``, from the multipliers that follow those of the pins."""
    found, at = [], 3 * system.size + 2 * len(system.pins)
    for slot in slots:
        angle = system.dtype(slot.axis) + (poses[slot.a, 2] if slot.a != GROUND else system.dtype(0))
        n = turned(np.asarray(angle), (0.0, 1.0))
        held: Any = x[at + 1] if slot.angle is not None else 0
        found.append([*(x[at] * n), held])
        at += 1 if slot.angle is None else 2
    return np.array(found).reshape(-1, 3)


def misses(system: System, slots: Sequence[Slot], poses: ArrayLike, velocities: ArrayLike) -> tuple[float, float]:
    """Largest miss of a joint (m or rad) and the largest rate at which one opens (m/s or rad/s)."""
    poses, velocities = np.asarray(poses, system.dtype), np.asarray(velocities, system.dtype)
    rows = _rows(system, slots, poses, velocities)
    centre = maximal.centre_velocities(system, poses, velocities).ravel()
    return float(np.max(np.abs(rows.miss))), float(np.max(np.abs(rows.jacobian @ centre)))


def freedoms(system: System, slots: Sequence[Slot], given: Sequence[Prescribed] = ()) -> int:
    """3 per link, less the rows of all joints and of prescribed motion."""
    return 3 * system.size - 2 * len(system.pins) - sum(1 if s.angle is None else 2 for s in slots) - len(given)


def conditioning(system: System, slots: Sequence[Slot], poses: ArrayLike, given: Sequence[Prescribed] = ()) -> float:
    """Condition number of G M⁻¹ Gᵀ with rows of length one: how near to dependent the joints are."""
    poses = np.asarray(poses, system.dtype)
    rows = _rows(system, slots, poses, np.zeros_like(poses), given).jacobian
    inertias = np.stack([system.mass, system.mass, system.inertia], axis=1).astype(system.dtype).ravel()
    scaled = (rows / np.sqrt(inertias)).astype(float)
    values = np.linalg.svd(scaled / np.linalg.norm(scaled, axis=1)[:, None], compute_uv=False)
    return float((values[0] / values[-1]) ** 2) if values[-1] else np.inf
