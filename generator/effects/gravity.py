"""Gravity: a uniform field along -y."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from pydantic import Field

from ..mechanism.links import Parameter
from .effect import Complain, Effect, Entry, Surroundings
from .table import Table

if TYPE_CHECKING:
    from ..derive.kinematics import Vector


class GravityTable(Table):
    """The table ``[gravity]``."""

    g: float = Field(default=9.81, description="the acceleration of gravity along -y in m/s², a finite number")


@dataclass(frozen=True)
class Gravity(Effect):
    """Uniform gravity ``g`` (m/s²) along -y."""

    g: Parameter

    def parameters(self) -> tuple[Parameter, ...]:
        return (self.g,)

    def field(self) -> Vector:
        from ..derive.kinematics import ZERO, symbol

        return (ZERO[0], -symbol(self.g))


def build(table: GravityTable, index: int, surroundings: Surroundings, complain: Complain) -> Gravity:
    return Gravity(Parameter("gravity.g", "g", table.g))


ENTRY = Entry("gravity", False, GravityTable, build)
