"""Stop: limits of a joint's angle, off which it bounces and against which it leans."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from pydantic import Field

from ..effect_base.contact import Restitution
from ..effect_base.effect import Complain, Effect, Entry, Part, Surroundings
from ..effect_base.part_at_joint import part_at_joint
from ..effect_base.points import find_joint, written
from ..effect_base.table import JointName, Name, Table
from ..effect_base.written_numbers import Angle, as_written
from ..mechanism.joints import Joint
from ..mechanism.links import FROM_0_TO_1, GROUND, Parameter

if TYPE_CHECKING:
    from ..derive.gaps import Gap
    from ..derive.terms_of_effects import Let
    from ..mechanism.assembled import Assembled
    from ..mechanism.mechanism import Mechanism

DEPTH = 1e-9
"""A start further beyond a stop than this (rad) is wrong; less is rounding."""


class StopTable(Table):
    """One ``[[stop]]``."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    joint: JointName = Field(description='the joint that it limits, such as "joint_1"')
    lowest: Angle | None = Field(
        default=None, description='the joint\'s lowest angle in rad, or a text such as "-30 deg"'
    )
    highest: Angle | None = Field(
        default=None, description='the joint\'s highest angle in rad, or a text such as "60 deg"'
    )
    restitution: Restitution = Field(description="the coefficient of restitution, a number from 0 to 1")


@dataclass(frozen=True)
class Limit:
    """One side of a stop: ``lowest`` or ``highest``, the angle (rad), and its parameter unless it is exactly zero."""

    key: str
    value: float
    parameter: Parameter | None

    @property
    def sign(self) -> int:
        """1 where angles must be above the limit, −1 where below."""
        return 1 if self.key == "lowest" else -1


@dataclass(frozen=True)
class Stop(Effect):
    """Keeps the angle of ``joint``, second link against first, from its lowest to its highest: one or both."""

    index: int
    name: str
    joint: Joint
    limits: tuple[Limit, ...]
    restitution: Parameter

    def __post_init__(self) -> None:
        values = [limit.value for limit in self.limits]
        if not values or (len(values) == 2 and not values[0] < values[1]):
            raise ValueError(f"{self.name} has the limits {values}; expected one, or a lower and a higher one")
        if not 0.0 <= self.restitution.value <= 1.0:
            raise ValueError(f"{self.restitution.path} is {self.restitution.value}; it must be from 0 to 1")

    def parameters(self) -> tuple[Parameter, ...]:
        return (*(limit.parameter for limit in self.limits if limit.parameter), self.restitution)

    def gaps(self, let: Let) -> tuple[Gap, ...]:
        """One gap per limit, called ``stop.lowest`` and ``stop.highest``."""
        from ..derive.gaps import AngleGap
        from ..derive.vectors import symbol

        first, second, e = self.joint.first.link, self.joint.second.link, symbol(self.restitution)
        return tuple(
            AngleGap(self.joint.name, f"{self.name}.{limit.key}", first, second, limit.sign, symbol(limit.parameter), e)
            for limit in self.limits
        )

    def parts(self, mechanism: Mechanism) -> tuple[Part, ...]:
        """One for each limit, with its angle (rad)."""
        return tuple(part_at_joint("stop", self.name, self.joint, limit.parameter) for limit in self.limits)

    def check_start(self, start: Assembled) -> tuple[str, ...]:
        found = start.angle(self.joint.second.link) - start.angle(self.joint.first.link)
        sides = {"lowest": "at least", "highest": "at most"}
        return tuple(
            f"the start has {self.joint.name} at {found:.6g} rad, expected {sides[limit.key]} "
            f"{as_written(limit.value, 'rad')}, whole turns counted; turn the start or move the stop"
            for limit in self.limits
            if limit.sign * (found - limit.value) < -DEPTH
        )


def build(table: StopTable, index: int, around: Surroundings, complain: Complain) -> Stop | None:
    """The record of a table, or ``None`` after having complained."""
    joint, wrong = find_joint(table.joint, around.mechanism)
    if joint is not None and around.mechanism.joints[joint].slides:
        wrong = _where_it_slides(around.mechanism, joint)
        joint = None
    if joint is None:
        complain(("joint",), f'found "{table.joint}", expected a joint; {wrong}')
    name = table.name or f"stop_{index}"
    given = {"lowest": table.lowest, "highest": table.highest}
    limits = tuple(
        Limit(key, value, Parameter(f"{name}.{key}", f"{key}_{index}", float(value)) if value else None)
        for key, value in given.items()
        if value is not None
    )
    if not limits:
        complain((), "found neither lowest nor highest, expected one of them or both; add one")
    if len(limits) == 2 and not limits[0].value < limits[1].value:
        low, high = (as_written(limit.value, "rad") for limit in limits)
        complain(("lowest",), f"found {low}, expected less than the highest angle, {high}; exchange them")
        return None
    if joint is None or not limits:
        return None
    restitution = Parameter(f"{name}.restitution", f"es_{index}", table.restitution, FROM_0_TO_1)
    return Stop(index, name, around.mechanism.joints[joint], limits, restitution)


def _where_it_slides(mechanism: Mechanism, joint: int) -> str:
    """What is wrong with a stop of a joint that slides, and what to write in its place."""
    first, second = mechanism.joints[joint].first, mechanism.joints[joint].second
    point = written(second, mechanism)
    if first.link == GROUND:
        write = f'[[ground]] with its normal along the line, to where it may slide, and contacts = ["{point}"]'
    else:
        write = f'[[touch]] between "{point}" and an edge of {mechanism.link_name(first.link)} across the line'
    return f"it slides along a line; a stop limits the angle of a revolute joint, and the end of a line is a {write}"


ENTRY = Entry("stop", True, StopTable, build, {"lowest": "lowest angle", "highest": "highest angle"})
