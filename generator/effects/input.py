"""Input: a force or a torque whose value is given at run time, by a controller or a table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pydantic import Field

from ..effect_base.direction import unit
from ..effect_base.effect import Complain, Effect, Entry, Surroundings
from ..effect_base.points import find_joint
from ..effect_base.table import Direction, JointName, LinkName, Name, PointName, Table
from ..mechanism.joints import PointRef
from ..mechanism.links import Parameter
from .force import FRAME, Frame, find_loaded
from .torque import find_link

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Couple, Force, Motion
    from ..derive.vectors import Vector

KINDS = ("point", "joint", "link")


class InputTable(Table):
    """One ``[[input]]``."""

    name: Name = Field(description="a name of letters, digits and _, beginning with a letter, by which it is given")
    point: PointName | None = Field(default=None, description='the point that a force acts on, a joint or "link.point"')
    direction: Direction | None = Field(default=None, description="the direction of the force, [x, y], not both zero")
    frame: Frame | None = Field(default=None, description=FRAME)
    joint: JointName | None = Field(
        default=None, description="the name of the joint that a torque turns or a force slides"
    )
    link: LinkName | None = Field(default=None, description="the name of the link that a torque turns")


@dataclass(frozen=True)
class OnPoint:
    """The value is a force (N) on a point, along ``direction`` in fixed axes or in those of the point's link.

    A direction along an axis is structural: its components are the numbers 0, 1 and -1 and no parameters.
    """

    point: PointRef
    direction: tuple[Parameter | int, Parameter | int]
    frame: Frame

    def parameters(self) -> tuple[Parameter, ...]:
        return tuple(part for part in self.direction if isinstance(part, Parameter))

    def loads(self, motion: Motion, given: Input) -> Sequence[Force]:
        from ..derive.motion import Force

        return (Force(self.point, self._force(motion, given)),)

    def rate(self, motion: Motion, given: Input) -> Expr:
        from ..derive.vectors import dot

        return dot(self._axis(motion, given), motion.velocity(self.point))

    def _force(self, motion: Motion, given: Input) -> Vector:
        from ..derive.vectors import scale

        return scale(motion.input(given.name), self._axis(motion, given))

    def _axis(self, motion: Motion, given: Input) -> Vector:
        """The direction in fixed axes, with length 1."""
        import sympy as sp

        x, y = (motion.value(p) if isinstance(p, Parameter) else sp.Integer(p) for p in self.direction)
        if self.parameters():
            length = motion.let(f"length_input_{given.index}", sp.sqrt(x * x + y * y))
            x, y = motion.let_vector(f"unit_input_{given.index}", (x / length, y / length))
        if self.frame == "fixed":
            return x, y
        return motion.let_vector(f"turned_input_{given.index}", motion.kinematics.turn(self.point.link, (x, y)))


@dataclass(frozen=True)
class AtJoint:
    """The value is a torque (N m) on the second link of a joint, with its reaction on the first; or a force (N) along
    the joint's line."""

    joint: int

    def parameters(self) -> tuple[Parameter, ...]:
        return ()

    def loads(self, motion: Motion, given: Input) -> Sequence[Force | Couple]:
        return motion.joint_effort(self.joint, motion.input(given.name))

    def rate(self, motion: Motion, given: Input) -> Expr:
        return motion.joint_speed(self.joint)


@dataclass(frozen=True)
class OnLink:
    """The value is a torque (N m) on a link, without reaction on another."""

    link: int

    def parameters(self) -> tuple[Parameter, ...]:
        return ()

    def loads(self, motion: Motion, given: Input) -> Sequence[Couple]:
        from ..derive.motion import Couple

        return (Couple(self.link, motion.input(given.name)),)

    def rate(self, motion: Motion, given: Input) -> Expr:
        return motion.rate(self.link)


@dataclass(frozen=True)
class Input(Effect):
    """A value called ``name``, given at run time, which acts as its ``action`` says."""

    index: int
    name: str
    action: OnPoint | AtJoint | OnLink

    def parameters(self) -> tuple[Parameter, ...]:
        return self.action.parameters()

    def inputs(self) -> tuple[str, ...]:
        return (self.name,)

    def loads(self, motion: Motion) -> Sequence[Force | Couple]:
        return self.action.loads(motion, self)

    def power(self, motion: Motion) -> Expr:
        """The value times the speed along its direction, or times the angular velocity that it drives."""
        return motion.input(self.name) * self.action.rate(motion, self)


def build(table: InputTable, index: int, around: Surroundings, complain: Complain) -> Input | None:
    """The record of a table, or ``None`` after having complained."""
    sound = _check_kind(table, complain)
    actions: list[OnPoint | AtJoint | OnLink] = []
    if table.point is not None:
        frame = table.frame or "fixed"
        ref, wrong = find_loaded(table.point, frame, around.mechanism)
        if ref is None:
            complain(("point",), f'found "{table.point}", expected a joint or link.point that moves; {wrong}')
        direction = _direction(table, complain)
        actions += [OnPoint(ref, direction, frame)] if ref and direction else []
    if table.joint is not None:
        joint, wrong = find_joint(table.joint, around.mechanism)
        if joint is None:
            complain(("joint",), f'found "{table.joint}", expected a joint; {wrong}')
        actions += [AtJoint(joint)] if joint is not None else []
    if table.link is not None:
        link, wrong = find_link(table.link, around.mechanism)
        if link is None:
            complain(("link",), f'found "{table.link}", expected a link that moves; {wrong}')
        actions += [OnLink(link)] if link is not None else []
    return Input(index, table.name, actions[0]) if sound and actions else None


def _check_kind(table: InputTable, complain: Complain) -> bool:
    """Whether the table says one thing; complains if not."""
    given = [key for key in KINDS if getattr(table, key) is not None]
    sound = len(given) == 1
    if not given:
        complain((), "found no point, joint or link, expected one of them; add one")
    for key in given[1:]:
        complain((key,), f"found {key} beside {given[0]}, expected one of point, joint and link; remove one")
    for key in ("direction", "frame"):
        if getattr(table, key) is not None and "point" not in given:
            complain((key,), f"found {key} without point, expected it with a force on a point only; remove it")
            sound = False
    if table.name == "t":
        complain(("name",), 'found "t", the name of the time, expected another name; change it')
        sound = False
    return sound


def _direction(table: InputTable, complain: Complain) -> tuple[Parameter | int, Parameter | int] | None:
    if table.direction is None:
        complain(("direction",), "missing, expected the direction of the force, [x, y], not both zero; add it")
        return None
    direction = unit(table.direction)
    if direction is None:
        message = f"found {table.direction}, expected a direction, not both zero; write [1, 0] for one along x"
        complain(("direction",), message)
        return None
    x, y = direction
    if not x or not y:
        return int(math.copysign(1.0, x)) if x else 0, int(math.copysign(1.0, y)) if y else 0
    path, symbol = f"{table.name}.direction", f"n_input_{table.name}"
    return Parameter(f"{path}.x", f"{symbol}_x", x), Parameter(f"{path}.y", f"{symbol}_y", y)


ENTRY = Entry("input", True, InputTable, build, {"direction": "vector"})
