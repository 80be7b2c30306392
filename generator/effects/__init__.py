"""Effects that a scene can name, one module each. To add one, write its module and add its entry below."""

from ..effect_base.effect import Contact, Effect, Entry, Level, Surroundings
from . import (
    brake,
    compliant_ground,
    compliant_touch,
    damper,
    drag,
    drive,
    force,
    gravity,
    ground,
    input,
    joint_friction,
    motor,
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
    spring.ENTRY,
    damper.ENTRY,
    torsion.ENTRY,
    joint_friction.ENTRY,
    brake.ENTRY,
    drag.ENTRY,
    motor.ENTRY,
    drive.ENTRY,
    force.ENTRY,
    torque.ENTRY,
    input.ENTRY,
)

__all__ = ["REGISTRY", "Contact", "Effect", "Entry", "Level", "Surroundings"]
