"""What a plan costs, counted on the pattern of the forms: which entries are there, not what they are.

The same steps as in ``derive/gibbs.py`` are taken on sets of variables. An entry is ``GENERAL``, or a whole number
where it is that number in every configuration: the +1 and −1 of a joint's two sides, which vanish where both meet.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, field

from ..equations.names import A_X, A_Y, ALPHA, SLIDE, Variable, multiplier, turn
from ..mechanism.joints import PointRef
from ..mechanism.links import GROUND, Point
from ..mechanism.mechanism import Mechanism
from ..mechanism.topology import Branch, Topology
from .plan import Pivot, is_dyad

GENERAL = 0.5
"""An entry that is no constant."""

Entry = float
Pair = tuple[Variable, Variable]


@dataclass
class Pattern:
    """Entries of one link's form by pairs of variables, the smaller first; absent ones are zero."""

    entries: dict[Pair, Entry] = field(default_factory=dict)
    near: dict[Variable, set[Variable]] = field(default_factory=dict)

    def add(self, v: Variable, w: Variable, value: Entry) -> None:
        """Add to an entry; what is then zero in every configuration is no entry."""
        if value == 0:
            return
        key = (v, w) if v <= w else (w, v)
        old = self.entries.get(key, 0)
        total = GENERAL if GENERAL in (value, old) else old + value
        if total == 0:
            del self.entries[key]
            self.near[v].discard(w)
            self.near[w].discard(v)
        else:
            self.entries[key] = total
            self.near.setdefault(v, set()).add(w)
            self.near.setdefault(w, set()).add(v)

    def get(self, v: Variable, w: Variable) -> Entry:
        return self.entries.get((v, w) if v <= w else (w, v), 0)

    def touched(self, pivot: Pivot) -> set[Variable]:
        """Variables outside of the pivot that share an entry with it."""
        return set[Variable]().union(*(self.near.get(e, set()) for e in pivot)) - set(pivot)

    def drop(self, pivot: Pivot) -> None:
        """Take the pivot's entries away."""
        for e in pivot:
            for v in self.near.pop(e, set()):
                self.entries.pop((e, v) if e <= v else (v, e), None)
                if v in self.near:
                    self.near[v].discard(e)


Choose = Callable[[int, Pattern], tuple[Pivot, ...]]
"""Says for a link and the pattern of its gathered form which pivots go there, in order."""


class Sweep:
    """Takes the steps of the recursion for a mechanism on patterns; ``driven`` joints have a prescribed motion.

    ``severed`` links begin segments.
    """

    def __init__(
        self, mechanism: Mechanism, topology: Topology, driven: Collection[int], severed: Collection[int] = ()
    ) -> None:
        self.mechanism, self.topology, self.driven, self.severed = mechanism, topology, driven, severed
        self.cuts = (*topology.cuts, *map(topology.severed, severed))
        self.branches = {branch.link: branch for branch in topology.branches}
        self.outboard: dict[int, list[Branch]] = {}
        for branch in topology.branches:
            if branch.link not in severed:
                self.outboard.setdefault(branch.parent, []).append(branch)
        self.meshed: dict[int, list[Variable]] = {}
        self.along: dict[int, list[Variable]] = {}
        for row in topology.meshes:
            v = multiplier(row.joint, "m")
            for link in row.mesh.levers():
                self.meshed.setdefault(link, []).append(v)
            for joint in row.mesh.slides:
                self.along.setdefault(joint, []).append(v)
        self.sides: dict[int, list[tuple[int, PointRef, int]]] = {}
        for index, cut in enumerate(self.cuts):
            for ref, sign in ((cut.first, 1), (cut.second, -1)):
                self.sides.setdefault(ref.link, []).append((index, ref, sign))

    def has_angle(self, link: int) -> bool:
        """Whether the angular acceleration of the link is an unknown of its own."""
        branch = self.branches.get(link)
        return branch is None or not (branch.follows or (branch.joint in self.driven and not branch.slides))

    def slides(self, link: int) -> bool:
        """Whether the link slides along its joint's line as it will."""
        branch = self.branches.get(link)
        return branch is not None and branch.slides and branch.joint not in self.driven

    def run(self, choose: Choose, limit: float = math.inf) -> tuple[dict[int, tuple[Pivot, ...]], dict[int, float]]:
        """The pivots that ``choose`` names, and about how many operations they cost, link by link.

        Where that is more than ``limit`` in all, the pivots are not complete.
        """
        forms: dict[int, Pattern] = {}
        pivots, costs, total = {}, dict[int, float](), 0.0
        for link in [branch.link for branch in reversed(self.topology.branches)] + [self.topology.root]:
            pattern, gathered = self._gather(link, forms)
            chosen = choose(link, pattern)
            costs[link] = gathered + sum(self._eliminate(link, pattern, pivot) for pivot in chosen)
            total += costs[link]
            if total > limit:
                break
            pivots[link] = chosen
            forms[link] = self._handed_on(link, pattern)
        return pivots, costs

    # -- one link --------------------------------------------------------------------------------------------------

    def _gather(self, link: int, forms: dict[int, Pattern]) -> tuple[Pattern, float]:
        pattern, cost = Pattern(), 0.0
        if link != GROUND:
            pattern.add(A_X, A_X, GENERAL)
            pattern.add(A_Y, A_Y, GENERAL)
            for v in (A_X, A_Y, ALPHA):
                pattern.add(v, ALPHA, GENERAL)
            cost += 12
        for branch in self.outboard.get(link, ()):
            cost += self._carry(link, branch, forms.pop(branch.link), pattern)
        if link == self.topology.root:
            for begin in self.severed:
                for (v, w), value in forms.pop(begin).entries.items():
                    pattern.add(v, w, value)
        for index, ref, sign in self.sides.get(link, ()):
            self._close(link, index, ref, sign, pattern)
        for v in self.meshed.get(link, ()):
            pattern.near.setdefault(v, set())
            if link != GROUND:
                pattern.add(ALPHA, v, GENERAL)
        return pattern, cost

    def _carry(self, link: int, branch: Branch, child: Pattern, pattern: Pattern) -> float:
        """What a child's form becomes in terms of the link's variables."""
        arm = not self._same(link, branch.attach) or branch.slides
        cost = 14.0
        for (v, w), value in child.entries.items():
            if v.kind == "a" and w.kind == "a":
                if link != GROUND:
                    pattern.add(v, w, GENERAL)
                    if arm:
                        pattern.add(v, ALPHA, GENERAL)
                        pattern.add(w, ALPHA, GENERAL)
                        pattern.add(ALPHA, ALPHA, GENERAL)
            elif v.kind == "a":
                other = ALPHA if w == ALPHA else w
                if link != GROUND:
                    pattern.add(v, other, value)
                    cost += 2 * (value == GENERAL)
                    if arm:
                        pattern.add(ALPHA, other, GENERAL)
                        cost += 1 + (value == GENERAL)
                cost += 1 + (value == GENERAL)
            elif ALPHA in (v, w):  # the child turns as the link does, or as much faster as is prescribed
                if link != GROUND:
                    pattern.add(v, w, value)
                cost += 2
            else:
                pattern.add(v, w, value)
        return cost

    def _close(self, link: int, index: int, ref: PointRef, sign: int, pattern: Pattern) -> None:
        cut = self.cuts[index]
        for row in cut.rows:
            v = multiplier(cut.joint, row, cut.rank)
            pattern.near.setdefault(v, set())
            if link == GROUND:
                continue
            if row == "a":
                pattern.add(ALPHA, v, sign)
            elif row == "n":
                pattern.add(A_X, v, GENERAL)
                pattern.add(A_Y, v, GENERAL)
                pattern.add(ALPHA, v, GENERAL)
            else:
                pattern.add(A_X if row == "x" else A_Y, v, sign)
                if not self._same(link, ref.point):
                    pattern.add(ALPHA, v, GENERAL)

    def _eliminate(self, link: int, pattern: Pattern, pivot: Pivot) -> float:
        here = tuple(ALPHA if v == turn(link) else v for v in pivot)
        if here == (SLIDE,):
            for v in [v for v in pattern.near if v.kind != "slide"]:
                if pattern.get(A_X, v) or pattern.get(A_Y, v):
                    pattern.add(SLIDE, v, GENERAL)
            pattern.add(SLIDE, SLIDE, GENERAL)
            for v in self.along.get(self.branches[link].joint, ()):
                pattern.add(SLIDE, v, GENERAL)
        touched = pattern.touched(here)
        cost = _dyad_cost(pattern, here, touched) if is_dyad(here) else pivot_cost(len(here), len(touched))
        if is_dyad(here):
            rows = pattern.touched(here[2:]) - set(here)
            pairs = [(v, w) for v in touched for w in rows if v not in rows or v <= w]
        else:
            pairs = [(v, w) for v in touched for w in touched if v <= w]
        for v, w in pairs:
            pattern.add(v, w, GENERAL)
        pattern.drop(here)
        return cost

    def _handed_on(self, link: int, pattern: Pattern) -> Pattern:
        """The form as the parent sees it: an angular acceleration that stays open bears its link's number."""
        if link == self.topology.root or not self.has_angle(link) or ALPHA not in pattern.near:
            return pattern
        named, own = Pattern(), {ALPHA: turn(link)}
        for (v, w), value in pattern.entries.items():
            named.add(own.get(v, v), own.get(w, w), value)
        return named

    def _same(self, link: int, point: str) -> bool:
        """Whether a point lies at the link's inboard point whatever the parameters are."""
        if link == GROUND:
            return False
        there = self.mechanism.links[link].points[point]
        branch = self.branches.get(link)
        return there == (self.mechanism.links[link].points[branch.inboard] if branch else Point())


def pivot_cost(size: int, touched: int) -> float:
    """Operations of eliminating one or two variables: gains, what they take from the rest, and the way outwards."""
    pairs = touched * (touched + 1) / 2
    gains = touched * (1 if size == 1 else 6)
    return 1 + 8 * (size - 1) + gains + 2 * size * pairs + 4 * size * touched + 2 * size


def _dyad_cost(pattern: Pattern, pivot: Pivot, touched: set[Variable]) -> float:
    rows = pattern.touched(pivot[2:]) - set(pivot)
    inertia = sum(bool(pattern.get(v, w)) for v in pivot[:2] for w in pivot[:2])
    gains = 6 * len(rows) + 2 * inertia * len(rows)
    pairs = [(v, w) for v in touched for w in rows if v not in rows or v <= w]
    taken = sum(4 if v not in rows else 8 for v, _ in pairs)
    return 20 + gains + taken + 8 * len(rows) + 6 * len(touched)
