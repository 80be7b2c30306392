"""Pairs of links of which one has a disc, and the other a disc or a straight edge: how scenes name them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import Discriminator, Field, Tag

from ..mechanism.joints import PointRef
from ..mechanism.links import NOT_NEGATIVE, Parameter, Point
from ..mechanism.mechanism import Mechanism
from .between import Side, distance_from, edge_between, find_disc, find_extent, on_two_links, title_of
from .contact import Radius
from .effect import Complain, Rim
from .points import choose_carrier
from .table import Name, Table, number_or_list

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.terms_of_effects import Let
    from ..derive.touching import TouchGap
    from ..mechanism.assembled import Assembled


THINNEST = 1e-6
"""Part of the mechanism's size: radii with a smaller sum are refused. A gap counts as closed from 1e-8 of it on at most
(``COARSEST_GAP`` of the core), and what is deeper than the sum is on the other side: two digits of it are known."""


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

    def gap(self, let: Let, name: str, label: str, restitution: Expr, friction: Expr) -> TouchGap:
        """The distance of both, called after the disc's centre and ``name``; symbols have the ``label``."""
        from ..derive.touching import TouchGap
        from ..derive.vectors import symbol

        return TouchGap(
            name=self.disc.title,
            ground=name,
            label=label,
            disc=self.disc.start,
            other=self.other.start,
            edge=edge_between(self.ends, self.other.end, f"span_{label}", let),
            radius=symbol(self.disc.radius),
            thickness=symbol(self.other.radius),
            restitution=restitution,
            friction=friction,
        )

    def rims(self) -> tuple[Rim, ...]:
        """Discs and edges to be drawn."""
        bodies = (self.disc, self.other)
        return tuple((body.start, body.end, body.radius) for body in bodies if body.end or body.radius)

    def depth(self, start: Assembled) -> float:
        """How far each is inside the other (m)."""
        ends = (self.other.start, self.other.end or self.other.start)
        away = distance_from(complex(*start.place(self.disc.start)), *(complex(*start.place(end)) for end in ends))
        return self.disc.size + self.other.size - away


def read_pair(table: PairTable, name: str, symbol: str, mechanism: Mechanism, complain: Complain) -> Pair | None:
    """The pair of a table, its radii under ``name`` with the ``symbol``; ``None`` after having complained."""
    first, second = table.between
    disc = find_disc(first, "the disc's", mechanism, complain)
    other = find_extent(second, mechanism, complain)
    apart = disc is not None and other is not None and on_two_links(first, disc, second, other, mechanism, complain)
    radii = read_radii(table, name, symbol, other is not None and other[1] is not None, mechanism, complain)
    if disc is None or other is None or not apart or radii is None:
        return None
    if not check_carriers(table, radii, mechanism, complain):
        return None
    ends = (mechanism.point(other[0]), mechanism.point(other[1])) if other[1] else None
    return Pair(Body(title_of(first), disc, None, radii[0]), Body(title_of(second), *other, radii[1]), ends)


def check_carriers(
    table: PairTable, radii: tuple[Parameter | None, Parameter | None], mechanism: Mechanism, complain: Complain
) -> bool:
    """Every disc turns with a link that the scene names."""
    fine = True
    for index, (side, radius) in enumerate(zip(table.between, radii, strict=True)):
        if radius and isinstance(side, str) and (wrong := choose_carrier(side, mechanism)):
            complain(("between", index), wrong)
            fine = False
    return fine


def read_radii(
    table: PairTable, name: str, symbol: str, edge: bool, mechanism: Mechanism, complain: Complain
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
    if one + other < (thinnest := THINNEST * _size(mechanism)):
        complain(
            ("radius",),
            f"found radii with the sum {one + other:.6g} m, expected at least {thinnest:.6g} m, a millionth of the "
            "mechanism's size, because a gap counts as closed from a hundredth of that on, and what is through by the "
            "sum is on the other side; make one of them larger",
        )
        return None
    if not isinstance(given, list):
        both = Parameter(f"{name}.radius", symbol, one, NOT_NEGATIVE)
        return both, None if edge else both
    paths = [f"{name}.radius.{title_of(side)}" for side in table.between]
    return (
        Parameter(paths[0], f"{symbol}_0", one, NOT_NEGATIVE) if one else None,
        Parameter(paths[1], f"{symbol}_1", other, NOT_NEGATIVE) if other else None,
    )


def _size(mechanism: Mechanism) -> float:
    """The distance (m) of the farthest point from its link's origin; 1 where all are there."""
    points = [point.values() for link in mechanism.links for point in link.points.values()]
    return max((math.hypot(*point) for point in points), default=0.0) or 1.0
