"""The two sides of a joint."""

from __future__ import annotations

from .joint_gap import Ends
from .model import Model


def between(model: Model, joint: str) -> tuple[int, int]:
    """The two links of a joint; -1: the ground."""
    first, second = model.data["between"][model.joints.index(joint)]
    return first, second


def ends_of(model: Model, joint: str) -> Ends:
    """The two ends of a joint that slides."""
    line = model.data["lines"][joint]
    axis, angle = model._coordinates([[line["axis"], line["angle"] or 0.0]])[0].tolist()
    first, second = line["links"]
    kind = "pin-in-slot" if line["angle"] is None else "prismatic"
    return Ends(kind, (first, second), model._coordinates(line["points"]), axis, angle)
