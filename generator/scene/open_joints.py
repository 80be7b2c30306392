"""The bodies of a scene with what no joint holds: while joints are open, and where links are free."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from ..mechanism.carriages import loose_parts, parts, with_carriages
from ..mechanism.mechanism import Mechanism
from .bodies import Bodies


def with_open(bodies: Bodies, released: Collection[str]) -> Bodies:
    """The bodies without the joints called as the ``released`` ones; what only these held, and what is free, is placed
    by carriages.

    What nothing holds with them either, and no link of it is free, stays so: that is told as in any scene.
    """
    mechanism = bodies.mechanism
    kept = [k for k, joint in enumerate(mechanism.joints) if joint.name not in released]
    freed = tuple(joint for joint in mechanism.joints if joint.name in released)
    rest = replace(mechanism, joints=tuple(mechanism.joints[k] for k in kept), open=freed)
    rows = [bodies.joint_rows[k] for k in kept] if bodies.joint_rows else []
    forgotten = any(not group & bodies.free for group in loose_parts(mechanism))
    if forgotten or not loose_parts(rest):
        return replace(bodies, mechanism=rest, joint_rows=tuple(rows))
    whole, carriages, carried = with_carriages(rest)
    if rows:
        holders = [_holder(mechanism, rest, link) for link in carried]
        rows += [-1 if holder is None else bodies.joint_rows[holder] for holder in holders for _ in range(2)]
    return replace(
        bodies,
        mechanism=replace(whole, aids=tuple(whole.joints[k].name for one in carriages for k in (one.across, one.up))),
        sketch=(*bodies.sketch, *(0.0 for _ in carried)),
        rates=(*bodies.rates, *(None for _ in carried)) if bodies.rates else (),
        link_rows=(*bodies.link_rows, *(bodies.link_rows[link] for link in carried)) if bodies.link_rows else (),
        joint_rows=tuple(rows),
    )


def _holder(mechanism: Mechanism, rest: Mechanism, link: int) -> int | None:
    """A joint that holds what hangs together with ``link`` in the ``rest``, if one does: faults of what places that are
    told there."""
    group = next(group for group in parts(len(mechanism.links), rest.joints) if link in group)
    held = (
        k
        for k, joint in enumerate(mechanism.joints)
        if joint in rest.open and {joint.first.link, joint.second.link} & group
    )
    return next(held, None)
