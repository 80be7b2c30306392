"""Spanning tree and cut joints: how the closed chains are cut open virtually.

Each link of a branch waits for the one outboard of it, so short branches make fast equations: the tree is rooted at the
ground, or at a centre of the graph when nothing holds the mechanism, and grown breadth-first, which leaves each loop
cut at the joint farthest from the root.
"""

from __future__ import annotations

from dataclasses import dataclass

import networkx as nx

from .joints import PointRef
from .links import GROUND
from .mechanism import Mechanism


@dataclass(frozen=True)
class Branch:
    """``link`` hangs from ``parent`` by ``joint``: its point ``inboard`` lies on the parent's point ``attach``."""

    link: int
    parent: int
    joint: int
    inboard: str
    attach: str


@dataclass(frozen=True)
class Cut:
    """A joint left out of the tree: its two sides, and the link ``meeting`` where their branches meet."""

    joint: int
    first: PointRef
    second: PointRef
    meeting: int


@dataclass(frozen=True)
class Topology:
    """The virtual open chain. ``root`` is the ground or the floating root link; ``branches`` run from root to tips."""

    root: int
    branches: tuple[Branch, ...]
    cuts: tuple[Cut, ...]

    @property
    def floating(self) -> bool:
        return self.root != GROUND

    def branch(self, link: int) -> Branch:
        """The branch that carries ``link``; the root has none (``KeyError``)."""
        for branch in self.branches:
            if branch.link == link:
                return branch
        raise KeyError(link)

    def outboard(self, link: int) -> tuple[Branch, ...]:
        """Branches that hang directly from ``link``."""
        return tuple(branch for branch in self.branches if branch.parent == link)

    def path(self, link: int) -> tuple[int, ...]:
        """Links from ``link`` inwards to the root, both included."""
        parents = {branch.link: branch.parent for branch in self.branches}
        found = [link]
        while found[-1] != self.root:
            found.append(parents[found[-1]])
        return tuple(found)


def span(mechanism: Mechanism) -> Topology:
    """Spanning tree of short branches and the joints it leaves cut.

    Raises ``ValueError`` naming the links that no chain of joints connects with the rest (with the ground, if any joint
    is on it).
    """
    graph = nx.MultiGraph()
    graph.add_nodes_from(range(len(mechanism.links)))
    for index, joint in enumerate(mechanism.joints):
        graph.add_edge(joint.first.link, joint.second.link, key=index)
    root = GROUND if GROUND in graph else _centre(graph)
    branches, used, reached = [], set(), {root}
    waiting = [root]
    while waiting:
        parent = waiting.pop(0)
        for index, joint in enumerate(mechanism.joints):
            ends = (joint.first, joint.second)
            if parent not in (ends[0].link, ends[1].link):
                continue
            near, far = ends if ends[0].link == parent else ends[::-1]
            if far.link in reached:
                continue
            reached.add(far.link)
            used.add(index)
            branches.append(Branch(far.link, parent, index, far.point, near.point))
            waiting.append(far.link)
    missing = [link.name for k, link in enumerate(mechanism.links) if k not in reached]
    if missing:
        raise ValueError(
            f"not connected with {mechanism.link_name(root)}: {', '.join(missing)}; add the missing joints"
        )
    tree = Topology(root, tuple(branches), ())
    paths = {link: tree.path(link) for link in reached}
    cuts = []
    for index, joint in enumerate(mechanism.joints):
        if index not in used:
            inwards = set(paths[joint.first.link])
            meeting = next(link for link in paths[joint.second.link] if link in inwards)
            cuts.append(Cut(index, joint.first, joint.second, meeting))
    return Topology(root, tuple(branches), tuple(cuts))


def _centre(graph: nx.MultiGraph) -> int:
    """The centre of the largest connected part with the lowest index."""
    part = max(nx.connected_components(graph), key=lambda nodes: (len(nodes), -min(nodes)))
    return int(min(nx.center(graph.subgraph(part))))
