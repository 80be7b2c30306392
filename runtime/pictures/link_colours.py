"""Which colour each link has: links that meet have different ones."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..record.drawable import Drawable
from .frames import Frames, placed

# Told apart with any colour vision (P. Tol's muted and bright schemes), in the order of the links.
COLOURS = ("#4477aa", "#cc6677", "#117733", "#ddaa33", "#88ccee", "#aa4499")
TOGETHER = 1e-6  # points nearer than this part of the size are one


def link_colours(model: Drawable, frames: Frames, size: float) -> list[int]:
    """The number of each link's colour: its own number, or the next that no link before it has which it meets.

    Links meet where points of both are in one place in the first of the ``frames``; ``size`` is the mechanism's (m).
    """
    places = [placed(np.asarray(outline), frames.poses[0, k]) for k, outline in enumerate(model.outlines)]
    found: list[int] = []
    for k, own in enumerate(places):
        taken = [found[other] for other in range(k) if _meet(own, places[other], TOGETHER * size)]
        wishes = [(k + step) % len(COLOURS) for step in range(len(COLOURS))]
        found.append(min(wishes, key=taken.count))  # the first of those that fewest have
    return found


def _meet(one: FloatArray, other: FloatArray, near: float) -> bool:
    if not len(one) or not len(other):
        return False
    return bool(np.min(np.hypot(*np.moveaxis(one[:, None] - other, -1, 0))) <= near)
