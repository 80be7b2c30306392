"""The table ``[[event]]``: instants of a run that a scene asks for, and what happens there."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

from ..effect_base.table import Name, Table
from ..effect_base.written_numbers import Measured

Direction = Literal["rising", "falling", "either"]


def _number_or_text(value: object) -> str:
    """Which alternative of a value is meant, as pydantic's tag."""
    return "<text>" if isinstance(value, str) else "<number>"


Value = Annotated[
    Annotated[float, Measured("1"), Tag("<number>")] | Annotated[str, Tag("<text>")], Discriminator(_number_or_text)
]
"""A number, or an expression of the time and the state, in SI units."""


class EventTable(Table):
    """One ``[[event]]``."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    when: str = Field(description='an expression of the time and the state that comes to zero, as "angle(crank) - pi"')
    direction: Direction = Field(default="either", description='"rising", "falling" or "either"')
    stop: bool = Field(default=False, description="true, if the run ends there, or false")
    times: Annotated[int, Field(ge=1), Measured("1")] | None = Field(
        default=None, description="beside stop: how often it comes until the run ends, a positive whole number"
    )
    on: list[str] = Field(default_factory=list, description='names of effects that act from then on, ["left_sole"]')
    off: list[str] = Field(default_factory=list, description="names of effects that are absent from then on")
    set: dict[str, Value] = Field(
        default_factory=dict,
        description='values of parameters from then on, { "motor_0.torque" = 2 }: numbers, or expressions as in when',
    )
