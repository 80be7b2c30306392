"""Forces gathered from the tips inwards: what they do along each quasi-velocity (theory, section 7)."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from ..mechanism.links import GROUND
from .kinematics import Kinematics
from .vectors import ZERO, Wrench, add, dot, perp


def gather_inwards(
    kinematics: Kinematics, wrenches: Mapping[int, Wrench], name: str, title: str
) -> tuple[sp.Expr, ...]:
    """Generalized forces of wrenches on the links, one per quasi-velocity (eq. 5.3).

    The force handed on by link k is named ``name``_k; ``title`` is the heading of what is written.
    """
    topology, state, ledger = kinematics.topology, kinematics.state, kinematics.ledger
    force = {link: wrench[0] for link, wrench in wrenches.items()}
    moment = {link: wrench[1] for link, wrench in wrenches.items()}
    along: dict[sp.Expr, sp.Expr] = {}
    for branch in reversed(topology.branches):
        link, parent = branch.link, branch.parent
        if link not in force:
            continue
        felt = ledger.let_vector(f"{name}_{link}", force[link])
        if link in kinematics.slides:
            slide = kinematics.slides[link]
            along[slide.speed] = dot(slide.direction, felt)
        if link in kinematics.lead:
            moment[link] += dot(perp(kinematics.lead[link]), felt)
        if parent != GROUND:
            force[parent] = add(force.get(parent, ZERO), felt)
            moment.setdefault(parent, sp.S.Zero)
            moment[parent] += dot(perp(kinematics.r[parent, branch.joint]), felt)
            if branch.follows:
                moment[parent] += moment[link]
    ledger.close(title)
    for branch in topology.branches:
        if branch.follows:
            moment.pop(branch.link, None)
    along |= {state.rate(link): value for link, value in moment.items()}
    base = force.get(topology.root, ZERO) if topology.floating else ()
    return (*base, *(along.get(u, sp.S.Zero) for u in state.u[state.base :]))
