"""What gears, racks and belts share: their record, and the carrier on which the axes of two wheels sit."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from ..mechanism.assembled import Assembled
from ..mechanism.joints import Joint, PointRef
from ..mechanism.links import ANY, GROUND, POSITIVE, Parameter
from ..mechanism.mechanism import Mechanism
from ..mechanism.meshes import Mesh, MeshTerm
from .effect import Effect, Part, Rim

APART = 1e-9
"""Points of a link nearer to each other than this share of their distance from its origin are in one place."""


@dataclass(frozen=True)
class Meshing(Effect):
    """Wheels that mesh, or are joined by a belt: the closure row ``row``. ``what`` says so in a description.

    ``circles`` are pitch circles to be drawn, and ``teeth`` what is drawn on them; it changes nothing else.
    """

    name: str
    row: Mesh
    what: str
    circles: tuple[Rim, ...] = ()
    teeth: tuple[Part, ...] = field(default=(), compare=False)

    def parameters(self) -> tuple[Parameter, ...]:
        radii = [term.radius for term in self.row.terms if term.radius]
        return (*radii, *(term.start for term in self.row.terms))

    def describe(self, mechanism: Mechanism) -> str:
        """``sun - planet on arm, gear_0.radius_1 = 0.03, gear_0.radius_2 = 0.02``."""
        radii = [f"{term.radius.path} = {term.radius.value!r}" for term in self.row.terms if term.radius]
        return ", ".join((self.what, *radii))

    def mesh(self) -> Mesh:
        return self.row

    def settled(self, start: Assembled) -> Meshing:
        """With the angles and lengths from which its row counts those of the start."""
        terms = tuple(
            dataclasses.replace(term, start=dataclasses.replace(term.start, value=_position(term, start)))
            for term in self.row.terms
        )
        return dataclasses.replace(self, row=dataclasses.replace(self.row, terms=terms))

    def rims(self) -> tuple[Rim, ...]:
        return self.circles

    def parts(self, mechanism: Mechanism) -> tuple[Part, ...]:
        return self.teeth


def _position(term: MeshTerm, start: Assembled) -> float:
    """The angle (rad) or length (m) that a term has."""
    if term.slide is not None:
        return start.length(term.slide)
    return start.angle(term.second) - start.angle(term.first)


@dataclass(frozen=True)
class Wheel:
    """Link ``link`` turns against ``carrier`` about the carrier's point ``axis``, its own point ``centre``."""

    joint: int
    link: int
    carrier: int
    axis: PointRef
    centre: PointRef


def term(name: str, number: int, sign: int, wheel: Wheel, radius: float, key: str) -> MeshTerm:
    """A wheel's part in a mesh: ``name.radius_1`` (m), and its angle at the start, ``name.start_1`` (rad)."""
    found = Parameter(f"{name}.radius_{number}", f"rp_{key}_{number}", radius, POSITIVE, "m")
    start = Parameter(f"{name}.start_{number}", f"xp_{key}_{number}", 0.0, ANY, "rad")
    return MeshTerm(sign, found, start, wheel.carrier, wheel.link)


def find_wheels(
    joints: Sequence[int], mechanism: Mechanism, carrier: int | None = None
) -> tuple[tuple[Wheel, ...], str]:
    """The wheels that turn by ``joints``, pins, on their one carrier, or what is wrong.

    The carrier is a link of each joint; or of a pin on the joint's own axis, as the arm of a planetary train is, that
    turns about the axis of its sun. It is ``carrier``, if that is given.
    """
    names = ", ".join(mechanism.joints[joint].name for joint in joints)
    links = range(GROUND, len(mechanism.links))
    found = [(k, [_wheel(joint, k, mechanism) for joint in joints]) for k in links if carrier in (None, k)]
    sound = [(k, tuple(w for w in wheels if w)) for k, wheels in found if all(wheels)]
    sound = [(k, wheels) for k, wheels in sound if len({wheel.link for wheel in wheels}) == len(wheels)]
    direct = [(k, wheels) for k, wheels in sound if all(k in _links(mechanism.joints[w.joint]) for w in wheels)]
    sound = direct or sound
    if len(sound) == 1:
        return sound[0][1], ""
    if not sound and carrier is not None:
        return (), f"{mechanism.link_name(carrier)} does not carry the axes of {names}"
    if not sound:
        return (), f"{names} have no link in common that carries both axes"
    several = " or ".join(mechanism.link_name(k) for k, _ in sound)
    return (), f"{several} carries the axes of {names}; say which by carrier"


def _wheel(index: int, carrier: int, mechanism: Mechanism) -> Wheel | None:
    """The wheel of a joint as the carrier sees it, if the joint's axis is fixed in it."""
    joint = mechanism.joints[index]
    for near, far in ((joint.first, joint.second), (joint.second, joint.first)):
        if near.link == carrier:
            return Wheel(index, far.link, carrier, near, far)
    for other in mechanism.joints:
        if other.slides or carrier not in _links(other):
            continue
        axis, shared = (other.first, other.second) if other.first.link == carrier else (other.second, other.first)
        for end in (joint.first, joint.second):
            if end.link == shared.link and distance(end, shared, mechanism) == 0.0:
                wheel = joint.first if joint.second.link == GROUND else joint.second
                return Wheel(index, wheel.link, carrier, axis, wheel)
    return None


def _links(joint: Joint) -> tuple[int, int]:
    return joint.first.link, joint.second.link


def distance(one: PointRef, other: PointRef, mechanism: Mechanism) -> float:
    """How far (m) two points of a link are apart; 0 where that is rounding."""
    (a, b), (c, d) = mechanism.point(one).values(), mechanism.point(other).values()
    found = math.hypot(c - a, d - b)
    return found if found > APART * max(math.hypot(a, b), math.hypot(c, d)) else 0.0


def size(mechanism: Mechanism) -> float:
    """The distance (m) of the farthest point from its link's origin; 1 where all are there."""
    points = [point for link in mechanism.links for point in link.points.values()]
    points += mechanism.ground_points.values()
    return max((math.hypot(*point.values()) for point in points), default=0.0) or 1.0
