"""Links, joints and ground of a scene as mechanism records: the general form ``[[link]]`` + ``[[joint]]``."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..effects.effect import Contact
from ..effects.table import NAME
from ..mechanism.joints import Joint, PointRef
from ..mechanism.links import GROUND, Link, Parameter, Point
from ..mechanism.mechanism import Mechanism
from .errors import Path, Report
from .schema import GroundLinkTable, JointTable, LinkTable

GROUND_NAME = "ground"


@dataclass(frozen=True)
class Bodies:
    """The mechanism of a scene, with what its form says about the rest.

    ``free_ends`` are points that touch grounds besides the joints; ``sketch`` holds the absolute angle of each link
    (rad) from which the start is assembled unless the scene gives others; ``path`` is the key that faults of the whole
    mechanism are reported at; ``rates`` are angular velocities (rad/s) of the links, ``None`` where open, unless the
    scene gives some.
    """

    mechanism: Mechanism
    free_ends: tuple[Contact, ...]
    sketch: tuple[float, ...]
    path: Path
    rates: tuple[float | None, ...] = ()

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """What touches a ground unless it says otherwise: joints off the ground, once per pin, and the free ends."""
        found: list[Contact] = []
        seen: set[PointRef] = set()
        for joint in self.mechanism.joints:
            ends = {joint.first, joint.second}
            if not joint.on_ground and not ends & seen:
                found.append((joint.name, joint.first))
            seen |= ends
        return (*found, *self.free_ends)


def coordinate(path: str, symbol: str, value: float) -> Parameter | None:
    """A coordinate as a parameter, or ``None`` where it is exactly zero and so part of the structure."""
    return Parameter(path, symbol, value) if value else None


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
    names = [_name(raw, index) for index, raw in enumerate(tables["link"])]
    points = {name: _points(raw) for name, raw in zip(names, tables["link"], strict=True)}
    points[GROUND_NAME] = _points(tables.get("ground_link"))
    fine = _check_names(names, points, joints, report)
    ends = [_ends(index, joint, names, points, report) for index, joint in enumerate(joints)]
    built = [_link(index, name, table) for index, (name, table) in enumerate(zip(names, links, strict=True)) if table]
    if not fine or len(built) < len(links) or None in ends or (ground is None and "ground_link" in tables):
        return None
    records = tuple(
        Joint(table.name or f"joint_{index}", *pair)
        for index, (table, pair) in enumerate(zip(joints, ends, strict=True))
        if table and pair
    )
    places = {
        key: point(f"ground.points.{key}", f"l_g_{key}", *xy) for key, xy in (ground.points if ground else {}).items()
    }
    mechanism = Mechanism(tuple(built), places, records)
    if not _check_lengths(mechanism, report):
        return None
    return Bodies(mechanism, (), (0.0,) * len(built), ("joint",) if records else ("link",))


def _name(raw: object, index: int) -> str:
    name = raw.get("name") if isinstance(raw, Mapping) else None
    return name if isinstance(name, str) else f"link_{index}"


def _points(raw: object) -> tuple[str, ...]:
    """Names of the points that a table gives, whatever else is wrong with it."""
    points = raw.get("points") if isinstance(raw, Mapping) else None
    return tuple(points) if isinstance(points, Mapping) else ()


def _link(index: int, name: str, table: LinkTable) -> Link:
    return Link(
        name=name,
        mass=Parameter(f"{name}.mass", f"m_{index}", table.mass),
        inertia=Parameter(f"{name}.inertia", f"I_{index}", table.inertia),
        com=point(f"{name}.com", f"c_{index}", *table.com),
        points={key: point(f"{name}.points.{key}", f"l_{index}_{key}", *xy) for key, xy in table.points.items()},
    )


def _check_names(
    names: Sequence[str],
    points: Mapping[str, Collection[str]],
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
        for key in found:
            if not re.fullmatch(NAME, key):
                message = f'found "{key}", expected a name of letters, digits and _, beginning with a letter; rename it'
                report.add((*base, "points", key), message)
                fine = False
    return fine


def _ends(
    index: int, table: JointTable | None, names: Sequence[str], points: Mapping[str, Collection[str]], report: Report
) -> tuple[PointRef, PointRef] | None:
    """Both sides of a joint, or ``None`` after a fault."""
    if table is None:
        return None
    found = []
    for side, text in enumerate(table.between):
        owner, dot, key = text.partition(".")
        path: Path = ("joint", index, "between", side)
        if not dot or not key:
            report.add(path, f'found "{text}", expected "link.point"; name the link and one of its points')
        elif owner not in points:
            known = ", ".join(dict.fromkeys((*names, GROUND_NAME)))
            report.add(path, f'found "{text}", expected a point of {known}; there is no link "{owner}"')
        elif key not in points[owner]:
            known = ", ".join(points[owner]) or "none yet"
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


def _check_lengths(mechanism: Mechanism, report: Report) -> bool:
    """A link between several joints has some length: its jointed points are not all in one place."""
    fine = True
    ends = [end for joint in mechanism.joints for end in (joint.first, joint.second)]
    for index, link in enumerate(mechanism.links):
        used = dict.fromkeys(end.point for end in ends if end.link == index)
        if len(used) > 1 and len({link.points[key].values() for key in used}) == 1:
            message = f"found {' and '.join(used)} in one place, expected a length above zero; move one of them"
            report.add(("link", index, "points"), message)
            fine = False
    return fine
