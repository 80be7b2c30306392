"""Torsion: a torsional spring and damper at a joint, which may have play."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from ..effect_base.dead_zone import DeadZone
from ..effect_base.effect import Complain, Effect, Entry, Part, Surroundings
from ..effect_base.part_at_joint import part_at_joint
from ..effect_base.points import find_joint
from ..effect_base.table import JointName, Name, NotNegative, Positive, Table
from ..effect_base.written_numbers import Angle, Measured
from ..mechanism.links import ANY, NOT_NEGATIVE, Domain, Parameter

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Couple, Motion
    from ..derive.terms_of_effects import Told
    from ..mechanism.mechanism import Mechanism


class TorsionTable(Table):
    """One ``[[torsion]]``."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    joint: JointName = Field(description='the joint at which it acts, such as "joint_1"')
    stiffness: Annotated[Positive, Measured("N m/rad")] | None = Field(
        default=None, description="the stiffness in N m/rad, a positive number"
    )
    angle: Angle = Field(default=0.0, description='the joint\'s angle at rest in rad, or a text such as "30 deg"')
    damping: Annotated[NotNegative, Measured("N m s/rad")] | None = Field(
        default=None, description="the damping in N m s/rad, zero or a positive number"
    )
    play: Annotated[Positive, Measured("rad")] | None = Field(
        default=None,
        description='the angle in rad in which it is free, half on either side of rest, a positive one, or "2 deg"',
    )


@dataclass(frozen=True)
class Torsion(Effect):
    """Turns joint ``joint`` (an index) back to ``angle`` (rad) with ``stiffness`` (N m/rad), and damps its turning.

    What is ``None`` is absent; an angle that is ``None`` is zero. With a ``zone`` it does both beyond its play only.
    """

    label: str
    name: str
    joint: int
    stiffness: Parameter | None
    angle: Parameter | None
    damping: Parameter | None
    zone: DeadZone | None = None

    def parameters(self) -> tuple[Parameter, ...]:
        play = self.zone.play if self.zone else None
        return tuple(p for p in (self.stiffness, self.angle, self.damping, play) if p is not None)

    def sides(self) -> tuple[str, ...]:
        return self.zone.sides() if self.zone else ()

    def switching(self, motion: Motion) -> Sequence[Expr]:
        return self.zone.switching(motion, self._twist(motion), self._rate(motion)) if self.zone else ()

    def loads(self, motion: Motion) -> Sequence[Couple]:
        """−k (φ − φ₀) − c dφ/dt on the joint's second link, the opposite on its first."""
        from ..derive.motion import Couple

        joint = motion.joint(self.joint)
        moment = motion.value(self.stiffness) * self._twist(motion)
        moment += motion.value(self.damping) * motion.joint_rate(joint)
        if self.zone:
            moment = self.zone.effort(motion, self._twist(motion), self._rate(motion))
        moment = motion.let(f"moment_{self.label}", moment)
        return Couple(joint.first.link, moment), Couple(joint.second.link, -moment)

    def outputs(self, motion: Motion) -> Sequence[Told]:
        """The moment on the joint's second link."""
        second = self.loads(motion)[1]
        return (("moment", "N m", second.moment, second.link),)

    def parts(self, mechanism: Mechanism) -> tuple[Part, ...]:
        return (part_at_joint("torsion", self.name, mechanism.joints[self.joint]),)

    def potential(self, motion: Motion) -> Expr:
        """½ k (φ − φ₀)²."""
        if self.zone:
            return self.zone.potential(motion, self._twist(motion))
        return motion.value(self.stiffness) * self._twist(motion) ** 2 / 2

    def power(self, motion: Motion) -> Expr:
        """−c (dφ/dt)²."""
        if self.zone:
            return self.zone.power(motion, self._twist(motion), self._rate(motion))
        return -motion.value(self.damping) * motion.joint_rate(motion.joint(self.joint)) ** 2

    def _rate(self, motion: Motion) -> Expr:
        return motion.joint_rate(motion.joint(self.joint))

    def _twist(self, motion: Motion) -> Expr:
        if self.stiffness is None:
            return motion.value(None)
        angle = motion.joint_angle(motion.joint(self.joint)) - motion.value(self.angle)
        return motion.let(f"twist_{self.label}", angle)


def build(table: TorsionTable, index: int, around: Surroundings, complain: Complain) -> Torsion | None:
    """The record of a table, or ``None`` after having complained."""
    joint, wrong = find_joint(table.joint, around.mechanism)
    if joint is not None and not around.mechanism.joints[joint].turns:
        joint, wrong = None, "it does not turn; put a [[spring]] between points of its links"
    if joint is None:
        complain(("joint",), f'found "{table.joint}", expected a joint; {wrong}')
    if table.stiffness is None and table.damping is None:
        complain((), "found neither stiffness nor damping, expected one of them or both; add one")
        return None
    if table.stiffness is None and table.angle:
        complain(("angle",), "found without stiffness, expected only with it; remove it or add a stiffness")
        return None
    if table.stiffness is None and table.play:
        complain(("play",), "found without stiffness, expected only with it; remove it or add a stiffness")
        return None
    if joint is None:
        return None
    label = f"torsion_{index}"
    name = table.name or label

    def parameter(key: str, symbol: str, value: float | None, domain: Domain = NOT_NEGATIVE) -> Parameter | None:
        return Parameter(f"{name}.{key}", f"{symbol}_{label}", value, domain) if value is not None else None

    stiffness, damping = parameter("stiffness", "k", table.stiffness), parameter("damping", "c", table.damping)
    play = parameter("play", "p", table.play)
    zone = DeadZone(label, play, stiffness, damping) if play and stiffness else None
    angle = parameter("angle", "phi", table.angle or None, ANY)
    return Torsion(label, name, joint, stiffness, angle, damping, zone)


ENTRY = Entry("torsion", True, TorsionTable, build, {"angle": "angle"})
