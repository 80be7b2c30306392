"""Joints that hold nothing: what they ask for follows from other joints, whatever the mechanism's configuration.

A pin is implied where other pins join the same two points already: a joint that is given twice, the third of three
joints between three links on one pin. A pin in a slot is implied where pins hold the same point on the same line, or
another slot does, or joints that slide along that line; a prismatic joint where others hold its links on the same line
and at the same angle, as the second of two rails does. Their closure rows would be zero or equal to others, so no
multiplier is theirs: they are left out of the equations, and share the forces of those that imply them.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from itertools import combinations

from .joints import Joint, PointRef
from .links import GROUND, Parameter
from .mechanism import Mechanism

SAME = 1e-14
"""Points of a link nearer than this part of its size are one: that much is rounding, and loops are closed to it."""
NEAR = 1e-6
"""Points nearer than this, but not the same, leave joints a lever so short that they count as redundant, yet not the
same: a slip of the scene."""

Mark = tuple[int, int]
"""A place on a link: the link, and the number of the place there."""


@dataclass(frozen=True)
class Part:
    """A joint that a self-stress goes through: the force on its second link is ``sign`` times that on the first's."""

    joint: int
    sign: int


@dataclass(frozen=True)
class Implied:
    """Joint ``joint`` follows from the joints of ``way``, which leads from its second side back to its first.

    Opposite forces in it and in those balance. ``rests_on`` are parameters that must keep their values for that.
    """

    joint: int
    way: tuple[Part, ...]
    rests_on: tuple[Parameter, ...]


def implied(mechanism: Mechanism, driven: Collection[int] = (), tolerance: float = SAME) -> tuple[Implied, ...]:
    """The joints that others imply, one left of each class: ``driven`` ones, racks, prismatic ones, pins, slots.
    Those that let go or take hold imply none, and none implies them.

    Cost grows with the number of joints times the number on one pin.
    """
    finder = _Finder(mechanism, tolerance)
    driven = {*driven, *(joint for mesh in mechanism.meshes for joint in mesh.slides)}
    order = {"prismatic": 0, "revolute": 1, "pin-in-slot": 2}
    lasting = (k for k, joint in enumerate(mechanism.joints) if k not in mechanism.gates and joint.kind != "weld")
    joints = sorted(lasting, key=lambda k: (k not in driven, order[mechanism.joints[k].kind], k))
    return tuple(sorted(filter(None, map(finder.judge, joints)), key=lambda found: found.joint))


@dataclass(frozen=True)
class _Rail:
    """Link ``link`` as seen from another one that it slides along: turned by ``angle``, its origin at ``origin`` but
    for a motion along ``axis``; ``way`` are the joints between them."""

    link: int
    angle: float
    origin: complex
    way: tuple[Part, ...]
    axes: tuple[float, ...]


def almost_implied(mechanism: Mechanism) -> tuple[tuple[Implied, float], ...]:
    """Joints that others would imply if points were a little elsewhere, and how far those are apart (m) at most."""
    exact = {found.joint for found in implied(mechanism)}
    near = [found for found in implied(mechanism, tolerance=NEAR) if found.joint not in exact]
    return tuple((found, _apart(mechanism, found)) for found in near)


def _apart(mechanism: Mechanism, found: Implied) -> float:
    ends = [mechanism.joints[part.joint] for part in (Part(found.joint, 1), *found.way)]
    refs = [end for joint in ends for end in (joint.first, joint.second)]
    places = [(ref.link, complex(*mechanism.point(ref).values())) for ref in refs]
    near = [abs(a - b) for (one, a), (other, b) in combinations(places, 2) if one == other]
    return min((distance for distance in near if distance > 0.0), default=0.0)


class _Finder:
    """Joints judged one after the other; those that others before them do not imply are remembered."""

    def __init__(self, mechanism: Mechanism, tolerance: float) -> None:
        self.mechanism, self.tolerance = mechanism, tolerance
        self.sizes: dict[int, float] = {}
        owners = [(GROUND, mechanism.ground_points), *((k, link.points) for k, link in enumerate(mechanism.links))]
        for owner, points in owners:
            self.sizes[owner] = max((math.hypot(*point.values()) for point in points.values()), default=0.0)
        self.cells: dict[int, dict[tuple[int, int], list[Mark]]] = {}
        self.places: dict[Mark, complex] = {}
        self.pinned: dict[Mark, list[tuple[Mark, Part]]] = {}
        self.railed: dict[int, list[tuple[int, Part]]] = {}
        self.slots: dict[int, list[int]] = {}

    def judge(self, index: int) -> Implied | None:
        """What implies the joint, or ``None`` after remembering it."""
        joint = self.mechanism.joints[index]
        way = {"revolute": self._pin, "pin-in-slot": self._slot, "prismatic": self._prismatic}[joint.kind](index, joint)
        return Implied(index, way, self._rests_on(index, way)) if way else None

    def _pin(self, index: int, joint: Joint) -> tuple[Part, ...]:
        first, second = self._mark(joint.first), self._mark(joint.second)
        if way := self._reached(second).get(first):
            return way
        self.pinned.setdefault(first, []).append((second, Part(index, 1)))
        self.pinned.setdefault(second, []).append((first, Part(index, -1)))
        return ()

    def _slot(self, index: int, joint: Joint) -> tuple[Part, ...]:
        """Pins hold the sliding point on the line, or another slot on the same line does, or rails along it."""
        line = joint.first.link
        reached = self._reached(self._mark(joint.second))
        on_line = {rail.link: rail for rail in self._rails(line) if self._parallel(joint, rail.axes)}
        for (link, number), way in reached.items():
            if rail := on_line.get(link):
                there = rail.origin + self.places[link, number] * cmath.exp(1j * rail.angle)
                if self._lies(joint, there, self.sizes[link]):
                    return (*way, *(Part(part.joint, -part.sign) for part in reversed(rail.way)))
        for other in self.slots.get(line, ()):
            twin = self.mechanism.joints[other]
            way = reached.get(self._mark(twin.second), ())
            same = self._parallel(joint, (_axis(twin),)) and self._lies(joint, self._local(twin.first), 0.0)
            if same and self._mark(twin.second) in reached:
                return (*way, Part(other, -1))
        self.slots.setdefault(line, []).append(index)
        return ()

    def _prismatic(self, index: int, joint: Joint) -> tuple[Part, ...]:
        angle = joint.angle.value if joint.angle else 0.0
        for rail in self._rails(joint.first.link):
            if rail.link != joint.second.link:
                continue
            there = rail.origin + self._local(joint.second) * cmath.exp(1j * rail.angle)
            held = abs(cmath.exp(1j * (rail.angle - angle)) - 1.0) <= self.tolerance
            if held and self._parallel(joint, rail.axes) and self._lies(joint, there, self.sizes[rail.link]):
                return tuple(Part(part.joint, -part.sign) for part in reversed(rail.way))
            return ()
        self.railed.setdefault(joint.first.link, []).append((joint.second.link, Part(index, 1)))
        self.railed.setdefault(joint.second.link, []).append((joint.first.link, Part(index, -1)))
        return ()

    def _reached(self, start: Mark) -> dict[Mark, tuple[Part, ...]]:
        """Marks that pins hold where ``start`` is, each with the way there."""
        found: dict[Mark, tuple[Part, ...]] = {start: ()}
        waiting = [start]
        for here in waiting:
            for there, part in self.pinned.get(here, ()):
                if there not in found:
                    found[there] = (*found[here], part)
                    waiting.append(there)
        return found

    def _rails(self, start: int) -> list[_Rail]:
        """Links that prismatic joints hold at the angle of ``start``, and where; ``start`` is the first."""
        found = [_Rail(start, 0.0, 0j, (), ())]
        seen = {start}
        for here in found:
            for link, part in self.railed.get(here.link, ()):
                if link in seen:
                    continue
                seen.add(link)
                joint = self.mechanism.joints[part.joint]
                near, far = (joint.first, joint.second) if part.sign > 0 else (joint.second, joint.first)
                angle = here.angle + part.sign * (joint.angle.value if joint.angle else 0.0)
                place = here.origin + self._local(near) * cmath.exp(1j * here.angle)
                owner = here.angle if part.sign > 0 else angle
                origin = place - self._local(far) * cmath.exp(1j * angle)
                found.append(_Rail(link, angle, origin, (*here.way, part), (*here.axes, owner + _axis(joint))))
        return found

    def _parallel(self, joint: Joint, axes: Iterable[float]) -> bool:
        """Whether lines in directions ``axes``, in the frame of the joint's first link, are parallel to the joint's."""
        return all(abs(cmath.exp(2j * (axis - _axis(joint))) - 1.0) <= 4.0 * self.tolerance for axis in axes)

    def _lies(self, joint: Joint, there: complex, size: float) -> bool:
        """Whether a place in the frame of the joint's first link lies on the joint's line."""
        away = ((there - self._local(joint.first)) * cmath.exp(-1j * _axis(joint))).imag
        return abs(away) <= self.tolerance * max(size, self.sizes[joint.first.link])

    def _local(self, ref: PointRef) -> complex:
        return complex(*self.mechanism.point(ref).values())

    def _mark(self, ref: PointRef) -> Mark:
        """The place on the link where the point is: one for all points that are the same."""
        here, reach = self._local(ref), self.tolerance * self.sizes[ref.link]
        cells = self.cells.setdefault(ref.link, {})
        column, row = (int(x / reach) if reach else 0 for x in (here.real, here.imag))
        for x in (column - 1, column, column + 1):
            for y in (row - 1, row, row + 1):
                for mark in cells.get((x, y), ()):
                    if abs(self.places[mark] - here) <= reach:
                        return mark
        mark = ref.link, len(self.places)
        cells.setdefault((column, row), []).append(mark)
        self.places[mark] = here
        return mark

    def _rests_on(self, index: int, way: tuple[Part, ...]) -> tuple[Parameter, ...]:
        """Parameters of what meets on the links along the way, if it is not the same thing that meets."""
        ring = [Part(index, 1), *way]
        found: dict[Parameter, None] = {}
        for part, after in zip(ring, [*ring[1:], ring[0]], strict=True):
            one, other = self._end(part, 1), self._end(after, -1)
            if one[0] == other[0] and not (one[1] and other[1]):
                continue  # a pin, and what else is at its point
            free = set(one[2]) & set(other[2])
            if any(end[1] and self.mechanism.joints[p.joint].axis is None for end, p in ((one, part), (other, after))):
                along = (self.mechanism.point(end[0]).x for end in (one, other))  # the line is the frame's x axis
                free |= {p for p in along if p is not None}
            found |= dict.fromkeys(p for p in (*one[2], *other[2]) if p not in free)
        return tuple(found)

    def _end(self, part: Part, side: int) -> tuple[PointRef, bool, tuple[Parameter, ...]]:
        """Where the way leaves a joint (``side`` 1) or enters it (-1): the point, whether a line meets the link there,
        and their parameters."""
        joint = self.mechanism.joints[part.joint]
        at_second = part.sign * side > 0
        ref = joint.second if at_second else joint.first
        line = joint.kind == "prismatic" or (joint.slides and not at_second)
        points = self.mechanism.point(ref).parameters()
        turned = (joint.angle,) if joint.angle and at_second else ()
        axis = (joint.axis,) if joint.axis and line else ()
        return ref, line, (*points, *axis, *turned)


def _axis(joint: Joint) -> float:
    return joint.axis.value if joint.axis else 0.0
