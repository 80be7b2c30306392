"""Other spanning trees for large mechanisms: where they are cut and rooted, by what the order from tip to root takes.

A tree is judged by the operations of that order on it, counted link by link as in ``pattern.py``, but on whole cut
joints, and as if all loops that a branch leaves open shared entries with one another. That takes a hundredth of the
time, and of two trees the one with fewer is nearly always the one with fewer by the pattern too.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from itertools import takewhile

from ..mechanism.links import GROUND
from ..mechanism.mechanism import Mechanism
from ..mechanism.topology import Topology, hang
from .fill import by_least_fill
from .pattern import pivot_cost

LARGE = 2000
"""Operations from tip to root, by the pattern, up to which the tree of short branches is kept."""

GAIN = 1.03
"""Times fewer operations for which the tree is left: with it, the multipliers are those of other joints."""

WORK = 1_000_000
"""Links of all trees that are looked at for one mechanism, and pairs of loops that share entries at them: they take
about a second. A search that comes to it ends with the best tree so far."""

OWN, CARRIED, ROW = 12, 26, 12
"""Operations of a link's own terms, of handing its form on, and of each row of a loop that is open in it."""


@dataclass(frozen=True)
class _Tree:
    root: int
    kept: frozenset[int]


def other_tree(mechanism: Mechanism, topology: Topology, driven: Collection[int]) -> Topology:
    """The spanning tree with the fewest operations that is found; ``topology`` itself where none has fewer.

    From a tree, the joints of one loop after another are tried as its cut, and the root moves to a neighbour, as long
    as that gains. The first start is ``topology``; then, for floating mechanisms, the tree of short branches from each
    link, as far as :data:`WORK` allows. Only pins are exchanged, and none that is driven. Where a link is without mass
    or inertia the tree stays: what resists its turning depends on the tree; and where joints let go.
    """
    if mechanism.gates or any(link.mass is None or link.inertia is None for link in mechanism.links):
        return topology
    search = _Search(mechanism, topology, driven)
    first = best = _Tree(topology.root, frozenset(branch.joint for branch in topology.branches))
    cost = search.operations(first)
    for start in search.starts(first):
        found = search.improved(start)
        if found[0] < cost:
            cost, best = found
    return topology if best == first else hang(mechanism, best.root, best.kept, topology.implied)


class _Search:
    def __init__(self, mechanism: Mechanism, topology: Topology, driven: Collection[int]) -> None:
        idle = {found.joint for found in topology.implied}
        joints = {index: joint for index, joint in enumerate(mechanism.joints) if index not in idle}
        self.floating, self.work = topology.floating, 0
        self.ends = {index: (joint.first.link, joint.second.link) for index, joint in joints.items()}
        self.rows = {index: 2 if joint.kind == "revolute" else 1 for index, joint in joints.items()}
        self.fixed = {index for index, joint in joints.items() if joint.kind != "revolute" or index in driven}
        reached = (topology.root, *(branch.link for branch in topology.branches))
        self.near: dict[int, list[tuple[int, int]]] = {link: [] for link in reached}
        for index, (a, b) in self.ends.items():
            self.near[a].append((index, b))
            self.near[b].append((index, a))

    def starts(self, first: _Tree) -> Iterator[_Tree]:
        """``first``, and where loops can share links, what grows breadth-first from each link, while there is time."""
        yield first
        everything = frozenset(self.ends)
        several = len(everything) > len(self.near)
        for root in sorted(self.near) if several and self.floating and not self.fixed else ():
            if self.work > WORK:
                return
            inwards = self._hang(_Tree(root, everything))
            yield _Tree(root, frozenset(joint for link, (joint, _) in inwards.items() if link != root))

    def improved(self, tree: _Tree) -> tuple[float, _Tree]:
        """What exchanges of joints and moves of the root lead to, each of which gains."""
        best, before = (self.operations(tree), tree), math.inf
        while best[0] < before and self.work <= WORK:
            before = best[0]
            for cut in [joint for joint in self.ends if joint not in best[1].kept | self.fixed]:
                if self.work > WORK:
                    break
                tree = best[1]
                others = (_Tree(tree.root, tree.kept - {joint} | {cut}) for joint in self._round(cut, tree))
                best = self._least(best, others)
            moved = math.inf
            while self.floating and best[0] < moved and self.work <= WORK:
                moved, tree = best
                neighbours = [link for joint, link in self.near[tree.root] if joint in tree.kept]
                best = self._least(best, (_Tree(link, tree.kept) for link in neighbours))
        return best

    def _least(self, best: tuple[float, _Tree], others: Iterable[_Tree]) -> tuple[float, _Tree]:
        """The cheapest, and of trees that cost the same the first, as far as there is time to look at them."""
        looked_at = takewhile(lambda _: self.work <= WORK, others)
        return min([best, *((self.operations(tree), tree) for tree in looked_at)], key=lambda found: found[0])

    def _hang(self, tree: _Tree) -> dict[int, tuple[int, int]]:
        """The joint and the link inwards of each link that the tree reaches, breadth-first; the root is its own."""
        self.work += len(self.near)
        inwards, waiting = {tree.root: (-1, tree.root)}, [tree.root]
        for link in waiting:
            for joint, other in self.near[link]:
                if joint in tree.kept and other not in inwards:
                    inwards[other] = joint, link
                    waiting.append(other)
        return inwards

    def _round(self, cut: int, tree: _Tree) -> list[int]:
        """Joints of the tree, other than fixed ones, on the way between the two sides of a cut."""
        first, second = self.ends[cut]
        inwards, found = self._hang(_Tree(first, tree.kept)), list[int]()
        while second != first:
            joint, second = inwards[second]
            found.append(joint)
        return [joint for joint in found if joint not in self.fixed]

    def operations(self, tree: _Tree) -> float:
        """About how many the order from tip to root takes."""
        inwards = self._hang(tree)
        depth = {tree.root: 0}
        for link, (_, parent) in inwards.items():
            depth[link] = depth[parent] + (link != tree.root)
        sides: dict[int, list[int]] = {}
        meeting: dict[int, list[int]] = {}
        for cut in [joint for joint in self.ends if joint not in tree.kept]:
            a, b = self.ends[cut]
            for link in (a, b):
                sides.setdefault(link, []).append(cut)
            while a != b:
                if depth[a] < depth[b]:
                    a, b = b, a
                a = inwards[a][1]
            meeting.setdefault(a, []).append(cut)
        open_loops: dict[int, list[set[int]]] = {}
        cost = 0.0
        for link in reversed(inwards):
            shared = {cut: {cut} for cut in sides.get(link, ())}
            for loops in open_loops.pop(link, ()):
                self.work += len(loops) ** 2
                for cut in loops:
                    shared[cut] = shared.get(cut, set()) | loops
            cost += self._close(meeting.get(link, []), shared, 0 if link == GROUND else 3)
            rows = sum(self.rows[cut] for cut in shared)
            if link != GROUND:
                cost += OWN
            if link != tree.root:
                cost += pivot_cost(1, 2 + rows) + CARRIED + ROW * rows
                open_loops.setdefault(inwards[link][1], []).append(set(shared))
        return cost

    def _close(self, waiting: list[int], shared: dict[int, set[int]], accelerations: int) -> float:
        """Eliminate loops in an order of least fill; ``shared`` says which share entries with which."""
        cost = 0.0
        for cut, others in by_least_fill(shared, waiting):
            self.work += len(waiting) + len(others) ** 2
            cost += pivot_cost(self.rows[cut], accelerations + sum(self.rows[other] for other in others))
        return cost
