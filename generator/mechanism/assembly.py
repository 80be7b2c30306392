"""Where the links are: poses from link angles, and the angles and speeds that hold every loop closed.

A point fixed in a link is a complex number z in the link's frame; turned by the link's angle θ it is z·exp(iθ). Every
place in the mechanism is then a constant plus one complex *arm* per link times exp(iθ) of that link, and so is the gap
of every joint that a spanning tree leaves open. Only NumPy is needed here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .joints import PointRef
from .links import GROUND
from .mechanism import Mechanism

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

CLOSED = 1e-14
"""A closed joint misses by no more than this times the length of all its arms."""

_ATTEMPTS = 8
_STEPS = 200
_STIFF = 1e12
"""Multipliers as large as this mean that the closure cannot be reached from here."""


class CannotClose(ValueError):
    """No closed configuration was found: joint ``joint`` misses by ``miss`` m at the best one."""

    def __init__(self, joint: int, miss: float) -> None:
        super().__init__(f"joint {joint} misses by {miss:.3g} m")
        self.joint = joint
        self.miss = miss


class Contradiction(ValueError):
    """Given angular velocities pull joint ``joint`` apart at ``speed`` m/s; ``links`` are those given that move it."""

    def __init__(self, joint: int, speed: float, links: tuple[int, ...]) -> None:
        super().__init__(f"joint {joint} opens at {speed:.3g} m/s")
        self.joint = joint
        self.speed = speed
        self.links = links


@dataclass(frozen=True)
class Layout:
    """Places as functions of the link angles: ``base + arms @ exp(iθ)``, complex, in m.

    ``base`` (nl,) and ``arms`` (nl, nl) give the origin of each link's frame, relative to that of the first link when
    the mechanism is ``floating``. ``gap_base`` (nc,) and ``gap_arms`` (nc, nl) give the gaps, second point
    minus first point, of the joints ``gaps`` that close loops. ``apart`` are links that no chain of joints connects.
    """

    floating: bool
    base: Complex
    arms: Complex
    gaps: tuple[int, ...]
    gap_base: Complex
    gap_arms: Complex
    apart: tuple[int, ...]

    def closure(self, angles: Real) -> Real:
        """Gaps in m, x and y of each, shape (2 nc,)."""
        return _split(self.gap_base + self.gap_arms @ np.exp(1j * angles))

    def jacobian(self, angles: Real) -> Real:
        """Derivative of the closure with respect to the angles, shape (2 nc, nl)."""
        return _split(1j * self.gap_arms * np.exp(1j * angles))

    def poses(self, angles: Real, position: tuple[float, float]) -> Real:
        """x, y and angle of each link's frame, shape (nl, 3); ``position`` is that of the first frame if floating."""
        origin = self.base + self.arms @ np.exp(1j * angles) + (complex(*position) if self.floating else 0.0)
        return np.column_stack([origin.real, origin.imag, angles])

    def velocities(self, angles: Real, rates: Real, velocity: tuple[float, float]) -> Real:
        """Velocity of each frame's origin and its angular velocity, shape (nl, 3)."""
        moved = self.arms @ (1j * np.exp(1j * angles) * rates) + (complex(*velocity) if self.floating else 0.0)
        return np.column_stack([moved.real, moved.imag, rates]) + 0.0 + 0.0

    @property
    def reach(self) -> Real:
        """Length of all arms of each gap (m), shape (nc,)."""
        total: Real = np.abs(self.gap_arms).sum(axis=1) + np.abs(self.gap_base)
        return total


def lay_out(mechanism: Mechanism) -> Layout:
    """The mechanism's places, along a spanning tree grown from the ground, or from the first link if none is fixed."""
    count = len(mechanism.links)
    held = any(joint.on_ground for joint in mechanism.joints)
    base: Complex = np.zeros(count, dtype=complex)
    arms: Complex = np.zeros((count, count), dtype=complex)
    placed = {GROUND} if held else {0}
    tree: set[int] = set()

    def local(ref: PointRef) -> complex:
        return complex(*mechanism.point(ref).values())

    def place(ref: PointRef) -> tuple[complex, Complex]:
        if ref.link == GROUND:
            return local(ref), np.zeros(count, dtype=complex)
        row = arms[ref.link].copy()
        row[ref.link] += local(ref)
        return complex(base[ref.link]), row

    waiting = list(placed)
    while waiting:
        near = waiting.pop(0)
        for index, joint in enumerate(mechanism.joints):
            inner, outer = (joint.first, joint.second) if joint.first.link == near else (joint.second, joint.first)
            if inner.link != near or outer.link in placed:
                continue
            base[outer.link], arms[outer.link] = place(inner)
            arms[outer.link, outer.link] -= local(outer)
            placed.add(outer.link)
            tree.add(index)
            waiting.append(outer.link)
    gaps = tuple(
        index for index, joint in enumerate(mechanism.joints) if index not in tree and joint.first.link in placed
    )
    sides = [(place(mechanism.joints[index].first), place(mechanism.joints[index].second)) for index in gaps]
    gap_base = np.array([second[0] - first[0] for first, second in sides], dtype=complex)
    gap_arms = np.array([second[1] - first[1] for first, second in sides], dtype=complex).reshape(len(gaps), count)
    apart = tuple(index for index in range(count) if index not in placed)
    return Layout(not held, base, arms, gaps, gap_base, gap_arms, apart)


def nearest(layout: Layout, sketch: Real) -> Real:
    """The closed configuration whose angles have the smallest sum of squared changes from ``sketch`` (rad, (nl,)).

    A sketch that is closed already comes back as it is. Raises ``CannotClose`` when no closed configuration is found.
    """
    tolerance = CLOSED * layout.reach
    if not layout.gaps or _closed(layout, sketch, tolerance):
        return sketch
    best = sketch
    for attempt in range(_ATTEMPTS):
        # A sketch can be a dead end, all links in one line say: the later attempts leave it by different ways.
        detour = 0.3 * attempt * np.cos(1.0 + (attempt + 1.0) * np.arange(len(sketch)))
        angles = _polish(layout, _descend(layout, sketch, sketch + detour))
        if _closed(layout, angles, tolerance):
            return angles
        best = min(best, angles, key=lambda found: float(_misses(layout, found).max()))
    worst = int(np.argmax(_misses(layout, best)))
    raise CannotClose(layout.gaps[worst], float(_misses(layout, best)[worst]))


def rates(layout: Layout, angles: Real, given: Mapping[int, float], tolerance: float = 1e-9) -> Real:
    """Angular velocities (rad/s, (nl,)) that keep every joint closed: those ``given`` as they are, the others smallest.

    Raises ``Contradiction`` when those given pull a joint apart faster than ``tolerance`` (m/s) whatever the others do.
    """
    found: Real = np.zeros(len(angles))
    held = np.array(sorted(given), dtype=int)
    found[held] = [given[link] for link in sorted(given)]
    if not layout.gaps:
        return found
    jacobian = layout.jacobian(angles)
    free = np.setdiff1d(np.arange(len(angles)), held)
    found[free] = -_smallest(jacobian[:, free], jacobian @ found)
    opening = jacobian @ found
    speeds = np.hypot(opening[0::2], opening[1::2])
    worst = int(np.argmax(speeds))
    if speeds[worst] > tolerance:
        moving = [int(link) for link in held if np.abs(jacobian[:, link]).max() > 0.0]
        raise Contradiction(layout.gaps[worst], float(speeds[worst]), tuple(moving))
    if speeds[worst] > CLOSED * float(np.abs(found).max()) * float(layout.reach.max()):
        found -= _smallest(jacobian, opening)
    return found


def _descend(layout: Layout, sketch: Real, start: Real) -> Real:
    """Stationary point of ½|θ - sketch|² on the closed configurations, by damped Newton steps from ``start``.

    The closure's second derivatives are diagonal, because each arm turns with one angle only; so is the Hessian of the
    Lagrangian, kept positive here so that every step goes down.
    """
    angles: Real = start
    multipliers: Real = np.zeros(2 * len(layout.gaps))
    penalty = 1.0
    for _ in range(_STEPS):
        gap, jacobian, away = layout.closure(angles), layout.jacobian(angles), angles - sketch
        curvature = -_split(layout.gap_arms * np.exp(1j * angles)).T @ multipliers
        hessian = np.maximum(1.0 + curvature, 0.1)
        schur = (jacobian / hessian) @ jacobian.T
        multipliers = _smallest(schur, gap - (jacobian / hessian) @ away)
        if np.linalg.norm(multipliers) > _STIFF:
            break
        step = -(away + jacobian.T @ multipliers) / hessian
        penalty = max(penalty, 2.0 * float(np.linalg.norm(multipliers)))
        size = _line_search(layout, sketch, angles, step, penalty)
        angles = angles + size * step
        if float(np.abs(size * step).max()) <= 1e-13:
            break
    return angles


def _line_search(layout: Layout, sketch: Real, angles: Real, step: Real, penalty: float) -> float:
    """Largest halving of ``step`` that lowers distance plus penalised gap; no step turns a link by over 1 rad."""

    def merit(size: float) -> float:
        at = angles + size * step
        return 0.5 * float(np.sum((at - sketch) ** 2)) + penalty * float(np.linalg.norm(layout.closure(at)))

    size = min(1.0, 1.0 / max(float(np.abs(step).max()), 1e-300))
    here = merit(0.0)
    while size > 1e-6 and merit(size) > here + 1e-14 * abs(here):
        size *= 0.5
    return size


def _polish(layout: Layout, angles: Real) -> Real:
    """The gaps made as small as they get from here, by smallest steps, damped where the full step does not help."""
    damping = 0.0
    for _ in range(_STEPS):
        gap, jacobian = layout.closure(angles), layout.jacobian(angles)
        if damping:
            square = jacobian @ jacobian.T
            step = jacobian.T @ np.linalg.solve(square + damping * np.eye(len(gap)), gap)
        else:
            step = _smallest(jacobian, gap)
        if np.linalg.norm(layout.closure(angles - step)) < np.linalg.norm(gap):
            angles = angles - step
            damping = 0.1 * damping if damping > 1e-6 else 0.0
        elif damping < 1e3 * float(layout.reach.max()) ** 2:
            damping = max(10.0 * damping, 1e-6)
        else:
            break
    return angles


def _smallest(matrix: Real, right: Real) -> Real:
    """Least-squares solution of matrix·x = right; the smallest where there are many."""
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=1e-12)[0], dtype=np.float64)


def _misses(layout: Layout, angles: Real) -> Real:
    """How far each gap is open (m), shape (nc,)."""
    gap = layout.closure(angles)
    return np.hypot(gap[0::2], gap[1::2])


def _closed(layout: Layout, angles: Real, tolerance: Real) -> bool:
    return bool(np.all(_misses(layout, angles) <= tolerance))


def _split(values: Complex) -> Real:
    """Complex rows as alternating real and imaginary rows."""
    return np.stack([values.real, values.imag], axis=1).reshape(2 * values.shape[0], *values.shape[1:])
