"""Gravity: a uniform field, along -y unless told otherwise."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pydantic import Field

from ..mechanism.links import Parameter, Point
from .effect import Complain, Effect, Entry, Surroundings
from .table import Pair, Table

if TYPE_CHECKING:
    from ..derive.kinematics import Vector


class GravityTable(Table):
    """The table ``[gravity]``."""

    g: float = Field(default=9.81, description="the acceleration of gravity in m/s², a finite number")
    direction: Pair = Field(
        default=[0.0, -1.0], description="the direction in which things fall, [x, y], not both zero"
    )


@dataclass(frozen=True)
class Gravity(Effect):
    """Uniform gravity ``g`` (m/s²) along -y."""

    g: Parameter

    def parameters(self) -> tuple[Parameter, ...]:
        return (self.g,)

    def field(self) -> Vector:
        from ..derive.kinematics import ZERO, symbol

        return (ZERO[0], -symbol(self.g))


@dataclass(frozen=True)
class DirectedGravity(Gravity):
    """Uniform gravity ``g`` (m/s²) along ``direction``: whole numbers along an axis, else parameters, of length 1."""

    direction: tuple[int, int] | Point

    @property
    def title(self) -> str:
        return "gravity"

    def parameters(self) -> tuple[Parameter, ...]:
        return (self.g, *(self.direction.parameters() if isinstance(self.direction, Point) else ()))

    def field(self) -> Vector:
        from ..derive.kinematics import local, symbol

        x, y = local(self.direction) if isinstance(self.direction, Point) else self.direction
        return (symbol(self.g) * x, symbol(self.g) * y)


def build(table: GravityTable, index: int, around: Surroundings, complain: Complain) -> Gravity | None:
    """The record of a table, or ``None`` after having complained."""
    x, y = table.direction
    length = math.hypot(x, y)
    if not 0.0 < length < math.inf:
        complain(("direction",), f"found [{x:g}, {y:g}], expected a direction, [x, y], not both zero; correct it")
        return None
    g = Parameter("gravity.g", "g", table.g)
    if x and y:
        path = "gravity.direction"
        direction = Point(Parameter(f"{path}.x", "down_x", x / length), Parameter(f"{path}.y", "down_y", y / length))
        return DirectedGravity(g, direction)
    if y < 0.0:
        return Gravity(g)
    return DirectedGravity(g, ((x > 0.0) - (x < 0.0), (y > 0.0) - (y < 0.0)))


ENTRY = Entry("gravity", False, GravityTable, build)
