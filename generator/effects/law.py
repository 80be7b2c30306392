"""Law: a name for an expression of time and state, with parameters, which loads, events and other laws may have."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Literal, get_args

from pydantic import Field

from ..effect_base.effect import Complain, Effect, Entry, Surroundings
from ..effect_base.expression_of_state import InLaw, OfState
from ..effect_base.expression_of_time import Law as Value
from ..effect_base.rows_in_time import CurveRows
from ..effect_base.table import Name, Table
from ..effect_base.written_numbers import Anything
from ..mechanism.links import Parameter
from ..mechanism.mechanism import Mechanism

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Motion
    from ..derive.terms_of_effects import Told


Unit = Literal["1", "N", "N m", "J", "W", "Pa", "rad", "rad/s", "m", "m/s", "N/m"]


class LawTable(Table):
    """One ``[[law]]``."""

    name: Name = Field(description="a name of letters, digits and _, beginning with a letter, that expressions have")
    value: Annotated[Value, InLaw()] = Field(
        description='a number or an expression of t and of the state, "-kp*angle(hip) - kd*rate(hip)"'
    )
    parameters: dict[Name, Annotated[float, Anything()]] = Field(
        default={}, description="names in the expression and their values, { kp = 30.0, kd = 2.0 }"
    )
    curves: dict[Name, CurveRows] = Field(
        default={}, description='functions in it by rows, { gas = { rows = [[x, value], ...], law = "monotone" } }'
    )
    unit: Unit = Field(
        default="1", description="the unit of what it gives, " + ", ".join(f'"{u}"' for u in get_args(Unit))
    )


@dataclass(frozen=True)
class Law(Effect):
    """A name for an expression. It acts on nothing itself."""

    index: int
    name: str
    value: OfState
    constants: tuple[Parameter, ...]
    unit: str

    def parameters(self) -> tuple[Parameter, ...]:
        return self.constants

    def defines(self) -> Mapping[str, OfState]:
        return {self.name: self.value}

    def describe(self, mechanism: Mechanism) -> str:
        curves = [f"{name} is {curve.shown}" for name, curve in self.value.curves]
        return ", ".join((self.value.shown, *curves, *(f"{p.path} = {p.value!r}" for p in self.constants)))

    def sides(self) -> tuple[str, ...]:
        return self.value.sides(f"{self.value.label}_part")

    def jumps(self) -> bool:
        return False

    def switching(self, motion: Motion) -> Sequence[Expr]:
        return self.value.switching(motion, f"{self.value.label}_part")

    def outputs(self, motion: Motion) -> Sequence[Told]:
        """Its value, by its name alone."""
        return (("", self.unit, motion.law(self.name)),)

    def left_out(self) -> Law:
        """A number: what the expression costs is gone, and others may still name it."""
        number = Parameter(self.name, f"number_law_{self.index}", 1.0)
        value = replace(self.value, text="number", own=(("number", number.symbol),), curves=())
        return replace(self, value=value, constants=(number,))


def build(table: LawTable, index: int, around: Surroundings, complain: Complain) -> Law:
    """The record of a table, which has been read."""
    if not isinstance(table.value, OfState):
        raise TypeError(f"{table.name} has not been read")
    symbols = dict(table.value.own)
    constants = tuple(
        Parameter(f"{table.name}.{name}", symbols[name], float(value)) for name, value in table.parameters.items()
    )
    return Law(index, table.name, table.value, constants, table.unit)


ENTRY = Entry("law", True, LawTable, build, {})
