"""Mass, mass centre and inertia of a ``[[link]]``: as written, or from the uniform bodies that it is made of."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import combinations
from typing import Any

from ..effect_base.arithmetic import Written
from ..mechanism.uniform_bodies import Mass, crossing_edges, disc, in_line, point, polygon, polygon_area, rod, together
from .around import first_circle
from .errors import Path, Report
from .schema import Body, DiscTable, LinkTable, PlateTable, PointMassTable, RodTable

PLAIN = ("mass", "inertia", "com")
"""Keys by which a link says itself what it weighs."""
UNKNOWN = Mass(1.0, 0j, 1.0)
"""Stands for what has a fault, so that the rest of the scene is checked too; nothing else there hangs on masses."""


def link_mass(table: LinkTable, path: Path, report: Report) -> Mass:
    """What a link weighs, in its frame. Faults go to ``report``, and leave some mass."""
    bodies = [*_bodies(table, path)]
    given = [key for key in PLAIN if getattr(table, key) is not None]
    if bodies:
        kinds = " and ".join(dict.fromkeys(str(place[2]) for place, _ in bodies))
        for key in given:
            message = f"found {key} beside {kinds}, expected no {key}, because that follows from the {kinds}; remove it"
            more = ', or write point_mass = { mass = ..., at = "A" } for a mass that comes on top' * (key == "mass")
            report.add((*path, key), message + more)
        parts = [_READERS[type(body)](body, table, place, report) for place, body in bodies]
        found = _finite([part for part in parts if part], (*path, str(bodies[0][0][2])), report)
        return found if found and len(parts) == len([part for part in parts if part]) else UNKNOWN
    for key in PLAIN:
        if key not in given:
            expected = LinkTable.model_fields[key].description
            advice = "add it, or a body that it follows from: rod = { mass = ... }, plate, disc or point_mass"
            report.add((*path, key), f"missing, expected {expected}; {advice}")
    if len(given) < len(PLAIN) or table.mass is None or table.inertia is None or table.com is None:
        return UNKNOWN
    places = _spots([table.com], table, path, report, key="com")
    return Mass(table.mass, places[0], table.inertia) if places else UNKNOWN


def _bodies(table: LinkTable, path: Path) -> Iterator[tuple[Path, Any]]:
    """The bodies of a link, each with its key."""
    for kind in ("rod", "plate", "disc", "point_mass"):
        given = getattr(table, kind)
        if isinstance(given, list):
            yield from (((*path, kind, index), one) for index, one in enumerate(given))
        elif given is not None:
            yield (*path, kind), given


def _finite(parts: Sequence[Mass], path: Path, report: Report) -> Mass | None:
    """All bodies together; ``None`` after the fault that no double holds what they weigh."""
    if not parts:
        return None
    try:
        whole = together(parts)
    except OverflowError:
        whole = Mass(math.fsum(part.mass for part in parts), 0j, math.inf)
    if all(map(math.isfinite, (whole.mass, whole.com.real, whole.com.imag, whole.inertia))):
        return whole
    report.add(path, _beyond(whole))
    return None


def _beyond(found: Mass) -> str:
    message = f"found a mass of {found.mass:.3g} kg and an inertia of {found.inertia:.3g} kg m²"
    return f"{message}, expected positive finite numbers; change lengths or masses"


def _rod(body: RodTable, link: LinkTable, path: Path, report: Report) -> Mass | None:
    if body.between is None and len(link.points) != 2:
        message = f"missing, expected the two ends of the rod, because the link has {_count(link)}"
        report.add((*path, "between"), f'{message}; add between = ["A", "B"] with names of its points or [x, y]')
        _heaviness(body, 0.0, 0.0, path, report)
        return None
    between: Sequence[str | list[float]] = body.between if body.between is not None else [*link.points]
    ends = _spots(between, link, (*path, "between") if body.between is not None else path, report)
    length = math.dist(*((end.real, end.imag) for end in ends)) if ends else 1.0
    if length == 0.0:
        names = " and ".join(map(_named, between))
        report.add(
            (*path, "between") if body.between is not None else path,
            f"found {names} in one place, expected two ends of a rod; move one of them",
        )
    mass = _heaviness(body, length * (body.width or 0.0), length, path, report)
    if mass is None or ends is None or not length:
        return None
    _judge_thickness(body, max(length, body.width or 0.0), path, report)
    return _computed(mass, lambda: rod(mass, ends[0], ends[1], body.width or 0.0), path, report)


def _plate(body: PlateTable, link: LinkTable, path: Path, report: Report) -> Mass | None:
    if body.corners is None and len(link.points) < 3:
        message = f"missing, expected at least three corners, because the link has {_count(link)}"
        report.add((*path, "corners"), f"{message}; add them, names of its points or [x, y]")
        _heaviness(body, 1.0, 0.0, path, report)
        return None
    outline = link.outline if link.around and len(link.outline or ()) > 2 else None
    corners_of_link = outline or first_circle(link) or [*link.points]
    chosen: Sequence[str | list[float]] = body.corners if body.corners is not None else corners_of_link
    at = (*path, "corners") if body.corners is not None else path
    corners = _spots(chosen, link, at, report)
    crossing = crossing_edges(corners) if corners else None
    if crossing:
        report.add(at, _crossing_sentence(crossing, [*map(_named, chosen)], corners or ()))
    mass = _heaviness(body, polygon_area(corners) if corners and not crossing else 1.0, 0.0, path, report)
    if mass is None or corners is None or crossing:
        return None
    _judge_thickness(body, max(abs(one - other) for one in corners for other in corners), path, report)
    return _computed(mass, lambda: polygon(mass, corners), path, report)


def _crossing_sentence(edges: tuple[int, int], names: Sequence[str], corners: Sequence[complex]) -> str:
    one, other = ((names[edge], names[(edge + 1) % len(names)]) for edge in edges)
    if one == other:
        return f"found the corners {one[0]} and {one[1]} in one place, expected an outline; leave one of them out"
    found = f"found an outline whose edges {'-'.join(one)} and {'-'.join(other)} cross or touch"
    if in_line(corners):
        ends = max(combinations(range(len(corners)), 2), key=lambda pair: abs(corners[pair[0]] - corners[pair[1]]))
        between = ", ".join(_quoted(names[end]) for end in ends)
        return (
            f"{found}: the corners lie in a line, expected some beside it; write rod = {{ mass = ..., "
            f"between = [{between}] }} for a bar"
        )
    advice = "list corners in their order round the plate, and no others"
    return f"{found}, expected one that does not meet itself; {advice}"


def _quoted(name: str) -> str:
    """A place as a scene has it: a name in quotes, or [x, y]."""
    return name if name.startswith("[") else f'"{name}"'


def _disc(body: DiscTable, link: LinkTable, path: Path, report: Report) -> Mass | None:
    inner = body.inner_radius or 0.0
    fine = inner < body.radius
    if not fine:
        message = f"found {inner:.6g} m, expected less than the radius, {body.radius:.6g} m; exchange them"
        report.add((*path, "inner_radius"), message)
    area = math.pi * (body.radius - inner) * (body.radius + inner)
    mass = _heaviness(body, area if fine else 1.0, 0.0, path, report)
    if body.centre is None and len(link.points) != 1:
        message = f"missing, expected the centre of the disc, because the link has {_count(link)}"
        report.add((*path, "centre"), f"{message}; add the name of one of them or [x, y]")
        return None
    centre: str | list[float] = body.centre if body.centre is not None else next(iter(link.points))
    places = _spots([centre], link, path, report, key="centre")
    if mass is None or places is None or not fine:
        return None
    _judge_thickness(body, 2.0 * body.radius, path, report)
    return _computed(mass, lambda: disc(mass, places[0], body.radius, inner), path, report)


def _point_mass(body: PointMassTable, link: LinkTable, path: Path, report: Report) -> Mass | None:
    places = _spots([body.at], link, path, report, key="at")
    return point(body.mass, places[0]) if places else None


_READERS: dict[type, Callable[[Any, LinkTable, Path, Report], Mass | None]] = {
    RodTable: _rod,
    PlateTable: _plate,
    DiscTable: _disc,
    PointMassTable: _point_mass,
}


def _computed(mass: float, compute: Callable[[], Mass], path: Path, report: Report) -> Mass | None:
    """The body of this mass (kg), or ``None`` after the fault that no double holds its mass or inertia."""
    try:
        found = compute() if 0.0 < mass < math.inf else Mass(mass, 0j, math.nan)
    except OverflowError:
        found = Mass(mass, 0j, math.inf)
    if 0.0 < found.inertia < math.inf:
        return found
    report.add(path, _beyond(found))
    return None


def _heaviness(body: Body, area: float, length: float, path: Path, report: Report) -> float | None:
    """The mass (kg) of a body of this ``area`` (m²) and ``length`` (m), by the one key that gives it; ``None`` after a
    fault."""
    given = [key for key in body.ONE_OF if getattr(body, key) is not None]
    ways = f"one of {', '.join(body.ONE_OF)}"
    fine = True
    if not given:
        report.add(path, f"found no mass, expected {ways}; add one")
        fine = False
    for key in given[1:]:
        report.add((*path, key), f"found {key} beside {given[0]}, expected {ways}; remove one")
        fine = False
    if body.density is not None and body.thickness is None:
        message = "missing, expected how thick the body is across the plane in m, because a density is given"
        report.add((*path, "thickness"), f"{message}; add it, or give mass_per_area")
        fine = False
    if body.thickness is not None and body.density is None and given:
        report.add((*path, "thickness"), "found thickness without density, expected it only with one; remove it")
        fine = False
    flat = [key for key in given if key in ("mass_per_area", "density")]
    if isinstance(body, RodTable) and flat and body.width is None:
        message = f"missing, expected how wide the rod is in the plane in m, because {flat[0]} is given"
        report.add((*path, "width"), f"{message}; add it, or give mass or mass_per_length")
        fine = False
    if not fine:
        return None
    per_length = body.mass_per_length if isinstance(body, RodTable) else None
    if body.mass is not None:
        return body.mass
    if per_length is not None:
        return per_length * length
    if body.mass_per_area is not None:
        return body.mass_per_area * area
    return (body.density or 0.0) * (body.thickness or 0.0) * area


def _judge_thickness(body: Body, extent: float, path: Path, report: Report) -> None:
    """Remark on a thickness without a unit that is more than the body's largest ``extent`` (m) in the plane: of what
    links are made of one is mostly a tenth to a hundredth of the other, and millimetres taken for metres are a
    thousand times as thick."""
    thickness = body.thickness
    if thickness is None or thickness <= extent or (isinstance(thickness, Written) and thickness.dimension is not None):
        return
    report.remark(
        (*path, "thickness"),
        f"{thickness:g} is taken as m, more than the {extent:.3g} m that the body measures in the plane, and its mass "
        f'is so many times as large; write "{thickness:g} mm" for millimetres, or "{thickness:g} m"',
    )


def _spots(
    given: Sequence[str | list[float]], link: LinkTable, path: Path, report: Report, key: str = ""
) -> list[complex] | None:
    """Places in the link's frame (m), ``None`` after faults; one alone stands at ``key`` of the table at ``path``."""
    found: list[complex] = []
    for index, spot in enumerate(given):
        if isinstance(spot, str) and spot not in link.points:
            message = f'found "{spot}", expected a point of the link: {", ".join(link.points)}, or [x, y] in m'
            report.add((*path, key or index), f"{message}; correct the name or add the point")
        else:
            found.append(complex(*(link.points[spot] if isinstance(spot, str) else spot)))
    return found if len(found) == len(given) else None


def _count(link: LinkTable) -> str:
    return f"{len(link.points)} point{'s' * (len(link.points) != 1)}: {', '.join(link.points)}"


def _named(spot: str | list[float]) -> str:
    return spot if isinstance(spot, str) else f"[{spot[0]:g}, {spot[1]:g}]"
