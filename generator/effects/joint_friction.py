"""Friction in joints: viscous, and dry friction smoothed about standstill, with Stribeck's curve if it is asked for.

Dry friction falls from its breakaway value to Coulomb's as in B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit,
A survey of models, analysis tools and compensation methods for the control of machines with friction, Automatica 30,
1994.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from ..effect_base.effect import Complain, Effect, Entry, Rub, Surroundings
from ..effect_base.points import find_joint
from ..effect_base.table import JointName, Name, NotNegative, Positive, Table
from ..effect_base.written_numbers import Measured, wrong_kind
from ..mechanism.joints import Joint
from ..mechanism.links import NOT_NEGATIVE, POSITIVE, Domain, Parameter
from ..mechanism.mechanism import Mechanism

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Couple, Force, Motion
    from ..derive.terms_of_effects import Told


class FrictionTable(Table):
    """One ``[[joint_friction]]``."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    joints: list[JointName] | None = Field(
        default=None, min_length=1, description='a list of joints, such as ["joint_1", "joint_2"] (default: all)'
    )
    viscous: Annotated[NotNegative, Measured("N m s/rad", "N s/m")] | None = Field(
        default=None, description="the viscous friction in N m s/rad, zero or a positive number (N s/m where it slides)"
    )
    dry: Annotated[NotNegative, Measured("N m", "N")] | None = Field(
        default=None,
        description="the moment of dry friction in N m, zero or a positive number (the force in N where it slides)",
    )
    rate: Annotated[Positive, Measured("rad/s", "m/s")] | None = Field(
        default=None,
        description="the rate about which dry friction changes its sign in rad/s, a positive number (m/s on a line)",
    )
    breakaway: Annotated[Positive, Measured("N m", "N")] | None = Field(
        default=None,
        description="the moment of dry friction near standstill in N m, more than dry (the force in N where it slides)",
    )
    stribeck: Annotated[Positive, Measured("rad/s", "m/s")] | None = Field(
        default=None,
        description="the rate at which e⁻¹ of what breakaway is more is left, in rad/s, positive (m/s on a line)",
    )


RATE = 0.01
"""Default of the rate (rad/s or m/s) at which smoothed dry friction has reached tanh 1 = 76 % of its moment."""
SMOOTHED = 0.01
"""The same with Stribeck's curve, as a part of its rate."""


@dataclass(frozen=True)
class JointFriction(Effect):
    """Resists the motion of joints (indices) with ``viscous`` · ω + ``dry`` · tanh(ω / ``rate``), each the same.

    Where there is ``breakaway`` it stands for ``dry`` with the part exp(−(ω/``stribeck``)²), ``dry`` with the rest. All
    of them turn, or all slide. ``viscous`` is in N m s/rad, ``dry`` in N m (N s/m and N where they slide); what is
    ``None`` is absent.
    """

    label: str
    name: str
    joints: tuple[int, ...]
    viscous: Parameter | None
    dry: Parameter | None
    rate: Parameter | None
    breakaway: Parameter | None = None
    stribeck: Parameter | None = None

    def at_joints(self) -> tuple[int, ...]:
        return self.joints

    def parameters(self) -> tuple[Parameter, ...]:
        given = (self.viscous, self.dry, self.rate, self.breakaway, self.stribeck)
        return tuple(p for p in given if p is not None)

    def rubs(self, mechanism: Mechanism) -> tuple[Rub, ...]:
        if self.rate is None:
            return ()
        names = ((index, _told_of(mechanism.joints[index])[0]) for index in self.joints)
        return tuple(Rub(index, self.rate, name, self.viscous) for index, name in names)

    def loads(self, motion: Motion) -> Sequence[Force | Couple]:
        """The moment resists on the joint's second link, and drags the first along."""
        loads: list[Force | Couple] = []
        for index in self.joints:
            loads += motion.joint_effort(index, -self._moment(motion, index))
        return loads

    def power(self, motion: Motion) -> Expr:
        """−ω (c ω + T(ω) tanh(ω/ω₀)) of every joint."""
        power = motion.value(None)
        for index in self.joints:
            power -= self._slip(motion, index) * self._moment(motion, index)
        return power

    def outputs(self, motion: Motion) -> Sequence[Told]:
        """Of each joint the moment (the force along its line) on the second link, and the power of all."""
        told: list[Told] = []
        for index in self.joints:
            joint = motion.joint(index)
            told.append((*_told_of(joint), -self._moment(motion, index), joint.second.link))
        return [*told, ("power", "W", self.power(motion))]

    def _moment(self, motion: Motion, index: int) -> Expr:
        from sympy import exp, tanh

        omega = self._slip(motion, index)
        moment = motion.value(self.viscous) * omega
        if self.dry:
            dry = motion.value(self.dry)
            if self.breakaway:
                near = exp(-((omega / motion.value(self.stribeck)) ** 2))
                dry += (motion.value(self.breakaway) - dry) * motion.let(f"near_{self.label}_{index}", near)
            moment += dry * tanh(omega / motion.value(self.rate))
        return motion.let(f"moment_{self.label}_{index}", moment)

    def _slip(self, motion: Motion, index: int) -> Expr:
        return motion.let(f"slip_{self.label}_{index}", motion.joint_speed(index))


def _told_of(joint: Joint) -> tuple[str, str]:
    """What runs call the friction in a joint, and its unit."""
    asked, unit = ("force", "N") if joint.slides else ("moment", "N m")
    return f"{joint.name}.{asked}", unit


def build(table: FrictionTable, index: int, around: Surroundings, complain: Complain) -> JointFriction | None:
    """The record of a table, or ``None`` after having complained."""
    joints = _joints(table, around, complain)
    if table.viscous is None and table.dry is None:
        complain((), "found neither viscous nor dry friction, expected one of them or both; add one")
        return None
    if table.dry is None and table.rate is not None:
        complain(("rate",), "found without dry friction, expected only with it; remove it or add dry")
        return None
    if not _check_stribeck(table, complain):
        return None
    if joints is None or not _check_units(table, around.mechanism.joints[joints[0]].slides, complain):
        return None
    label = f"joint_friction_{index}"
    name = table.name or label

    usual = SMOOTHED * table.stribeck if table.stribeck else RATE

    def parameter(key: str, symbol: str, value: float | None, domain: Domain = NOT_NEGATIVE) -> Parameter | None:
        return Parameter(f"{name}.{key}", f"{symbol}_{label}", value, domain) if value is not None else None

    return JointFriction(
        label,
        name,
        joints,
        parameter("viscous", "c", table.viscous),
        parameter("dry", "T", table.dry),
        parameter("rate", "w0", (table.rate or usual) if table.dry is not None else None, POSITIVE),
        parameter("breakaway", "Tb", table.breakaway),
        parameter("stribeck", "ws", table.stribeck, POSITIVE),
    )


def _check_stribeck(table: FrictionTable, complain: Complain) -> bool:
    """A curve that falls: breakaway is more than dry, and its rate well beyond that of the change of sign."""
    for key, other in (("breakaway", "stribeck"), ("stribeck", "breakaway")):
        if getattr(table, key) is not None and getattr(table, other) is None:
            complain((key,), f"found without {other}, expected both or neither; add {other} or remove {key}")
            return False
    if table.breakaway is None or table.stribeck is None:
        return True
    if table.dry is None:
        complain(
            ("breakaway",), "found without dry friction, expected only with it; add dry, or remove it and stribeck"
        )
        return False
    if not table.breakaway > table.dry:
        told = f"found {table.breakaway:g}, expected more than dry, {table.dry:g}, to which it falls; correct one"
        complain(("breakaway",), told)
        return False
    if table.rate is not None and not table.rate < table.stribeck:
        told = f"found {table.rate:g}, expected less than stribeck, {table.stribeck:g}, or breakaway is never reached"
        complain(("rate",), f"{told}; correct one")
        return False
    return True


def _check_units(table: FrictionTable, slides: bool, complain: Complain) -> bool:
    """Units that are written are those of the kind of joint."""
    units = {"viscous": "N s/m", "dry": "N", "rate": "m/s", "breakaway": "N", "stribeck": "m/s"}
    if not slides:
        units = {"viscous": "N m s/rad", "dry": "N m", "rate": "rad/s", "breakaway": "N m", "stribeck": "rad/s"}
    wrong = {key: sentence for key, unit in units.items() if (sentence := wrong_kind(getattr(table, key), unit))}
    for key, sentence in wrong.items():
        complain((key,), sentence)
    return not wrong


def _joints(table: FrictionTable, around: Surroundings, complain: Complain) -> tuple[int, ...] | None:
    """Indices of the joints that rub: those listed, or all. ``None`` after a complaint."""
    joints = _listed(table, around, complain)
    kinds = {around.mechanism.joints[index].slides for index in joints or ()}
    if len(kinds) > 1:
        complain(
            ("joints",) if table.joints else (),
            "found joints that turn and joints that slide, expected one kind, because their units differ; list one "
            "kind in joints and write a second table for the other",
        )
        return None
    return joints


def _listed(table: FrictionTable, around: Surroundings, complain: Complain) -> tuple[int, ...] | None:
    if table.joints is None:
        if not around.mechanism.joints:
            complain((), "found a mechanism without joints, expected at least one; remove the table")
        mechanism = around.mechanism
        return tuple(k for k, joint in enumerate(mechanism.joints) if joint.name not in mechanism.hidden_joints) or None
    found = []
    for at, name in enumerate(table.joints):
        joint, wrong = find_joint(name, around.mechanism)
        if name in table.joints[:at]:
            joint, wrong = None, "it is listed twice; remove one of them"
        if joint is None:
            complain(("joints", at), f'found "{name}", expected a joint; {wrong}')
        else:
            found.append(joint)
    return tuple(found) if len(found) == len(table.joints) else None


ENTRY = Entry("joint_friction", True, FrictionTable, build, {})
