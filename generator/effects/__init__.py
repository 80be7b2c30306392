"""Effects that a scene can name, one module each. To add one, write its module and add its entry below."""

from ..effect_base.effect import Contact, Effect, Entry, Level, Surroundings
from . import (
    belt,
    brake,
    compliant_ground,
    compliant_touch,
    damper,
    drag,
    drive,
    force,
    gear,
    gravity,
    ground,
    input,
    joint_friction,
    journal,
    motor,
    rack,
    rope,
    spring,
    stop,
    torque,
    torsion,
    touch,
)

REGISTRY: tuple[Entry, ...] = (
    gravity.ENTRY,
    ground.ENTRY,
    compliant_ground.ENTRY,
    stop.ENTRY,
    touch.ENTRY,
    compliant_touch.ENTRY,
    journal.ENTRY,
    rope.ENTRY,
    spring.ENTRY,
    damper.ENTRY,
    torsion.ENTRY,
    joint_friction.ENTRY,
    brake.ENTRY,
    drag.ENTRY,
    motor.ENTRY,
    drive.ENTRY,
    gear.ENTRY,
    rack.ENTRY,
    belt.ENTRY,
    force.ENTRY,
    torque.ENTRY,
    input.ENTRY,
)

__all__ = ["REGISTRY", "Contact", "Effect", "Entry", "Level", "Surroundings"]
