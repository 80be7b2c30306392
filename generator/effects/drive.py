"""Drive: the motion of a joint prescribed over time, whatever force that takes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

from pydantic import Field

from ..effect_base.changing import Changing
from ..effect_base.effect import Complain, Effect, Entry, Part, Surroundings
from ..effect_base.expression_of_time import (
    Expression,
    OfTime,
    Quantity,
    kinks_of,
    own_parameters,
    quantity,
    those_over_time,
)
from ..effect_base.part_at_joint import mover
from ..effect_base.piecewise_in_time import Piecewise
from ..effect_base.points import find_joint
from ..effect_base.rows_in_time import AngleInTime, PositionInTime, SpeedInTime, Spline, law_of, straying
from ..effect_base.table import JointName, Name, Table
from ..effect_base.written_numbers import wrong_kind
from ..mechanism.links import Parameter
from ..mechanism.mechanism import Mechanism

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Motion

KINDS = ("speed", "angle", "position")


class DriveTable(Table):
    """One ``[[drive]]``."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    joint: JointName = Field(description="the name of the joint whose motion is given")
    speed: SpeedInTime | None = Field(
        default=None,
        description="the joint's rate in rad/s, a number, an expression of t, or rows or pieces over time (m/s where "
        "it slides)",
    )
    angle: AngleInTime | None = Field(
        default=None,
        description='the joint\'s angle in rad, a number or text as "30 deg", an expression of t, or rows or pieces '
        "over time",
    )
    position: PositionInTime | None = Field(
        default=None,
        description="the length along the line in m, a number, an expression of t, or rows or pieces over time",
    )


@dataclass(frozen=True)
class Drive(Effect):
    """Moves joint ``joint`` (an index) as ``law`` says: its second link against its first, or along its line.

    ``given`` is what the law gives: the speed (rad/s or m/s), or the position (rad or m). The acceleration is what
    enters the equations; the force that it takes is the joint's reaction, and its work enters the energy balance.
    ``key`` is that of its table and ``unit`` what it is measured in, for messages.
    """

    index: int
    name: str
    joint: int
    given: Literal["speed", "position"]
    law: Quantity
    key: str = field(default="", compare=False)
    unit: str = field(default="", compare=False)

    def parameters(self) -> tuple[Parameter, ...]:
        return own_parameters(self.law) if self.given == "speed" else ()

    def over_time(self) -> Mapping[str, Changing]:
        return those_over_time({f"{self.name}.{self.key}": self.law})

    def describe(self, mechanism: Mechanism) -> str:
        """``axle at speed drive_0.speed = 6.28``, ``guide at position 0.6 + 0.1 * sin(3 * t)``."""
        joint, law = mechanism.joints[self.joint], self.law
        what = "speed" if self.given == "speed" else "position" if joint.slides else "angle"
        if isinstance(law, OfTime):
            return f"{joint.name} at {what} {law.shown}"
        named = f"{self.parameters()[0].path} = " if self.parameters() else ""
        return f"{joint.name} at {what} {named}{self._number!r}"

    def kinks(self) -> tuple[tuple[float, float], ...]:
        return kinks_of(self.law)

    def remarks(self) -> tuple[tuple[str, str], ...]:
        return straying(self.law, self.key, self.unit)

    def sides(self) -> tuple[str, ...]:
        return tuple(f"drive_{self.index}_{number}" for number in self._jumps())

    def switching(self, motion: Motion) -> Sequence[Expr]:
        """The times since the acceleration has jumped."""
        return [motion.time - t for t in self._jumps().values()]

    def driven(self) -> tuple[int, ...]:
        return (self.joint,)

    def begins(self) -> tuple[float | None, float]:
        law = self.law
        if self.given == "speed":
            return None, law.at(0.0) if isinstance(law, OfTime) else self._number
        if isinstance(law, OfTime):
            return law.at(0.0), law.slope_at(0.0)
        return self._number, 0.0

    def drives(self, motion: Motion) -> Sequence[tuple[int, Expr]]:
        import sympy as sp

        if not isinstance(self.law, OfTime):
            return ((self.joint, sp.S.Zero),)
        name = f"prescribed_{self.index}"
        begun = dict(zip(self._jumps(), map(motion.side, self.sides()), strict=True))
        return ((self.joint, motion.let(name, self.law.derivative(motion, name, self._order, begun))),)

    def parts(self, mechanism: Mechanism) -> tuple[Part, ...]:
        return (mover(self.name, mechanism.joints[self.joint]),)

    @property
    def _number(self) -> float:
        """What the law is where it does not change."""
        return self.law.value if isinstance(self.law, Parameter) else 0.0

    @property
    def _order(self) -> int:
        """Of the derivative of the law that is an acceleration."""
        return 1 if self.given == "speed" else 2

    def _jumps(self) -> Mapping[int, float]:
        """The times at which the acceleration jumps, by number."""
        return self.law.jumps(self._order) if isinstance(self.law, OfTime) else {}


def build(table: DriveTable, index: int, around: Surroundings, complain: Complain) -> Drive | None:
    """The record of a table, or ``None`` after having complained."""
    joint, wrong = find_joint(table.joint, around.mechanism)
    if joint is not None and around.mechanism.joints[joint].kind == "pin-in-slot":
        joint, wrong = None, "a pin in a slot both turns and slides; drive a revolute or prismatic joint"
    if joint is None:
        complain(("joint",), f'found "{table.joint}", expected a joint; {wrong}')
        return None
    aim, other = ("position", "angle") if around.mechanism.joints[joint].slides else ("angle", "position")
    given = [key for key in KINDS if getattr(table, key) is not None]
    if other in given:
        complain((other,), f"found {other}, expected {aim} at this joint; write {aim} in its place")
        return None
    if len(given) != 1:
        found = " beside ".join(given) or f"no speed or {aim}"
        complain((), f"found {found}, expected one of speed and {aim}; give one")
        return None
    law = law_of(getattr(table, given[0]))
    if given[0] == "speed" and (wrong := wrong_kind(law, "m/s" if aim == "position" else "rad/s")):
        complain(("speed",), wrong)
        return None
    if isinstance(law, Expression) and not law.has_rate():
        complain((given[0],), "found abs in a prescribed motion, expected one that is smooth; write it without abs")
        return None
    if isinstance(law, Piecewise) and (wrong := _rough(law, given[0])):
        complain((given[0], "order") if isinstance(law, Spline) else (given[0],), wrong)
        return None
    if isinstance(law, Expression) and (wrong := _undefined(law, given[0])):
        complain((given[0],), f"found {wrong} at t = 0, expected a motion that is smooth from there; shift it")
        return None
    name = table.name or f"drive_{index}"
    kind: Literal["speed", "position"] = "speed" if given[0] == "speed" else "position"
    unit = ("m" if aim == "position" else "rad") + ("/s" if kind == "speed" else "")
    return Drive(index, name, joint, kind, quantity(law, f"{name}.{given[0]}", f"v_drive_{index}"), given[0], unit)


def _rough(law: Piecewise, key: str) -> str:
    """What a law in pieces may not be where a motion is prescribed."""
    if key != "speed" and not law.has_rate():
        return (
            f"found order = 1 for the {key}, expected 3 or 5, for else its speed jumps; write 3 or 5, or in place of "
            'the order law = "monotone", which keeps within the rows'
        )
    if law.ends == "periodic" and not law.has_rate():
        return "found order = 1 for a speed that is periodic, expected 3 or 5; write 3 or 5"
    if law.ends == "periodic" and law.jumps(1 if key == "speed" else 2):
        found = f"found {law.shown} for the {key}, expected one whose acceleration does not jump"
        return f'{found}; write order = 3 or 5, or law = "cycloidal" or "3-4-5"'
    return ""


def _undefined(law: Expression, key: str) -> str:
    """What a law that begins at t = 0 lacks there: a value, a rate, or an acceleration."""
    try:
        value = law.at(0.0)
    except (ArithmeticError, ValueError):
        value = math.nan
    orders = (("rate", 1),) if key == "speed" else (("rate", 1), ("acceleration", 2))
    found = [("value", value), *((what, law.slope_at(0.0, order)) for what, order in orders)]
    return next((f"no finite {what}" for what, number in found if not math.isfinite(number)), "")


ENTRY = Entry("drive", True, DriveTable, build, {"speed": "moment", "angle": "angle"})
