"""Torque: an external torque on a link."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import dist
from typing import TYPE_CHECKING

from pydantic import Field

from ..effect_base.changing import Changing
from ..effect_base.effect import Complain, Effect, Entry, Part, Surroundings
from ..effect_base.expression_of_state import sides_of, switching_of
from ..effect_base.expression_of_time import (
    Quantity,
    kinks_of,
    load_quantity,
    own_parameters,
    term,
    those_over_time,
)
from ..effect_base.rows_in_time import TorqueInTime, law_of, straying
from ..effect_base.table import LinkName, Name, Table
from ..mechanism.joints import PointRef
from ..mechanism.links import Parameter
from ..mechanism.mechanism import Mechanism

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Couple, Motion
    from ..derive.terms_of_effects import Told


class TorqueTable(Table):
    """One ``[[torque]]``."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    link: LinkName = Field(description="the name of the link it acts on")
    torque: TorqueInTime = Field(
        description="a torque in N m, a number, an expression of t or the state, or rows or pieces over time"
    )


@dataclass(frozen=True)
class Torque(Effect):
    """A torque (N m, counter-clockwise) on a link, without reaction on another."""

    index: int
    name: str
    link: int
    torque: Quantity

    def parameters(self) -> tuple[Parameter, ...]:
        return own_parameters(self.torque)

    def over_time(self) -> Mapping[str, Changing]:
        return those_over_time({f"{self.name}.torque": self.torque})

    def kinks(self) -> tuple[tuple[float, float], ...]:
        return kinks_of(self.torque)

    def remarks(self) -> tuple[tuple[str, str], ...]:
        return straying(self.torque, "torque", "N m")

    def sides(self) -> tuple[str, ...]:
        return sides_of({self._label: self.torque})

    def jumps(self) -> bool:
        return False

    def switching(self, motion: Motion) -> Sequence[Expr]:
        return switching_of({self._label: self.torque}, motion)

    def loads(self, motion: Motion) -> Sequence[Couple]:
        from ..derive.motion import Couple

        return (Couple(self.link, self._torque(motion)),)

    def power(self, motion: Motion) -> Expr:
        """The torque times the link's angular velocity."""
        return self._torque(motion) * motion.rate(self.link)

    def outputs(self, motion: Motion) -> Sequence[Told]:
        """The torque on the link, and its power."""
        return ("torque", "N m", self._torque(motion), self.link), ("power", "W", self.power(motion))

    def parts(self, mechanism: Mechanism) -> tuple[Part, ...]:
        """An arc about the link's point that is nearest to its mass centre."""
        link = mechanism.links[self.link]
        near = min(link.points, key=lambda name: dist(link.points[name].values(), link.com.values()))
        at = PointRef(self.link, near)
        return (("torque", self.name, (at, at), (self.torque if isinstance(self.torque, Parameter) else 1.0,)),)

    def _torque(self, motion: Motion) -> Expr:
        return term(self.torque, motion, self._label)

    @property
    def _label(self) -> str:
        """Its name in the equations."""
        return f"torque_{self.index}"


def find_link(name: str, mechanism: Mechanism) -> tuple[int | None, str]:
    """The index of the link called ``name``, or what is wrong with the name."""
    names = [link.name for link in mechanism.links]
    if name in mechanism.welded:
        return None, f"it is welded to {mechanism.link_name(mechanism.welded[name])}; name that one"
    if name not in names:
        return None, f"the links are {', '.join(names)}"
    return names.index(name), ""


def build(table: TorqueTable, index: int, around: Surroundings, complain: Complain) -> Torque | None:
    """The record of a table, or ``None`` after having complained."""
    link, wrong = find_link(table.link, around.mechanism)
    if link is None:
        complain(("link",), f'found "{table.link}", expected a link that moves; {wrong}')
    name = table.name or f"torque_{index}"
    torque = load_quantity(law_of(table.torque), f"{name}.torque", f"tau_torque_{index}")
    return Torque(index, name, link, torque) if link is not None else None


ENTRY = Entry("torque", True, TorqueTable, build, {"torque": "moment"})
