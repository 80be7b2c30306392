"""Touch: a disc on one link that touches a disc, or an edge, of another: only pairs that a scene lists."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import Discriminator, Field, Tag

from ..effect_base.contact import DEPTH, LAW_MEANS, Friction, Law, Radius, Restitution
from ..effect_base.effect import Complain, ContactPoint, Effect, Entry, Place, Rim, Surroundings
from ..effect_base.line import NO_DIRECTION, links_at
from ..effect_base.points import choose_carrier, find_point
from ..effect_base.table import Name, PointName, Table, number_or_list, text_or_list
from ..mechanism.joints import PointRef
from ..mechanism.links import FROM_0_TO_1, GROUND, NOT_NEGATIVE, Parameter, Point
from ..mechanism.mechanism import Mechanism

if TYPE_CHECKING:
    from ..derive.gaps import Gap
    from ..derive.terms_of_effects import Let
    from ..derive.touching import Edge

Ends = Annotated[list[PointName], Field(min_length=2, max_length=2)]


Side = Annotated[Annotated[PointName, Tag("<text>")] | Annotated[Ends, Tag("<list>")], Discriminator(text_or_list)]


class TouchTable(Table):
    """One ``[[touch]]``."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    between: list[Side] = Field(
        min_length=2,
        max_length=2,
        description='a disc\'s centre, and another one or an edge: ["ball.C", "other.C"], ["ball.C", "plank"] or '
        '["ball.C", ["plank.A", "plank.B"]]',
    )
    radius: Annotated[
        Annotated[Radius, Tag("<number>")]
        | Annotated[Annotated[list[Radius], Field(min_length=2, max_length=2)], Tag("<list>")],
        Discriminator(number_or_list),
    ] = Field(
        description="the radius of the discs in m, not negative, or a list of two: of an edge, half of its thickness"
    )
    restitution: Restitution = Field(description="the coefficient of restitution, a number from 0 to 1")
    friction: Friction | None = Field(default=None, description="Coulomb's coefficient of friction, a positive number")
    law: Law | None = Field(default=None, description=LAW_MEANS)


@dataclass(frozen=True)
class Body:
    """One side of a touch: a disc about ``start``, or an edge from there to ``end``; ``title`` is what the scene says.

    ``radius`` is the disc's, or half of what the edge is thick (m); ``None`` is zero.
    """

    title: str
    start: PointRef
    end: PointRef | None
    radius: Parameter | None

    @property
    def size(self) -> float:
        return self.radius.value if self.radius else 0.0


@dataclass(frozen=True)
class Touch(Effect):
    """Keeps ``disc`` out of ``other``, with ``restitution`` (0 to 1) and ``friction``.

    ``ends`` are those of an edge in its link's frame, ``None`` where ``other`` is a disc.
    """

    index: int
    name: str
    disc: Body
    other: Body
    ends: tuple[Point, Point] | None
    restitution: Parameter
    friction: Parameter | None = None

    def __post_init__(self) -> None:
        if not self.disc.size + self.other.size > 0.0:
            raise ValueError(f"{self.name} has radii without a positive sum")
        if self.disc.end or self.disc.start.link == self.other.start.link:
            raise ValueError(f"{self.name} is not between a disc and another link")

    def parameters(self) -> tuple[Parameter, ...]:
        radii = dict.fromkeys(body.radius for body in (self.disc, self.other) if body.radius)
        return (*radii, self.restitution, *((self.friction,) if self.friction else ()))

    def describe(self, mechanism: Mechanism) -> str:
        return f"{self.disc.title} against {self.other.title}, {super().describe(mechanism)}"

    def gaps(self, let: Let) -> tuple[Gap, ...]:
        """One gap, called after the disc's centre and the touch."""
        from ..derive.touching import TouchGap
        from ..derive.vectors import symbol

        disc, other = self.disc, self.other
        return (
            TouchGap(
                disc.title,
                self.name,
                f"touch_{self.index}",
                disc.start,
                other.start,
                self._edge(let),
                symbol(disc.radius),
                symbol(other.radius),
                symbol(self.restitution),
                symbol(self.friction),
            ),
        )

    def _edge(self, let: Let) -> Edge | None:
        """The edge and its length, which depends on parameters alone."""
        from sympy import sqrt

        from ..derive.touching import Edge
        from ..derive.vectors import dot, less, local

        if self.ends is None or self.other.end is None:
            return None
        along = less(local(self.ends[1]), local(self.ends[0]))
        return Edge(self.other.end, let(f"span_touch_{self.index}", sqrt(dot(along, along))))

    def rims(self) -> tuple[Rim, ...]:
        bodies = (self.disc, self.other)
        return tuple((body.start, body.end, body.radius) for body in bodies if body.end or body.radius)

    def contact_points(self) -> tuple[ContactPoint, ...]:
        discs = (self.disc, self.other) if self.other.end is None else (self.disc,)
        return tuple((body.title, self.name, body.start, body.radius) for body in discs)

    def check_start(self, place: Place) -> tuple[str, ...]:
        centre, start = place(self.disc.start), place(self.other.start)
        away = _distance(centre, start, place(self.other.end) if self.other.end else start)
        depth = self.disc.size + self.other.size - away
        if depth <= DEPTH:
            return ()
        return (
            f"the start has {self.disc.title} inside {self.other.title} by {depth:.6g} m, expected at or off its "
            "surface; change the start or the radii",
        )


def _distance(centre: Sequence[float], start: Sequence[float], end: Sequence[float]) -> float:
    """From a point to the nearest point of a segment (m)."""
    c, edge = complex(*centre) - complex(*start), complex(*end) - complex(*start)
    along = (c * edge.conjugate()).real / abs(edge) ** 2 if edge else 0.0
    return abs(c - min(max(along, 0.0), 1.0) * edge)


def build(table: TouchTable, index: int, around: Surroundings, complain: Complain) -> Touch | None:
    """The record of a table, or ``None`` after having complained."""
    name = table.name or f"touch_{index}"
    mechanism, (first, second) = around.mechanism, table.between
    disc = _disc(first, mechanism, complain)
    other = _other(second, mechanism, complain)
    apart = disc is not None and other is not None and _apart(first, disc, second, other, mechanism, complain)
    radii = _radii(table, name, index, other is not None and other[1] is not None, complain)
    if disc is None or other is None or not apart or radii is None:
        return None
    if not _check_carriers(table, radii, mechanism, complain):
        return None
    return Touch(
        index=index,
        name=name,
        disc=Body(_title(first), disc, None, radii[0]),
        other=Body(_title(second), *other, radii[1]),
        ends=(mechanism.point(other[0]), mechanism.point(other[1])) if other[1] else None,
        restitution=Parameter(f"{name}.restitution", f"et_{index}", table.restitution, FROM_0_TO_1),
        friction=None
        if table.friction is None
        else Parameter(f"{name}.friction", f"ft_{index}", table.friction, NOT_NEGATIVE),
    )


def _check_carriers(
    table: TouchTable, radii: tuple[Parameter | None, Parameter | None], mechanism: Mechanism, complain: Complain
) -> bool:
    """Every disc turns with a link that the scene names."""
    fine = True
    for index, (side, radius) in enumerate(zip(table.between, radii, strict=True)):
        if radius and isinstance(side, str) and (wrong := choose_carrier(side, mechanism)):
            complain(("between", index), wrong)
            fine = False
    return fine


def _title(side: str | list[str]) -> str:
    return side if isinstance(side, str) else "-".join(side)


def _disc(side: str | list[str], mechanism: Mechanism, complain: Complain) -> PointRef | None:
    """The centre of the disc that stands first."""
    ref, wrong = find_point(side, mechanism) if isinstance(side, str) else (None, "put the edge in the second place")
    if ref is None:
        complain(("between", 0), f"found {_shown(side)}, expected a joint or link.point, the disc's centre; {wrong}")
    return ref


def _other(side: str | list[str], mechanism: Mechanism, complain: Complain) -> tuple[PointRef, PointRef | None] | None:
    """The centre of a disc and ``None``, or the ends of an edge: of a link that is named, or two points."""
    names = side
    if isinstance(side, str):
        ref, wrong = find_point(side, mechanism)
        if ref is not None:
            return ref, None
        names = _points_of(side, mechanism)
        if len(names) != 2:
            wrong = f"it has the points {', '.join(names)}; name two of them" if names else wrong
            expected = "a joint or link.point, a link with two points, or a list of two points of a link"
            complain(("between", 1), f'found "{side}", expected {expected}; {wrong}')
            return None
    found = [find_point(name, mechanism) for name in names]
    wrong = next((f"{name}: {fault}" for name, (ref, fault) in zip(names, found, strict=True) if ref is None), "")
    ends = [ref for ref, _ in found if ref is not None]
    if not wrong and ends[0].link != ends[1].link:
        wrong = "they are on different links"
    elif not wrong and _length(mechanism, ends) <= NO_DIRECTION:
        wrong = "they are at the same place; an edge has a direction"
    if wrong:
        complain(("between", 1), f"found {_shown(side)}, expected two points of one link, the ends of an edge; {wrong}")
        return None
    return ends[0], ends[1]


def _shown(side: str | list[str]) -> str:
    return f'"{side}"' if isinstance(side, str) else str([*side]).replace("'", '"')


def _points_of(link: str, mechanism: Mechanism) -> list[str]:
    """All points of a link as a scene names them; none where there is no such link.

    Points of welded links are among those of the body that they have become, with the link's name before their own.
    """
    links = {one.name: index for index, one in enumerate(mechanism.links)}
    names = {"ground": GROUND, **links, **mechanism.welded}
    if link not in names:
        return []
    owner = names[link]
    points = mechanism.ground_points if owner == GROUND else mechanism.links[owner].points
    prefixes = sorted((f"{name}_" for name, body in mechanism.welded.items() if body == owner), key=len, reverse=True)
    own = f"{link}_" if link in mechanism.welded else ""
    return [
        f"{link}.{name.removeprefix(own)}"
        for name in points
        if own == next((prefix for prefix in prefixes if name.startswith(prefix)), "")
    ]


def _length(mechanism: Mechanism, ends: Sequence[PointRef]) -> float:
    (x, y), (x2, y2) = (mechanism.point(ref).values() for ref in ends)
    return math.hypot(x2 - x, y2 - y)


def _apart(
    first: str | list[str],
    disc: PointRef,
    second: str | list[str],
    other: tuple[PointRef, PointRef | None],
    mechanism: Mechanism,
    complain: Complain,
) -> bool:
    """Whether the two sides are on two links: a pin is on both of its own."""
    of_other = links_at(second, other[0], mechanism) if isinstance(second, str) else {other[0].link}
    shared = links_at(_title(first), disc, mechanism) & of_other
    if shared:
        names = " and ".join(sorted(map(mechanism.link_name, shared)))
        complain(("between",), f"found two places on {names}, expected places on two links; change one")
    return not shared


def _radii(
    table: TouchTable, name: str, index: int, edge: bool, complain: Complain
) -> tuple[Parameter | None, Parameter | None] | None:
    """Radii of both sides: one parameter for two discs if the scene gives one number, which an edge does not share."""
    given = table.radius
    one, other = given if isinstance(given, list) else (given, 0.0 if edge else given)
    if not one + other > 0.0:
        complain(
            ("radius",),
            f"found radii with the sum {one + other:.6g}, expected a positive one, because points have no common "
            "normal; give one of them a radius",
        )
        return None
    if not isinstance(given, list):
        both = Parameter(f"{name}.radius", f"rt_{index}", one, NOT_NEGATIVE)
        return both, None if edge else both
    paths = [f"{name}.radius.{_title(side)}" for side in table.between]
    return (
        Parameter(paths[0], f"rt_{index}_0", one, NOT_NEGATIVE) if one else None,
        Parameter(paths[1], f"rt_{index}_1", other, NOT_NEGATIVE) if other else None,
    )


ENTRY = Entry("touch", True, TouchTable, build, {})
