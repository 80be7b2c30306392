"""The order of elimination for a person: what was chosen, what it costs, and what other plans would have cost."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ..mechanism.mechanism import Mechanism
from ..planning.choose import DYADS, WORTH, Candidate, Choice
from ..planning.plan import is_dyad
from ..program.dialects import C
from ..program.program import Program, lower
from ..program.routine import Routines
from ..scene.scene import Scene
from ..stages import derive_scene

COUNTED = 20_000
"""Operations, by the pattern, up to which a plan that is not taken is derived to count them: that takes seconds."""


def order_lines(scene: Scene, choice: Choice, program: Program, folded: bool = False) -> Iterator[str]:
    """Which plan of elimination is taken, what each costs, and what it closes and leaves open.

    ``program`` is that of the plan taken, its parameters ``folded`` or not.
    """
    mechanism, topology, plan = scene.mechanism, choice.topology, choice.plan
    total, chain = _counts(program)
    beside = f"; {len(plan.modules)} segments side by side" if plan.severed else ""
    yield f"{plan.name}: {total} operations of the acceleration, {chain}{beside}"
    for one in choice.found:
        if one is not choice.taken:
            yield f"{one.plan.name}: " + _compared(scene, choice, one, total, folded)
    if plan.severed:
        ends = [f"{mechanism.link_name(s[0])} to {mechanism.link_name(s[-1])}" for s in plan.modules]
        yield f"{len(ends)} segments of {len(plan.modules[0])} links: {', '.join(ends)}"
        open_ = [mechanism.joints[topology.branch(link).joint].name for link in plan.severed]
        yield f"cut open between them as well: {', '.join(open_)}"
    dyads = [pivot for pivots in plan.pivots.values() for pivot in pivots if is_dyad(pivot)]
    if dyads:
        closed = [" with ".join(mechanism.link_name(v.joint) for v in pivot[:2]) for pivot in dyads]
        yield "closed as dyads, the outermost first: " + ", ".join(closed)
        taken = {v for pivot in dyads for v in pivot}
        late = [
            mechanism.link_name(v.joint)
            for link, pivots in plan.pivots.items()
            for pivot in pivots
            for v in pivot
            if v.kind == "turn" and v not in taken and v.joint not in (link, topology.root)
        ]
        if late:
            yield f"left open until then: {', '.join(late)}"
    if dyads or plan.severed:
        safe = "tip to root" if plan.otherwise else "the runtime's solution of dependent rows"
        yield f"where {'a dyad is near its dead centre' if dyads else 'a segment is light across its line'}: {safe}"


def _counts(program: Program) -> tuple[int, str]:
    """Operations of the acceleration, and in words how many of them are on its longest chain."""
    acceleration = program.function("acceleration")
    return acceleration.counts().total, f"{acceleration.longest_chain()} of them one after the other"


def _compared(scene: Scene, choice: Choice, one: Candidate, total: int, folded: bool) -> str:
    """What a plan that is not taken would cost, and where that is less, why it is not taken."""
    if one.cost > COUNTED:
        return f"more than {COUNTED} operations, {COUNTED / total:.0f} times as many"
    count, chain = _counts(lower(derive_scene(scene, folded, choice=Choice(choice.found, one))[1]))
    better = count < total and not choice.plan.severed
    return f"{count} operations, {count / total:.2g} times as many, {chain}{_why_not(one) if better else ''}"


def _why_not(one: Candidate) -> str:
    if one.plan.name == DYADS:
        return f"; taken only where they are {WORTH} times fewer, since dyads divide by sines that the motion changes"
    if math.isinf(one.price):
        return "; not taken, since forces or values make its segments unequal"
    return "; not taken, since side by side its segments would take longer"


def module_lines(mechanism: Mechanism, program: Program) -> Iterator[str]:
    """Modules whose accelerations are computed side by side, group by group."""
    links = [
        ", ".join(
            mechanism.link_name(int(s.name.removeprefix("theta_"))) for s in module if s.name.startswith("theta_")
        )
        for module in program.modules
    ]
    for members in Routines(program, C.term).one_by_one("acceleration").modules:
        yield f"{len(members)} side by side: " + "; ".join(links[m] for m in members)
