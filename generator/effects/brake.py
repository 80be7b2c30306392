"""Brake: a joint is braked by dry friction of a given size, constant or over time, between times if they are given."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import Field

from ..effect_base.changing import Changing
from ..effect_base.effect import Complain, Effect, Entry, Part, Rub, Surroundings
from ..effect_base.expression_of_state import InLoad, free, sides_of, switching_of
from ..effect_base.expression_of_time import (
    Law,
    Quantity,
    own_parameters,
    term,
    those_over_time,
)
from ..effect_base.part_at_joint import braker
from ..effect_base.points import find_joint
from ..effect_base.table import JointName, Name, NotNegative, Positive, Table
from ..effect_base.written_numbers import Measured, wrong_kind
from ..mechanism.joints import Joint
from ..mechanism.links import ANY, NOT_NEGATIVE, POSITIVE, Parameter
from ..mechanism.mechanism import Mechanism

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Couple, Force, Motion
    from ..derive.terms_of_effects import Told

RATE = 0.001
"""Default of the rate (rad/s or m/s) at which a brake resists with tanh 1 = 76 % of its moment."""


class BrakeTable(Table):
    """One ``[[brake]]``."""

    MISPLACED: ClassVar[Mapping[str, str]] = {"dry": "it belongs to [[joint_friction]]; write torque, or force, here"}

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    joint: JointName = Field(description="the name of the joint that it brakes")
    torque: Annotated[Law, InLoad("N m")] | None = Field(
        default=None,
        description="the most torque in N m, zero or a positive number or an expression",
    )
    force: Annotated[Law, InLoad("N")] | None = Field(
        default=None,
        description="the most force along the line in N, zero or a positive number or an expression",
    )
    begins: Annotated[NotNegative, Measured("s")] | None = Field(
        default=None, description="the time in s from which on it brakes, zero or a positive number"
    )
    ends: Annotated[Positive, Measured("s")] | None = Field(
        default=None, description="the time in s up to which it brakes, a positive number"
    )
    rate: Annotated[Positive, Measured("rad/s", "m/s")] | None = Field(
        default=None,
        description="the rate about which it changes its sign in rad/s, a positive number (m/s where the joint slides)",
    )


@dataclass(frozen=True)
class Brake(Effect):
    """Resists the motion of joint ``joint`` (an index) with ``effort`` · tanh(ω / ``rate``), from ``first`` to ``last``
    (s) where they are given, and never where the effort is negative.

    ``effort`` is in N m and ``rate`` in rad/s, N and m/s where the joint slides. ``key`` is that of its table.
    """

    label: str
    name: str
    joint: int
    effort: Quantity
    rate: Parameter
    first: Parameter | None
    last: Parameter | None
    key: str = field(default="", compare=False)

    def at_joints(self) -> tuple[int, ...]:
        return (self.joint,)

    def parameters(self) -> tuple[Parameter, ...]:
        return own_parameters(self.effort, self.rate, self.first, self.last)

    def over_time(self) -> Mapping[str, Changing]:
        return those_over_time({f"{self.name}.{self.key}": self.effort})

    def sides(self) -> tuple[str, ...]:
        return (*self._own_sides(), *sides_of({f"torque_{self.label}": self.effort}))

    def jumps(self) -> bool:
        return self.first is not None or self.last is not None

    def _own_sides(self) -> tuple[str, ...]:
        """Those that tell whether it acts."""
        kinds = (("pressed", isinstance(self.effort, Changing)), ("begun", self.first), ("over", self.last))
        return tuple(f"{self.label}_{kind}" for kind, there in kinds if there)

    def switching(self, motion: Motion) -> Sequence[Expr]:
        """The effort where it is an expression, and times after its beginning and its end."""
        values = [self._pressed(motion)] if isinstance(self.effort, Changing) else []
        values += [motion.time - motion.value(instant) for instant in (self.first, self.last) if instant]
        return [*values, *switching_of({f"torque_{self.label}": self.effort}, motion)]

    def rubs(self, mechanism: Mechanism) -> tuple[Rub, ...]:
        asked, _ = _told_of(mechanism.joints[self.joint])
        return (Rub(self.joint, self.rate, asked),)

    def loads(self, motion: Motion) -> Sequence[Force | Couple]:
        return motion.joint_effort(self.joint, -self._moment(motion))

    def power(self, motion: Motion) -> Expr:
        """−ω T tanh(ω/ω₀)."""
        return -motion.joint_speed(self.joint) * self._moment(motion)

    def outputs(self, motion: Motion) -> Sequence[Told]:
        """The torque (the force along its line) on the joint's second link, and its power."""
        joint = motion.joint(self.joint)
        told = (*_told_of(joint), -self._moment(motion), joint.second.link)
        return told, ("power", "W", self.power(motion))

    def parts(self, mechanism: Mechanism) -> tuple[Part, ...]:
        return (braker(self.name, mechanism.joints[self.joint]),)

    def _effort(self, motion: Motion) -> Expr:
        return term(self.effort, motion, f"torque_{self.label}")

    def _pressed(self, motion: Motion) -> Expr:
        """The effort as a switching function, which has no sides in it."""
        return free(self.effort, motion, f"torque_{self.label}")

    def _moment(self, motion: Motion) -> Expr:
        from sympy import tanh

        most = self._effort(motion)
        for side in self._own_sides():
            on = motion.side(side)
            most *= 1 - on if side.endswith("_over") else on
        slip = motion.let(f"slip_{self.label}", motion.joint_speed(self.joint))
        return motion.let(f"moment_{self.label}", most * tanh(slip / motion.value(self.rate)))


def _told_of(joint: Joint) -> tuple[str, str]:
    """What runs call what a brake does at a joint, and its unit."""
    return ("force", "N") if joint.slides else ("torque", "N m")


def build(table: BrakeTable, index: int, around: Surroundings, complain: Complain) -> Brake | None:
    """The record of a table, or ``None`` after having complained."""
    joint, wrong = find_joint(table.joint, around.mechanism)
    if joint is None:
        complain(("joint",), f'found "{table.joint}", expected a joint; {wrong}')
    if table.begins is not None and table.ends is not None and not table.begins < table.ends:
        message = f"found {table.ends:g} s, expected a time after begins, {table.begins:g} s"
        complain(("ends",), f"{message}; correct one of them")
        return None
    if joint is None or not _check_keys(table, around.mechanism.joints[joint].slides, complain):
        return None
    label = f"brake_{index}"
    name = table.name or label
    key = "force" if around.mechanism.joints[joint].slides else "torque"
    first = Parameter(f"{name}.begins", f"tb_{label}", table.begins, ANY) if table.begins else None
    last = Parameter(f"{name}.ends", f"te_{label}", table.ends, ANY) if table.ends else None
    rate = Parameter(f"{name}.rate", f"w0_{label}", table.rate or RATE, POSITIVE)
    law = getattr(table, key)
    effort = law if isinstance(law, Changing) else Parameter(f"{name}.{key}", f"T_{label}", law, NOT_NEGATIVE)
    return Brake(label, name, joint, effort, rate, first, last, key)


def _check_keys(table: BrakeTable, slides: bool, complain: Complain) -> bool:
    """The effort is the one of the kind of joint, and of a size."""
    key, other = ("force", "torque") if slides else ("torque", "force")
    does = "slides along a line" if slides else "turns"
    law, sound = getattr(table, key), True
    if getattr(table, other) is not None:
        complain((other,), f"found {other} at a joint that {does}, expected {key}; write {key} in its place")
        return False
    if law is None:
        complain((), f"found no {key}, expected the most {key} with which it brakes; add {key}")
        sound = False
    elif not isinstance(law, Changing) and not law >= 0.0:
        complain(
            (key,),
            f"found {law:g}, expected zero or a positive number or an expression of t or of the state; correct it",
        )
        sound = False
    if wrong := wrong_kind(table.rate, "m/s" if slides else "rad/s"):
        complain(("rate",), wrong)
        sound = False
    return sound


ENTRY = Entry("brake", True, BrakeTable, build, {})
