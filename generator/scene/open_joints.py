"""The bodies of a scene with what no joint holds: while joints are open, and where links are free."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import replace

from ..mechanism.carriages import loose_parts, parts, with_carriages
from ..mechanism.joints import Joint, PointRef
from ..mechanism.links import GROUND, OFF_OR_ON, ORIGIN, Link, Parameter
from ..mechanism.mechanism import Mechanism
from .bodies import Bodies
from .scene import HELD, Kept, Start, Triple

SHAFT, WELD = "_shaft", "_weld"
"""Behind that of a driven joint that lets go in those of its shaft, and of the weld that lets go in its place."""


def with_open(bodies: Bodies, released: Collection[str]) -> Bodies:
    """The bodies without the joints called as the ``released`` ones; what only these held, and what is free, is placed
    by carriages.

    What nothing holds with them either, and no link of it is free, stays so: that is told as in any scene.
    """
    mechanism = bodies.mechanism
    kept = [k for k, joint in enumerate(mechanism.joints) if joint.name not in released]
    freed = tuple(joint for joint in mechanism.joints if joint.name in released)
    rest = replace(mechanism, joints=tuple(mechanism.joints[k] for k in kept), open=freed)
    rows = tuple(bodies.joint_rows[k] for k in kept) if bodies.joint_rows else ()
    bare = replace(bodies, mechanism=rest, joint_rows=rows)
    return _carried(bare, bodies, loose_parts(rest))


def with_gates(bodies: Bodies, changing: Collection[str], opened: Collection[str], driven: Collection[str]) -> Bodies:
    """The bodies with gates at the joints that are called as the ``changing`` ones, 0 at those that are ``opened``, and
    with carriages for all that is placed by none of the other joints.

    Where one of them is ``driven``, its first link drives a shaft without mass, and the second is welded to that: the
    drive goes on where the weld lets go, and moves nothing.
    """
    shafted = _with_shafts(bodies, [name for name in driven if name in changing])
    mechanism = shafted.mechanism
    named = {mechanism.shafts.get(name, name): name for name in changing}
    rest = [joint for joint in mechanism.joints if joint.name not in named]
    found = parts(len(mechanism.links), rest)
    grounded = len(found) > 1 or any(joint.on_ground for joint in mechanism.joints)
    gates = {
        k: Parameter(f"{named[joint.name]}{HELD}", f"held_{k}", float(named[joint.name] not in opened), OFF_OR_ON, "1")
        for k, joint in enumerate(mechanism.joints)
        if joint.name in named
    }
    gated = replace(shafted, mechanism=replace(mechanism, gates=gates))
    return _carried(gated, bodies, [group for group in found if grounded and GROUND not in group])


def _with_shafts(bodies: Bodies, names: Sequence[str]) -> Bodies:
    """The bodies with a shaft at each of these joints."""
    mechanism = bodies.mechanism
    links, joints = list(mechanism.links), list(mechanism.joints)
    for name in names:
        k = next(k for k, joint in enumerate(joints) if joint.name == name)
        shaft = PointRef(len(links), "P")
        links.append(Link(f"{name}{SHAFT}", None, None, ORIGIN, {"P": ORIGIN}))
        joints.append(Joint(f"{name}{WELD}", shaft, joints[k].second, "weld"))
        joints[k] = replace(joints[k], second=shaft)
    count = len(names)
    return replace(
        bodies,
        mechanism=replace(
            mechanism, links=tuple(links), joints=tuple(joints), shafts={name: f"{name}{WELD}" for name in names}
        ),
        sketch=(*bodies.sketch, *(0.0 for _ in names)),
        rates=(*bodies.rates, *(None for _ in names)) if bodies.rates else (),
        link_rows=(*bodies.link_rows, *(-1 for _ in range(count))) if bodies.link_rows else (),
        joint_rows=(*bodies.joint_rows, *(-1 for _ in range(count))) if bodies.joint_rows else (),
    )


def _carried(bodies: Bodies, whole: Bodies, groups: Sequence[frozenset[int]]) -> Bodies:
    """The bodies with a carriage for each of the ``groups`` of links; ``whole`` has all joints."""
    if not groups or any(not group & bodies.free for group in loose_parts(whole.mechanism)):
        return bodies
    mechanism, carriages, carried = with_carriages(bodies.mechanism, groups)
    rows = [*bodies.joint_rows]
    if rows:
        holders = [_holder(whole.mechanism, next(group for group in groups if link in group)) for link in carried]
        rows += [-1 if holder is None else whole.joint_rows[holder] for holder in holders for _ in range(2)]
    aids = tuple(mechanism.joints[k].name for one in carriages for k in (one.across, one.up))
    return replace(
        bodies,
        mechanism=replace(mechanism, aids=aids),
        sketch=(*bodies.sketch, *(0.0 for _ in carried)),
        rates=(*bodies.rates, *(None for _ in carried)) if bodies.rates else (),
        link_rows=(*bodies.link_rows, *(bodies.link_rows[link] for link in carried)) if bodies.link_rows else (),
        joint_rows=tuple(rows),
    )


def _holder(mechanism: Mechanism, group: frozenset[int]) -> int | None:
    """A joint that holds a ``group`` of links to others, if one does: faults of what places it are told there."""
    ends = [{joint.first.link, joint.second.link} for joint in mechanism.joints]
    return next((k for k, links in enumerate(ends) if links & group and links - group), None)


def on_carriages(start: Start, mechanism: Mechanism, before: Mechanism) -> Start:
    """A start of the mechanism ``before``, which has the same links of the scene and their joints, as one of the
    ``mechanism`` with gates: carriages are below what they carry, and integrals as they are."""
    count = mechanism.own_links
    poses, velocities = list(start.poses[:count]), list(start.velocities[:count])
    for weld in mechanism.shafts.values():
        joint = next(one for one in mechanism.joints if one.name == weld)
        pose, velocity = _at(mechanism, joint.second, poses, velocities)
        poses.append(pose)
        velocities.append(velocity)
    joints = {joint.name: k for k, joint in enumerate(mechanism.joints)}
    for up in mechanism.aids[1::2]:
        body = mechanism.joints[joints[up]].second
        (x, _, _), (rate, _, _) = _at(mechanism, body, poses, velocities)
        poses.append((x, 0.0, 0.0))
        velocities.append((rate, 0.0, 0.0))
    for one in before.integrators:
        poses.append(start.poses[one.link])
        velocities.append(start.velocities[one.link])

    def numbered(kept: Sequence[Kept]) -> tuple[Kept, ...]:
        named = ((kind, before.joints[k].name) for kind, k in kept if kind == "slide")
        angles = (one for one in kept if one[0] == "angle" and one[1] < count)
        return (*angles, *((kind, joints[name]) for kind, name in named if name in joints))

    missing = len(poses) - len(start.sketch.angles[:count])
    sketch = replace(
        start.sketch,
        angles=(*start.sketch.angles[:count], *(0.0 for _ in range(missing))),
        rates=(*start.sketch.rates[:count], *(None for _ in range(missing))),
    )
    return replace(
        start,
        poses=tuple(poses),
        velocities=tuple(velocities),
        sketch=sketch,
        kept_places=numbered(start.kept_places),
        kept_rates=numbered(start.kept_rates),
        wanted=(),
    )


def _at(
    mechanism: Mechanism, ref: PointRef, poses: Sequence[Triple], velocities: Sequence[Triple]
) -> tuple[Triple, Triple]:
    """Pose and velocity of a link's frame as it would be at a point of it."""
    if ref.link == GROUND:
        return (*mechanism.point(ref).values(), 0.0), (0.0, 0.0, 0.0)
    (x, y, angle), (u, v, spin) = poses[ref.link], velocities[ref.link]
    along, across = mechanism.point(ref).values()
    c, s = math.cos(angle), math.sin(angle)
    way = c * along - s * across, s * along + c * across
    return (x + way[0], y + way[1], angle), (u - spin * way[1], v + spin * way[0], spin)
