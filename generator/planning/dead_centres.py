"""Which dyads stand away from their dead centres, by numbers: those that may be closed by themselves."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..mechanism.mechanism import Mechanism
from ..mechanism.topology import Cut, Topology

Triple = tuple[float, float, float]

SMALLEST_SINE = 0.1
"""Sine of the angle between a dyad's arms below which the state is solved on another way: rounding grows as 1/sine."""

SOUND = 1.2 * SMALLEST_SINE
"""The least such sine at the start and on the motion through it, so that a model does not begin on its second way, and
seldom takes it."""


def sound_dyads(mechanism: Mechanism, topology: Topology, poses: Sequence[Triple]) -> tuple[int, ...]:
    """Cut pins whose two links stand across each other where the links are at ``poses`` (x, y, angle of each), but
    those that may be open."""
    inboard = {branch.link: branch.inboard for branch in topology.branches}

    def sine(cut: Cut) -> float:
        arms = []
        for ref in (cut.first, cut.second):
            if ref.link not in inboard:
                return 0.0
            points = mechanism.links[ref.link].points
            (x, y), (x0, y0) = points[ref.point].values(), points[inboard[ref.link]].values()
            arms.append(complex(x - x0, y - y0) * complex(math.cos(poses[ref.link][2]), math.sin(poses[ref.link][2])))
        area, size = (arms[0].conjugate() * arms[1]).imag, abs(arms[0]) * abs(arms[1])
        return abs(area) / size if size > 0.0 else 0.0

    lasting = (cut for cut in topology.cuts if cut.kind == "revolute" and cut.gate is None)
    return tuple(cut.joint for cut in lasting if sine(cut) > SOUND)


def lasting_dyads(mechanism: Mechanism, topology: Topology, samples: Sequence[Sequence[Triple]]) -> tuple[int, ...]:
    """Cut pins whose dyads are sound at every one of the ``samples``, at least one, of the motion."""
    found = [sound_dyads(mechanism, topology, poses) for poses in samples]
    return tuple(joint for joint in found[0] if all(joint in others for others in found[1:]))
