"""Long loops cut into equal segments, whose equations go side by side (theory, section 4.13)."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from itertools import pairwise

from ..mechanism.links import Point
from ..mechanism.mechanism import Mechanism
from ..mechanism.topology import Cut, Topology, recut

SEGMENTS = 4
"""As many as there are lanes in a vector of modules (``program/routine.py``)."""

LEAST_LINKS = 5
"""Links of a segment, at least: with fewer, states side by side take longer than from tip to root."""

APART = 10.0
"""Times that masses, or inertias, of the links may differ. A light link at the end of a segment, or beside it, that is
alone with its acceleration costs digits: rounding is at most 7e-15 of the accelerations at 10, 3e-14 at 100, 2e-13 at
1000, where the order from tip to root keeps 2e-15."""

COMPACT = 0.03
"""Least share that an inertia has of the mass times the square of the distance from its centre to the farther pin (a
uniform rod: 1/3). In a straight row of links that are more compact than that, hardly anything resists motions across
it that turn all links about their centres (theory, section 4.13)."""

FIRM = 1e-4
"""Φ⊥² over m Φ∥ below which the state is solved on another way: rounding is at most ε / FIRM where a segment feels the
mass Φ∥ along its row, Φ⊥ across it, and its first link has the mass m (theory, section 4.13). Segments of 800 uniform
rods may be straight, and of 75 links that are as compact as they may be."""

FAINT = 1e-3
"""J over m l² of a link at the outer side of a joint that is cut between segments (J about its inner pin, l from there
to the joint, m the mass of the link across the joint) below which the state is solved on another way: alone, such a
link gives way so easily that the joint's multipliers lose about ε / FAINT (see :data:`APART`)."""

Segment = tuple[int, ...]


def in_segments(
    mechanism: Mechanism, topology: Topology, driven: Collection[int]
) -> tuple[Topology, tuple[Segment, ...]] | None:
    """The longest row of links alike in a loop, cut into segments, each from its inner end outwards.

    The loop is cut where the row ends instead of in its middle, so that all segments run the same way. ``None`` where
    no loop has a row that is long enough on both sides of its cut pin.
    """
    search = _Search(mechanism, topology, driven)
    found = [one for cut in topology.cuts if cut.gate is None for one in search.rows(cut)]
    if not found:
        return None
    row, recut_ = max(found, key=lambda one: len(one[0]))
    length = len(row) // SEGMENTS
    outer = row[len(row) - SEGMENTS * length :]
    return recut_, tuple(outer[i : i + length] for i in range(0, len(outer), length))


def same_values(mechanism: Mechanism, topology: Topology, segments: Sequence[Segment]) -> bool:
    """Whether the links at the same place of all segments have the same mass, inertia and lengths."""
    branches = {branch.link: branch for branch in topology.branches}
    outer = {branch.parent: branch.attach for branch in topology.branches}
    outer |= {side.link: side.point for cut in topology.cuts for side in (cut.first, cut.second)}

    def values(k: int) -> tuple[object, ...]:
        link = mechanism.links[k]
        points = (link.com, link.points[branches[k].inboard], link.points[outer[k]])
        amounts = (link.mass, link.inertia)
        return (*(x and x.value for x in amounts), *(point.values() for point in points))

    return all(len({values(k) for k in links}) == 1 for links in zip(*segments, strict=True))


class _Search:
    def __init__(self, mechanism: Mechanism, topology: Topology, driven: Collection[int]) -> None:
        self.mechanism, self.topology, self.driven = mechanism, topology, driven
        self.branches = {branch.link: branch for branch in topology.branches}
        self.degree = Counter(ref.link for joint in mechanism.joints for ref in (joint.first, joint.second))

    def rows(self, cut: Cut) -> Iterator[tuple[Segment, Topology]]:
        """Rows of links alike through a cut pin, long enough for segments, each with the loop cut at its end instead.

        Equal segments need that joint's first side to be theirs, as it is at joints between segments. Where the link on
        its other side is unlike the row, the row's last link stays there.
        """
        if cut.kind != "revolute":
            return
        sides = [self._inwards(ref.link) for ref in (cut.first, cut.second)]
        if not all(sides) or sum(map(len, sides)) < SEGMENTS * LEAST_LINKS:
            return
        for near, whole in (sides, sides[::-1]):
            for far in (whole, whole[:-1]):
                joint = self.branches[far[-1]].joint if far else cut.joint
                if self.mechanism.joints[joint].first.link != (far[-1] if far else near[0]):
                    break
                turned = recut(self.mechanism, self.topology, joint, cut.joint)
                row = _Row(self.mechanism, turned, joint, (*reversed(near), *far))
                if row.is_held():
                    if len(row.links) >= SEGMENTS * LEAST_LINKS:
                        yield row.links, turned
                    break

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


class _Row:
    """The outer links of a row as far as segments may take them: a row from the root's side to the joint ``end`` that
    is cut, as it hangs in a topology.

    What a segment hangs from, and what its outer end is joined to, accelerate without it until the multipliers go. So a
    link that is light, compact or without inertia stays away from the ends of segments on either side. Not so the root:
    it goes last, when all others resist its motion too.
    """

    def __init__(self, mechanism: Mechanism, topology: Topology, end: int, row: Segment) -> None:
        self.mechanism, self.row = mechanism, row
        self.branches = {branch.link: branch for branch in topology.branches}
        self.beyond = next(cut for cut in topology.cuts if cut.joint == end)
        self.outer = {a: self.branches[b].attach for a, b in pairwise(row)} | {row[-1]: self.beyond.first.point}
        self.links = self._carried(self._alike())

    def is_held(self) -> bool:
        """Whether the link on the other side of the cut may be joined to a segment's end."""
        other = self.beyond.second
        return other.link not in self.branches or self._suits(other.link, other.point, self.links)

    def _carried(self, found: Segment) -> Segment:
        """The links less the first one where segments would leave none of them over, and what carries it is unlike."""
        if found and len(found) % SEGMENTS == 0:
            branch = self.branches[found[0]]
            if branch.parent in self.branches and not self._suits(branch.parent, branch.attach, found):
                return found[1:]
        return found

    def _alike(self) -> Segment:
        """The outer links of the row as far as the same coordinates are zero in each, and none is light or compact."""
        found: list[int] = []
        shape = None
        for k in reversed(self.row):
            link = self.mechanism.links[k]
            own = tuple(
                _zeros(p) for p in (link.points[self.branches[k].inboard], link.points[self.outer[k]], link.com)
            )
            if own != (shape or own) or not self._suits(k, self.outer[k], found):
                break
            shape = own
            found.append(k)
        return tuple(reversed(found))

    def _suits(self, k: int, outer: str, others: Sequence[int]) -> bool:
        """Whether a link resists its motions as well as ``others`` do, alone with what hangs from it."""
        links = [self.mechanism.links[other] for other in (k, *others)]
        if links[0].mass is None or links[0].inertia is None:
            return False
        masses = [link.mass.value for link in links if link.mass]
        inertias = [link.inertia.value for link in links if link.inertia]
        centre = links[0].com.values()
        arms = [math.dist(centre, links[0].points[p].values()) for p in (self.branches[k].inboard, outer)]
        compact = inertias[0] < COMPACT * masses[0] * max(arms) ** 2
        return not compact and all(max(x) <= APART * min(x) for x in (masses, inertias))


def _zeros(point: Point) -> tuple[bool, bool]:
    return point.x is None, point.y is None
