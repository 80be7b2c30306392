"""Integrals over time that effects ask for: links without mass whose rates are the integrals.

An integrator hangs on a hinge beside the mechanism, has no mass and an inertia that nothing else feels. The couple of
this inertia times a value turns it, so its rate is the value's integral, exact in time as the motion itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from .joints import Joint, PointRef
from .links import GROUND, ORIGIN, Link
from .mechanism import Integrator, Mechanism

PIN = "P"
"""The one point of an integrator."""


def with_integrators(mechanism: Mechanism, names: Sequence[str]) -> Mechanism:
    """The mechanism with an integrator for each name, behind all other links and joints.

    They hang on a point of the ground that a joint uses, so that no point is added; on the first link's first point
    where the ground holds nothing. The hinge carries nothing, wherever it is.
    """
    links, joints, found = list(mechanism.links), list(mechanism.joints), list(mechanism.integrators)
    held = (side for joint in joints for side in (joint.first, joint.second) if side.link == GROUND)
    at = next(held, None) or PointRef(0, next(iter(links[0].points)))
    used = {link.name for link in links} | {joint.name for joint in (*joints, *mechanism.open)}
    used |= {*mechanism.welded, *mechanism.welds}
    for name in names:
        free = name
        while {free, f"{free}_hinge"} & used:
            free += "_"
        used |= {free, f"{free}_hinge"}
        found.append(Integrator(name, len(links), f"{free}_hinge"))
        joints.append(Joint(f"{free}_hinge", at, PointRef(len(links), PIN)))
        links.append(Link(free, None, None, ORIGIN, {PIN: ORIGIN}, integrates=True))
    return replace(mechanism, links=tuple(links), joints=tuple(joints), integrators=tuple(found))


def without_integrators(mechanism: Mechanism, names: Sequence[str]) -> tuple[Mechanism, tuple[int, ...]]:
    """The mechanism without some of its integrators, and the numbers that the links left had before."""
    own = len(mechanism.links) - len(mechanism.integrators)
    kept = [one for one in mechanism.integrators if one.name not in names]
    hinges = {one.joint for one in mechanism.integrators}
    bare = replace(
        mechanism,
        links=mechanism.links[:own],
        joints=tuple(joint for joint in mechanism.joints if joint.name not in hinges),
        integrators=(),
    )
    return with_integrators(bare, [one.name for one in kept]), (*range(own), *(one.link for one in kept))
