"""Gravity: a uniform field, along -y unless told otherwise."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import BeforeValidator, Field
from pydantic_core import PydanticCustomError

from ..effect_base.direction import unit
from ..effect_base.effect import Complain, Effect, Entry, Surroundings
from ..effect_base.table import Direction, Table
from ..effect_base.written_numbers import Measured
from ..mechanism.links import Parameter, Point

if TYPE_CHECKING:
    from ..derive.vectors import Vector


def _read_g(value: object) -> object:
    """A number; of a vector the error says how it is written."""
    if isinstance(value, list) and len(value) == 2 and all(isinstance(x, int | float) for x in value) and any(value):
        size = math.hypot(*value)
        advice = f"write g = {size:.12g} and direction = [{value[0]:g}, {value[1]:g}]"
        raise PydanticCustomError("vector", "{advice}", {"advice": advice})
    return value


class GravityTable(Table):
    """The table ``[gravity]``."""

    g: Annotated[float, Measured("m/s²"), BeforeValidator(_read_g)] = Field(
        default=9.81, description="the acceleration of gravity in m/s², a finite number"
    )
    direction: Direction = Field(
        default=[0.0, -1.0], description="the direction in which things fall, [x, y], not both zero"
    )


@dataclass(frozen=True)
class Gravity(Effect):
    """Uniform gravity ``g`` (m/s²) along -y."""

    g: Parameter

    def parameters(self) -> tuple[Parameter, ...]:
        return (self.g,)

    def field(self) -> Vector:
        from ..derive.vectors import ZERO, symbol

        return (ZERO[0], -symbol(self.g))

    def accelerations(self) -> tuple[Parameter, ...]:
        return (self.g,)

    def remarks(self) -> tuple[tuple[str, str], ...]:
        """Signs that turn gravity round."""
        if self.g.value >= 0.0:
            return ()
        x, y = self.down()
        upwards = f"along [{0.0 - x:.3g}, {0.0 - y:.3g}], against its direction [{x:.3g}, {y:.3g}]"
        return (
            ("g", f"{self.g.value:g} is taken as given, so that things fall {upwards}; write {-self.g.value:g} if not"),
        )

    def down(self) -> tuple[float, float]:
        """The direction that a positive g points in."""
        return (0.0, -1.0)


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
        from ..derive.vectors import local, symbol

        x, y = local(self.direction) if isinstance(self.direction, Point) else self.direction
        return (symbol(self.g) * x, symbol(self.g) * y)

    def down(self) -> tuple[float, float]:
        x, y = self.direction.values() if isinstance(self.direction, Point) else self.direction
        return (float(x), float(y))


def build(table: GravityTable, index: int, around: Surroundings, complain: Complain) -> Gravity | None:
    """The record of a table, or ``None`` after having complained."""
    x, y = table.direction
    down = unit(table.direction)
    if down is None:
        complain(("direction",), f"found [{x:g}, {y:g}], expected a direction, [x, y], not both zero; correct it")
        return None
    g = Parameter("gravity.g", "g", table.g)
    if down[0] and down[1]:
        path = "gravity.direction"
        direction = Point(Parameter(f"{path}.x", "down_x", down[0]), Parameter(f"{path}.y", "down_y", down[1]))
        return DirectedGravity(g, direction)
    if y < 0.0:
        return Gravity(g)
    return DirectedGravity(g, ((x > 0.0) - (x < 0.0), (y > 0.0) - (y < 0.0)))


ENTRY = Entry("gravity", False, GravityTable, build)
