"""Ground: a half-plane that points of the mechanism, or discs about them, cannot enter."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Annotated

from pydantic import Discriminator, Field, Tag

from ..effect_base.contact import DEPTH, LAW_MEANS, Friction, Law, Radius, Restitution
from ..effect_base.direction import unit
from ..effect_base.effect import Complain, Contact, ContactPoint, Effect, Entry, Level, Plane, Rim, Surroundings
from ..effect_base.points import choose_carrier, find_point
from ..effect_base.table import Direction, Name, PointName, Position, Table, number_or_list
from ..mechanism.joints import PointRef
from ..mechanism.links import FROM_0_TO_1, GROUND, NOT_NEGATIVE, Parameter, Point
from ..mechanism.mechanism import Mechanism

if TYPE_CHECKING:
    from ..derive.gaps import Gap
    from ..derive.terms_of_effects import Let
    from ..mechanism.assembled import Assembled


class HalfPlaneTable(Table):
    """A half-plane, and what touches it."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    point: Position = Field(default=[0.0, 0.0], description="a point of the surface, [x, y] in m")
    normal: Direction = Field(default=[0.0, 1.0], description="the direction out of the ground, [x, y], not both zero")
    friction: Friction | None = Field(default=None, description="Coulomb's coefficient of friction, zero or positive")
    contacts: list[PointName] | None = Field(
        default=None, min_length=1, description='a list of points that touch it, such as ["joint_3", "link_0.A"]'
    )
    radius: (
        Annotated[
            Annotated[Radius, Tag("<number>")] | Annotated[list[Radius], Tag("<list>")], Discriminator(number_or_list)
        ]
        | None
    ) = Field(
        default=None,
        description="the radius in m of discs about the contacts, not negative, or a list with one per contact",
    )


class GroundTable(HalfPlaneTable):
    """One ``[[ground]]``."""

    restitution: Restitution = Field(description="the coefficient of restitution, a number from 0 to 1")
    law: Law | None = Field(default=None, description=LAW_MEANS)


@dataclass(frozen=True)
class HalfPlane:
    """The half-plane ``normal·(x - point) < 0``, ``point`` in m and ``normal`` of length 1, and what touches it:
    points, or the centres of discs, ``radii`` having one radius (m) or ``None``, a point, for each."""

    normal: Point
    point: Point
    contacts: tuple[Contact, ...]
    radii: tuple[Parameter | None, ...]

    def rounded(self) -> list[tuple[Contact, Parameter | None]]:
        """Contacts and their radii."""
        return list(zip(self.contacts, self.radii or (None,) * len(self.contacts), strict=True))


@dataclass(frozen=True)
class Ground(Effect):
    """The half-plane ``normal·(x - point) < 0`` is inside; ``contacts`` are the points that it keeps out,
    or the centres of discs: ``radii`` has one radius (m) or ``None``, a point, for each.

    ``normal`` has length 1, ``point`` is in m, ``restitution`` is between 0 and 1. Without ``friction`` the ground is
    smooth.
    """

    index: int
    name: str
    normal: Point
    point: Point
    restitution: Parameter
    contacts: tuple[Contact, ...]
    friction: Parameter | None = None
    radii: tuple[Parameter | None, ...] = ()

    def __post_init__(self) -> None:
        if abs(math.hypot(*self.normal.values()) - 1.0) > 1e-12:
            raise ValueError(f"{self.name}.normal is {self.normal.values()}; it must have length 1")
        if not 0.0 <= self.restitution.value <= 1.0:
            raise ValueError(f"{self.restitution.path} is {self.restitution.value}; it must be from 0 to 1")
        if self.friction and not self.friction.value >= 0.0:
            raise ValueError(f"{self.friction.path} is {self.friction.value}; it must not be negative")
        if self.radii and len(self.radii) != len(self.contacts):
            raise ValueError(f"{self.name} has {len(self.radii)} radii for {len(self.contacts)} contacts")
        for radius in self.radii:
            if radius and not radius.value > 0.0:
                raise ValueError(f"{radius.path} is {radius.value}; it must be positive")

    def parameters(self) -> tuple[Parameter, ...]:
        return (
            *self.normal.parameters(),
            *self.point.parameters(),
            self.restitution,
            *((self.friction,) if self.friction else ()),
            *dict.fromkeys(radius for radius in self.radii if radius),
        )

    def planes(self) -> tuple[Plane, ...]:
        return ((self.name, self.point, self.normal),)

    def gaps(self, let: Let) -> tuple[Gap, ...]:
        """The unit normal and the offset of the plane, named once, and one gap per contact point."""
        from ..derive.gaps import PlaneGap
        from ..derive.vectors import dot, local, symbol

        given, at = local(self.normal), local(self.point)
        length = let(f"length_n_{self.index}", dot(given, given) ** Fraction(1, 2))
        normal = (let(f"nu_{self.index}_x", given[0] / length), let(f"nu_{self.index}_y", given[1] / length))
        offset = let(f"offset_{self.index}", dot(normal, at))
        e, mu = symbol(self.restitution), symbol(self.friction)
        return tuple(
            PlaneGap(name, ref, self.name, normal, offset, e, mu, symbol(radius))
            for (name, ref), radius in self._rounded()
        )

    def rims(self) -> tuple[Rim, ...]:
        return tuple((ref, None, radius) for (_, ref), radius in self._rounded() if radius)

    def _rounded(self) -> list[tuple[Contact, Parameter | None]]:
        """Contacts and their radii."""
        return list(zip(self.contacts, self.radii or (None,) * len(self.contacts), strict=True))

    def contact_points(self) -> tuple[ContactPoint, ...]:
        return tuple((name, self.name, ref, radius) for (name, ref), radius in self._rounded())

    def level(self) -> Level:
        return Level(self.point.values(), self.normal.values())

    def check_start(self, start: Assembled) -> tuple[str, ...]:
        level = self.level()
        depths = [
            (name, (radius.value if radius else 0.0) - level.height(*start.place(ref)))
            for (name, ref), radius in self._rounded()
        ]
        return tuple(
            f"the start has {name} inside {self.name} by {depth:.6g} m, expected at or above its surface; "
            "raise or move the start, or move the ground"
            for name, depth in depths
            if depth > DEPTH
        )


def read_half_plane(
    table: HalfPlaneTable, name: str, label: str, around: Surroundings, complain: Complain
) -> HalfPlane | None:
    """The half-plane of a table, its parameters under ``name``, symbols with ``label``; ``None`` after complaints."""
    normal = unit(table.normal)
    if normal is None:
        complain(("normal",), f"found {table.normal}, expected a direction, not both zero; write [0, 1] for a floor")
    contacts = _contacts(table, around, complain)
    radii = _radii(table, name, label, contacts, complain) if contacts is not None else None
    fixed = _check_carriers(table, contacts or (), radii or (), around.mechanism, complain)
    if contacts is None or radii is None or not fixed or normal is None:
        return None
    return HalfPlane(
        _point(f"{name}.normal", f"n_{label}", *normal),
        _point(f"{name}.point", f"o_{label}", *table.point),
        contacts,
        radii,
    )


def build(table: GroundTable, index: int, surroundings: Surroundings, complain: Complain) -> Ground | None:
    """The record of a table, or ``None`` after having complained."""
    name = table.name or f"ground_{index}"
    plane = read_half_plane(table, name, str(index), surroundings, complain)
    if plane is None:
        return None
    return Ground(
        index=index,
        name=name,
        normal=plane.normal,
        point=plane.point,
        restitution=Parameter(f"{name}.restitution", f"e_{index}", table.restitution, FROM_0_TO_1),
        contacts=plane.contacts,
        friction=None
        if table.friction is None
        else Parameter(f"{name}.friction", f"fr_{index}", table.friction, NOT_NEGATIVE),
        radii=plane.radii,
    )


def _point(path: str, symbol: str, x: float, y: float) -> Point:
    return Point(
        Parameter(f"{path}.x", f"{symbol}_x", x) if x else None, Parameter(f"{path}.y", f"{symbol}_y", y) if y else None
    )


def _contacts(table: HalfPlaneTable, around: Surroundings, complain: Complain) -> tuple[Contact, ...] | None:
    """The points that touch: those listed, or the usual ones. ``None`` after a complaint."""
    if table.contacts is None:
        if not around.contacts:
            complain((), 'found no joint that could touch the ground; list the points, as contacts = ["body.tip"]')
        return around.contacts or None
    found = []
    for index, name in enumerate(table.contacts):
        ref, wrong = _moving_point(name, around.mechanism)
        if name in table.contacts[:index]:
            wrong = "it is listed twice; remove one of them"
        if ref is None or wrong:
            complain(("contacts", index), f'found "{name}", expected a joint or link.point that moves; {wrong}')
        else:
            found.append((name, ref))
    return tuple(found) if len(found) == len(table.contacts) else None


def _radii(
    table: HalfPlaneTable, name: str, label: str, contacts: tuple[Contact, ...], complain: Complain
) -> tuple[Parameter | None, ...] | None:
    """One radius per contact, one parameter for all if the scene gives one number. ``None`` after a complaint."""
    if not isinstance(table.radius, list):
        shared = Parameter(f"{name}.radius", f"rd_{label}", table.radius, NOT_NEGATIVE) if table.radius else None
        return (shared,) * len(contacts) if shared else ()
    if len(table.radius) != len(contacts):
        complain(
            ("radius",),
            f"found {len(table.radius)} values, expected {len(contacts)}, one per contact; correct the list or "
            "write one number for all",
        )
        return None
    return tuple(
        Parameter(f"{name}.radius.{point}", f"rd_{label}_{k}", value, NOT_NEGATIVE) if value else None
        for k, ((point, _), value) in enumerate(zip(contacts, table.radius, strict=True))
    )


def _check_carriers(
    table: HalfPlaneTable,
    contacts: tuple[Contact, ...],
    radii: tuple[Parameter | None, ...],
    mechanism: Mechanism,
    complain: Complain,
) -> bool:
    """Every disc turns with a link that the scene names: a pin of two links that move could mean either."""
    fine = True
    for index, ((name, _), radius) in enumerate(zip(contacts, radii, strict=False)):
        if radius and (wrong := choose_carrier(name, mechanism)):
            listed = table.contacts is not None
            complain(("contacts", index) if listed else ("radius",), wrong + ("" if listed else " in contacts = [...]"))
            fine = False
    return fine


def _moving_point(name: str, mechanism: Mechanism) -> tuple[PointRef | None, str]:
    """The point called ``name`` if it can touch something, or what is wrong with the name."""
    if name.startswith("ground."):
        return None, "points of the ground do not move; leave it out"
    for joint in mechanism.joints:
        if joint.name != name or not joint.on_ground:
            continue
        if not joint.slides:
            return None, f"{name} is fixed on the ground; leave it out"
        if joint.second.link == GROUND:
            first = f"{mechanism.link_name(joint.first.link)}.{joint.first.point}"
            return None, f"{name} is the ground's point {joint.second.point}; name a point of the link, as {first}"
    return find_point(name, mechanism)


ENTRY = Entry("ground", True, GroundTable, build, {})
