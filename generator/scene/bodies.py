"""Links, joints and ground of a scene as mechanism records: the general form ``[[link]]`` + ``[[joint]]``."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from ..effect_base.effect import Contact
from ..effect_base.table import NAME
from ..mechanism.implied import almost_implied, implied
from ..mechanism.joints import Joint, PointRef
from ..mechanism.links import ANY, GROUND, POSITIVE, Domain, Link, Parameter, Point
from ..mechanism.mechanism import Mechanism
from ..mechanism.modules import varied
from ..mechanism.touching_points import touching_points
from ..mechanism.uniform_bodies import Mass
from .around import names_around
from .errors import Path, Report
from .link_mass import link_mass
from .schema import GroundLinkTable, JointTable, LinkTable, PlateTable, Spot
from .weld import Body, Weld, Welded, merge

GROUND_NAME = "ground"


@dataclass(frozen=True)
class Bodies:
    """The mechanism of a scene, with what its form says about the rest.

    ``free_ends`` are points that touch grounds besides the joints; ``sketch`` holds the absolute angle of each link
    (rad) from which the start is assembled unless the scene gives others; ``path`` is the key that faults of the whole
    mechanism are reported at; ``rates`` are angular velocities (rad/s) of the links, ``None`` where open, unless the
    scene gives some. ``link_rows`` and ``joint_rows`` are the tables that describe the links and joints that are left
    after welding, -1 for a joint that no table describes. ``free`` are links that no joint need hold.
    """

    mechanism: Mechanism
    free_ends: tuple[Contact, ...]
    sketch: tuple[float, ...]
    path: Path
    rates: tuple[float | None, ...] = ()
    link_rows: tuple[int, ...] = ()
    joint_rows: tuple[int, ...] = ()
    free: frozenset[int] = frozenset()

    def at_link(self, index: int) -> Path:
        """The key that faults of a link are reported at."""
        return ("link", self.link_rows[index]) if self.link_rows else self.path

    def at_joint(self, index: int) -> Path:
        """The key that faults of a joint are reported at."""
        row = self.joint_rows[index] if self.joint_rows else -1
        return self.path if row < 0 else ("joint", row)

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """What touches a ground unless it says otherwise: the points of :func:`touching_points`, and the free ends."""
        found = [(one.name, one.ref) for one in touching_points(self.mechanism)]
        own = {name for name, _ in self.free_ends}
        return (*(one for one in found if one[0] not in own), *self.free_ends)


def coordinate(path: str, symbol: str, value: float, domain: Domain = ANY) -> Parameter | None:
    """A number as a parameter, or ``None`` where it is exactly zero and so part of the structure."""
    return Parameter(path, symbol, value, domain) if value else None


def point(path: str, symbol: str, x: float, y: float) -> Point:
    """The point (x, y) in m, with parameters ``path``.x and ``path``.y."""
    return Point(coordinate(f"{path}.x", f"{symbol}_x", x), coordinate(f"{path}.y", f"{symbol}_y", y))


def general(
    tables: Mapping[str, Any],
    links: Sequence[LinkTable | None],
    joints: Sequence[JointTable | None],
    ground: GroundLinkTable | None,
    report: Report,
) -> Bodies | None:
    """The general form as records, or ``None`` after faults. ``tables`` is the scene as written."""
    names = [name_of_link(raw, index) for index, raw in enumerate(tables["link"])]
    points = {
        name: tuple(table.points) if table else _points(raw)
        for name, table, raw in zip(names, links, tables["link"], strict=True)
    }
    points[GROUND_NAME] = _points(tables.get("ground_link", {"points": {}}))
    fine = _check_names(names, points, joints, report)
    told = all(isinstance(raw, Mapping) and isinstance(raw.get("name", ""), str) for raw in tables["link"])
    unknown = _unknown_links(names, points, joints) if told else {}
    ends = [_ends(index, joint, names, points, unknown, report) for index, joint in enumerate(joints)]
    fine = sum(not _check_keys(index, joint, report) for index, joint in enumerate(joints) if joint) == 0 and fine
    bodies = [
        _body(name, table, link_mass(table, ("link", index), report))
        for index, (name, table) in enumerate(zip(names, links, strict=True))
        if table
    ]
    for index, body in enumerate(bodies):
        if body.inertia and not body.mass:
            message = f"found {body.inertia:.6g} with a mass of 0, expected 0 for a link without mass; give it a mass"
            report.add(("link", index, "inertia"), message, also=[("link", index, "mass")])
            fine = False
    fine = _check_outlines(links, report) and fine
    if not fine or len(bodies) < len(links) or None in ends or (ground is None and "ground_link" in tables):
        return None
    fixed = {key: complex(*xy) for key, xy in (ground.points if ground else {}).items()}
    pairs = [(row, table, pair) for row, (table, pair) in enumerate(zip(joints, ends, strict=True)) if table and pair]
    lasting = [row for row, table, _ in pairs if table.type == "weld" and not _lets_go(tables, row, table)]
    welds = [
        Weld(row, table.name or f"joint_{row}", *pair, table.angle or 0.0)
        for row, table, pair in pairs
        if row in lasting
    ]
    merged = merge(bodies, fixed, welds, report)
    if merged is None or (found := _assemble(merged, pairs, lasting, report)) is None:
        return None
    by_name = {link.name: index for index, link in enumerate(found.mechanism.links)} | dict(merged.names)
    described = [(name, table) for name, table in zip(names, links, strict=True) if table]
    corners = {name: named for name, table in described if (named := _named_corners(name, table))}
    return replace(
        found,
        mechanism=replace(found.mechanism, corners=corners),
        free=frozenset(by_name[name] for name, table in described if table.free),
    )


def _lets_go(tables: Mapping[str, Any], row: int, table: JointTable) -> bool:
    """Whether a table names the joint as one that lets go or takes hold: a weld is a joint then."""
    every = [one for key in ("release", "hold") for one in tables.get(key, ()) if isinstance(one, Mapping)]
    return any(one.get("joint") == (table.name or f"joint_{row}") for one in every)


def _named_corners(name: str, table: LinkTable) -> tuple[str, ...]:
    """The outline of a link by its points, ``link.point`` each; nothing where it has none, or corners without names."""
    outline = table.outline or []
    if len(outline) > 3 and outline[0] == outline[-1]:  # closed, as a picture may have it
        outline = outline[:-1]
    corners = tuple(f"{name}.{corner}" for corner in outline if isinstance(corner, str))
    return corners if len(corners) == len(outline) > 1 else ()


def _assemble(
    merged: Welded,
    pairs: Sequence[tuple[int, JointTable, tuple[PointRef, PointRef]]],
    welds: Collection[int],
    report: Report,
) -> Bodies | None:
    """Records of the bodies that ``welds``, rows of joints, have left, and of the joints between them; ``None`` after
    faults."""
    built = tuple(_link(index, body) for index, body in enumerate(merged.bodies))
    places = {key: _place(f"ground.points.{key}", f"l_g_{key}", z) for key, z in merged.ground.items()}
    records: list[Joint] = []
    rows: list[int] = []
    for row, table, pair in pairs:
        if row in welds:
            continue
        first, second = (merged.refs.get(ref, ref) for ref in pair)
        if first.link == second.link:
            message = f"found {table.between[0]} and {table.between[1]}, which are welded together, expected points of "
            report.add(("joint", row, "between"), message + "two links that can move; remove the joint or a weld")
            continue
        records.append(_joint(row, len(records), table, first, second))
        rows.append(row)
    if len(records) < len(pairs) - len(welds):
        return None
    outlines = {
        body.name: tuple(corner if isinstance(corner, str) else (corner.real, corner.imag) for corner in body.outline)
        for body in merged.bodies
        if body.outline is not None
    }
    mechanism = Mechanism(built, places, tuple(records), merged.names, _welds(pairs, welds), outlines=outlines)
    if kept := varied(mechanism):
        built = tuple(_link(index, body, kept) for index, body in enumerate(merged.bodies))
        mechanism = replace(mechanism, links=built)
    bodies = Bodies(
        mechanism, (), (0.0,) * len(built), ("joint",) if pairs else ("link",), (), merged.rows, tuple(rows)
    )
    fine = _check_lengths(bodies, report)
    return bodies if _check_apart(bodies, report) and fine else None


def _welds(
    pairs: Sequence[tuple[int, JointTable, tuple[PointRef, PointRef]]], welds: Collection[int]
) -> tuple[str, ...]:
    return tuple(table.name or f"joint_{row}" for row, table, _ in pairs if row in welds)


def _joint(row: int, index: int, table: JointTable, first: PointRef, second: PointRef) -> Joint:
    name = table.name or f"joint_{row}"
    if table.type == "revolute":
        return Joint(name, first, second)
    if table.type == "weld":
        angle = coordinate(f"{name}.angle", f"phi_{index}", table.angle or 0.0)
        return Joint(name, first, second, "weld", angle=angle)
    axis = math.atan2(table.axis[1], table.axis[0]) if isinstance(table.axis, list) else table.axis or 0.0
    return Joint(
        name,
        first,
        second,
        table.type,
        coordinate(f"{name}.axis", f"axis_{index}", axis),
        coordinate(f"{name}.angle", f"phi_{index}", table.angle or 0.0),
    )


def _check_keys(index: int, table: JointTable, report: Report) -> bool:
    """A joint has the keys of its kind: a line where something slides, an angle where one is held."""
    fine = True
    slides = table.type in ("prismatic", "pin-in-slot")
    holds = table.type in ("prismatic", "weld")
    for key, allowed, kinds in (("axis", slides, "prismatic or pin-in-slot"), ("angle", holds, "prismatic or weld")):
        if getattr(table, key) is not None and not allowed:
            message = f"found {key} at a {table.type} joint, expected it at a {kinds} joint only; remove it"
            report.add(("joint", index, key), message)
            fine = False
    if slides and table.axis is None:
        message = "missing, expected the direction of the line in the first link's frame, [x, y] or an angle; add it"
        report.add(("joint", index, "axis"), message)
        fine = False
    if isinstance(table.axis, list) and not any(table.axis):
        message = f"found {table.axis}, expected a direction, not both zero; write [1, 0] for one along x"
        report.add(("joint", index, "axis"), message)
        fine = False
    return fine


def name_of_link(raw: object, index: int) -> str:
    """The name that a ``[[link]]`` gives itself, or has by its place."""
    name = raw.get("name") if isinstance(raw, Mapping) else None
    return name if isinstance(name, str) else f"link_{index}"


def _points(raw: object) -> tuple[str, ...] | None:
    """Names of the points that a table gives, whatever else is wrong with it; ``None`` where it does not say any."""
    points = raw.get("points") if isinstance(raw, Mapping) else None
    around = names_around(raw.get("around", [])) if isinstance(raw, Mapping) else None
    return (*points, *around) if isinstance(points, Mapping) and around is not None else None


def _body(name: str, table: LinkTable, mass: Mass) -> Body:
    points = {key: complex(*xy) for key, xy in table.points.items()}
    outline = None
    drawn = table.outline if table.outline is not None else _corners_of_plate(table)
    if drawn is not None:
        outline = tuple(corner if isinstance(corner, str) else complex(*corner) for corner in drawn)
    return Body(name, mass.mass, mass.inertia, mass.com, points, outline)


def _link(index: int, body: Body, kept: Collection[tuple[int, str, str]] = ()) -> Link:
    """The record of a body; coordinates ``kept`` are parameters, zero or not."""
    name = body.name

    def place(key: str, path: str, symbol: str, z: complex) -> Point:
        found = _place(path, symbol, z)
        x, y = (
            Parameter(f"{path}.{axis}", f"{symbol}_{axis}", 0.0) if (index, key, axis) in kept else value
            for axis, value in (("x", found.x), ("y", found.y))
        )
        return Point(x, y)

    return Link(
        name=name,
        mass=coordinate(f"{name}.mass", f"m_{index}", body.mass, POSITIVE),
        inertia=coordinate(f"{name}.inertia", f"I_{index}", body.inertia, POSITIVE),
        com=place("", f"{name}.com", f"c_{index}", body.com),
        points={key: place(key, f"{name}.points.{key}", f"l_{index}_{key}", z) for key, z in body.points.items()},
    )


def _corners_of_plate(table: LinkTable) -> list[Spot] | None:
    """The corners of the only plate that the link is made of, in their order, where that is not what its points are."""
    beside = any(getattr(table, name) is not None for name in ("rod", "disc", "point_mass"))
    corners = table.plate.corners if isinstance(table.plate, PlateTable) and not beside else None
    return corners if corners and list(corners) != list(table.points) else None


def _check_outlines(links: Sequence[LinkTable | None], report: Report) -> bool:
    """Names in outlines are those of the links' points."""
    fine = True
    for index, table in enumerate(links):
        for number, corner in enumerate((table.outline if table else None) or ()):
            if table and isinstance(corner, str) and corner not in table.points:
                message = f'found "{corner}", expected a point of the link: {", ".join(table.points)}, or [x, y] in m'
                place = ("link", index, "outline", number)
                report.add(place, f"{message}; correct the name or add the point")
                fine = False
    return fine


def _place(path: str, symbol: str, z: complex) -> Point:
    return point(path, symbol, z.real, z.imag)


def _check_names(
    names: Sequence[str],
    points: Mapping[str, Collection[str] | None],
    joints: Sequence[JointTable | None],
    report: Report,
) -> bool:
    """Names of links and joints are used once, ``ground`` is not a link, points have usable names."""
    fine = True
    joint_names = [(table.name if table else None) or f"joint_{index}" for index, table in enumerate(joints)]
    for kind, used in (("link", names), ("joint", joint_names)):
        for index, name in enumerate(used):
            if name in used[:index]:
                message = f'found "{name}" a second time, expected a new name; rename one of them'
                report.add((kind, index, "name"), message)
                fine = False
    for index, name in enumerate(names):
        if name == GROUND_NAME:
            message = 'found "ground", expected another name; the fixed link is [ground_link]'
            report.add(("link", index, "name"), message)
            fine = False
    for owner, found in points.items():
        base: Path = ("ground_link",) if owner == GROUND_NAME else ("link", names.index(owner))
        for key in found or ():
            if not re.fullmatch(NAME, key):
                message = f'found "{key}", expected a name of letters, digits and _, beginning with a letter; rename it'
                report.add((*base, "points", key), message)
                fine = False
    return fine


def _unknown_links(
    names: Sequence[str], points: Mapping[str, Collection[str] | None], joints: Sequence[JointTable | None]
) -> dict[str, tuple[int, list[Path]]]:
    """How often joints name links that are not there, and where; nothing where links have wrong names, which is told.

    To these places belong the names of links that no joint names: one of them may be meant.
    """
    wrong = [name for name in names if not re.fullmatch(NAME, name) or name == GROUND_NAME]
    if wrong or len(set(names)) < len(names):
        return {}
    found: dict[str, list[Path]] = {}
    named: set[str] = set()
    for index, table in enumerate(joints):
        for side, text in enumerate(table.between if table else ()):
            if (owner := text.partition(".")[0]) not in points:
                found.setdefault(owner, []).append(("joint", index, "between", side))
            named.add(owner)
    meant: list[Path] = [("link", index, "name") for index, name in enumerate(names) if name not in named]
    return {owner: (len(places), [*places, *meant]) for owner, places in found.items()}


def _ends(
    index: int,
    table: JointTable | None,
    names: Sequence[str],
    points: Mapping[str, Collection[str] | None],
    unknown: dict[str, tuple[int, list[Path]]],
    report: Report,
) -> tuple[PointRef, PointRef] | None:
    """Both sides of a joint, or ``None`` after a fault. Each of the ``unknown`` links is told of once."""
    if table is None:
        return None
    found = []
    for side, text in enumerate(table.between):
        owner, dot, key = text.partition(".")
        path: Path = ("joint", index, "between", side)
        if not dot or not key:
            report.add(path, f'found "{text}", expected "link.point"; name the link and one of its points')
        elif owner not in points:
            if owner in unknown:
                times, places = unknown.pop(owner)
                known = ", ".join(dict.fromkeys((*names, GROUND_NAME)))
                often = f", which joints name {times} times" if times > 1 else ""
                message = f'found "{text}", expected a point of {known}; there is no link "{owner}"{often}'
                report.add(path, message, also=places)
        elif (there := points[owner]) is None:
            continue  # what is wrong with its points is told
        elif key not in there:
            known = ", ".join(there) or "none yet"
            report.add(path, f'found "{text}", expected a point of {owner}: {known}; add it or name another')
        else:
            found.append(PointRef(GROUND if owner == GROUND_NAME else names.index(owner), key))
    if len(found) < 2:
        return None
    if found[0].link == found[1].link:
        message = f"found {table.between[0]} and {table.between[1]}, expected points of two links; name another link"
        report.add(("joint", index, "between"), message)
        return None
    return found[0], found[1]


def _check_lengths(bodies: Bodies, report: Report) -> bool:
    """A link between several pins has some length: its jointed points are not all in one place."""
    fine = True
    idle = {found.joint for found in implied(bodies.mechanism)}
    pins = [joint for k, joint in enumerate(bodies.mechanism.joints) if not joint.slides and k not in idle]
    ends = [end for joint in pins for end in (joint.first, joint.second)]
    for index, link in enumerate(bodies.mechanism.links):
        used = dict.fromkeys(end.point for end in ends if end.link == index)
        if len(used) > 1 and len({link.points[key].values() for key in used}) == 1:
            message = f"found {' and '.join(used)} in one place, expected a length above zero; move one of them"
            report.add((*bodies.at_link(index), "points"), message)
            fine = False
    return fine


def _check_apart(bodies: Bodies, report: Report) -> bool:
    """Joints that hold the same links do so at one place, or far enough apart to hold an angle."""
    joints, found = bodies.mechanism.joints, almost_implied(bodies.mechanism)
    for idle, apart in found:
        others = ", ".join(joints[part.joint].name for part in idle.way)
        message = f"found a joint that all but holds what {others} hold{'s' * (len(idle.way) == 1)} already"
        message += f", at points {apart:.3g} m apart" if apart else ""
        advice = "expected it to hold exactly that or something else; name the same points in both, or move it away"
        report.add(bodies.at_joint(idle.joint), f"{message}, {advice}")
    return not found


def check_masses(
    bodies: Bodies, driven: Collection[int], report: Report, poses: Sequence[Sequence[float]] | None = None
) -> bool:
    """Every motion of the opened mechanism moves some mass: links without mass or inertia carry links that have it.

    Without ``poses`` of the links this is asked of a general configuration.
    """
    links = bodies.mechanism.links
    if all(link.mass and link.inertia for link in links):
        return True
    from ..mechanism.idle import idle_links  # the only check that needs the spanning tree

    idle = idle_links(bodies.mechanism, driven, poses)
    for index in idle:
        lacks = "mass" if links[index].massless else "inertia"
        found = f"found {'a mass' if lacks == 'mass' else 'an inertia'} of 0"
        message = f"expected more than 0, because nothing else resists this link's motion; give it a small {lacks}, or"
        if poses is None:
            slot = any(
                joint.kind == "pin-in-slot" and index in (joint.first.link, joint.second.link)
                for joint in bodies.mechanism.joints
            )
            instead = "make its slot a prismatic joint" if slot and lacks == "inertia" else "weld it to a neighbour"
            report.add((*bodies.at_link(index), lacks), f"{found}, {message} {instead}")
            continue
        found += " and a start with a mass on its own pin or links in line"
        report.add((*bodies.at_link(index), lacks), f"{found}, {message} start elsewhere")
    return not idle
