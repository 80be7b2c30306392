"""Links in line at a dead point."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from .geometry import Geometry

MOVES = 1e-2
"""Links that move less than this part of those that move most stand still; so far from the stop they do nearly."""


def lined_up(model: Geometry, q: FloatArray, motion: FloatArray) -> str:
    """The beginning of a sentence on two links on one pin, each on one more pin that stands still, that alone move by
    ``motion`` (nu,) from the configuration ``q`` (nq,), at which loops close no further: they are in line there. Else
    nothing."""
    speeds = np.abs(np.asarray(model.velocities(q, motion), dtype=float) / [model.length, model.length, 1.0]).max(
        axis=1
    )
    moving = np.flatnonzero(speeds > MOVES * speeds.max())
    pins = [
        links
        for joint, links in zip(model.joints, model.data["between"], strict=True)
        if joint not in model.data["lines"]
    ]
    on = [[links for links in model.data["between"] if link in links] for link in moving]
    if len(moving) != 2 or sorted(moving) not in map(sorted, pins) or any(len(own) != 2 for own in on):
        return ""
    if any(links not in pins for own in on for links in own):
        return ""
    first, second = (model.links[link] for link in moving)
    return f"{first} and {second} are in line there, and "
