"""What joints slide along, and the blocks that slide, as shapes in the frames of links."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ..arrays import FloatArray
from ..model.joint_sides import ends_of
from ..record.drawable import Drawable
from .frames import Frames

BEYOND = 0.06
"""How far a guide goes beyond what is slid along it, of the mechanism's size."""
BLOCK = np.array([[-1.0, -0.6], [1.0, -0.6], [1.0, 0.6], [-1.0, 0.6], [-1.0, -0.6]])
HALF_BLOCK = 0.04
"""Half a block's length, of that size."""


@dataclass(frozen=True)
class Guide:
    """A line that a joint slides along, or a block, by its points (m, 2) in the frame of a ``link``; -1: the ground."""

    kind: Literal["line", "block"]
    link: int
    points: FloatArray


def guides_of(model: Drawable, frames: Frames, size: float) -> tuple[Guide, ...]:
    """Lines as far as the joints slide in these frames, and a bit more, and the blocks of those that do not turn."""
    found: list[Guide] = []
    whole: Any = model
    for joint, lengths in model.slides(frames.q).items():
        if joint not in model.drawn_joints:
            continue
        ends = ends_of(whole, joint)
        if any(link >= 0 and not len(model.outlines[link]) for link in ends.links):
            continue  # a carriage without mass, of which nothing is to be seen
        way = np.array([np.cos(ends.axis), np.sin(ends.axis)])
        reach = np.array([np.min(lengths) - BEYOND * size, np.max(lengths) + BEYOND * size])
        found.append(Guide("line", ends.links[0], ends.points[0] + reach[:, None] * way))
        if ends.kind == "prismatic":
            angle = ends.axis - ends.angle
            turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
            found.append(Guide("block", ends.links[1], ends.points[1] + HALF_BLOCK * size * BLOCK @ turn))
    return tuple(found)
