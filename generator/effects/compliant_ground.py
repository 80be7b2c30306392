"""Compliant ground: a half-plane that gives way under points of the mechanism, or discs about them, and pushes back.

The law is Hunt's and Crossley's (K. H. Hunt, F. R. E. Crossley, Coefficient of restitution interpreted as damping in
vibroimpact, J. Appl. Mech. 42, 1975): a damping that grows with the depth, so that no force jumps.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from ..effect_base.effect import Complain, Effect, Entry, Level, Plane, Rim, Surroundings
from ..effect_base.table import NotNegative, Positive
from ..effect_base.written_numbers import Measured
from ..mechanism.links import NOT_NEGATIVE, POSITIVE, Parameter
from .ground import HalfPlane, HalfPlaneTable, read_half_plane

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Couple, Force, Motion
    from ..derive.vectors import Vector

SLIP_SPEED = 0.001
"""Default of the speed (m/s) at which smoothed friction has reached tanh 1 = 76 % of its force."""
EXPONENTS = (1.0, 1.5, 2.0, 2.5, 3.0)
"""Powers that need no logarithm: whole ones, and these times a root."""


class CompliantGroundTable(HalfPlaneTable):
    """One ``[[compliant_ground]]``."""

    load: Annotated[Positive, Measured("N")] = Field(
        description="the force in N that presses a contact as deep as depth, a positive number"
    )
    depth: Annotated[Positive, Measured("m")] = Field(
        default=0.001, description="the depth in m to which the load presses a contact, a positive number"
    )
    exponent: Annotated[float, Measured("1")] = Field(
        default=1.5, description="the power of the depth with which the force grows, 1, 1.5 (Hertz), 2, 2.5 or 3"
    )
    damping: Annotated[NotNegative, Measured("s/m")] = Field(
        default=0.0, description="by what part the force is larger per speed of approach, in s/m, zero or positive"
    )
    slip_speed: Annotated[Positive, Measured("m/s")] | None = Field(
        default=None, description="the speed about which friction changes its sign in m/s, a positive number"
    )


@dataclass(frozen=True)
class Touched:
    """One contact as the effect sees it: names, and expressions of its motion."""

    name: str
    """In symbols, and of its kinks."""
    depth: Expr
    approach: Expr
    """d(depth)/dt (m/s)."""
    slip: Expr
    """Speed along the ground of what touches (m/s), the normal turned clockwise."""
    arm: Expr
    """Radius (m)."""


@dataclass(frozen=True)
class CompliantGround(Effect):
    """Presses contacts that are ``d`` m deep in its ``plane`` out with load (d/depth)ⁿ (1 + damping ḋ), never inwards.

    It resists their slip v with friction tanh(v/slip_speed) times that.

    ``load`` is in N, ``depth`` in m, ``damping`` in s/m, ``slip_speed`` in m/s; n is the ``exponent``. Without
    ``friction`` it is smooth.
    """

    index: int
    name: str
    plane: HalfPlane
    load: Parameter
    depth: Parameter
    exponent: float
    damping: Parameter | None
    friction: Parameter | None
    slip_speed: Parameter | None

    def parameters(self) -> tuple[Parameter, ...]:
        own = (self.load, self.depth, self.damping, self.friction, self.slip_speed)
        return (
            *self.plane.normal.parameters(),
            *self.plane.point.parameters(),
            *(p for p in own if p),
            *dict.fromkeys(radius for radius in self.plane.radii if radius),
        )

    def sides(self) -> tuple[str, ...]:
        kinds = ("in", "loaded") if self.damping else ("in",)
        return tuple(f"{name}_{kind}" for name in self._names() for kind in kinds)

    def switching(self, motion: Motion) -> Sequence[Expr]:
        """The depth of each contact; with damping also 1 + c ḋ, below which the ground would pull."""
        values: list[Expr] = []
        for touched in self._touched(motion):
            values.append(touched.depth)
            if self.damping:
                values.append(self._swelling(motion, touched))
        return values

    def loads(self, motion: Motion) -> Sequence[Force | Couple]:
        """The normal force and friction where each contact touches, moved to the centre of its disc."""
        from ..derive.motion import Couple, Force
        from ..derive.vectors import add, scale

        normal, along = self._directions(motion)
        loads: list[Force | Couple] = []
        for touched, (_, ref) in zip(self._touched(motion), self.plane.contacts, strict=True):
            push, drag = self._push(motion, touched), self._drag(motion, touched)
            force = add(scale(push, normal), scale(drag, along))
            loads.append(Force(ref, motion.let_vector(f"force_{touched.name}", force)))
            if self.friction and touched.arm != 0:
                loads.append(Couple(ref.link, touched.arm * drag))
        return loads

    def potential(self, motion: Motion) -> Expr:
        """load depth (d/depth)ⁿ⁺¹/(n + 1) of every contact."""
        total = motion.value(None)
        for touched in self._touched(motion):
            stored = self._power_of(motion, touched.depth) * touched.depth / (self.exponent + 1)
            total += motion.step(touched.depth) * motion.value(self.load) * stored
        return total

    def power(self, motion: Motion) -> Expr:
        """What damping and friction take."""
        total = motion.value(None)
        for touched in self._touched(motion):
            if self.damping:
                total += (self._elastic(motion, touched) - self._push(motion, touched)) * touched.approach
            total += self._drag(motion, touched) * touched.slip
        return total

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

    def _touched(self, motion: Motion) -> Iterator[Touched]:
        from ..derive.vectors import dot, local

        normal, along = self._directions(motion)
        offset = motion.let(f"offset_compliant_{self.index}", dot(normal, local(self.plane.point)))
        for name, ((_, ref), radius) in zip(self._names(), self.plane.rounded(), strict=True):
            arm, velocity = motion.value(radius), motion.velocity(ref)
            slip = dot(along, velocity) + arm * motion.rate(ref.link)
            yield Touched(
                name,
                motion.let(f"depth_{name}", arm + offset - dot(normal, motion.position(ref))),
                motion.let(f"approach_{name}", -dot(normal, velocity)),
                motion.let(f"slip_{name}", slip) if self.friction else motion.value(None),
                arm,
            )

    def _power_of(self, motion: Motion, depth: Expr) -> Expr:
        """(d/depth)ⁿ; of a half the root of |d|, since a stage of a step may lie outside."""
        from sympy import Abs, Integer, sqrt

        part = depth / motion.value(self.depth)
        whole = int(self.exponent)
        found = part**whole if whole else Integer(1)
        return found if whole == self.exponent else found * sqrt(Abs(part))

    def _elastic(self, motion: Motion, touched: Touched) -> Expr:
        force = motion.side(f"{touched.name}_in") * motion.value(self.load) * self._power_of(motion, touched.depth)
        return motion.let(f"elastic_{touched.name}", force)

    def _swelling(self, motion: Motion, touched: Touched) -> Expr:
        """1 + c ḋ."""
        return motion.let(f"swelling_{touched.name}", 1 + motion.value(self.damping) * touched.approach)

    def _push(self, motion: Motion, touched: Touched) -> Expr:
        elastic = self._elastic(motion, touched)
        if self.damping is None:
            return elastic
        loaded = motion.side(f"{touched.name}_loaded") * self._swelling(motion, touched)
        return motion.let(f"push_{touched.name}", elastic * loaded)

    def _drag(self, motion: Motion, touched: Touched) -> Expr:
        from sympy import tanh

        if self.friction is None:
            return motion.value(None)
        limit = motion.value(self.friction) * self._push(motion, touched)
        return motion.let(f"drag_{touched.name}", -limit * tanh(touched.slip / motion.value(self.slip_speed)))


def build(table: CompliantGroundTable, index: int, around: Surroundings, complain: Complain) -> CompliantGround | None:
    """The record of a table, or ``None`` after having complained."""
    name, label = table.name or f"compliant_ground_{index}", f"compliant_{index}"
    plane = read_half_plane(table, name, label, around, complain)
    if table.exponent not in EXPONENTS:
        complain(("exponent",), f"found {table.exponent:g}, expected 1, 1.5, 2, 2.5 or 3; choose one")
    if table.friction is None and table.slip_speed is not None:
        complain(("slip_speed",), "found it without friction, expected only with it; remove it or add friction")
    if plane is None or table.exponent not in EXPONENTS:
        return None
    slip_speed = table.slip_speed or SLIP_SPEED
    return CompliantGround(
        index,
        name,
        plane,
        Parameter(f"{name}.load", f"K_{label}", table.load, NOT_NEGATIVE),
        Parameter(f"{name}.depth", f"d0_{label}", table.depth, POSITIVE),
        table.exponent,
        Parameter(f"{name}.damping", f"c_{label}", table.damping, NOT_NEGATIVE) if table.damping else None,
        Parameter(f"{name}.friction", f"fr_{label}", table.friction, NOT_NEGATIVE) if table.friction else None,
        Parameter(f"{name}.slip_speed", f"vs_{label}", slip_speed, POSITIVE) if table.friction else None,
    )


ENTRY = Entry("compliant_ground", True, CompliantGroundTable, build, {})
