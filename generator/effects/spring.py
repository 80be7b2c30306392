"""Spring: a linear spring without mass between two points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from ..effect_base.effect import Complain, Effect, Entry, Place, Surroundings
from ..effect_base.line import Line, find_line
from ..effect_base.table import Name, NotNegative, PointName, Positive, Table
from ..effect_base.written_numbers import Measured
from ..mechanism.links import NOT_NEGATIVE, Parameter

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Force, Motion


class SpringTable(Table):
    """One ``[[spring]]``."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    between: list[PointName] = Field(
        min_length=2, max_length=2, description='the two points it joins, ["link.point", "ground.point"]'
    )
    stiffness: Annotated[Positive, Measured("N/m")] = Field(description="the stiffness in N/m, a positive number")
    length: Annotated[NotNegative, Measured("m")] = Field(
        default=0.0, description="the length at rest in m, zero or a positive number"
    )


@dataclass(frozen=True)
class Spring(Effect):
    """Pulls the ends of its line together with ``stiffness`` (N/m) times its elongation beyond ``length`` (m)."""

    name: str
    line: Line
    stiffness: Parameter
    length: Parameter | None

    def parameters(self) -> tuple[Parameter, ...]:
        return (self.stiffness, *((self.length,) if self.length else ()))

    def loads(self, motion: Motion) -> Sequence[Force]:
        """k (L − L₀) along the line; without a length at rest, k times the vector between the points."""
        tension = motion.value(self.stiffness)
        if self.length:
            slack = 1 - motion.value(self.length) / self.line.length(motion)
            tension = motion.let(f"tension_{self.line.label}", tension * slack)
        return self.line.pull(motion, tension)

    def potential(self, motion: Motion) -> Expr:
        """½ k (L − L₀)²."""
        stiffness = motion.value(self.stiffness)
        if self.length is None:
            return stiffness * self.line.square(motion) / 2
        return stiffness * (self.line.length(motion) - motion.value(self.length)) ** 2 / 2

    def check_start(self, place: Place) -> tuple[str, ...]:
        if self.length is None or not self.line.is_point(place):
            return ()
        return (
            f"the start has both ends of {self.name} at the same place, where a spring with a length at rest has no "
            "direction; change the start, or leave out the length",
        )


def build(table: SpringTable, index: int, around: Surroundings, complain: Complain) -> Spring | None:
    """The record of a table, or ``None`` after having complained."""
    label = f"spring_{index}"
    name = table.name or label
    line = find_line(label, table.between, around.mechanism, complain)
    if line is None:
        return None
    length = Parameter(f"{name}.length", f"L0_{label}", table.length, NOT_NEGATIVE) if table.length else None
    return Spring(name, line, Parameter(f"{name}.stiffness", f"k_{label}", table.stiffness, NOT_NEGATIVE), length)


ENTRY = Entry("spring", True, SpringTable, build)
