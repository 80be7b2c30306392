"""Points of a link round a circle, ``[link.around]``: as of a wheel's teeth, written once for all of them."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

from .errors import Path, Report
from .schema import MOST_CORNERS, AroundTable, LinkTable
from .turning import cos_sin


def with_around(table: LinkTable, path: Path, report: Report) -> LinkTable | None:
    """The link with all points of its circles among its own, and with those of the first for its outline unless it says
    another; ``None`` after faults."""
    if table.around is None:
        return table
    circles = table.around if isinstance(table.around, list) else [table.around]
    points, outline, fine = dict(table.points), table.outline, True
    for number, circle in enumerate(circles):
        where = (*path, "around", number) if isinstance(table.around, list) else (*path, "around")
        centre = _centre(circle, points, where, report)
        found = dict(_places(circle, centre or 0j))
        fine = _check(circle, found, points, where, report) and centre is not None and fine
        points |= {name: [place.real, place.imag] for name, place in found.items()}
        outline = outline if outline is not None else [*found]
    return table.model_copy(update={"points": points, "outline": outline}) if fine else None


def first_circle(table: LinkTable) -> list[str]:
    """Names of the points of a link's first circle, in the order round it; none where it has no circle."""
    if table.around is None:
        return []
    circle = table.around[0] if isinstance(table.around, list) else table.around
    return [f"{name}{k}" for k in range(circle.count) for name in circle.points]


def names_around(raw: Any) -> list[str] | None:
    """Names of a table's points round circles, whatever else is wrong with it; ``None`` where it does not say them."""
    circles = raw if isinstance(raw, list) else [raw]
    found: list[str] = []
    for circle in circles:
        count, points = (circle.get(key) for key in ("count", "points")) if isinstance(circle, dict) else (None, None)
        if not isinstance(count, int) or count > MOST_CORNERS or not isinstance(points, dict):
            return None
        found += [f"{name}{k}" for k in range(count) for name in points]
    return found


def _places(circle: AroundTable, centre: complex) -> Iterator[tuple[str, complex]]:
    """Points (m) by their names, ``count`` times all of them, in the order round the circle."""
    way = -1.0 if circle.clockwise else 1.0
    for k in range(circle.count):
        for name, (radius, angle) in circle.points.items():
            cos, sin = cos_sin(angle + way * (4 * k / circle.count) * (math.pi / 2.0))
            yield f"{name}{k}", centre + radius * complex(cos, sin)


def _centre(circle: AroundTable, points: Mapping[str, Sequence[float]], path: Path, report: Report) -> complex | None:
    """Where the middle is (m), maybe at a point written before it; ``None`` after a fault."""
    if not isinstance(circle.centre, str):
        return complex(*circle.centre) if circle.centre is not None else 0j
    if circle.centre in points:
        return complex(*points[circle.centre])
    known = ", ".join(points)
    message = f'found "{circle.centre}", expected a point of the link: {known}, or [x, y] in m; correct the name'
    report.add((*path, "centre"), message)
    return None


def _check(circle: AroundTable, found: Collection[str], taken: Collection[str], path: Path, report: Report) -> bool:
    """Whether the names of the points are new and not too many."""
    if circle.count * len(circle.points) > MOST_CORNERS:
        message = f"found {circle.count} times {len(circle.points)} points, expected at most {MOST_CORNERS} in all"
        report.add((*path, "count"), f"{message}; take fewer")
        return False
    if len(found) < circle.count * len(circle.points):
        known = " and ".join(circle.points)
        message = f"found {known}, whose numbers give one name to two points, expected names that differ by more"
        report.add((*path, "points"), f"{message}; let no name end in a digit")
        return False
    if twice := [name for name in found if name in taken]:
        message = f"found {twice[0]}, which is a point of the link already, expected new names; rename one of them"
        report.add((*path, "points"), message)
        return False
    return True
