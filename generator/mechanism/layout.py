"""Where the links are: poses from link angles and slides, and by how much joints miss that close loops.

A point fixed in a link is a complex number z in the link's frame; turned by the link's angle θ it is z·exp(iθ), and
the length s along a line of the link is s·d·exp(iθ). Every place in the mechanism is then a constant plus one complex
*arm* per link times exp(iθ) of that link, plus the sliding joints' lengths along their lines, and so is the gap of
every joint that a spanning tree leaves open. Only NumPy is needed here.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .implied import implied
from .joints import PointRef
from .links import GROUND
from .mechanism import Mechanism

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

_ROUNDED = 0.1
"""Share of the points' distance from their frames' origins that counts as a gap's reach: the difference of two points
is known to a few units in their last place, and gaps close to 1e-14 of their reach."""


@dataclass(frozen=True)
class Line:
    """The line of sliding joint ``joint``: fixed in link ``owner`` (or the ground), in the direction ``axis`` (rad)."""

    joint: int
    owner: int
    axis: float


@dataclass(frozen=True)
class Held:
    """Joint ``joint`` holds the angle (rad) of link ``second`` against that of link ``first``."""

    joint: int
    first: int
    second: int
    angle: float


@dataclass(frozen=True)
class Length:
    """Sliding joint ``joint`` is ``length`` (m) along its line; ``index`` is that of its displacement."""

    joint: int
    index: int
    length: float


@dataclass(frozen=True)
class Layout:
    """Places as functions of the displacements x: the angles θ of all links (rad), then the lengths of the sliding
    joints along their ``lines``, in units of ``unit`` (m).

    A place is ``base + arms @ spokes``, complex, in m: the spokes are exp(iθ) of every link and, per line, its length
    times its direction. ``base`` (nl,) and ``arms`` (nl, nl + ns) give the origin of each link's frame, relative to
    that of the first link when the mechanism is ``floating``. ``gap_base`` (nc,) and ``gap_arms`` (nc, nl + ns) give
    the gaps, second point minus first point, of the joints ``gaps`` that close loops; ``held`` are angles that
    prismatic joints hold. ``apart`` are links that no chain of joints connects. ``ends`` (nc,) say how far (m) the
    points of each gap's joint are from the frames' origins at most, if that is known.
    """

    floating: bool
    base: Complex
    arms: Complex
    gaps: tuple[int, ...]
    gap_base: Complex
    gap_arms: Complex
    apart: tuple[int, ...]
    lines: tuple[Line, ...] = ()
    held: tuple[Held, ...] = ()
    unit: float = 1.0
    lengths: tuple[Length, ...] = ()
    ends: tuple[float, ...] = ()

    def closure(self, x: Real) -> Real:
        """Gaps in m, x and y of each, then what misses of the held angles (rad) and lengths (m)."""
        gaps = _split(self.gap_base + self.gap_arms @ self._spokes(x))
        angles = [_wrapped(self._angle(x, h.second) - self._angle(x, h.first) - h.angle) for h in self.held]
        lengths = [self.unit * x[one.index] - one.length for one in self.lengths]
        return np.concatenate([gaps, angles, lengths])

    def jacobian(self, x: Real) -> Real:
        """Derivative of the closure with respect to the displacements, shape (2 nc + nh + lengths, nl + ns)."""
        rows = _split(self.gap_arms @ self.turned(x))
        held = np.zeros((len(self.held), len(x)))
        for row, h in zip(held, self.held, strict=True):
            for link, sign in ((h.second, 1.0), (h.first, -1.0)):
                if link != GROUND:
                    row[link] += sign
        lengths = self.unit * np.eye(len(x))[[one.index for one in self.lengths]]
        return np.vstack([rows, held, lengths])

    def curvature(self, x: Real, multipliers: Real) -> Real:
        """Second derivatives of closure·multipliers by each displacement, shape (nl + ns,)."""
        count, spokes = len(self.base), self._spokes(x)
        found = np.zeros(len(x))
        parts = -_split(self.gap_arms * spokes).T @ multipliers[: 2 * len(self.gaps)]
        found[:count] = parts[:count]
        for k, line in enumerate(self.lines):
            if line.owner != GROUND:
                found[line.owner] += parts[count + k]
        return found

    def poses(self, x: Real, position: tuple[float, float]) -> Real:
        """x, y and angle of each link's frame, shape (nl, 3); ``position`` is that of the first frame if floating."""
        origin = self.base + self.arms @ self._spokes(x) + (complex(*position) if self.floating else 0.0)
        return np.column_stack([origin.real, origin.imag, x[: len(self.base)]])

    def velocities(self, x: Real, rates: Real, velocity: tuple[float, float]) -> Real:
        """Velocity of each frame's origin and its angular velocity, shape (nl, 3)."""
        moved = self.arms @ (self.turned(x) @ rates) + (complex(*velocity) if self.floating else 0.0)
        return np.column_stack([moved.real, moved.imag, rates[: len(self.base)]]) + 0.0 + 0.0

    def read_off(self, poses: Real) -> Real:
        """The displacements of links at ``poses`` (nl, 3), shape (nl + ns,)."""
        count = len(self.base)
        x = np.append(poses[:, 2], np.zeros(len(self.lines)))
        if len(x) == count:
            return x
        places = self.base + self.arms[:, :count] @ np.exp(1j * x[:count])
        offset = poses[:, 0] + 1j * poses[:, 1] - places
        offset = offset - offset[0] if self.floating else offset
        gaps = self.gap_base + self.gap_arms[:, :count] @ np.exp(1j * x[:count])
        left = _split(np.concatenate([offset, -gaps]))
        turned = _split(np.vstack([self.arms[:, count:], self.gap_arms[:, count:]]) * self._directions(x))
        x[count:] = np.linalg.lstsq(turned, left, rcond=1e-12)[0]
        return x

    @property
    def groups(self) -> tuple[tuple[int, str], ...]:
        """Joint and unit of each entry of the misses: gaps, then held angles and lengths."""
        angles, lengths = ((h.joint, "rad") for h in self.held), ((one.joint, "m") for one in self.lengths)
        return (*((joint, "m") for joint in self.gaps), *angles, *lengths)

    @property
    def reach(self) -> Real:
        """Length of all arms of each gap (m), then the size of a held angle (rad), shape (nc + nh,).

        Arms are differences of points: where those are near each other, what rounding leaves of them counts.
        """
        count = len(self.base)
        lengths: Real = np.abs(self.gap_arms[:, :count]).sum(axis=1) + np.abs(self.gap_base)
        lengths = lengths + self.unit * np.abs(self.gap_arms[:, count:]).sum(axis=1)
        if self.ends:
            lengths = np.maximum(lengths, _ROUNDED * np.array(self.ends, dtype=float))
        held: Real = np.full(len(self.held), 4.0 * np.pi)
        known = np.array([4.0 * max(self.unit, abs(one.length)) for one in self.lengths], dtype=float)
        return np.concatenate([lengths, held, known])

    def _angle(self, x: Real, link: int) -> float:
        return 0.0 if link == GROUND else float(x[link])

    def _directions(self, x: Real) -> Complex:
        """Direction of each line in the plane times the unit of length."""
        angles = [self._angle(x, line.owner) + line.axis for line in self.lines]
        return np.asarray(self.unit * np.exp(1j * np.array(angles, dtype=float)), dtype=complex)

    def _spokes(self, x: Real) -> Complex:
        count = len(self.base)
        return np.concatenate([np.exp(1j * x[:count]), x[count:] * self._directions(x)])

    def turned(self, x: Real) -> Complex:
        """Derivatives of the spokes by the displacements, shape (nl + ns, nl + ns)."""
        count, spokes = len(self.base), self._spokes(x)
        found = np.zeros((len(x), len(x)), dtype=complex)
        found[np.arange(count), np.arange(count)] = 1j * spokes[:count]
        directions = self._directions(x)
        for k, line in enumerate(self.lines):
            found[count + k, count + k] = directions[k]
            if line.owner != GROUND:
                found[count + k, line.owner] = 1j * spokes[count + k]
        return found


def lay_out(mechanism: Mechanism, tree: frozenset[int] | None = None, driven: Collection[int] = ()) -> Layout:
    """The mechanism's places, along a spanning tree grown from the ground, or from the first link if none is fixed.

    ``tree`` holds the joints that it may grow along, all unless given. Those that others imply, of
    which ``driven`` ones come first, add nothing.
    """
    return _Drawing(mechanism, tree, driven).layout()


class _Drawing:
    def __init__(self, mechanism: Mechanism, tree: frozenset[int] | None, driven: Collection[int]) -> None:
        self.mechanism, self.count = mechanism, len(mechanism.links)
        idle = {found.joint for found in implied(mechanism, driven)} | mechanism.open_gates
        self.joints = {index: joint for index, joint in enumerate(mechanism.joints) if index not in idle}
        self.usable = [index for index in self.joints if tree is None or index in tree]
        sliding = [(index, joint) for index, joint in self.joints.items() if joint.slides]
        self.lines = tuple(
            Line(index, joint.first.link, joint.axis.value if joint.axis else 0.0) for index, joint in sliding
        )
        self.spoke = {line.joint: self.count + k for k, line in enumerate(self.lines)}
        self.base: Complex = np.zeros(self.count, dtype=complex)
        self.arms: Complex = np.zeros((self.count, self.count + len(self.lines)), dtype=complex)

    def layout(self) -> Layout:
        floating = not any(joint.on_ground for joint in self.mechanism.joints)
        placed, tree = self._place_all({0} if floating else {GROUND})
        gaps = tuple(k for k, joint in self.joints.items() if k not in tree and joint.first.link in placed)
        found = [self._gap(index) for index in gaps]
        gap_base = np.array([gap[0] for gap in found], dtype=complex)
        gap_arms = np.array([gap[1] for gap in found], dtype=complex).reshape(len(gaps), self.arms.shape[1])
        apart = tuple(index for index in range(self.count) if index not in placed)
        held = tuple(
            Held(index, joint.first.link, joint.second.link, joint.angle.value if joint.angle else 0.0)
            for index, joint in self.joints.items()
            if not joint.turns
        )
        size = np.abs(self.arms[:, : self.count]).max(initial=0.0) or 1.0
        ends = tuple(max(abs(self._local(e)) for e in (self.joints[k].first, self.joints[k].second)) for k in gaps)
        return Layout(
            floating,
            self.base,
            self.arms,
            gaps,
            gap_base,
            gap_arms,
            apart,
            self.lines,
            held,
            float(size),
            ends=ends,
        )

    def _place_all(self, placed: set[int]) -> tuple[set[int], set[int]]:
        """Frames of all links that joints reach, breadth-first; the links, and the joints that were followed."""
        tree: set[int] = set()
        waiting = list(placed)
        around: dict[int, list[int]] = {}
        for index in self.usable:
            for end in (self.mechanism.joints[index].first, self.mechanism.joints[index].second):
                around.setdefault(end.link, []).append(index)
        while waiting:
            near = waiting.pop(0)
            for index in around.get(near, ()):
                joint = self.mechanism.joints[index]
                outwards = joint.first.link == near
                inner, outer = (joint.first, joint.second) if outwards else (joint.second, joint.first)
                if outer.link in placed:
                    continue
                self.base[outer.link], self.arms[outer.link] = self._point(inner)
                if joint.slides:
                    self.arms[outer.link, self.spoke[index]] += 1.0 if outwards else -1.0
                self.arms[outer.link, outer.link] -= self._local(outer)
                placed.add(outer.link)
                tree.add(index)
                waiting.append(outer.link)
        return placed, tree

    def _local(self, ref: PointRef) -> complex:
        return complex(*self.mechanism.point(ref).values())

    def _point(self, ref: PointRef) -> tuple[complex, Complex]:
        if ref.link == GROUND:
            return self._local(ref), np.zeros(self.arms.shape[1], dtype=complex)
        row = self.arms[ref.link].copy()
        row[ref.link] += self._local(ref)
        return complex(self.base[ref.link]), row

    def _gap(self, index: int) -> tuple[complex, Complex]:
        """Second point less first point, less the length along the line if the joint slides."""
        joint = self.mechanism.joints[index]
        (base, arms), (other, others) = self._point(joint.second), self._point(joint.first)
        row = arms - others
        if joint.slides:
            row[self.spoke[index]] -= 1.0
        return base - other, row


def _wrapped(angle: float) -> float:
    """The same angle (rad) between −π and π."""
    return float(np.remainder(angle + np.pi, 2.0 * np.pi) - np.pi)


def _split(values: Complex) -> Real:
    """Complex rows as alternating real and imaginary rows."""
    return np.stack([values.real, values.imag], axis=1).reshape(2 * values.shape[0], *values.shape[1:])
