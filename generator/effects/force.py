"""Force: an external force on a point of a link."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from ..effect_base.changing import Changing
from ..effect_base.effect import Complain, Effect, Entry, Part, Surroundings
from ..effect_base.expression_of_state import InLoad, sides_of, switching_of
from ..effect_base.expression_of_time import (
    Law,
    Quantity,
    load_quantity,
    own_parameters,
    quantity,
    term,
    those_over_time,
)
from ..effect_base.points import find_point
from ..effect_base.table import Name, PointName, Table
from ..mechanism.joints import PointRef
from ..mechanism.links import GROUND, Parameter
from ..mechanism.mechanism import Mechanism

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Force as Load
    from ..derive.motion import Motion
    from ..derive.terms_of_effects import Told
    from ..derive.vectors import Vector

Frame = Literal["fixed", "link"]
FRAME = '"fixed" for fixed axes or "link" for axes that turn with the link'


class ForceTable(Table):
    """One ``[[force]]``."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    point: PointName = Field(description='the point it acts on, a joint or "link.point"')
    vector: Annotated[list[Annotated[Law, InLoad("N")]], Field(min_length=2, max_length=2)] = Field(
        description="the force [x, y] in N, numbers or expressions of t or of the state"
    )
    frame: Frame = Field(default="fixed", description=FRAME)


@dataclass(frozen=True)
class Force(Effect):
    """A force (N) on a point: ``vector`` in fixed axes, or in axes that turn with the point's link."""

    index: int
    name: str
    point: PointRef
    vector: tuple[Quantity, Quantity]
    frame: Frame

    def parameters(self) -> tuple[Parameter, ...]:
        return own_parameters(*self.vector)

    def over_time(self) -> Mapping[str, Changing]:
        return those_over_time({f"{self.name}.vector.{axis}": of for axis, of in zip("xy", self.vector, strict=True)})

    def sides(self) -> tuple[str, ...]:
        return sides_of(self._named())

    def jumps(self) -> bool:
        return False

    def switching(self, motion: Motion) -> Sequence[Expr]:
        return switching_of(self._named(), motion)

    def loads(self, motion: Motion) -> Sequence[Load]:
        from ..derive.motion import Force as Load

        return (Load(self.point, self._force(motion)),)

    def power(self, motion: Motion) -> Expr:
        """The force times the point's velocity."""
        from ..derive.vectors import dot

        return dot(self._force(motion), motion.velocity(self.point))

    def outputs(self, motion: Motion) -> Sequence[Told]:
        """The force in fixed axes, and its power."""
        x, y = self._force(motion)
        on = self.point.link
        return ("fx", "N", x, on), ("fy", "N", y, on), ("power", "W", self.power(motion))

    def parts(self, mechanism: Mechanism) -> tuple[Part, ...]:
        """An arrow at the point: the force, or where it changes with time 1 along each axis that it has."""
        changes = any(isinstance(part, Changing) for part in self.vector)
        shown = tuple(float(part is not None) for part in self.vector) if changes else self._constant()
        turns = float(self.frame == "link")
        return (("force", self.name, (self.point, self.point), (*shown, float(changes), turns)),)

    def _constant(self) -> tuple[Parameter | None, ...]:
        return tuple(part if isinstance(part, Parameter) else None for part in self.vector)

    def _named(self) -> dict[str, Quantity]:
        """The components by their names in the equations."""
        return {f"force_{self.index}_{axis}": of for axis, of in zip("xy", self.vector, strict=True)}

    def _force(self, motion: Motion) -> Vector:
        x, y = (term(part, motion, name) for name, part in self._named().items())
        if self.frame == "fixed":
            return x, y
        return motion.let_vector(f"turned_force_{self.index}", motion.kinematics.turn(self.point.link, (x, y)))


def find_loaded(name: str, frame: str, mechanism: Mechanism) -> tuple[PointRef | None, str]:
    """The point that a force acts on, or what is wrong with its name."""
    ref, wrong = find_point(name, mechanism)
    if ref is not None and ref.link == GROUND:
        return None, "the ground does not move; choose a point of a link"
    if ref is not None and frame == "link" and "." not in name:
        return None, 'a joint has two links; write "link.point" to say whose axes are meant'
    return ref, wrong


def build(table: ForceTable, index: int, around: Surroundings, complain: Complain) -> Force | None:
    """The record of a table, or ``None`` after having complained."""
    ref, wrong = find_loaded(table.point, table.frame, around.mechanism)
    if ref is None:
        complain(("point",), f'found "{table.point}", expected a joint or link.point that moves; {wrong}')
    name = table.name or f"force_{index}"
    # one component that is zero is left out; of a force that is zero both are kept, so that they can be raised
    made = load_quantity if table.vector == [0.0, 0.0] else quantity
    x, y = (
        made(law, f"{name}.vector.{axis}", f"F_force_{index}_{axis}")
        for law, axis in zip(table.vector, "xy", strict=True)
    )
    return Force(index, name, ref, (x, y), table.frame) if ref else None


ENTRY = Entry("force", True, ForceTable, build, {"vector": "vector"})
