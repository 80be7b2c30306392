"""What stands at ``between`` in the tables of contacts of two links: a disc's centre, and another point or an edge."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

from pydantic import Discriminator, Field, Tag

from ..mechanism.joints import PointRef
from ..mechanism.links import GROUND, Point
from ..mechanism.mechanism import Mechanism
from .effect import Complain
from .line import NO_DIRECTION, links_at
from .points import find_point
from .table import PointName, text_or_list

if TYPE_CHECKING:
    from ..derive.terms_of_effects import Let
    from ..derive.touching import Edge

Ends = Annotated[list[PointName], Field(min_length=2, max_length=2)]

Side = Annotated[Annotated[PointName, Tag("<text>")] | Annotated[Ends, Tag("<list>")], Discriminator(text_or_list)]
"""A point, or the two ends of an edge; a text may also be a link with just two points."""

Extent = tuple[PointRef, PointRef | None]
"""A point and ``None``, or the ends of an edge."""


def title_of(side: str | list[str]) -> str:
    """What the scene says; of more than two points the link's name."""
    if isinstance(side, str):
        return side
    return "-".join(side) if len(side) == 2 else side[0].partition(".")[0]


def find_disc(side: str | list[str], whose: str, mechanism: Mechanism, complain: Complain) -> PointRef | None:
    """The centre that stands first, ``whose`` as faults say it; ``None`` after a complaint."""
    ref, wrong = find_point(side, mechanism) if isinstance(side, str) else (None, "put the edge in the second place")
    if ref is None:
        complain(("between", 0), f"found {shown(side)}, expected a joint or link.point, {whose} centre; {wrong}")
    return ref


def find_extent(side: str | list[str], mechanism: Mechanism, complain: Complain) -> Extent | None:
    """A point and ``None``, or the ends of an edge, of a link that is named, or two points; ``None`` after a
    complaint."""
    names = side
    if isinstance(side, str):
        ref, wrong = find_point(side, mechanism)
        if ref is not None:
            return ref, None
        names, points = corners_of(side, mechanism), points_of(side, mechanism)
        if len(names) != 2:
            wrong = f"it has the points {', '.join(points)}; name two of them" if points else wrong
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
        complain(("between", 1), f"found {shown(side)}, expected two points of one link, the ends of an edge; {wrong}")
        return None
    return ends[0], ends[1]


def shown(side: str | list[str]) -> str:
    """As faults quote it."""
    return f'"{side}"' if isinstance(side, str) else str([*side]).replace("'", '"')


def points_of(link: str, mechanism: Mechanism) -> list[str]:
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


def corners_of(link: str, mechanism: Mechanism) -> list[str]:
    """The corners of a link's outline as a scene names them, or both points of a link with two; none of any other."""
    if link in mechanism.corners:
        return [*mechanism.corners[link]]
    points = points_of(link, mechanism)
    return points if len(points) == 2 and not mechanism.outlines.get(link) else []


def _length(mechanism: Mechanism, ends: Sequence[PointRef]) -> float:
    (x, y), (x2, y2) = (mechanism.point(ref).values() for ref in ends)
    return math.hypot(x2 - x, y2 - y)


def on_two_links(
    first: str | list[str],
    disc: PointRef,
    second: str | list[str],
    other: Extent,
    mechanism: Mechanism,
    complain: Complain,
) -> bool:
    """Whether the two sides are on two links: a pin is on both of its own."""
    of_other = links_at(second, other[0], mechanism) if isinstance(second, str) else {other[0].link}
    shared = links_at(title_of(first), disc, mechanism) & of_other
    if shared:
        names = " and ".join(sorted(map(mechanism.link_name, shared)))
        complain(("between",), f"found two places on {names}, expected places on two links; change one")
    return not shared


def edge_between(ends: tuple[Point, Point] | None, end: PointRef | None, name: str, let: Let) -> Edge | None:
    """The edge to ``end`` between two points of a link's frame, its length called ``name``; ``None`` where there is
    none."""
    from sympy import sqrt

    from ..derive.touching import Edge
    from ..derive.vectors import dot, less, local

    if ends is None or end is None:
        return None
    along = less(local(ends[1]), local(ends[0]))
    return Edge(end, let(name, sqrt(dot(along, along))))


def distance_from(centre: complex, start: complex, end: complex) -> float:
    """From a place to the nearest point of a segment (m)."""
    off, edge = centre - start, end - start
    along = (off * edge.conjugate()).real / abs(edge) ** 2 if edge else 0.0
    return abs(off - min(max(along, 0.0), 1.0) * edge)
