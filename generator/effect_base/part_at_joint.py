"""What is drawn of an effect at a joint."""

from __future__ import annotations

from ..mechanism.joints import Joint
from ..mechanism.links import Parameter
from .effect import Part


def part_at_joint(kind: str, name: str, joint: Joint, *numbers: Parameter | float | None) -> Part:
    """Between the two points that a joint joins."""
    return kind, name, (joint.first, joint.second), numbers


def braker(name: str, joint: Joint) -> Part:
    """Of what brakes a joint: shoes about its pin, or pads beside its line (rad)."""
    if joint.slides:
        return part_at_joint("linear brake", name, joint, joint.axis)
    return part_at_joint("brake", name, joint)


def mover(name: str, joint: Joint) -> Part:
    """Of what moves a joint: an arc about its pin, or an arrow along its line (rad)."""
    if joint.slides:
        return part_at_joint("linear motor", name, joint, joint.axis)
    return part_at_joint("motor", name, joint)
