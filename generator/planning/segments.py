"""Long loops cut into equal segments, whose equations go side by side (theory, section 4.13)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator
from itertools import pairwise

from ..mechanism.links import Point
from ..mechanism.mechanism import Mechanism
from ..mechanism.topology import Cut, Topology, recut

SEGMENTS = 4
"""As many as there are lanes in a vector of modules (``program/routine.py``)."""

LEAST_LINKS = 5
"""Links of a segment, at least: with fewer, states side by side take longer than from tip to root."""

APART = 10.0
"""Times that masses, or inertias, of the links may differ. A light link at the end of a segment that is alone with its
acceleration costs digits: rounding is at most 7e-15 of the accelerations at 10, 3e-14 at 100, 2e-13 at 1000, where the
order from tip to root keeps 2e-15."""

Segment = tuple[int, ...]


def in_segments(
    mechanism: Mechanism, topology: Topology, driven: Collection[int]
) -> tuple[Topology, tuple[Segment, ...]] | None:
    """The longest row of links alike in a loop, cut into segments, each from its inner end outwards.

    The loop is cut where the row ends instead of in its middle, so that all segments run the same way. ``None`` where
    no loop has a row that is long enough on both sides of its cut pin.
    """
    search = _Search(mechanism, topology, driven)
    found = [one for cut in topology.cuts for one in search.rows(cut)]
    if not found:
        return None
    row, recut_ = max(found, key=lambda one: len(one[0]))
    length = len(row) // SEGMENTS
    outer = row[len(row) - SEGMENTS * length :]
    return recut_, tuple(outer[i : i + length] for i in range(0, len(outer), length))


class _Search:
    def __init__(self, mechanism: Mechanism, topology: Topology, driven: Collection[int]) -> None:
        self.mechanism, self.topology, self.driven = mechanism, topology, driven
        self.branches = {branch.link: branch for branch in topology.branches}
        self.degree = Counter(ref.link for joint in mechanism.joints for ref in (joint.first, joint.second))

    def rows(self, cut: Cut) -> Iterator[tuple[Segment, Topology]]:
        """Rows of links alike through a cut pin, long enough for segments, each with the loop cut at its end instead.

        Equal segments need that joint's first side to be theirs, as it is at joints between segments.
        """
        if cut.kind != "revolute":
            return
        sides = [self._inwards(ref.link) for ref in (cut.first, cut.second)]
        if not all(sides) or sum(map(len, sides)) < SEGMENTS * LEAST_LINKS:
            return
        for near, far in (sides, sides[::-1]):
            joint = self.branches[far[-1]].joint
            if self.mechanism.joints[joint].first.link == far[-1]:
                turned = recut(self.mechanism, self.topology, joint, cut.joint)
                row = self._alike(turned, (*reversed(near), *far))
                if len(row) >= SEGMENTS * LEAST_LINKS:
                    yield row, turned

    def _inwards(self, tip: int) -> list[int]:
        """Links from a tip inwards that hang from pins which turn as they will, and are joined once more.

        Each resists every motion of its own: the ends of segments have no others that would do it for them.
        """
        row = []
        while tip in self.branches and self.degree[tip] == 2 and self.mechanism.links[tip].inertia is not None:
            branch = self.branches[tip]
            if branch.kind != "revolute" or branch.joint in self.driven:
                break
            row.append(tip)
            tip = branch.parent
        return row

    def _alike(self, topology: Topology, row: Segment) -> Segment:
        """The outer links of a row as far as the same coordinates are zero in each, and masses are not far apart."""
        branches = {branch.link: branch for branch in topology.branches}
        cut = next(cut for cut in topology.cuts if cut.first.link == row[-1])
        outer = {a: branches[b].attach for a, b in pairwise(row)} | {row[-1]: cut.first.point}
        found: list[int] = []
        shape, masses, inertias = None, list[float](), list[float]()
        for k in reversed(row):
            link = self.mechanism.links[k]
            own = tuple(_zeros(p) for p in (link.points[branches[k].inboard], link.points[outer[k]], link.com))
            masses.append(link.mass.value if link.mass else 0.0)
            inertias.append(link.inertia.value if link.inertia else 0.0)
            if own != (shape or own) or any(max(x) > APART * min(x) for x in (masses, inertias)):
                break
            shape = own
            found.append(k)
        return tuple(reversed(found))


def _zeros(point: Point) -> tuple[bool, bool]:
    return point.x is None, point.y is None
