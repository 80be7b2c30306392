"""Damper: a linear damper without mass between two points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from ..effect_base.effect import Complain, Effect, Entry, Part, Surroundings
from ..effect_base.line import Line, find_line
from ..effect_base.table import Name, NotNegative, PointName, Table
from ..effect_base.written_numbers import Measured
from ..mechanism.links import NOT_NEGATIVE, Parameter

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Force, Motion
    from ..derive.terms_of_effects import Told
    from ..derive.vectors import Vector
    from ..mechanism.assembled import Assembled
    from ..mechanism.mechanism import Mechanism


class DamperTable(Table):
    """One ``[[damper]]``."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    between: list[PointName] = Field(
        min_length=2, max_length=2, description='the two points it joins, ["link.point", "ground.point"]'
    )
    damping: Annotated[NotNegative, Measured("N s/m")] = Field(
        description="the damping in N s/m, zero or a positive number"
    )


@dataclass(frozen=True)
class Damper(Effect):
    """Resists the change of its line's length with ``damping`` (N s/m) times the rate of that length."""

    name: str
    line: Line
    damping: Parameter

    def parameters(self) -> tuple[Parameter, ...]:
        return (self.damping,)

    def reaches(self, motion: Motion) -> Sequence[Vector]:
        return (self.line.reach(motion),)

    def loads(self, motion: Motion) -> Sequence[Force]:
        """c dL/dt along the line: (r·ṙ)/(r·r) times the vector r between the points."""
        line = self.line
        tension = motion.value(self.damping) * line.stretching(motion) / line.square(motion)
        return line.pull(motion, motion.let(f"tension_{line.label}", tension))

    def power(self, motion: Motion) -> Expr:
        """−c (dL/dt)²."""
        line = self.line
        return -motion.value(self.damping) * line.stretching(motion) ** 2 / line.square(motion)

    def outputs(self, motion: Motion) -> Sequence[Told]:
        """The force that pulls its ends together, and its power."""
        line = self.line
        speed = line.stretching(motion) / line.length(motion)
        return ("force", "N", motion.value(self.damping) * speed), ("power", "W", self.power(motion))

    def parts(self, mechanism: Mechanism) -> tuple[Part, ...]:
        return (("damper", self.name, self.line.points, ()),)

    def check_start(self, start: Assembled) -> tuple[str, ...]:
        if not self.line.is_point(start):
            return ()
        return (
            f"the start has both ends of {self.name} at the same place, where a damper has no direction; "
            "change the start or the points",
        )


def build(table: DamperTable, index: int, around: Surroundings, complain: Complain) -> Damper | None:
    """The record of a table, or ``None`` after having complained."""
    label = f"damper_{index}"
    name = table.name or label
    line = find_line(label, table.between, around.mechanism, complain)
    return Damper(name, line, Parameter(f"{name}.damping", f"c_{label}", table.damping, NOT_NEGATIVE)) if line else None


ENTRY = Entry("damper", True, DamperTable, build, {})
