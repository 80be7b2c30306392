"""Motor: a torque at a joint, or a force along its line, over time or by a proportional-integral-derivative law."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import Field

from ..effect_base.changing import Changing
from ..effect_base.effect import Complain, Effect, Entry, Part, Surroundings
from ..effect_base.expression_of_state import sides_of, switching_of
from ..effect_base.expression_of_time import (
    OfTime,
    Quantity,
    kinks_of,
    load_quantity,
    own_parameters,
    quantity,
    term,
    those_over_time,
)
from ..effect_base.part_at_joint import mover
from ..effect_base.points import find_joint
from ..effect_base.rows_in_time import (
    ROWS,
    AngleInTime,
    ForceInTime,
    PositionInTime,
    Spline,
    TorqueInTime,
    law_of,
    straying,
)
from ..effect_base.table import Columns, JointName, Name, NotNegative, Positive, Table
from ..effect_base.written_numbers import Measured, wrong_kind
from ..mechanism.links import NOT_NEGATIVE, POSITIVE, Parameter

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Couple, Force, Motion
    from ..derive.terms_of_effects import Told
    from ..mechanism.mechanism import Mechanism

Row = Annotated[
    list[float],
    Field(min_length=2, max_length=2),
    Columns(Annotated[float, Measured("s")], Annotated[float, Measured("N m", "N")]),
]
FADES = 0.1
"""Part of a limit beyond it, over which an integral ceases to grow."""
TURNING, SLIDING = ("torque", "table", "angle"), ("force", "table", "position")
"""Keys that say what a motor does: at a joint that turns, and at one that slides."""


class MotorTable(Table):
    """One ``[[motor]]``."""

    INSTEAD: ClassVar[Mapping[str, str]] = {
        "speed": "a speed that is given is a [[drive]]; write [[drive]], or a torque, a table or an angle here"
    }

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    joint: JointName = Field(description="the name of the joint that it moves")
    torque: TorqueInTime | None = Field(
        default=None,
        description="a torque in N m, a number, an expression of t or the state, or rows or pieces over time",
    )
    force: ForceInTime | None = Field(
        default=None,
        description="a force along the line in N, a number, an expression of t or the state, or rows or pieces over "
        "time",
    )
    table: list[Row] | None = Field(
        default=None,
        min_length=2,
        description="a torque over time, rows [t, torque] in s and N m, at least two",
    )
    angle: AngleInTime | None = Field(
        default=None,
        description='the wanted angle in rad, a number or text as "30 deg", an expression of t, or rows or pieces '
        "over time",
    )
    position: PositionInTime | None = Field(
        default=None,
        description="the wanted length along the line in m, a number, an expression of t, or rows or pieces over time",
    )
    stiffness: Annotated[NotNegative, Measured("N m/rad", "N/m")] | None = Field(
        default=None, description="the stiffness in N m/rad, zero or a positive number (N/m where it slides)"
    )
    damping: Annotated[NotNegative, Measured("N m s/rad", "N s/m")] | None = Field(
        default=None, description="the damping in N m s/rad, zero or a positive number (N s/m where it slides)"
    )
    integral: Annotated[NotNegative, Measured("N m/(rad s)", "N/(m s)")] | None = Field(
        default=None,
        description="the gain of the error's integral in N m/(rad s), zero or a positive number (N/(m s) where it "
        "slides)",
    )
    limit: Annotated[Positive, Measured("N m", "N")] | None = Field(
        default=None,
        description="the most torque towards a wanted angle, in N m, a positive number (N where it slides)",
    )


@dataclass(frozen=True)
class Given:
    """A constant torque, or one over time."""

    torque: Quantity

    def parameters(self) -> tuple[Parameter, ...]:
        return own_parameters(self.torque)

    def kinks(self) -> tuple[tuple[float, float], ...]:
        return kinks_of(self.torque)

    def realise(self, motion: Motion, motor: Motor) -> Expr:
        return term(self.torque, motion, f"torque_motor_{motor.index}")

    def sides(self, motor: Motor) -> tuple[str, ...]:
        """Kinks of an expression of the state."""
        return sides_of({f"torque_motor_{motor.index}": self.torque})

    def switching(self, motion: Motion, motor: Motor) -> Sequence[Expr]:
        return switching_of({f"torque_motor_{motor.index}": self.torque}, motion)


@dataclass(frozen=True)
class Rows:
    """A torque that is piecewise linear in time, constant before the first row and after the last.

    Row i is (t_i, y_i). With slopes s_i the torque is exactly (y_0 + y_n)/2 + Σ s_i (|t − t_i| − |t − t_{i+1}|)/2.
    """

    rows: tuple[tuple[Parameter, Parameter], ...]

    def parameters(self) -> tuple[Parameter, ...]:
        return tuple(p for row in self.rows for p in row)

    def kinks(self) -> tuple[tuple[float, float], ...]:
        return ()  # its times are parameters

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
    """Proportional-derivative law: stiffness (φ_w − φ) + damping (dφ_w/dt − dφ/dt), φ of second link against first.

    With a ``limit`` no more than that, either way.
    """

    angle: Quantity
    stiffness: Parameter | None
    damping: Parameter | None
    limit: Parameter | None

    def parameters(self) -> tuple[Parameter, ...]:
        return own_parameters(self.angle, self.stiffness, self.damping, self.limit)

    def kinks(self) -> tuple[tuple[float, float], ...]:
        return kinks_of(self.angle)

    def sides(self, motor: Motor) -> tuple[str, ...]:
        """Kinks of the limit."""
        return (f"motor_{motor.index}_above", f"motor_{motor.index}_below") if self.limit else ()

    def realise(self, motion: Motion, motor: Motor) -> Expr:
        asked = self.ask(motion, motor)
        if self.limit is None:
            return asked
        above, below = (motion.side(name) for name in self.sides(motor)[:2])
        return asked * (1 - above - below) + motion.value(self.limit) * (above - below)

    def switching(self, motion: Motion, motor: Motor) -> tuple[Expr, ...]:
        """By how much more than the limit is asked for, forward and backward."""
        if self.limit is None:
            return ()
        asked, limit = self.ask(motion, motor), motion.value(self.limit)
        return asked - limit, -asked - limit

    def behind(self, motion: Motion, motor: Motor) -> Expr:
        """The error, wanted less actual."""
        return term(self.angle, motion, f"angle_motor_{motor.index}") - motion.joint_position(motor.joint)

    def ask(self, motion: Motion, motor: Motor) -> Expr:
        """The law without its limit."""
        asked = self.parts(motion, motor)
        return motion.let(f"asked_motor_{motor.index}", asked) if self.limit else asked

    def parts(self, motion: Motion, motor: Motor) -> Expr:
        """What the error and its rate ask for."""
        import sympy as sp

        rate: Expr = sp.S.Zero
        behind = self.behind(motion, motor)
        if isinstance(self.angle, OfTime) and self.damping:
            part = f"angle_motor_{motor.index}_part"
            rate = motion.let(f"rate_motor_{motor.index}", self.angle.rate(motion, part))
        slow = rate - motion.joint_speed(motor.joint)
        return motion.value(self.stiffness) * behind + motion.value(self.damping) * slow


@dataclass(frozen=True)
class Integrating(Servo):
    """The same with integral (∫ (φ_w − φ) dt from the start of the run), which windup does not reach.

    With a ``limit`` the integral grows more slowly where more than that is asked for and the error would drive it
    further, and stands from (1 + ``FADES``) limit on. To stop at the limit itself has no solution: where it grows
    it passes the limit, and where it stands it falls back.
    """

    integral: Parameter

    def parameters(self) -> tuple[Parameter, ...]:
        return own_parameters(self.angle, self.stiffness, self.damping, self.limit, self.integral)

    def sides(self, motor: Motor) -> tuple[str, ...]:
        found = super().sides(motor)
        return (*found, *(f"motor_{motor.index}_{name}" for name in ("over", "under", "ahead"))) if found else ()

    def switching(self, motion: Motion, motor: Motor) -> tuple[Expr, ...]:
        if self.limit is None:
            return ()
        asked, most = self.ask(motion, motor), self._stands(motion)
        return *super().switching(motion, motor), asked - most, -asked - most, self.behind(motion, motor)

    def parts(self, motion: Motion, motor: Motor) -> Expr:
        gathered = motion.integral(motor.integrals()[0])
        return super().parts(motion, motor) + motion.value(self.integral) * gathered

    def grow(self, motion: Motion, motor: Motor) -> Couple:
        """What makes the integral grow."""
        rate = behind = self.behind(motion, motor)
        if self.limit is not None:
            asked, most = self.ask(motion, motor), self._stands(motion)
            above, below, over, under, ahead = map(motion.side, self.sides(motor))
            width = most - motion.value(self.limit)
            forward = 1 - above + (above - over) * (most - asked) / width
            backward = 1 - below + (below - under) * (most + asked) / width
            rate = behind * (ahead * forward + (1 - ahead) * backward)
        return motion.integrate(motor.integrals()[0], motion.let(f"error_motor_{motor.index}", rate))

    def _stands(self, motion: Motion) -> Expr:
        """From what is asked for on the integral stands."""
        import sympy as sp

        return motion.value(self.limit) * (1 + sp.Rational(str(FADES)))


@dataclass(frozen=True)
class Motor(Effect):
    """A torque on the second link of a joint (a force, where it slides), and its reaction on the first.

    It follows the law of its ``drive``. Whether its joint ``slides`` is for messages.
    """

    index: int
    name: str
    joint: int
    drive: Given | Rows | Servo
    slides: bool = field(default=False, compare=False)

    def at_joints(self) -> tuple[int, ...]:
        return (self.joint,)

    def parameters(self) -> tuple[Parameter, ...]:
        return self.drive.parameters()

    def over_time(self) -> Mapping[str, Changing]:
        given, key, _ = self._given
        return those_over_time({f"{self.name}.{key}": given})

    def instants(self) -> tuple[Parameter, ...]:
        return tuple(t for t, _ in self.drive.rows) if isinstance(self.drive, Rows) else ()

    def kinks(self) -> tuple[tuple[float, float], ...]:
        return self.drive.kinks()

    def remarks(self) -> tuple[tuple[str, str], ...]:
        return straying(*self._given)

    def sides(self) -> tuple[str, ...]:
        return () if isinstance(self.drive, Rows) else self.drive.sides(self)

    def jumps(self) -> bool:
        return False

    def switching(self, motion: Motion) -> Sequence[Expr]:
        return () if isinstance(self.drive, Rows) else self.drive.switching(motion, self)

    def integrals(self) -> tuple[str, ...]:
        return (f"{self.name}_integral",) if isinstance(self.drive, Integrating) else ()

    def loads(self, motion: Motion) -> Sequence[Force | Couple]:
        effort = motion.joint_effort(self.joint, self._torque(motion))
        return [*effort, self.drive.grow(motion, self)] if isinstance(self.drive, Integrating) else effort

    def power(self, motion: Motion) -> Expr:
        """The torque (force) times the rate of the joint."""
        return self._torque(motion) * motion.joint_speed(self.joint)

    def outputs(self, motion: Motion) -> Sequence[Told]:
        """The torque (the force along its line) on the joint's second link, and its power."""
        asked, unit = ("force", "N") if motion.joint(self.joint).slides else ("torque", "N m")
        second = motion.joint(self.joint).second.link
        return (asked, unit, self._torque(motion), second), ("power", "W", self.power(motion))

    def parts(self, mechanism: Mechanism) -> tuple[Part, ...]:
        return (mover(self.name, mechanism.joints[self.joint]),)

    @property
    def _given(self) -> tuple[Quantity, str, str]:
        """What its table gives by a number or over time, at which key and in which unit; rows of a ``table`` are none
        of this."""
        if isinstance(self.drive, Servo):
            return self.drive.angle, *(("position", "m") if self.slides else ("angle", "rad"))
        effort = ("force", "N") if self.slides else ("torque", "N m")
        return self.drive.torque if isinstance(self.drive, Given) else None, *effort

    def _torque(self, motion: Motion) -> Expr:
        return motion.let(f"torque_motor_{self.index}", self.drive.realise(motion, self))


def build(table: MotorTable, index: int, around: Surroundings, complain: Complain) -> Motor | None:
    """The record of a table, or ``None`` after having complained."""
    joint, wrong = find_joint(table.joint, around.mechanism)
    slides = table.force is not None or table.position is not None
    if joint is None:
        complain(("joint",), f'found "{table.joint}", expected a joint; {wrong}')
    else:
        slides = around.mechanism.joints[joint].slides
    sound = _check_kind(table, slides, complain)
    if joint is not None:
        sound = _check_units(table, slides, complain) and sound
    if joint is None or not sound:
        return None
    name = table.name or f"motor_{index}"
    return Motor(index, name, joint, _drive(table, index, name, slides), slides)


def _drive(table: MotorTable, index: int, name: str, slides: bool) -> Given | Rows | Servo:
    for key in ("torque", "force"):
        if (law := getattr(table, key)) is not None:
            return Given(load_quantity(law_of(law), f"{name}.{key}", f"tau_motor_{index}"))
    if table.table is not None:
        return Rows(_rows(table.table, index, name, "force" if slides else "torque"))
    stiffness, damping = (
        Parameter(f"{name}.{key}", f"{symbol}_motor_{index}", value, NOT_NEGATIVE) if value is not None else None
        for key, symbol, value in (("stiffness", "k", table.stiffness), ("damping", "d", table.damping))
    )
    most = POSITIVE if table.integral else NOT_NEGATIVE  # an integral fades over a part of it
    limit = Parameter(f"{name}.limit", f"most_motor_{index}", table.limit, most) if table.limit else None
    key, law = ("angle", table.angle) if table.angle is not None else ("position", table.position)
    wanted = quantity(law_of(law) if law is not None else 0.0, f"{name}.{key}", f"phi_motor_{index}")
    if not table.integral:
        return Servo(wanted, stiffness, damping, limit)
    gain = Parameter(f"{name}.integral", f"i_motor_{index}", table.integral, NOT_NEGATIVE)
    return Integrating(wanted, stiffness, damping, limit, gain)


def _rows(table: list[list[float]], index: int, name: str, kind: str) -> tuple[tuple[Parameter, Parameter], ...]:
    return tuple(
        (
            Parameter(f"{name}.table.{i}.t", f"t_motor_{index}_{i}", t),
            Parameter(f"{name}.table.{i}.{kind}", f"y_motor_{index}_{i}", value),
        )
        for i, (t, value) in enumerate(table)
    )


def _check_kind(table: MotorTable, slides: bool, complain: Complain) -> bool:
    """Whether the table says one thing, and one that its joint can do; complains if not."""
    kinds, others = (SLIDING, TURNING) if slides else (TURNING, SLIDING)
    wrong = [key for key in others if key not in kinds and getattr(table, key) is not None]
    for key in wrong:
        other = kinds[others.index(key)]
        does = "slides along a line" if slides else "turns"
        complain((key,), f"found {key} at a joint that {does}, expected {other}; write {other} in its place")
    given = [key for key in kinds if getattr(table, key) is not None]
    if not given and not wrong:
        complain((), f"found no {kinds[0]}, {kinds[1]} or {kinds[2]}, expected one of them; add one")
    for key in given[1:]:
        message = f"found {key} beside {given[0]}, expected one of {kinds[0]}, {kinds[1]} and {kinds[2]}; remove one"
        complain((key,), message)
    if wrong:
        return False
    gains = [key for key in ("stiffness", "damping", "integral", "limit") if getattr(table, key) is not None]
    aim = kinds[2]
    if given and aim not in given:
        for key in gains:
            complain((key,), f"found {key} without {aim}, expected it with {_a(aim)} only; remove it")
        sound = not gains
    else:
        sound = given == [aim] and _check_servo(table, aim, complain)
    if len(table.table or ()) > ROWS:
        message = f"found {len(table.table or ())} rows, expected at most {ROWS}, because all stand in the equations"
        give = f'an [[input]] with joint = "{table.joint}", and simulate(inputs={{"t": [...], its name: [...]}})'
        complain(("table",), f"{message}; write fewer, or give them at run time: {give}")
        return False
    for i, (row, after) in enumerate(pairwise(table.table or ()), start=1):
        if not row[0] < after[0]:
            complain(("table", i), f"found t = {after[0]:g} after t = {row[0]:g}, expected times that grow; correct it")
            sound = False
    return sound and len(given) == 1


def _check_units(table: MotorTable, slides: bool, complain: Complain) -> bool:
    """Units that are written are those of the kind of joint."""
    units = ("N/m", "N s/m", "N/(m s)", "N") if slides else ("N m/rad", "N m s/rad", "N m/(rad s)", "N m")
    stiffness, damping, integral, effort = units
    found: list[tuple[tuple[str | int, ...], float | None, str]] = [
        (("stiffness",), table.stiffness, stiffness),
        (("damping",), table.damping, damping),
        (("integral",), table.integral, integral),
        (("limit",), table.limit, effort),
        *((("table", row, 1), values[1], effort) for row, values in enumerate(table.table or ())),
    ]
    wrong = [(key, sentence) for key, number, unit in found if (sentence := wrong_kind(number, unit))]
    for key, sentence in wrong:
        complain(key, sentence)
    return not wrong


def _a(aim: str) -> str:
    return "an angle" if aim == "angle" else "a position"


def _check_servo(table: MotorTable, aim: str, complain: Complain) -> bool:
    law = law_of(getattr(table, aim))
    if table.stiffness is None and table.damping is None:
        complain((), f"found {_a(aim)} without stiffness and damping, expected one of them; add stiffness")
        return False
    if table.damping is not None and isinstance(law, OfTime) and not law.has_rate():
        why = "order = 1" if isinstance(law, Spline) else "abs"
        how = 'write order = 3, or law = "monotone"' if isinstance(law, Spline) else "write it without abs"
        complain((aim,), f"found {why} in {_a(aim)} with damping, expected one that has a rate; {how}")
        return False
    return True


ENTRY = Entry("motor", True, MotorTable, build, {"torque": "moment", "table": "moment", "angle": "angle"})
