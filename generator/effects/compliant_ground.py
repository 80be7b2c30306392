"""Compliant ground: a half-plane that gives way under points of the mechanism, or discs about them, and pushes back."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect_base.compliance import Compliance, ComplianceTable, Hertz, Pressed, read_compliance
from ..effect_base.effect import Complain, Effect, Entry, Level, Plane, Rim, Surroundings
from ..mechanism.joints import PointRef
from ..mechanism.links import Parameter
from .ground import HalfPlane, HalfPlaneTable, read_half_plane

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Couple, Force, Motion
    from ..derive.terms_of_effects import Told
    from ..derive.vectors import Vector


class CompliantGroundTable(HalfPlaneTable, ComplianceTable):
    """One ``[[compliant_ground]]``."""


@dataclass(frozen=True)
class CompliantGround(Effect):
    """Presses contacts that are deep in its ``plane`` out by a ``law``, never inwards, and resists their slip."""

    index: int
    name: str
    plane: HalfPlane
    law: Compliance

    def parameters(self) -> tuple[Parameter, ...]:
        return (
            *self.plane.normal.parameters(),
            *self.plane.point.parameters(),
            *self.law.parameters(),
            *dict.fromkeys(radius for radius in self.plane.radii if radius),
        )

    def sides(self) -> tuple[str, ...]:
        return self.law.sides(self._names())

    def switching(self, motion: Motion) -> Sequence[Expr]:
        return [value for pressed, _ in self._pressed(motion) for value in self.law.switching(motion, pressed)]

    def latches(self) -> tuple[tuple[str, str], ...]:
        return self.law.latches(self._names())

    def latching(self, motion: Motion) -> Sequence[Expr]:
        return [value for pressed, _ in self._pressed(motion) for value in self.law.latching(motion, pressed)]

    def loads(self, motion: Motion) -> Sequence[Force | Couple]:
        """The normal force and friction where each contact touches, moved to the centre of its disc."""
        from ..derive.motion import Couple, Force
        from ..derive.vectors import add, scale

        normal, along = self._directions(motion)
        loads: list[Force | Couple] = []
        for (pressed, ref), (_, radius) in zip(self._pressed(motion), self.plane.rounded(), strict=True):
            push, drag = self.law.push(motion, pressed), self.law.drag(motion, pressed)
            force = add(scale(push, normal), scale(drag, along))
            loads.append(Force(ref, motion.let_vector(f"force_{pressed.name}", force)))
            if self.law.friction and radius:
                loads.append(Couple(ref.link, motion.value(radius) * drag))
        return loads

    def potential(self, motion: Motion) -> Expr:
        """What is stored in every contact."""
        total = motion.value(None)
        for pressed, _ in self._pressed(motion):
            total += self.law.stored(motion, pressed)
        return total

    def power(self, motion: Motion) -> Expr:
        """What damping and friction take."""
        total = motion.value(None)
        for pressed, _ in self._pressed(motion):
            total += self.law.spent(motion, pressed)
        return total

    def outputs(self, motion: Motion) -> Sequence[Told]:
        """Of each contact how deep it is, negative where it is apart, its normal force and friction."""
        told: list[Told] = []
        for (pressed, _), ((name, _), _) in zip(self._pressed(motion), self.plane.rounded(), strict=True):
            told += self.law.outputs(motion, pressed, f"{name}.")
        return told

    def planes(self) -> tuple[Plane, ...]:
        return ((self.name, self.plane.point, self.plane.normal),)

    def rims(self) -> tuple[Rim, ...]:
        return tuple((ref, None, radius) for (_, ref), radius in self.plane.rounded() if radius)

    def level(self) -> Level:
        return Level(self.plane.point.values(), self.plane.normal.values())

    def _names(self) -> list[str]:
        return [f"compliant_{self.index}_{number}" for number in range(len(self.plane.contacts))]

    def _directions(self, motion: Motion) -> tuple[Vector, Vector]:
        """The outward normal, and along the ground."""
        from sympy import sqrt

        from ..derive.vectors import dot, local

        given = local(self.plane.normal)
        length = motion.let(f"length_n_compliant_{self.index}", sqrt(dot(given, given)))
        x, y = motion.let_vector(f"nu_compliant_{self.index}", (given[0] / length, given[1] / length))
        return (x, y), (y, -x)

    def _pressed(self, motion: Motion) -> Iterator[tuple[Pressed, PointRef]]:
        """Every contact, and the point or the centre of the disc that touches."""
        from ..derive.vectors import dot, local

        normal, along = self._directions(motion)
        offset = motion.let(f"offset_compliant_{self.index}", dot(normal, local(self.plane.point)))
        for name, ((_, ref), radius) in zip(self._names(), self.plane.rounded(), strict=True):
            arm, velocity = motion.value(radius), motion.velocity(ref)
            slip = dot(along, velocity) + arm * motion.rate(ref.link)
            pressed = Pressed(
                name,
                motion.let(f"depth_{name}", arm + offset - dot(normal, motion.position(ref))),
                motion.let(f"approach_{name}", -dot(normal, velocity)),
                motion.let(f"slip_{name}", slip) if self.law.friction else motion.value(None),
                1 / arm if radius else motion.value(None),
            )
            yield pressed, ref


def build(table: CompliantGroundTable, index: int, around: Surroundings, complain: Complain) -> CompliantGround | None:
    """The record of a table, or ``None`` after having complained."""
    name, label = table.name or f"compliant_ground_{index}", f"compliant_{index}"
    plane = read_half_plane(table, name, label, around, complain)
    law = read_compliance(table, name, label, complain)
    if plane is None or law is None:
        return None
    if isinstance(law.elastic, Hertz) and not all(radius for _, radius in plane.rounded()):
        message = (
            "found young with points that have no radius, expected discs, because Hertz's law is one of round bodies"
        )
        complain(("young",), f"{message}; add radius, or write load in its place")
        return None
    return CompliantGround(index, name, plane, law)


ENTRY = Entry("compliant_ground", True, CompliantGroundTable, build, {})
