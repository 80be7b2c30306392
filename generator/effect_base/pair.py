"""Pairs of links of which one has a disc, and the other a disc or a straight edge: how scenes name them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import Discriminator, Field, Tag

from ..mechanism.joints import PointRef
from ..mechanism.links import GROUND, NOT_NEGATIVE, Parameter, Point
from ..mechanism.mechanism import Mechanism
from .contact import Radius
from .effect import Complain, Place, Rim
from .line import NO_DIRECTION, links_at
from .points import choose_carrier, find_point
from .table import Name, PointName, Table, number_or_list, text_or_list

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.terms_of_effects import Let
    from ..derive.touching import Edge, TouchGap

Ends = Annotated[list[PointName], Field(min_length=2, max_length=2)]


Side = Annotated[Annotated[PointName, Tag("<text>")] | Annotated[Ends, Tag("<list>")], Discriminator(text_or_list)]


class PairTable(Table):
    """A pair of bodies that touch."""

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
class Pair:
    """A ``disc`` and an ``other`` disc, or an edge with its ``ends`` in its link's frame."""

    disc: Body
    other: Body
    ends: tuple[Point, Point] | None

    def __post_init__(self) -> None:
        if not self.disc.size + self.other.size > 0.0:
            raise ValueError(f"{self.disc.title} and {self.other.title} have radii without a positive sum")
        if self.disc.end or self.disc.start.link == self.other.start.link:
            raise ValueError(f"{self.disc.title} and {self.other.title} are not a disc and another link")

    def parameters(self) -> tuple[Parameter, ...]:
        """The radii, each once."""
        return tuple(dict.fromkeys(body.radius for body in (self.disc, self.other) if body.radius))

    @property
    def title(self) -> str:
        return f"{self.disc.title} against {self.other.title}"

    def edge(self, let: Let, label: str) -> Edge | None:
        """The edge and its length, which depends on parameters alone."""
        from sympy import sqrt

        from ..derive.touching import Edge
        from ..derive.vectors import dot, less, local

        if self.ends is None or self.other.end is None:
            return None
        along = less(local(self.ends[1]), local(self.ends[0]))
        return Edge(self.other.end, let(f"span_{label}", sqrt(dot(along, along))))

    def gap(self, let: Let, name: str, label: str, restitution: Expr, friction: Expr) -> TouchGap:
        """The distance of both, called after the disc's centre and ``name``; symbols have the ``label``."""
        from ..derive.touching import TouchGap
        from ..derive.vectors import symbol

        return TouchGap(
            self.disc.title,
            name,
            label,
            self.disc.start,
            self.other.start,
            self.edge(let, label),
            symbol(self.disc.radius),
            symbol(self.other.radius),
            restitution,
            friction,
        )

    def rims(self) -> tuple[Rim, ...]:
        """Discs and edges to be drawn."""
        bodies = (self.disc, self.other)
        return tuple((body.start, body.end, body.radius) for body in bodies if body.end or body.radius)

    def depth(self, place: Place) -> float:
        """How far each is inside the other (m)."""
        centre, start = place(self.disc.start), place(self.other.start)
        away = _distance(centre, start, place(self.other.end) if self.other.end else start)
        return self.disc.size + self.other.size - away


def _distance(centre: Sequence[float], start: Sequence[float], end: Sequence[float]) -> float:
    """From a point to the nearest point of a segment (m)."""
    c, edge = complex(*centre) - complex(*start), complex(*end) - complex(*start)
    along = (c * edge.conjugate()).real / abs(edge) ** 2 if edge else 0.0
    return abs(c - min(max(along, 0.0), 1.0) * edge)


def read_pair(table: PairTable, name: str, symbol: str, mechanism: Mechanism, complain: Complain) -> Pair | None:
    """The pair of a table, its radii under ``name`` with the ``symbol``; ``None`` after having complained."""
    first, second = table.between
    disc = _disc(first, mechanism, complain)
    other = _other(second, mechanism, complain)
    apart = disc is not None and other is not None and _apart(first, disc, second, other, mechanism, complain)
    radii = _radii(table, name, symbol, other is not None and other[1] is not None, complain)
    if disc is None or other is None or not apart or radii is None:
        return None
    if not _check_carriers(table, radii, mechanism, complain):
        return None
    ends = (mechanism.point(other[0]), mechanism.point(other[1])) if other[1] else None
    return Pair(Body(_title(first), disc, None, radii[0]), Body(_title(second), *other, radii[1]), ends)


def _check_carriers(
    table: PairTable, radii: tuple[Parameter | None, Parameter | None], mechanism: Mechanism, complain: Complain
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
    table: PairTable, name: str, symbol: str, edge: bool, complain: Complain
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
        both = Parameter(f"{name}.radius", symbol, one, NOT_NEGATIVE)
        return both, None if edge else both
    paths = [f"{name}.radius.{_title(side)}" for side in table.between]
    return (
        Parameter(paths[0], f"{symbol}_0", one, NOT_NEGATIVE) if one else None,
        Parameter(paths[1], f"{symbol}_1", other, NOT_NEGATIVE) if other else None,
    )
