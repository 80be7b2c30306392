"""Drag: resistance of a still medium to the motion of a point, linear and quadratic in its speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from ..effect_base.effect import Complain, Effect, Entry, Surroundings
from ..effect_base.line import links_at
from ..effect_base.points import find_point
from ..effect_base.table import Name, NotNegative, PointName, Table
from ..effect_base.written_numbers import Measured
from ..mechanism.joints import PointRef
from ..mechanism.links import GROUND, NOT_NEGATIVE, POSITIVE, Domain, Parameter

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Force, Motion
    from ..derive.terms_of_effects import Told
    from ..derive.vectors import Vector

SPEED = 1e-3
"""Default of the speed (m/s) below which quadratic drag is linear."""


class DragTable(Table):
    """One ``[[drag]]``."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    point: PointName = Field(description='the point on which it acts, such as "link_0.B" or "joint_1"')
    linear: Annotated[NotNegative, Measured("N s/m")] | None = Field(
        default=None, description="the linear drag in N s/m, zero or a positive number"
    )
    quadratic: Annotated[NotNegative, Measured("N s²/m²")] | None = Field(
        default=None, description="the quadratic drag in N s²/m², zero or a positive number"
    )
    speed: Annotated[NotNegative, Measured("m/s")] | None = Field(
        default=None,
        description="the speed below which quadratic drag is linear in m/s, zero or a positive number",
    )


@dataclass(frozen=True)
class Drag(Effect):
    """Acts on ``point`` against its velocity v with (``linear`` + ``quadratic`` · √(v² + ``speed``²)) v.

    ``linear`` is in N s/m, ``quadratic`` in N s²/m², ``speed`` in m/s; what is ``None`` is absent.
    """

    label: str
    name: str
    point: PointRef
    linear: Parameter | None
    quadratic: Parameter | None
    speed: Parameter | None

    def parameters(self) -> tuple[Parameter, ...]:
        return tuple(p for p in (self.linear, self.quadratic, self.speed) if p is not None)

    def loads(self, motion: Motion) -> Sequence[Force]:
        from ..derive.motion import Force
        from ..derive.vectors import scale

        force = scale(-self._resistance(motion), self._velocity(motion))
        return (Force(self.point, motion.let_vector(f"force_{self.label}", force)),)

    def power(self, motion: Motion) -> Expr:
        return -self._resistance(motion) * self._square(motion)

    def outputs(self, motion: Motion) -> Sequence[Told]:
        """The size of the force, and its power."""
        from sympy import sqrt

        force = self._resistance(motion) * sqrt(self._square(motion))
        return ("force", "N", force), ("power", "W", self.power(motion))

    def _resistance(self, motion: Motion) -> Expr:
        """Force per speed (N s/m)."""
        from sympy import sqrt

        resistance = motion.value(self.linear)
        if self.quadratic:
            floor = motion.value(self.speed)
            resistance += motion.value(self.quadratic) * sqrt(self._square(motion) + floor**2)
        return motion.let(f"resistance_{self.label}", resistance)

    def _square(self, motion: Motion) -> Expr:
        from ..derive.vectors import dot

        velocity = self._velocity(motion)
        return motion.let(f"square_{self.label}", dot(velocity, velocity))

    def _velocity(self, motion: Motion) -> Vector:
        return motion.let_vector(f"velocity_{self.label}", motion.velocity(self.point))


def build(table: DragTable, index: int, around: Surroundings, complain: Complain) -> Drag | None:
    """The record of a table, or ``None`` after having complained."""
    point, wrong = find_point(table.point, around.mechanism)
    if point is None:
        complain(("point",), f'found "{table.point}", expected a joint or link.point that moves; {wrong}')
    elif GROUND in links_at(table.point, point, around.mechanism):
        still = "it is fixed on the ground; name another point"
        complain(("point",), f'found "{table.point}", expected a joint or link.point that moves; {still}')
        point = None
    if table.linear is None and table.quadratic is None:
        complain((), "found neither linear nor quadratic drag, expected one of them or both; add one")
        return None
    if table.quadratic is None and table.speed is not None:
        complain(("speed",), "found without quadratic drag, expected only with it; remove it or add quadratic")
        return None
    if point is None:
        return None
    label = f"drag_{index}"
    name = table.name or label
    speed = SPEED if table.speed is None else table.speed

    def parameter(key: str, symbol: str, value: float | None, domain: Domain = NOT_NEGATIVE) -> Parameter | None:
        return Parameter(f"{name}.{key}", f"{symbol}_{label}", value, domain) if value is not None else None

    return Drag(
        label,
        name,
        point,
        parameter("linear", "c", table.linear),
        parameter("quadratic", "k", table.quadratic),
        parameter("speed", "v0", speed if table.quadratic is not None and speed else None, POSITIVE),
    )


ENTRY = Entry("drag", True, DragTable, build, {})
