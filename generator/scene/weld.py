"""Welded links as one body: their points, masses and inertias in the frame of the first of them."""

from __future__ import annotations

import cmath
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ..mechanism.joints import PointRef
from ..mechanism.links import GROUND
from ..mechanism.uniform_bodies import Mass, together
from .errors import Report

AGREE = 1e-9
"""Welds that close a ring may disagree by this much (m, and rad), not by more."""


@dataclass
class Body:
    """A link as written: mass (kg), inertia about the centre of mass (kg m²), places in its frame (m, complex)."""

    name: str
    mass: float
    inertia: float
    com: complex
    points: dict[str, complex]
    outline: tuple[str | complex, ...] | None = None
    """What is drawn of it, if that is not all its points."""


@dataclass(frozen=True)
class Weld:
    """Joint ``row`` of the scene: the points coincide, and the second frame has ``angle`` (rad) against the first."""

    row: int
    name: str
    first: PointRef
    second: PointRef
    angle: float


@dataclass
class Frame:
    """Where a link's frame is in its body: ``owner`` (a link or the ground), place (m), direction exp(iφ)."""

    owner: int
    place: complex = 0j
    turn: complex = 1.0 + 0j

    def put(self, z: complex) -> complex:
        """A point of the link in the body's frame."""
        return self.place + self.turn * z


@dataclass
class Welded:
    """Bodies after welding. ``bodies`` are those that are left, ``rows`` their tables, ``names`` what became of others.

    ``refs`` says where each point of the scene is now.
    """

    bodies: list[Body]
    ground: dict[str, complex]
    rows: tuple[int, ...]
    names: dict[str, int] = field(default_factory=dict)
    refs: dict[PointRef, PointRef] = field(default_factory=dict)


def merge(
    bodies: Sequence[Body], ground: Mapping[str, complex], welds: Sequence[Weld], report: Report
) -> Welded | None:
    """One body for each group of welded links, ``None`` after faults (welds that contradict each other)."""
    frames = [Frame(index) for index in range(len(bodies))]
    fine = True
    for weld in welds:
        fine = _join(weld, frames, bodies, ground, report) and fine
    left = [index for index, frame in enumerate(frames) if frame.owner == index]
    if not left:
        report.add(("joint",), "found all links welded to the ground, expected one that moves; remove a weld")
    if not fine or not left:
        return None
    number = {owner: new for new, owner in enumerate(left)} | {GROUND: GROUND}
    found = Welded([], dict(ground), tuple(left))
    for owner in left:
        found.bodies.append(_composed(owner, frames, bodies))
    for index, (body, frame) in enumerate(zip(bodies, frames, strict=True)):
        owner = number[frame.owner]
        welded = frame.owner != index
        if welded:
            found.names[body.name] = owner
        home = found.ground if owner == GROUND else found.bodies[owner].points
        for key, place in body.points.items():
            name = f"{body.name}_{key}" if welded else key
            if welded and name in home:
                message = f"found {body.name}.{key}, which becomes {name} of the body that it is welded to, expected "
                report.add(("link", index, "points", key), message + "a name that is free there; rename it")
                fine = False
            home[name] = frame.put(place)
            found.refs[PointRef(index, key)] = PointRef(owner, name)
    for new, owner in enumerate(left):
        found.bodies[new].outline = _outline(owner, frames, bodies)
    return found if fine else None


def _outline(owner: int, frames: Sequence[Frame], bodies: Sequence[Body]) -> tuple[str | complex, ...] | None:
    """What is drawn of a body: of each of its links what that says, or else its points."""
    parts = [(k, body, frames[k]) for k, body in enumerate(bodies) if frames[k].owner == owner]
    if all(body.outline is None for _, body, _ in parts):
        return None
    corners: list[str | complex] = []
    for k, body, frame in parts:
        for corner in body.points if body.outline is None else body.outline:
            before = f"{body.name}_" if k != owner else ""
            corners.append(before + corner if isinstance(corner, str) else frame.put(corner))
    return tuple(corners)


def _join(
    weld: Weld, frames: list[Frame], bodies: Sequence[Body], ground: Mapping[str, complex], report: Report
) -> bool:
    """Move the body of one side into the frame of the other's; whether the weld agrees with those before it."""
    sides = []
    for ref in (weld.first, weld.second):
        frame = Frame(GROUND) if ref.link == GROUND else frames[ref.link]
        point = ground[ref.point] if ref.link == GROUND else bodies[ref.link].points[ref.point]
        sides.append((frame, frame.put(point)))
    (one, here), (other, there) = sides
    turn = one.turn * cmath.exp(1j * weld.angle) / other.turn  # of the other body's frame in the one's
    shift = here - turn * there
    if one.owner == other.owner:
        miss, twist = abs(shift), abs(cmath.phase(turn))
        if miss <= AGREE and twist <= AGREE:
            return True
        message = f"found a weld that misses by {miss:.3g} m and {twist:.3g} rad, expected it to agree with the welds "
        report.add(("joint", weld.row), message + "that hold its links already; correct one of them or remove it")
        return False
    if other.owner == GROUND or (one.owner != GROUND and other.owner < one.owner):
        turn, shift = 1.0 / turn, -shift / turn
        one, other = other, one
    moved, to = other.owner, one.owner
    for frame in frames:
        if frame.owner == moved:
            frame.owner, frame.place, frame.turn = to, shift + turn * frame.place, turn * frame.turn
    return True


def _composed(owner: int, frames: Sequence[Frame], bodies: Sequence[Body]) -> Body:
    """Mass, mass centre and inertia of the body that ``owner`` stands for (parallel axes); points come later."""
    parts = [(body, frame) for body, frame in zip(bodies, frames, strict=True) if frame.owner == owner]
    if len(parts) == 1:
        return Body(bodies[owner].name, bodies[owner].mass, bodies[owner].inertia, bodies[owner].com, {})
    whole = together([Mass(body.mass, frame.put(body.com), body.inertia) for body, frame in parts])
    com = whole.com if whole.mass else bodies[owner].com
    return Body(bodies[owner].name, whole.mass, whole.inertia, com, {})
