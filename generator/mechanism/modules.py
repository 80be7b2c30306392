"""Modules that may be equal: sets of links that meet the rest at a few links only, as the legs of a walking machine do.

Whether they are equal is decided where it counts, statement by statement (:mod:`~ccgen.generator.program.abreast`).
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Collection

from .links import GROUND, Link
from .mechanism import Mechanism

MOST_HUBS = 4
"""Links, at most, that are taken out to see what falls apart: a body, a shaft, and two more."""

LEAST_LINKS = 3
"""Links of a module for whose sake coordinates that are zero become parameters: the equations of fewer are short."""

ROUNDED = 1e-9
"""Of a link's size: what a coordinate that is zero in another link may have been made by rounding. Drawings are written
with nine digits or more, and no part is made to a thousandth of that."""

Module = tuple[int, ...]


def alike(mechanism: Mechanism) -> tuple[Module, ...]:
    """Sets of links that look like each other, in the order of their first links; empty where none do.

    The ground and the links with the most joints are taken out, one after the other; what falls apart are modules. They
    look alike if their links have the same numbers of joints. As few links are taken out as make most others repeat.
    """
    return tuple(sorted(module for kind in kinds(mechanism) for module in kind))


def kinds(mechanism: Mechanism) -> tuple[tuple[Module, ...], ...]:
    """The same, each kind of modules by itself."""
    near: dict[int, list[int]] = {k: [] for k in range(len(mechanism.links))}
    for joint in mechanism.joints:
        one, other = joint.first.link, joint.second.link
        for here, there in ((one, other), (other, one)):
            if here != GROUND:
                near[here].append(there)
    hubs = sorted(near, key=lambda link: (-len(near[link]), link))[:MOST_HUBS]
    best: tuple[tuple[Module, ...], ...] = ()
    saved = 0
    for count in range(len(hubs) + 1):
        found = _repeated(near, {GROUND, *hubs[:count]})
        repeats = sum(len(module) for kind in found for module in kind[1:])
        if repeats > saved:
            best, saved = found, repeats
    return best


def varied(mechanism: Mechanism) -> frozenset[tuple[int, str, str]]:
    """Coordinates that are zero in one module and rounding in another like it: link, point and axis.

    The point is "" for the centre of mass. With a parameter for each of them, the modules have equal equations. Only
    links with the same named points, in the same places of their modules, are compared.
    """
    found = set()
    for kind in (kind for kind in kinds(mechanism) if len(kind[0]) >= LEAST_LINKS):
        for links in zip(*kind, strict=True):
            twins = {k: _coordinates(mechanism.links[k]) for k in links}
            first, *others = twins.values()
            if any(other.keys() != first.keys() for other in others):
                continue
            size = max((abs(value) for twin in twins.values() for value in twin.values()), default=0.0)
            for key in first:
                values = [abs(twin[key]) for twin in twins.values()]
                if 0.0 < max(values) <= ROUNDED * size:
                    found |= {(k, *key) for k in links if not twins[k][key]}
    return frozenset(found)


def _coordinates(link: Link) -> dict[tuple[str, str], float]:
    """Coordinates of a link's points (m), zero where they are no parameters."""
    points = dict(link.points) if link.massless else {"": link.com, **link.points}
    return {(name, axis): value for name, p in points.items() for axis, value in zip("xy", p.values(), strict=True)}


def _repeated(near: dict[int, list[int]], out: Collection[int]) -> tuple[tuple[Module, ...], ...]:
    """What the mechanism falls into without the links ``out``, by kinds of which there are several."""
    modules: list[Module] = []
    seen = set(out)
    for start in near:
        if start in seen:
            continue
        found, waiting = {start}, [start]
        while waiting:
            new = [k for k in near[waiting.pop()] if k not in out and k not in found]
            found.update(new)
            waiting += new
        seen |= found
        modules.append(tuple(sorted(found)))
    by_kind: dict[object, list[Module]] = defaultdict(list)
    for module in modules:
        inside = set(module)
        joints = Counter((len(near[k]), sum(other in inside for other in near[k])) for k in module)
        by_kind[tuple(sorted(joints.items()))].append(module)
    return tuple(tuple(kind) for kind in by_kind.values() if len(kind) > 1)
