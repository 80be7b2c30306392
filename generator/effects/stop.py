"""Stop: limits of a joint, of its angle or along its line, off which it bounces and against which it leans."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from ..effect_base.contact import Restitution
from ..effect_base.effect import Complain, Effect, Entry, Part, Surroundings
from ..effect_base.part_at_joint import part_at_joint
from ..effect_base.points import find_joint
from ..effect_base.table import JointName, Name, Table
from ..effect_base.written_numbers import Measured, as_written, wrong_kind
from ..mechanism.joints import Joint
from ..mechanism.links import FROM_0_TO_1, Parameter

if TYPE_CHECKING:
    from ..derive.gaps import Gap
    from ..derive.terms_of_effects import Let
    from ..mechanism.assembled import Assembled
    from ..mechanism.mechanism import Mechanism

DEPTH = 1e-9
"""A start further beyond a stop than this (rad, m) is wrong; less is rounding."""


class StopTable(Table):
    """One ``[[stop]]``."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    joint: JointName = Field(description='the joint that it limits, such as "joint_1"')
    lowest: Annotated[float, Measured("rad", "m")] | None = Field(
        default=None,
        description='the joint\'s lowest angle in rad, or a text such as "-30 deg" (m along its line where it slides)',
    )
    highest: Annotated[float, Measured("rad", "m")] | None = Field(
        default=None,
        description='the joint\'s highest angle in rad, or a text such as "60 deg" (m along its line where it slides)',
    )
    restitution: Restitution = Field(description="the coefficient of restitution, a number from 0 to 1")


@dataclass(frozen=True)
class Limit:
    """One side of a stop: ``lowest`` or ``highest``, the angle (rad) or place along the line (m), and its parameter
    unless it is exactly zero."""

    key: str
    value: float
    parameter: Parameter | None

    @property
    def sign(self) -> int:
        """1 where the joint must be above the limit, −1 where below."""
        return 1 if self.key == "lowest" else -1


@dataclass(frozen=True)
class Stop(Effect):
    """Keeps the angle of ``joint`` (number ``place`` of the mechanism), second link against first, or where it slides
    its way along the line, from its lowest to its highest: one or both."""

    index: int
    name: str
    place: int
    joint: Joint
    limits: tuple[Limit, ...]
    restitution: Parameter

    def __post_init__(self) -> None:
        values = [limit.value for limit in self.limits]
        if not values or (len(values) == 2 and not values[0] < values[1]):
            raise ValueError(f"{self.name} has the limits {values}; expected one, or a lower and a higher one")
        if not 0.0 <= self.restitution.value <= 1.0:
            raise ValueError(f"{self.restitution.path} is {self.restitution.value}; it must be from 0 to 1")

    def at_joints(self) -> tuple[int, ...]:
        return (self.place,)

    def parameters(self) -> tuple[Parameter, ...]:
        return (*(limit.parameter for limit in self.limits if limit.parameter), self.restitution)

    def gaps(self, let: Let) -> tuple[Gap, ...]:
        """One gap per limit, called ``stop.lowest`` and ``stop.highest``."""
        from ..derive.gaps import JointGap
        from ..derive.vectors import symbol

        joint, e = self.joint, symbol(self.restitution)
        at = self.place, joint.slides, (joint.first, joint.second)
        return tuple(
            JointGap(joint.name, f"{self.name}.{limit.key}", *at, limit.sign, symbol(limit.parameter), e)
            for limit in self.limits
        )

    def parts(self, mechanism: Mechanism) -> tuple[Part, ...]:
        """One for each limit, with its angle (rad); where it slides with its place (m), the direction (rad) and the
        sign of what is beyond it."""
        if self.joint.slides:
            return tuple(
                part_at_joint(
                    "linear stop", self.name, self.joint, limit.parameter, self.joint.axis, float(-limit.sign)
                )
                for limit in self.limits
            )
        return tuple(part_at_joint("stop", self.name, self.joint, limit.parameter) for limit in self.limits)

    def angles(self) -> tuple[str, ...]:
        return () if self.joint.slides else tuple(limit.key for limit in self.limits)

    def check_start(self, start: Assembled) -> tuple[str, ...]:
        found, unit = start.angle(self.joint.second.link) - start.angle(self.joint.first.link), "rad"
        counted = ", whole turns counted; turn the start or move the stop"
        if self.joint.slides:
            found, unit, counted = start.length(self.place), "m", "; move the start or the stop"
        sides = {"lowest": "at least", "highest": "at most"}
        return tuple(
            f"the start has {self.joint.name} at {found:.6g} {unit}, expected {sides[limit.key]} "
            f"{as_written(limit.value, unit)}{counted}"
            for limit in self.limits
            if limit.sign * (found - limit.value) < -DEPTH
        )


def build(table: StopTable, index: int, around: Surroundings, complain: Complain) -> Stop | None:
    """The record of a table, or ``None`` after having complained."""
    joint, wrong = find_joint(table.joint, around.mechanism)
    if joint is None:
        complain(("joint",), f'found "{table.joint}", expected a joint; {wrong}')
    name = table.name or f"stop_{index}"
    given = {"lowest": table.lowest, "highest": table.highest}
    limits = tuple(
        Limit(key, value, Parameter(f"{name}.{key}", f"{key}_{index}", float(value)) if value else None)
        for key, value in given.items()
        if value is not None
    )
    slides = joint is not None and around.mechanism.joints[joint].slides
    unit, what = ("m", "place") if slides else ("rad", "angle")
    wrong_units = {key: wrong_kind(value, unit) for key, value in given.items() if joint is not None}
    for key, sentence in wrong_units.items():
        if sentence:
            complain((key,), sentence)
    if not limits:
        complain((), "found neither lowest nor highest, expected one of them or both; add one")
    if any(wrong_units.values()):
        return None
    if len(limits) == 2 and not limits[0].value < limits[1].value:
        low, high = (as_written(limit.value, unit) for limit in limits)
        complain(("lowest",), f"found {low}, expected less than the highest {what}, {high}; exchange them")
        return None
    if joint is None or not limits:
        return None
    restitution = Parameter(f"{name}.restitution", f"es_{index}", table.restitution, FROM_0_TO_1)
    return Stop(index, name, joint, around.mechanism.joints[joint], limits, restitution)


ENTRY = Entry("stop", True, StopTable, build, {"lowest": "lowest angle", "highest": "highest angle"})
