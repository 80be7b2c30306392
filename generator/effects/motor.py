"""Motor: a torque at a joint, given over time or by a proportional-derivative law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from ..mechanism.links import Parameter
from .effect import Complain, Effect, Entry, Surroundings
from .expressions import Expression, Law, Quantity, own_parameters, quantity, term
from .points import find_joint
from .table import Name, Pair, Table

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Couple, Motion

Gain = Annotated[float, Field(ge=0.0)]
KINDS = ("torque", "table", "angle")


class MotorTable(Table):
    """One ``[[motor]]``."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    joint: str = Field(description="the name of the joint that it turns")
    torque: Law | None = Field(default=None, description="a torque in N m, a number or an expression of t")
    table: list[Pair] | None = Field(
        default=None, min_length=2, description="a torque over time, rows [t, torque] in s and N m, at least two"
    )
    angle: Law | None = Field(default=None, description="the wanted angle in rad, a number or an expression of t")
    stiffness: Gain | None = Field(default=None, description="the stiffness in N m/rad, zero or a positive number")
    damping: Gain | None = Field(default=None, description="the damping in N m s/rad, zero or a positive number")


@dataclass(frozen=True)
class Given:
    """A constant torque, or an expression of t."""

    torque: Quantity

    def parameters(self) -> tuple[Parameter, ...]:
        return own_parameters(self.torque)

    def realise(self, motion: Motion, motor: Motor) -> Expr:
        return term(self.torque, motion, f"torque_motor_{motor.index}")


@dataclass(frozen=True)
class Rows:
    """A torque that is piecewise linear in time, constant before the first row and after the last.

    Row i is (t_i, y_i). With slopes s_i the torque is exactly (y_0 + y_n)/2 + Σ s_i (|t − t_i| − |t − t_{i+1}|)/2.
    """

    rows: tuple[tuple[Parameter, Parameter], ...]

    def parameters(self) -> tuple[Parameter, ...]:
        return tuple(p for row in self.rows for p in row)

    def realise(self, motion: Motion, motor: Motor) -> Expr:
        import sympy as sp

        name = f"motor_{motor.index}"
        times, values = zip(*((motion.value(t), motion.value(y)) for t, y in self.rows), strict=True)
        since = [motion.let(f"since_{name}_{i}", sp.Abs(motion.time - t)) for i, t in enumerate(times)]
        terms = [motion.let(f"mean_{name}", (values[0] + values[-1]) / 2)]
        for i, ((t0, t1), (y0, y1), (a, b)) in enumerate(zip(*map(pairwise, (times, values, since)), strict=True)):
            terms.append(motion.let(f"slope_{name}_{i}", (y1 - y0) / (2 * (t1 - t0))) * (a - b))
        return sp.Add(*terms)


@dataclass(frozen=True)
class Servo:
    """Proportional-derivative law: stiffness (φ_w − φ) + damping (dφ_w/dt − dφ/dt), φ of second link against first."""

    angle: Quantity
    stiffness: Parameter | None
    damping: Parameter | None

    def parameters(self) -> tuple[Parameter, ...]:
        return own_parameters(self.angle, self.stiffness, self.damping)

    def realise(self, motion: Motion, motor: Motor) -> Expr:
        import sympy as sp

        joint, name = motion.joint(motor.joint), f"angle_motor_{motor.index}"
        wanted, rate = term(self.angle, motion, name), sp.S.Zero
        if isinstance(self.angle, Expression) and self.damping:
            rate = motion.let(f"rate_motor_{motor.index}", self.angle.rate(motion, f"{name}_part"))
        behind, slow = wanted - motion.joint_angle(joint), rate - motion.joint_rate(joint)
        return motion.value(self.stiffness) * behind + motion.value(self.damping) * slow


@dataclass(frozen=True)
class Motor(Effect):
    """A torque on the second link of a joint, and its reaction on the first, after the law of its ``drive``."""

    index: int
    name: str
    joint: int
    drive: Given | Rows | Servo

    def parameters(self) -> tuple[Parameter, ...]:
        return self.drive.parameters()

    def instants(self) -> tuple[Parameter, ...]:
        return tuple(t for t, _ in self.drive.rows) if isinstance(self.drive, Rows) else ()

    def loads(self, motion: Motion) -> Sequence[Couple]:
        from ..derive.motion import Couple

        joint, torque = motion.joint(self.joint), self._torque(motion)
        return Couple(joint.first.link, -torque), Couple(joint.second.link, torque)

    def power(self, motion: Motion) -> Expr:
        """The torque times the rate of the joint."""
        return self._torque(motion) * motion.joint_rate(motion.joint(self.joint))

    def _torque(self, motion: Motion) -> Expr:
        return motion.let(f"torque_motor_{self.index}", self.drive.realise(motion, self))


def build(table: MotorTable, index: int, around: Surroundings, complain: Complain) -> Motor | None:
    """The record of a table, or ``None`` after having complained."""
    joint, wrong = find_joint(table.joint, around.mechanism)
    if joint is None:
        complain(("joint",), f'found "{table.joint}", expected a joint; {wrong}')
    sound = _check_kind(table, complain)
    if joint is None or not sound:
        return None
    name = table.name or f"motor_{index}"
    return Motor(index, name, joint, _drive(table, index, name))


def _drive(table: MotorTable, index: int, name: str) -> Given | Rows | Servo:
    if table.torque is not None:
        return Given(quantity(table.torque, f"{name}.torque", f"tau_motor_{index}"))
    if table.table is not None:
        return Rows(_rows(table.table, index, name))
    stiffness, damping = (
        Parameter(f"{name}.{key}", f"{symbol}_motor_{index}", value) if value else None
        for key, symbol, value in (("stiffness", "k", table.stiffness), ("damping", "d", table.damping))
    )
    angle = quantity(table.angle, f"{name}.angle", f"phi_motor_{index}") if table.angle is not None else None
    return Servo(angle, stiffness, damping)


def _rows(table: list[list[float]], index: int, name: str) -> tuple[tuple[Parameter, Parameter], ...]:
    return tuple(
        (
            Parameter(f"{name}.table.{i}.t", f"t_motor_{index}_{i}", t),
            Parameter(f"{name}.table.{i}.torque", f"y_motor_{index}_{i}", torque),
        )
        for i, (t, torque) in enumerate(table)
    )


def _check_kind(table: MotorTable, complain: Complain) -> bool:
    """Whether the table says one thing; complains if not."""
    given = [key for key in KINDS if getattr(table, key) is not None]
    if not given:
        complain((), "found no torque, table or angle, expected one of them; add one")
    for key in given[1:]:
        complain((key,), f"found {key} beside {given[0]}, expected one of torque, table and angle; remove one")
    gains = [key for key in ("stiffness", "damping") if getattr(table, key) is not None]
    if given and "angle" not in given:
        for key in gains:
            complain((key,), f"found {key} without angle, expected it with an angle only; remove it")
        sound = not gains
    else:
        sound = given == ["angle"] and _check_servo(table, complain)
    for i, (row, after) in enumerate(pairwise(table.table or ()), start=1):
        if not row[0] < after[0]:
            complain(("table", i), f"found t = {after[0]:g} after t = {row[0]:g}, expected times that grow; correct it")
            sound = False
    return sound and len(given) == 1


def _check_servo(table: MotorTable, complain: Complain) -> bool:
    if not table.stiffness and not table.damping:
        complain((), "found an angle without stiffness and damping, expected one that is not zero; add stiffness")
        return False
    if table.damping and isinstance(table.angle, Expression) and not table.angle.has_rate():
        complain(("angle",), "found abs in an angle with damping, expected one that has a rate; write it without abs")
        return False
    return True


ENTRY = Entry("motor", True, MotorTable, build)
