"""The part of a package's data that says where runs begin: with the scene's own values, and with others."""

from __future__ import annotations

from collections.abc import Sequence

from ..mechanism.mechanism import Mechanism
from ..mechanism.topology import Topology
from ..mechanism.totals import total
from ..scene.scene import Kept, Start

Coordinate = tuple[str, str | int]


def coordinates(mechanism: Mechanism, topology: Topology) -> list[Coordinate]:
    """What each coordinate is: x or y of a link's frame, the angle of a link, or the length along a joint's line."""
    root: list[Coordinate] = [("x", topology.root), ("y", topology.root)] if topology.floating else []
    angles = [("angle", k) for k in range(len(mechanism.links)) if topology.leader(k) == k]
    slides = sorted(branch.joint for branch in topology.branches if branch.slides)
    return [*root, *angles, *(("slide", mechanism.joints[joint].name) for joint in slides)]


def start_data(mechanism: Mechanism, topology: Topology, start: Start) -> dict[str, object]:
    """The start, and what becomes of it with other values of parameters.

    Coordinates are weighed as the generator weighs the links' angles and the lengths along lines, in units of its
    longest arm: links that turn alike count together. Lengths of joints at which loops are cut are no coordinates;
    where they would count, the start with other values is the nearest to that with the scene's own.
    """
    named = coordinates(mechanism, topology)
    idle = {one.joint for one in topology.implied}
    lines = [joint.name for k, joint in enumerate(mechanism.joints) if joint.slides and k not in idle]
    whole = {*lines} <= {of for kind, of in named if kind == "slide"}
    return {
        "poses": [list(pose) for pose in start.poses],
        "velocities": [list(velocity) for velocity in start.velocities],
        "kept_places": _kept(named, mechanism, topology, start.kept_places),
        "kept_rates": _kept(named, mechanism, topology, start.kept_rates),
        "weights": [_weight(one, mechanism, topology, start) for one in named],
        "sketch": [_wanted(one, mechanism, topology, start, lines) for one in named] if start.wanted and whole else [],
        "kept_drives": [*start.kept_drives],
        "smallest_rates": not start.sketched_rates and (whole or not start.free_rates),
    }


def _alike(link: int, mechanism: Mechanism, topology: Topology) -> list[int]:
    """The links that turn as one that has an angle."""
    return [k for k in range(len(mechanism.links)) if topology.leader(k) == link]


def _weight(of: Coordinate, mechanism: Mechanism, topology: Topology, start: Start) -> float:
    kind, name = of
    if kind == "angle":
        return float(len(_alike(int(name), mechanism, topology)))
    return 1.0 / start.unit**2 if kind == "slide" else 1.0


def _wanted(of: Coordinate, mechanism: Mechanism, topology: Topology, start: Start, lines: Sequence[str]) -> float:
    """What the sketch has; of links that turn alike the mean of what it has for each."""
    kind, name = of
    if kind == "slide":
        return start.unit * start.wanted[len(mechanism.links) + lines.index(str(name))]
    link = int(name)
    if kind != "angle":
        return start.poses[link][("x", "y").index(kind)]
    alike = _alike(link, mechanism, topology)
    return total(start.wanted[one] - (start.poses[one][2] - start.poses[link][2]) for one in alike) / len(alike)


def _kept(named: list[Coordinate], mechanism: Mechanism, topology: Topology, entries: Sequence[Kept]) -> list[int]:
    """Which coordinates these are; a length that is none, as along the line of a cut joint, is left out."""
    wanted: list[Coordinate] = [
        (kind, topology.leader(k) if kind == "angle" else mechanism.joints[k].name) for kind, k in entries
    ]
    return sorted({named.index(one) for one in wanted if one in named})
