"""How the start is assembled, for a person: the branch of each loop, joints that are redundant, what cannot move."""

from __future__ import annotations

from collections.abc import Sequence

from ..mechanism.branch import branches
from ..mechanism.implied import implied
from ..mechanism.integrators import without_integrators
from ..mechanism.mechanism import Mechanism
from ..mechanism.redundancy import Group, Mobility, mobility
from ..mechanism.topology import Topology
from ..scene.scene import Scene

EXAMINED = 300
"""Links up to which redundant joints are looked for."""
LISTED = 10
"""Joints that a line names before it counts the others. One more than these is named too, in no more room."""


def branch_lines(scene: Scene, topology: Topology) -> list[str]:
    """The branch of each loop at the start."""
    mechanism = scene.mechanism
    closing, idle = ([found.joint for found in joints] for joints in (topology.cuts, topology.implied))
    closing = [joint for joint in closing if joint not in mechanism.open_gates]
    found = branches(mechanism, scene.start.poses, closing, idle)
    return [branch.text(mechanism) for branch in found]


def mobility_of(scene: Scene) -> Mobility | None:
    """The mobility at the start; ``None`` for mechanisms that are too large to look for redundant joints."""
    mechanism, links = moving(scene.mechanism)
    return mobility(mechanism, [scene.start.poses[k] for k in links]) if len(links) <= EXAMINED else None


def redundancy_lines(scene: Scene, found: Mobility | None, every: bool = False) -> list[str]:
    """What is not as Grübler counts: joints that are redundant, a change point, a structure. Of many joints the first
    are named and the others counted, unless ``every`` one is asked for."""
    idle, mechanism = implied_lines(scene, every), moving(scene.mechanism)[0]
    if found is None:
        return [*idle, f"more than {EXAMINED} links: not searched for redundant joints"]
    lines = [*(f"redundant: {_group(mechanism, group, every)}" for group in found.groups), *idle]
    if found.elsewhere < found.freedom:
        lines += [
            f"in line here, not elsewhere (a change point, {found.elsewhere} degree{'s' * (found.elsewhere != 1)} of "
            "freedom nearby): " + _group(mechanism, group, every)
            for group in found.here
        ]
    if found.structure:
        lines.append("a structure: nothing can move, only forces can be asked for")
    return lines


def moving(mechanism: Mechanism) -> tuple[Mechanism, tuple[int, ...]]:
    """The mechanism without what integrates, and the numbers of its links."""
    return without_integrators(mechanism, [one.name for one in mechanism.integrators])


def implied_lines(scene: Scene, every: bool = False) -> list[str]:
    """Joints that follow from others, and what becomes of them."""
    joints = scene.mechanism.joints
    return [
        f"{joints[idle.joint].name} holds what {_listed([joints[part.joint].name for part in idle.way], every)} hold"
        f"{'s' * (len(idle.way) == 1)}: it is left out of the equations, and the forces are shared"
        for idle in implied(scene.mechanism, scene.driven)
    ]


def _group(mechanism: Mechanism, group: Group, every: bool) -> str:
    held = [*(joint.name for joint in mechanism.joints), *(mesh.name for mesh in mechanism.meshes)]
    names = _listed([held[joint] for joint in group.joints], every)
    count = f"{group.surplus} equation{'s' * (group.surplus != 1)}"
    return f"{names} together have {count} more than they need, so their reactions are not determined by the motion"


def _listed(names: Sequence[str], every: bool) -> str:
    """The names with commas between them; of many the first, and how many more there are."""
    if every or len(names) <= LISTED + 1:
        return ", ".join(names)
    return f"{', '.join(names[:LISTED])} and {len(names) - LISTED} more"
