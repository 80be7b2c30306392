"""Long loops cut into equal segments, whose equations go side by side (theory, section 4.13)."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from ..mechanism.links import Point
from ..mechanism.mechanism import Mechanism
from ..mechanism.topology import Cut, Topology, recut

SEGMENTS = 4
"""As many as there are lanes in a vector of modules."""

LEAST_LINKS = 5
"""Links of a segment, at least: what its ends cost is what two or three links do."""

Segment = tuple[int, ...]


def in_segments(
    mechanism: Mechanism, topology: Topology, driven: Collection[int]
) -> tuple[Topology, tuple[Segment, ...]] | None:
    """The longest row of equal links in a loop, cut into segments, each from its inner end outwards.

    The loop is cut where the row ends instead of in its middle, so that all segments run the same way. ``None`` where
    no loop has a row that is long enough.
    """
    found = [(row, cut, opened) for cut in topology.cuts for row, opened in _rows(mechanism, topology, cut, driven)]
    if not found:
        return None
    row, cut, opened = max(found, key=lambda one: (len(one[0]), -one[1].joint))
    length = len(row) // SEGMENTS
    if length < LEAST_LINKS:
        return None
    outer = row[len(row) - SEGMENTS * length :]
    segments = tuple(outer[i : i + length] for i in range(0, len(outer), length))
    return recut(mechanism, topology, opened, cut.joint), segments


def _rows(mechanism: Mechanism, topology: Topology, cut: Cut, driven: Collection[int]) -> Iterator[tuple[Segment, int]]:
    """The row of links through a cut pin, and the joint at its end, where it is to be cut instead.

    Equal segments need that joint's first side to be theirs, as it is at joints between segments.
    """
    sides = [_inwards(mechanism, topology, ref.link, driven) for ref in (cut.first, cut.second)]
    if cut.kind != "revolute" or not all(sides):
        return
    for near, far in (sides, sides[::-1]):
        joint = topology.branch(far[-1]).joint
        if mechanism.joints[joint].first.link == far[-1]:
            row = (*reversed(near), *far)
            turned = recut(mechanism, topology, joint, cut.joint)
            if _are_equal(mechanism, turned, row):
                yield row, joint


def _inwards(mechanism: Mechanism, topology: Topology, tip: int, driven: Collection[int]) -> list[int]:
    """Links from a tip inwards that hang from pins which turn as they will, and are joined once more."""
    degree: dict[int, int] = {}
    for joint in mechanism.joints:
        for ref in (joint.first, joint.second):
            degree[ref.link] = degree.get(ref.link, 0) + 1
    parents = {branch.link: branch for branch in topology.branches}
    row = []
    while tip in parents and degree[tip] == 2 and not mechanism.links[tip].massless:
        branch = parents[tip]
        if branch.kind != "revolute" or branch.joint in driven:
            break
        row.append(tip)
        tip = branch.parent
    return row


def _are_equal(mechanism: Mechanism, topology: Topology, row: Sequence[int]) -> bool:
    """Whether the equations of all links of the row read the same: whether the same coordinates are zero in each."""
    seen = set()
    for link, following in zip(row, (*row[1:], None), strict=True):
        points, branch = mechanism.links[link].points, topology.branch(link)
        if following is None:
            outer = next(cut.first.point for cut in topology.cuts if cut.first.link == link)
        else:
            outer = topology.branch(following).attach
        seen.add(tuple(map(_zeros, (points[branch.inboard], points[outer], mechanism.links[link].com))))
    return len(seen) == 1


def _zeros(point: Point) -> tuple[bool, bool]:
    return point.x is None, point.y is None
