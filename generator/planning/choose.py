"""The portfolio of plans, and the choice among them (theory, section 4.13).

``tip to root`` eliminates what belongs to a link at that link, and the multipliers of a loop where its branches meet.
It costs the same per link in chains, rings and ladders. Where many loops pass through one link, as legs on a shaft do,
that link's angular acceleration couples the multipliers of all of them, and it pays to leave it open: ``dyads`` closes
two links at a time between links that are known (Assur groups), so that their multipliers vanish, and leaves open what
joins the dyads. ``segments`` cuts a long loop into pieces that go side by side.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from ..equations.names import A_X, A_Y, ALPHA, SLIDE, Variable, multiplier, turn
from ..mechanism.links import GROUND
from ..mechanism.mechanism import Mechanism
from ..mechanism.modules import alike
from ..mechanism.topology import Branch, Cut, MeshRow, Topology
from .fill import by_least_fill, take_out
from .pattern import Pattern, Sweep
from .plan import Pivot, Plan
from .segments import LEAST_LINKS, SEGMENTS, in_segments, same_values


@dataclass(frozen=True)
class Candidate:
    """A plan, the virtual open chain that it is for, about how many operations of the recursion it costs, and what it
    is compared by."""

    topology: Topology
    plan: Plan
    cost: float
    price: float


@dataclass(frozen=True)
class Choice:
    """The plans of the portfolio that a mechanism has, and the one of them that is taken."""

    found: tuple[Candidate, ...]
    taken: Candidate

    @property
    def topology(self) -> Topology:
        """The virtual open chain of the plan."""
        return self.taken.topology

    @property
    def plan(self) -> Plan:
        """The plan that is taken."""
        return self.taken.plan

    @property
    def costs(self) -> tuple[tuple[str, int], ...]:
        """About how many operations each plan costs."""
        return tuple((one.plan.name, round(one.cost)) for one in self.found)

    def with_others(self, other: Choice, gain: float, wanted: str | None = None) -> Choice:
        """The choice among these plans and those on another tree where they take ``gain`` times fewer operations."""
        elsewhere = {one.plan.name: one for one in other.found}
        best = [
            elsewhere[one.plan.name]
            if one.plan.name in elsewhere and gain * elsewhere[one.plan.name].cost < one.cost
            else one
            for one in self.found
        ]
        return _best(best, wanted)


TIP_TO_ROOT, DYADS, IN_SEGMENTS = "tip to root", "dyads", "segments"
PLANS = (TIP_TO_ROOT, DYADS, IN_SEGMENTS)
"""The portfolio: of plans that cost the same, the first is taken."""

WORTH = 1.8
"""Times fewer operations that a plan must take than the order from tip to root. Closing a dyad divides by the sine of
an angle that the motion changes, which costs digits, and wants a second set of functions near dead centres. Four-bars,
and legs by themselves, come to 1.76 at most; machines that walk, from 1.83 on, take less than half of the time."""

GATHERING = 1.3
"""Times that segments take longer than their operations, side by side, would: states are gathered and results are laid
out again."""

LACKING = {
    DYADS: "the mechanism has no dyad to close, or none that is away from its dead centre at the start; leave out the "
    "plan",
    IN_SEGMENTS: f"no loop has a row of {SEGMENTS * LEAST_LINKS} links alike, with inertia, on pins that nothing "
    "drives, through its cut pin; leave out the plan",
}
"""Why there is no plan of a name."""

FAR = 10
"""Times the operations of the other plan at which the count of the order from tip to root is given up, though not below
:data:`LONGEST`: up to there it is needed whole."""

LONGEST = 6000
"""Operations up to which the plan for states where a guard fails is compiled. Beyond them its code costs more to
compile than the runtime's robust path costs in the few states that need it."""


def check_plan(wanted: str | None) -> None:
    """Raise ``ValueError`` for a name that no plan of the portfolio has."""
    if wanted is not None and wanted not in PLANS:
        raise ValueError(
            f"plan: found {wanted!r}, expected {', '.join(map(repr, PLANS[:-1]))} or {PLANS[-1]!r}; name one of them"
        )


def choose(
    mechanism: Mechanism,
    topology: Topology,
    driven: Collection[int],
    sound: Collection[int],
    wanted: str | None = None,
    *,
    loaded: bool = False,
    folded: bool = False,
) -> Choice:
    """The order from tip to root unless another is worth it, or the ``wanted`` one of :data:`PLANS`.

    ``driven`` joints have a prescribed motion; ``sound`` are the cut pins whose dyads may be closed; ``loaded`` says
    that segments do not go side by side, as where forces make them unequal, so that they are cut only where they are
    wanted; ``folded`` that the values of parameters stand in the equations. Raises
    ``ValueError`` where the wanted plan is not one of the portfolio, or the mechanism has none of its kind.
    """
    check_plan(wanted)
    sweep = Sweep(mechanism, topology, driven)
    modules = alike(mechanism)
    meshed = bool(topology.meshes)  # their rows share links with those of dyads and segments
    dyads = None if meshed else _with_dyads(sweep, [cut for cut in topology.cuts if cut.joint in sound])
    limit = max(FAR * dyads[1], LONGEST) if dyads and wanted != TIP_TO_ROOT else math.inf
    own, cost = _summed(sweep.run(_Order(sweep, {}), limit))
    found = [Candidate(topology, Plan(TIP_TO_ROOT, own, None, modules), cost, cost)]
    if dyads:
        otherwise = Plan(TIP_TO_ROOT, own) if cost <= LONGEST else None
        plan = Plan(DYADS, dyads[0], otherwise, modules)
        found.append(Candidate(topology, plan, dyads[1], WORTH * dyads[1]))
    found += [] if meshed else _in_segments(mechanism, topology, driven, loaded, folded)
    return _best(found, wanted)


def _best(found: Sequence[Candidate], wanted: str | None) -> Choice:
    named = [one for one in found if wanted in (None, one.plan.name)]
    if not named:
        raise ValueError(f"plan: found {wanted!r}, expected {TIP_TO_ROOT!r}: {LACKING[str(wanted)]}")
    return Choice(tuple(found), min(named, key=lambda one: one.price))


def _summed(found: tuple[dict[int, tuple[Pivot, ...]], dict[int, float]]) -> tuple[dict[int, tuple[Pivot, ...]], float]:
    return found[0], sum(found[1].values())


def _in_segments(
    mechanism: Mechanism, topology: Topology, driven: Collection[int], loaded: bool, folded: bool
) -> list[Candidate]:
    """The longest loop's row of links in segments, if it has one that is long enough."""
    row = in_segments(mechanism, topology, driven)
    if row is None:
        return []
    severed = tuple(segment[0] for segment in row[1])
    sweep = Sweep(mechanism, row[0], driven, severed)
    pivots, costs = sweep.run(_Order(sweep, {}))
    cost, side_by_side = sum(costs.values()), sum(costs[link] for segment in row[1] for link in segment)
    price = GATHERING * (cost - side_by_side + side_by_side / len(row[1]))
    own, from_tips = _summed((whole := Sweep(mechanism, row[0], driven)).run(_Order(whole, {}), LONGEST))
    otherwise = Plan(TIP_TO_ROOT, own) if from_tips <= LONGEST else None
    plan = Plan(IN_SEGMENTS, pivots, otherwise, row[1], severed)
    unequal = loaded or (folded and not same_values(mechanism, *row))
    return [Candidate(row[0], plan, cost, math.inf if unequal else price)]


def _with_dyads(sweep: Sweep, cuts: list[Cut]) -> tuple[dict[int, tuple[Pivot, ...]], float] | None:
    """Pivots and cost where as many of the dyads at ``cuts`` are closed as leave all other loops their links.

    The multipliers of a loop that no dyad closes have a pivot only once the angular accelerations on its way have gone.
    Dyads that hold one of them back are not closed.
    """
    while dyads := _close_dyads(sweep, cuts):
        order = _Order(sweep, _when(sweep, dyads))
        found = _summed(sweep.run(order))
        if not order.starved:
            return found
        ways = [_between(cut, sweep.branches) for cut in order.starved]
        barred = [cut for cut in dyads if any(way & _between(cut, sweep.branches) for way in ways)]
        cuts = [cut for cut in cuts if cut not in barred] if barred else []
    return None


# -- what is eliminated at a link ----------------------------------------------------------------------------------


@dataclass
class _Order:
    """Dyads where they are due, other loops where their branches meet (at the root if a segment begins on their way),
    then what belongs to the link or was left open."""

    sweep: Sweep
    dyads: dict[int, list[Cut]]
    waiting: set[Variable] = field(default_factory=set)
    starved: list[Cut] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.closed = {cut.joint for cuts in self.dyads.values() for cut in cuts}
        self.waiting = {v for cuts in self.dyads.values() for cut in cuts for v in _dyad(cut)}
        root, severed, branches = self.sweep.topology.root, set(self.sweep.severed), self.sweep.branches
        self.loops: dict[int, list[Cut | MeshRow]] = {}
        for cut in (cut for cut in self.sweep.cuts if cut.joint not in self.closed):
            link = root if severed & _between(cut, branches) else cut.meeting
            self.loops.setdefault(link, []).append(cut)
        for row in self.sweep.topology.meshes:
            self.loops.setdefault(row.meeting, []).append(row)

    def __call__(self, link: int, pattern: Pattern) -> tuple[Pivot, ...]:
        if not self.dyads:
            return (*self._loops(link, pattern), *self._belongings(link))
        return tuple(self._with_dyads(link, pattern))

    def _loops(self, link: int, pattern: Pattern) -> list[Pivot]:
        cuts = self.loops.get(link, [])
        ordered = _least_fill(cuts, pattern)
        return [tuple(multiplier(cut.joint, row, cut.rank) for row in rows) for cut in ordered for rows in _blocks(cut)]

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
            take_out(left, pivot)
            yield pivot
        if link in self.sweep.branches or link == self.sweep.topology.root:
            for v in sorted(x for x in left if x.kind == "turn" and x != turn(link) and x not in self.waiting):
                if not left[v] & self.waiting:
                    take_out(left, (v,))
                    yield (v,)
        for pivot in self._loops(link, pattern):
            cut = next(one for one in self.sweep.topology.cuts if one.joint == pivot[0].joint)
            if any(turn(k) in left for k in _between(cut, self.sweep.branches)):
                self.starved.append(cut)
            take_out(left, pivot)
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


def _blocks(cut: Cut | MeshRow) -> tuple[tuple[str, ...], ...]:
    """The rows of a joint that go together: two at most."""
    return tuple(cut.rows[k : k + 2] for k in range(0, len(cut.rows), 2))


def _least_fill(cuts: list[Cut | MeshRow], pattern: Pattern) -> list[Cut | MeshRow]:
    """Loops that meet at a link, in an order of least fill by the multipliers that they share."""
    at = {cut.joint: cut for cut in cuts}
    near = {joint: {joint} for joint in at}
    for v, w in pattern.entries:
        if v.kind == w.kind == "lambda" and v.joint in at and w.joint in at:
            near[v.joint].add(w.joint)
            near[w.joint].add(v.joint)
    return [at[joint] for joint, _ in by_least_fill(near, at)]


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
