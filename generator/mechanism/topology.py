"""Spanning tree and cut joints: how the closed chains are cut open virtually.

Each link of a branch waits for the one outboard of it, so short branches make fast equations: the tree is rooted at the
ground, or at a centre of the graph when nothing holds the mechanism, and grown breadth-first, which leaves each loop
cut at the joint farthest from the root. Prismatic joints come into the tree before others, because a link that only
slides along another needs no angle of its own; joints of links without mass come next, because such a link must carry
others; pins in slots come last, because cut open they cost one closure row and in the tree two coordinates.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from dataclasses import dataclass

import networkx as nx

from .implied import Implied, implied
from .joints import Joint, Kind, PointRef
from .links import GROUND, Parameter
from .mechanism import Mechanism
from .meshes import Mesh


@dataclass(frozen=True)
class Branch:
    """``link`` hangs from ``parent`` by ``joint``: its point ``inboard`` lies on the parent's point ``attach``.

    If the joint slides, one of both slides along a line of the other: of the parent when ``outwards``, which is to say
    that the joint's first side is the parent's.
    """

    link: int
    parent: int
    joint: int
    inboard: str
    attach: str
    kind: Kind = "revolute"
    outwards: bool = True

    @property
    def slides(self) -> bool:
        return self.kind in ("prismatic", "pin-in-slot")

    @property
    def follows(self) -> bool:
        """Whether the link turns as its parent does and has no angle of its own."""
        return self.kind in ("prismatic", "weld")

    @property
    def owner(self) -> int:
        """The link that a sliding joint's line turns with; where both turn alike, the parent."""
        return self.link if self.kind == "pin-in-slot" and not self.outwards else self.parent


@dataclass(frozen=True)
class Cut:
    """A joint left out of the tree: its two sides, and the link ``meeting`` where their branches meet.

    ``rank`` enters the order of multipliers alone, so that those of segments have the same order in each; it is 0 for
    all but joints between segments. ``gate`` is the parameter that is 1 while the joint holds and 0 while it is open,
    of one that lets go or takes hold; ``arm`` (m) is what an angle that it holds is multiplied by to be a length.
    """

    joint: int
    first: PointRef
    second: PointRef
    meeting: int
    kind: Kind = "revolute"
    rank: int = 0
    gate: Parameter | None = None
    arm: float = 1.0

    @property
    def turns_alike(self) -> bool:
        """Whether it holds an angle that the tree does not: what a prismatic joint with a gate does, and a weld."""
        return self.kind in ("prismatic", "weld") and self.gate is not None

    @property
    def rows(self) -> tuple[str, ...]:
        """Directions of the closure rows: ``x`` and ``y`` of the fixed frame, or ``n`` across the line of a joint that
        slides, and ``a`` of an angle that it holds. A prismatic joint that is cut closes a ring of such joints, whose
        links turn alike, unless it has a gate: nothing is left to close about their angles."""
        way = ("n",) if self.slides else ("x", "y")
        return (*way, "a") if self.turns_alike else way

    @property
    def slides(self) -> bool:
        return self.kind in ("prismatic", "pin-in-slot")


@dataclass(frozen=True)
class MeshRow:
    """The closure row of a mesh; its multiplier has the number ``joint``, behind those of all joints.

    The branches of all links in it meet at ``meeting``, and so does that of a sliding joint's parent: what the row
    depends on goes further out.
    """

    mesh: Mesh
    joint: int
    meeting: int
    rank: int = 0

    @property
    def rows(self) -> tuple[str, ...]:
        return ("m",)


@dataclass(frozen=True)
class Topology:
    """The virtual open chain. ``root`` is the ground or the floating root link; ``branches`` run from root to tips.

    ``implied`` joints are in neither tree nor cuts: others hold what they hold. ``meshes`` are closed as cuts are.
    """

    root: int
    branches: tuple[Branch, ...]
    cuts: tuple[Cut, ...]
    implied: tuple[Implied, ...] = ()
    meshes: tuple[MeshRow, ...] = ()

    @property
    def floating(self) -> bool:
        return self.root != GROUND

    @property
    def rows(self) -> tuple[tuple[int, str], ...]:
        """The closure rows in order: cut joint and direction, then those of the meshes."""
        of_cuts = ((cut.joint, row) for cut in self.cuts for row in cut.rows)
        return (*of_cuts, *((mesh.joint, row) for mesh in self.meshes for row in mesh.rows))

    @property
    def partners(self) -> tuple[int, ...]:
        """Per closure row the other row of the same pin, or the row itself."""
        first = {joint: index for index, (joint, row) in reversed(list(enumerate(self.rows))) if row in ("x", "y")}
        return tuple(
            2 * first[joint] + 1 - index if row in ("x", "y") else index for index, (joint, row) in enumerate(self.rows)
        )

    @property
    def links(self) -> frozenset[int]:
        """Links of the tree, the root among them."""
        return frozenset({self.root} | {branch.link for branch in self.branches})

    def sides(self, joints: int) -> tuple[int, ...]:
        """Per joint of so many on which link the equations have its force: 1 on the second of the joint, the outboard
        one of the tree or the second side of a joint that is cut or implied, and -1 on the first."""
        inwards = {branch.joint for branch in self.branches if not branch.outwards}
        return tuple(-1 if joint in inwards else 1 for joint in range(joints))

    def branch(self, link: int) -> Branch:
        """The branch that carries ``link``; the root has none (``KeyError``)."""
        for branch in self.branches:
            if branch.link == link:
                return branch
        raise KeyError(link)

    def severed(self, link: int) -> Cut:
        """The joint that carries ``link``, cut open as well; its branches meet at the root.

        Its rank is below those of joints further out, and of all others.
        """
        branch, rank = self.branch(link), len(self.path(link)) - len(self.branches) - 2
        first, second = PointRef(branch.parent, branch.attach), PointRef(link, branch.inboard)
        return Cut(branch.joint, first, second, self.root, branch.kind, rank)

    def leader(self, link: int) -> int:
        """The link whose angle ``link`` follows: itself, unless a prismatic joint carries it (the ground: none)."""
        while link != self.root and (branch := self.branch(link)).follows:
            link = branch.parent
        return link

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


def span(mechanism: Mechanism, driven: Collection[int] = ()) -> Topology:
    """Spanning tree of short branches and the joints it leaves cut; ``driven`` joints come into the tree first, and
    those that let go or take hold never.

    Raises ``ValueError`` naming the links that no chain of joints connects with the rest (with the ground, if any joint
    is on it).
    """
    idle = implied(mechanism, driven)
    held = {found.joint for found in idle} | {*mechanism.gates}
    usable = [index for index in range(len(mechanism.joints)) if index not in held]
    graph = nx.MultiGraph()
    graph.add_nodes_from(range(len(mechanism.links)))
    for index in usable:
        joint = mechanism.joints[index]
        graph.add_edge(joint.first.link, joint.second.link, key=index)
    root = GROUND if GROUND in graph else _centre(graph)
    kept = _keep(mechanism, usable, _grow(mechanism, root, usable), driven)
    tree = hang(mechanism, root, kept, idle)
    reached = {root} | {branch.link for branch in tree.branches}
    missing = [link.name for k, link in enumerate(mechanism.links) if k not in reached]
    if missing:
        raise ValueError(
            f"not connected with {mechanism.link_name(root)}: {', '.join(missing)}; add the missing joints"
        )
    return tree


def recut(mechanism: Mechanism, topology: Topology, opened: int, closed: int) -> Topology:
    """The topology with the joint ``opened`` of a loop cut in the place of the loop's cut joint ``closed``."""
    kept = ({branch.joint for branch in topology.branches} | {closed}) - {opened}
    return hang(mechanism, topology.root, kept, topology.implied)


def hang(mechanism: Mechanism, root: int, kept: Collection[int], idle: tuple[Implied, ...]) -> Topology:
    """The tree of the joints ``kept`` as it hangs from ``root``; other joints are cut, but those that are ``idle``."""
    branches = _grow(mechanism, root, sorted(kept))
    tree = Topology(root, branches, (), idle)
    reached = {root} | {branch.link for branch in branches}
    paths = {link: tree.path(link) for link in reached}
    out = {branch.joint for branch in branches} | {found.joint for found in idle}
    cuts = []
    for index, joint in enumerate(mechanism.joints):
        if index not in out and joint.first.link in reached and joint.second.link in reached:
            inwards = set(paths[joint.first.link])
            meeting = next(link for link in paths[joint.second.link] if link in inwards)
            gate = mechanism.gates.get(index)
            arm = _longest_arm(mechanism) if gate else 1.0
            cuts.append(Cut(index, joint.first, joint.second, meeting, joint.kind, gate=gate, arm=arm))
    meshes = [_mesh_row(mechanism, tree, number) for number in range(len(mechanism.meshes))] if branches else []
    return Topology(tree.root, tree.branches, tuple(cuts), tree.implied, tuple(meshes))


def _longest_arm(mechanism: Mechanism) -> float:
    """About how long (m) the longest arm of a link is, as a power of two: a product with it has no rounding."""
    size = max((math.hypot(*point.values()) for link in mechanism.links for point in link.points.values()), default=0.0)
    return 2.0 ** round(math.log2(size)) if size else 1.0


def _mesh_row(mechanism: Mechanism, tree: Topology, number: int) -> MeshRow:
    """The row of a mesh, and where the branches of what is in it meet."""
    mesh, branches = mechanism.meshes[number], {branch.joint: branch for branch in tree.branches}
    links = set(mesh.levers())
    for joint in mesh.slides:
        if joint in branches:
            links |= {branches[joint].link, branches[joint].parent}
    paths = [tree.path(link) if link in tree.links else (tree.root,) for link in sorted(links)]
    meeting = next(link for link in paths[0] if all(link in path for path in paths))
    return MeshRow(mesh, len(mechanism.joints) + number, meeting)


def _grow(mechanism: Mechanism, root: int, usable: Iterable[int]) -> tuple[Branch, ...]:
    """Branches breadth-first from the root over the ``usable`` joints."""
    joints = [(index, mechanism.joints[index]) for index in usable]
    branches, reached, waiting = [], {root}, [root]
    while waiting:
        parent = waiting.pop(0)
        for index, joint in joints:
            if parent not in (joint.first.link, joint.second.link):
                continue
            outwards = joint.first.link == parent
            near, far = (joint.first, joint.second) if outwards else (joint.second, joint.first)
            if far.link not in reached:
                reached.add(far.link)
                waiting.append(far.link)
                branches.append(Branch(far.link, parent, index, far.point, near.point, joint.kind, outwards))
    return tuple(branches)


def _keep(mechanism: Mechanism, usable: Iterable[int], grown: tuple[Branch, ...], driven: Collection[int]) -> set[int]:
    """Joints of the tree: the preferred ones that form no ring (Kruskal's algorithm), ``grown`` ones before others."""
    order = {branch.joint: place for place, branch in enumerate(grown)}
    first = {*driven, *(joint for mesh in mechanism.meshes for joint in mesh.slides)}

    def preference(index: int) -> tuple[int, int, int]:
        rank = 0 if index in first else _rank(mechanism, mechanism.joints[index])
        return rank, order.get(index, len(order)), index

    piece = {link: link for link in range(GROUND, len(mechanism.links))}

    def find(link: int) -> int:
        while piece[link] != link:
            piece[link] = link = piece[piece[link]]
        return link

    kept = set()
    for index in sorted(usable, key=preference):
        ends = [find(side.link) for side in (mechanism.joints[index].first, mechanism.joints[index].second)]
        if ends[0] != ends[1]:
            piece[ends[0]] = ends[1]
            kept.add(index)
    return kept


def _rank(mechanism: Mechanism, joint: Joint) -> int:
    if not joint.turns:
        return 0
    if joint.kind == "pin-in-slot":
        return 3
    links = [side.link for side in (joint.first, joint.second) if side.link != GROUND]
    return 1 if any(mechanism.links[link].massless for link in links) else 2


def _centre(graph: nx.MultiGraph) -> int:
    """The centre of the largest connected part with the lowest index."""
    part = max(nx.connected_components(graph), key=lambda nodes: (len(nodes), -min(nodes)))
    return int(min(nx.center(graph.subgraph(part))))
