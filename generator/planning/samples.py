"""Closed configurations along a motion, at which a plan's pivots are judged by numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ..mechanism.assembly import CannotClose, shut, tangent
from ..mechanism.layout import Layout, Real, lay_out
from ..mechanism.mechanism import Mechanism

Poses = tuple[tuple[float, float, float], ...]

STEP = 0.4
"""Change of the fastest displacement (rad; of a slide in units of the mechanism's size) from a sample to the next."""

STEPS = 8
"""Samples each way: together with the start they take the fastest link once around, 2 · 8 · 0.4 rad = 2.04 π."""

STILL = 1e-9
"""A unit motion of which the closure leaves no more than this is none: the mechanism cannot move on."""


def sample_poses(mechanism: Mechanism, poses: Sequence[tuple[float, float, float]]) -> tuple[Poses, ...]:
    """Poses (x, y, angle of each link) on a motion through ``poses``, both ways, loops closed; these themselves first.

    A mechanism of one degree of freedom goes once around; of more, along one path that stands for all. It ends early
    where the loops let it go no further. Prescribed motions are left out of account: the machine is turned by hand.
    """
    layout = lay_out(mechanism)
    start = layout.read_off(np.array(poses, dtype=float))
    found: list[Poses] = [tuple(poses)]
    for way in (1.0, -1.0):
        for x in _path(layout, start, way * np.cos(1.0 + np.arange(len(start)))):
            rows = layout.poses(x, poses[0][:2]).tolist()
            found.append(tuple((x, y, angle) for x, y, angle in rows))
    return tuple(found)


def _path(layout: Layout, x: Real, direction: Real) -> Iterator[Real]:
    """Displacements from ``x`` on, each ``STEP`` from the one before, straight on as far as the closure allows."""
    for _ in range(STEPS):
        direction = tangent(layout, x, direction / np.abs(direction).max())
        size = float(np.abs(direction).max())
        if size <= STILL:
            return
        try:
            moved = shut(layout, x + STEP / size * direction)
        except CannotClose:
            return
        direction, x = moved - x, moved
        if not direction.any():
            return
        yield x
