"""Which points of a mechanism touch grounds that name none: where two links meet, and the ends of open joints.

A point may do so only while some joints hold and others are open: then it is told while which.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

from .joints import Joint, PointRef
from .links import GROUND
from .mechanism import Mechanism

While = frozenset[tuple[int, bool]]
"""Joints (their indices) that let go or take hold, each with whether it holds."""


@dataclass(frozen=True)
class TouchingPoint:
    """A point and what it is called: by the pin that it is of, or ``link.point``. It touches while one of ``whiles`` is
    so: no two of them can be so at once, and an empty one always is."""

    name: str
    ref: PointRef
    whiles: tuple[While, ...]


def is_pin(joint: Joint) -> bool:
    """Whether two links meet in the joint that both move, as in the end of one."""
    return joint.kind == "revolute" and not joint.on_ground


def touching_points(mechanism: Mechanism) -> tuple[TouchingPoint, ...]:
    """The points that touch: once per pin off the ground, and each end of a joint while that is open.

    A pin touches unless a joint named before it meets one of its ends: that touches in its place, or holds it to the
    ground or to a line. An end touches while nothing holds it but welds of which it is the first end.
    """
    gates = mechanism.gates_at
    joints = {
        k: mechanism.as_named(k)
        for k, joint in enumerate(mechanism.joints)
        if joint.name not in mechanism.hidden_joints
    }
    names = dict[PointRef, str]()
    found = defaultdict[PointRef, list[While]](list)
    met = defaultdict[PointRef, list[int]](list)
    for k, joint in joints.items():
        before = {*met[joint.first], *met[joint.second]}
        if is_pin(joint) and before <= gates.keys():
            names.setdefault(joint.first, joint.name)
            own = {(k, True)} if k in gates else set()
            found[joint.first].append(frozenset(own | {(one, False) for one in before}))
        for end in _held_by(joint):
            met[end].append(k)
    for joint in (*mechanism.open, *(joints[k] for k in gates if k in joints)):
        for end in (joint.first, joint.second):
            if end.link != GROUND and frozenset() not in found[end] and set(met[end]) <= gates.keys():
                pin = is_pin(joint) and end == joint.first
                names.setdefault(end, joint.name if pin else f"{mechanism.link_name(end.link)}.{end.point}")
                free = frozenset((one, False) for one in met[end])
                found[end] += [] if free in found[end] else [free]
    return tuple(TouchingPoint(name, ref, tuple(found[ref])) for ref, name in names.items())


def _held_by(joint: Joint) -> Iterator[PointRef]:
    """The ends that a joint keeps from touching while it holds."""
    yield joint.second
    if joint.kind != "weld" or joint.on_ground:
        yield joint.first
