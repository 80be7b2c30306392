"""Bodies that no joint holds beside others that are held: carriages without mass place them in the plane."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

from .joints import Joint, PointRef
from .links import GROUND, ORIGIN, Link, Parameter
from .mechanism import Mechanism


@dataclass(frozen=True)
class Carriage:
    """Link ``link`` slides on the ground along x by joint ``across``, and the point ``body`` slides on it along y, and
    turns, by joint ``up``: three freedoms, and no mass of its own."""

    link: int
    body: PointRef
    across: int
    up: int


def parts(links: int, joints: Sequence[Joint]) -> list[frozenset[int]]:
    """Links that joints connect, in groups, the one with the ground (which it holds) first if any is on the ground."""
    around: dict[int, set[int]] = {link: set() for link in (GROUND, *range(links))}
    for joint in joints:
        around[joint.first.link].add(joint.second.link)
        around[joint.second.link].add(joint.first.link)
    found: list[frozenset[int]] = []
    left = set(around)
    for start in (GROUND, *range(links)):
        if start not in left:
            continue
        group, waiting = {start}, [start]
        while waiting:
            for near in around[waiting.pop()] - group:
                group.add(near)
                waiting.append(near)
        left -= group
        found.append(frozenset(group))
    return [group for group in found if group != {GROUND}]


def loose_parts(mechanism: Mechanism) -> list[frozenset[int]]:
    """Groups of links that nothing places: all that are not on the ground, unless there is but one group in all."""
    found = parts(len(mechanism.links), mechanism.joints)
    return [] if len(found) < 2 else [group for group in found if GROUND not in group]


def with_carriages(
    mechanism: Mechanism, groups: Sequence[frozenset[int]] | None = None
) -> tuple[Mechanism, tuple[Carriage, ...], tuple[int, ...]]:
    """The mechanism with a carriage for each of the ``groups`` of links, those that nothing places unless given, and
    the link that each carries.

    A carriage is called as the first link of its group, with ``_carriage``, and its joints with ``_x`` and ``_y``; the
    origin of the ground is where they slide from.
    """
    links, joints, ground = list(mechanism.links), list(mechanism.joints), dict(mechanism.ground_points)
    carriages: list[Carriage] = []
    carried: list[int] = []
    for group in loose_parts(mechanism) if groups is None else groups:
        link = min(group)
        body = links[link]
        point = PointRef(link, next(iter(body.points)))
        names = {one.name for one in links} | {one.name for one in joints}
        stem = _free(body.name, ("_carriage", "_x", "_y"), names)
        origin = _free("origin", ("",), ground)
        ground[origin] = ORIGIN
        number, across = len(links), len(joints)
        links.append(Link(f"{stem}_carriage", None, None, ORIGIN, {"P": ORIGIN}))
        upright = Parameter(f"{stem}_y.axis", f"axis_{across + 1}", math.pi / 2)
        joints += [
            Joint(f"{stem}_x", PointRef(GROUND, origin), PointRef(number, "P"), "prismatic"),
            Joint(f"{stem}_y", PointRef(number, "P"), point, "pin-in-slot", upright),
        ]
        carriages.append(Carriage(number, point, across, across + 1))
        carried.append(link)
    whole = replace(mechanism, links=tuple(links), joints=tuple(joints), ground_points=ground)
    return whole, tuple(carriages), tuple(carried)


def _free(stem: str, ends: Sequence[str], used: Collection[str]) -> str:
    """The stem with as many ``_`` behind it as leave no name with one of the ``ends`` used."""
    while any(f"{stem}{end}" in used for end in ends):
        stem += "_"
    return stem
