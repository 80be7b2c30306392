"""What is drawn where effects act, and of joints that slide: springs, motors, teeth, blocks in their guides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..arrays import FloatArray


@dataclass(frozen=True)
class Part:
    """A part of the given `kind` at points (k, 2), in m, of the frames of its `links`; -1 is the ground.

    Kinds and `numbers` (m, rad) are those of `parts[]` in model.json, and "slider": a joint's two links and points,
    with the angle of its line in the first link's frame, or "rails", where the second link is drawn as it is.
    """

    kind: str
    name: str
    links: Sequence[int]
    points: FloatArray
    numbers: Sequence[float]
