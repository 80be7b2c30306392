"""The portfolio of plans, and the choice among them (theory, section 4.13).

``tip to root`` eliminates what belongs to a link at that link, and the multipliers of a loop where its branches meet.
It costs the same per link in chains, rings and ladders. Where many loops pass through one link, as legs on a shaft do,
that link's angular acceleration couples the multipliers of all of them, and it pays to leave it open: ``dyads`` closes
two links at a time between links that are known (Assur groups), so that their multipliers vanish, and leaves open what
joins the dyads.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from ..derive.names import A_X, A_Y, ALPHA, SLIDE, Variable, multiplier, turn
from ..mechanism.links import GROUND
from ..mechanism.mechanism import Mechanism
from ..mechanism.modules import alike
from ..mechanism.topology import Branch, Cut, Topology
from .pattern import Pattern, Sweep
from .plan import Pivot, Plan
from .segments import in_segments


@dataclass(frozen=True)
class Choice:
    """The plan that is taken, and about how many operations of the recursion each of the portfolio's plans costs."""

    topology: Topology
    plan: Plan
    costs: tuple[tuple[str, int], ...]


TIP_TO_ROOT, DYADS, IN_SEGMENTS = "tip to root", "dyads", "segments"
PLANS = (TIP_TO_ROOT, DYADS, IN_SEGMENTS)
"""The portfolio: of plans that cost the same, the first is taken."""

WORTH = 2.0
"""Times fewer operations that a plan must take than the order from tip to root. Closing a dyad divides by the sine of
an angle that the motion changes, which costs digits, and wants a second set of functions near dead centres."""

FAR = 10
"""Times the operations of the other plan at which the count of the order from tip to root is given up, though not below
:data:`LONGEST`: up to there it is needed whole."""

LONGEST = 6000
"""Operations up to which the plan for dead centres is compiled. Beyond them its code costs more to compile than the
runtime's robust path costs in the few states that need it."""


def choose(
    mechanism: Mechanism,
    topology: Topology,
    driven: Collection[int],
    sound: Collection[int],
    wanted: str | None = None,
) -> Choice:
    """The order from tip to root unless another is :data:`WORTH` it, or the ``wanted`` one of :data:`PLANS`.

    ``driven`` joints have a prescribed motion; ``sound`` are the cut pins whose dyads may be closed. Raises
    ``ValueError`` where the wanted plan is not one of the portfolio, or the mechanism has no dyad to close.
    """
    if wanted is not None and wanted not in PLANS:
        raise ValueError(f"plan: found {wanted!r}, expected {' or '.join(map(repr, PLANS))}; name one of them")
    sweep = Sweep(mechanism, topology, driven)
    embedded = _embedded(sweep, [cut for cut in topology.cuts if cut.joint in sound])
    limit = max(FAR * embedded[1], LONGEST) if embedded and wanted != TIP_TO_ROOT else math.inf
    found = [(TIP_TO_ROOT, *sweep.run(_Order(sweep, {}), limit))]
    if embedded:
        found.append((DYADS, *embedded))
    runs = in_segments(mechanism, topology, driven)
    if runs and wanted in (None, IN_SEGMENTS):
        topology, modules = runs
        severed = tuple(module[0] for module in modules)
        cut = Sweep(mechanism, topology, driven, severed)
        plan = Plan(IN_SEGMENTS, cut.run(_Order(cut, {}))[0], None, modules, severed)
        return Choice(topology, plan, ((IN_SEGMENTS, round(cut.run(_Order(cut, {}))[1])), (found[0][0], round(found[0][2]))))
    named = [one for one in found if wanted in (None, one[0])]
    if not named:
        raise ValueError(
            f"plan: found {wanted!r}, expected {TIP_TO_ROOT!r}: the mechanism has no dyad to close that is away from "
            "its dead centre at the start; leave out the plan, or start elsewhere"
        )
    safe, own, cost = found[0]
    name, pivots, _ = min(named, key=lambda one: one[2] * (1.0 if one[0] == safe else WORTH))
    otherwise = Plan(safe, own) if name != safe and cost <= LONGEST else None
    return Choice(topology, Plan(name, pivots, otherwise, alike(mechanism)), tuple((one[0], round(one[2])) for one in found))


def _embedded(sweep: Sweep, cuts: list[Cut]) -> tuple[dict[int, tuple[Pivot, ...]], float] | None:
    """Pivots and cost where as many of the dyads at ``cuts`` are closed as leave all other loops their links.

    The multipliers of a loop that no dyad closes have a pivot only once the angular accelerations on its way have gone.
    Dyads that hold one of them back are not closed.
    """
    while dyads := _close_dyads(sweep, cuts):
        order = _Order(sweep, _when(sweep, dyads))
        found = sweep.run(order)
        if not order.starved:
            return found
        ways = [_between(cut, sweep.branches) for cut in order.starved]
        barred = [cut for cut in dyads if any(way & _between(cut, sweep.branches) for way in ways)]
        cuts = [cut for cut in cuts if cut not in barred] if barred else []
    return None


# -- what is eliminated at a link ----------------------------------------------------------------------------------


@dataclass
class _Order:
    """Dyads where they are due, other loops where their branches meet, then what belongs to the link or was left
    open."""

    sweep: Sweep
    dyads: dict[int, list[Cut]]
    waiting: set[Variable] = field(default_factory=set)
    starved: list[Cut] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.closed = {cut.joint for cuts in self.dyads.values() for cut in cuts}
        self.waiting = {v for cuts in self.dyads.values() for cut in cuts for v in _dyad(cut)}

    def __call__(self, link: int, pattern: Pattern) -> tuple[Pivot, ...]:
        if not self.dyads:
            return (*self._loops(link, pattern), *self._belongings(link))
        return tuple(self._with_dyads(link, pattern))

    def _loops(self, link: int, pattern: Pattern) -> list[Pivot]:
        cuts = [c for c in self.sweep.cuts if self._goes_at(c) == link and c.joint not in self.closed]
        return [tuple(multiplier(cut.joint, row, cut.rank) for row in cut.rows) for cut in _least_fill(cuts, pattern)]

    def _goes_at(self, cut: Cut) -> int:
        """Where the branches of a loop meet; at the root if a segment begins on its way."""
        way = _between(cut, self.sweep.branches)
        return self.sweep.topology.root if way & set(self.sweep.severed) else cut.meeting

    def _belongings(self, link: int) -> list[Pivot]:
        """α of the link unless it follows another's, s̈ if it slides: first where the line is its own (eq. 4.5)."""
        if link == GROUND:
            return []
        found: list[Pivot] = [(turn(link),)] if self.sweep.has_angle(link) else []
        if self.sweep.slides(link):
            found.append((SLIDE,))
            if self.sweep.branches[link].owner == link:
                found.reverse()
        if link in self.sweep.severed:
            found.append((A_X, A_Y))
        return found

    def _with_dyads(self, link: int, pattern: Pattern) -> Iterator[Pivot]:
        """Dyads first; then what no dyad waits for any more; then loops that no dyad closes."""
        left = {v: set(near) for v, near in _outside(link, pattern).items()}
        for cut in self.dyads.get(link, ()):
            pivot = _dyad(cut)
            self.waiting -= set(pivot)
            _fill(left, pivot)
            yield pivot
        if link in self.sweep.branches or link == self.sweep.topology.root:
            for v in sorted(x for x in left if x.kind == "turn" and x != turn(link) and x not in self.waiting):
                if not left[v] & self.waiting:
                    _fill(left, (v,))
                    yield (v,)
        for pivot in self._loops(link, pattern):
            cut = next(one for one in self.sweep.topology.cuts if one.joint == pivot[0].joint)
            if any(turn(k) in left for k in _between(cut, self.sweep.branches)):
                self.starved.append(cut)
            _fill(left, pivot)
            yield pivot
        for pivot in self._belongings(link):
            v = pivot[0]
            root = link == self.sweep.topology.root
            if v == SLIDE or root or (v not in self.waiting and not left.get(v, set()) & self.waiting):
                yield pivot


def _outside(link: int, pattern: Pattern) -> dict[Variable, set[Variable]]:
    """Who shares an entry with whom, the link's own α under its number."""
    own = {ALPHA: turn(link)}
    return {own.get(v, v): {own.get(w, w) for w in near} for v, near in pattern.near.items()}


def _fill(near: dict[Variable, set[Variable]], pivot: Pivot) -> None:
    around = set[Variable]().union(*(near.pop(e, set()) for e in pivot)) - set(pivot)
    for v in around:
        near[v] = (near[v] | around) - set(pivot)


def _least_fill(cuts: list[Cut], pattern: Pattern) -> list[Cut]:
    """Loops that meet at a link, in an order of least fill (minimum degree on shared multipliers)."""
    waiting, joints = list(cuts), {cut.joint for cut in cuts}
    near = {cut.joint: set[int]() for cut in waiting}
    for v, w in pattern.entries:
        if v.kind == w.kind == "lambda" and v.joint != w.joint and {v.joint, w.joint} <= joints:
            near[v.joint].add(w.joint)
            near[w.joint].add(v.joint)
    ordered: list[Cut] = []
    while waiting:
        cut = min(waiting, key=lambda c: (len(near[c.joint]), c.joint))
        waiting.remove(cut)
        ordered.append(cut)
        shared = near.pop(cut.joint)
        for joint in shared:
            near[joint] = (near[joint] | shared) - {joint, cut.joint}
    return ordered


# -- dyads ---------------------------------------------------------------------------------------------------------


def _dyad(cut: Cut) -> Pivot:
    return (turn(cut.first.link), turn(cut.second.link), *(multiplier(cut.joint, row) for row in cut.rows))


def _close_dyads(sweep: Sweep, cuts: list[Cut]) -> list[Cut]:
    """Dyads in the order in which they close outwards from the root, which is known.

    A dyad closes where both of its links hang from known links. Where none does, the link that makes most others known
    is taken as known: its angular acceleration stays open.
    """
    parents = {branch.link: branch.parent for branch in sweep.topology.branches}
    hanging: dict[int, list[Cut]] = {}
    for cut in cuts:
        if _is_pair(sweep, cut):
            for parent in {parents[end] for end in _ends(cut)}:
                hanging.setdefault(parent, []).append(cut)
    known, closed = set[int](), list[Cut]()

    def spread(start: Sequence[int]) -> tuple[set[int], list[Cut]]:
        """What becomes known with the links ``start``, these included, and the dyads that close then."""
        found, dyads, waiting = set(start), list[Cut](), list(start)
        while waiting:
            link = waiting.pop(0)
            new = [b.link for b in sweep.outboard.get(link, ()) if not sweep.has_angle(b.link)]
            for cut in hanging.get(link, ()):
                ends = _ends(cut)
                hangs = all(parents[end] in known or parents[end] in found for end in ends)
                if hangs and not known & ends and not found & ends:
                    dyads.append(cut)
                    found |= ends
                    waiting += sorted(ends)
            new = [one for one in dict.fromkeys(new) if one not in known and one not in found]
            found |= set(new)
            waiting += new
        return found, dyads

    opened: Sequence[int] = sorted({GROUND, sweep.topology.root})
    edge: set[int] = set()
    while hanging and opened:
        found, dyads = spread(opened)
        known |= found
        closed += dyads
        edge = (edge | {branch.link for link in found for branch in sweep.outboard.get(link, ())}) - known
        opened = sorted(edge, key=lambda link: (-len(spread((link,))[0]), link))[:1]
    return closed


def _ends(cut: Cut) -> set[int]:
    return {cut.first.link, cut.second.link}


def _is_pair(sweep: Sweep, cut: Cut) -> bool:
    """Whether a cut pin joins two links that turn by themselves on pins."""
    ends = (cut.first.link, cut.second.link)
    if cut.kind != "revolute" or ends[0] == ends[1] or cut.meeting in ends:
        return False
    if any(sweep.slides(link) for link in _between(cut, sweep.branches)):
        return False
    return all(not sweep.branches[end].slides and sweep.has_angle(end) for end in ends)


def _when(sweep: Sweep, closed: list[Cut]) -> dict[int, list[Cut]]:
    """At which link each dyad goes, in order: where its branches meet, and not before those that hang from it."""
    depth = {sweep.topology.root: 0}
    for branch in sweep.topology.branches:
        depth[branch.link] = depth[branch.parent] + 1
    due: dict[int, int] = {}
    for cut in reversed(closed):
        own = {cut.first.link, cut.second.link}
        after = [c for c in closed if c.joint in due and own & _between(c, sweep.branches)]
        due[cut.joint] = min([cut.meeting, *(due[c.joint] for c in after)], key=lambda link: depth[link])
    found: dict[int, list[Cut]] = {}
    for cut in reversed(closed):
        found.setdefault(due[cut.joint], []).append(cut)
    return found


def _between(cut: Cut, branches: Mapping[int, Branch]) -> set[int]:
    """Links on the way between a loop's cut and where its branches meet: its rows depend on their angles."""
    found: set[int] = set()
    for end in (cut.first.link, cut.second.link):
        link = end
        while link != cut.meeting:
            found.add(link)
            link = branches[link].parent
    return found
