"""Compliant contact: how hard what is a little inside a body is pushed out, and what damps and rubs it meanwhile.

Damping after K. H. Hunt and F. R. E. Crossley (Coefficient of restitution interpreted as damping in vibroimpact,
J. Appl. Mech. 42, 1975), or after H. M. Lankarani and P. E. Nikravesh (A contact force model with hysteresis damping
for impact analysis of multibody systems, J. Mech. Design 112, 1990), whose damping is that of the speed with which the
contact has begun; stiffness as written, or of two materials after Hertz, as Lankarani and Nikravesh have it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import Discriminator, Field, Tag

from ..mechanism.links import FROM_0_TO_1, NOT_NEGATIVE, POSITIVE, Domain, Parameter
from .contact import Friction, Restitution
from .effect import Complain
from .table import NotNegative, Positive, Table, number_or_list
from .written_numbers import Measured

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Motion
    from ..derive.terms_of_effects import Told

SLIP_SPEED = 0.001
"""Default of the speed (m/s) at which smoothed friction has reached tanh 1 = 76 % of its force."""
SLOWEST = 0.001
"""Default of the speed of approach (m/s) below which damping after Lankarani and Nikravesh grows no more."""
DEPTH = 0.001
"""Default of the depth (m) to which the load presses."""
EXPONENTS = (1.0, 1.5, 2.0, 2.5, 3.0)
"""Powers that need no logarithm: whole ones, and these times a root."""
HERTZ = 1.5
"""That of two round bodies."""

Young = Annotated[Positive, Measured("Pa")]
Poisson = Annotated[float, Field(ge=0.0, le=0.5), Measured("1")]


class ComplianceTable(Table):
    """How a contact gives way."""

    load: Annotated[NotNegative, Measured("N")] | None = Field(
        default=None, description="the force in N that presses a contact as deep as depth, zero or positive"
    )
    depth: Annotated[Positive, Measured("m")] | None = Field(
        default=None, description="the depth in m to which the load presses a contact, a positive number"
    )
    exponent: Annotated[float, Measured("1")] | None = Field(
        default=None, description="the power of the depth with which the force grows, 1, 1.5 (Hertz), 2, 2.5 or 3"
    )
    young: (
        Annotated[
            Annotated[Young, Tag("<number>")]
            | Annotated[Annotated[list[Young], Field(min_length=2, max_length=2)], Tag("<list>")],
            Discriminator(number_or_list),
        ]
        | None
    ) = Field(
        default=None,
        description="Young's modulus of both bodies in Pa, a positive number, or a list of two, one for each",
    )
    poisson: (
        Annotated[
            Annotated[Poisson, Tag("<number>")]
            | Annotated[Annotated[list[Poisson], Field(min_length=2, max_length=2)], Tag("<list>")],
            Discriminator(number_or_list),
        ]
        | None
    ) = Field(default=None, description="Poisson's ratio of both bodies, a number from 0 to 0.5, or a list of two")
    damping: Annotated[NotNegative, Measured("s/m")] | None = Field(
        default=None, description="by what part the force is larger per speed of approach, in s/m, zero or positive"
    )
    restitution: Restitution | None = Field(
        default=None, description="the coefficient of restitution after Lankarani and Nikravesh, a number from 0 to 1"
    )
    slowest: Annotated[Positive, Measured("m/s")] | None = Field(
        default=None, description="the speed of approach in m/s up to which damping is that of this speed, positive"
    )
    friction: Friction | None = Field(default=None, description="Coulomb's coefficient of friction, zero or positive")
    slip_speed: Annotated[Positive, Measured("m/s")] | None = Field(
        default=None, description="the speed about which friction changes its sign in m/s, a positive number"
    )


@dataclass(frozen=True)
class Pressed:
    """One contact as the law sees it: ``name`` in symbols and of its kinks, and expressions of its motion.

    ``depth`` (m); ``approach``, its rate, and ``slip`` along the surface (m/s); ``roundness`` is 1/R₁ + 1/R₂ (1/m) of
    both bodies, of a flat one 0.
    """

    name: str
    depth: Expr
    approach: Expr
    slip: Expr
    roundness: Expr


@dataclass(frozen=True)
class Loaded:
    """``load`` (N) presses ``depth`` (m) deep, and any other depth d with load (d/depth)ⁿ; n is the ``exponent``."""

    load: Parameter
    depth: Parameter
    exponent: float

    def parameters(self) -> tuple[Parameter, ...]:
        return (self.load, self.depth)

    def scale(self, motion: Motion, pressed: Pressed) -> Expr:
        """The force (N) at a depth of one ``unit``."""
        return motion.value(self.load)

    def unit(self, motion: Motion) -> Expr:
        return motion.value(self.depth)


@dataclass(frozen=True)
class Hertz:
    """Round bodies of materials with moduli ``young`` (Pa) and ratios ``poisson``: K d^1.5 with
    K = 4/(3π (h₁ + h₂) √(1/R₁ + 1/R₂)), h = (1 − ν²)/(π E), as Lankarani and Nikravesh write Hertz's law."""

    young: tuple[Parameter, Parameter]
    poisson: tuple[Parameter | None, Parameter | None]
    exponent = HERTZ

    def parameters(self) -> tuple[Parameter, ...]:
        return tuple(dict.fromkeys(p for p in (*self.young, *self.poisson) if p))

    def scale(self, motion: Motion, pressed: Pressed) -> Expr:
        from sympy import Rational, sqrt

        give = sum(
            (1 - motion.value(nu) ** 2) / motion.value(e) for e, nu in zip(self.young, self.poisson, strict=True)
        )
        return motion.let(f"hertz_{pressed.name}", Rational(4, 3) / (give * sqrt(pressed.roundness)))

    def unit(self, motion: Motion) -> Expr:
        from sympy import Integer

        return Integer(1)


@dataclass(frozen=True)
class HuntCrossley:
    """The elastic force times 1 + ``damping`` ḋ (s/m)."""

    damping: Parameter

    def parameters(self) -> tuple[Parameter, ...]:
        return (self.damping,)

    def latches(self, names: Sequence[str]) -> tuple[tuple[str, str], ...]:
        return ()

    def latching(self, motion: Motion, pressed: Pressed) -> tuple[Expr, ...]:
        return ()

    def rate(self, motion: Motion, name: str) -> Expr:
        """What ḋ is multiplied by (s/m)."""
        return motion.value(self.damping)


@dataclass(frozen=True)
class LankaraniNikravesh:
    """The elastic force times 1 + ¾(1 − e²) ḋ/ḋ⁻: e is the ``restitution`` and ḋ⁻ the approach with which the contact
    has begun, or ``slowest`` (m/s) where that is more."""

    restitution: Parameter
    slowest: Parameter

    def parameters(self) -> tuple[Parameter, ...]:
        return (self.restitution, self.slowest)

    def latches(self, names: Sequence[str]) -> tuple[tuple[str, str], ...]:
        return tuple((f"{name}_damping", f"{name}_in") for name in names)

    def latching(self, motion: Motion, pressed: Pressed) -> tuple[Expr, ...]:
        from sympy import Rational

        least = motion.value(self.slowest)
        begun = least + (pressed.approach - least) * motion.step(pressed.approach - least)
        return (Rational(3, 4) * (1 - motion.value(self.restitution) ** 2) / begun,)

    def rate(self, motion: Motion, name: str) -> Expr:
        return motion.latched(f"{name}_damping")


@dataclass(frozen=True)
class Compliance:
    """The law of contacts that give way: elastic, damped and rough as far as ``damping`` and ``friction`` are there.

    Friction is tanh(v/``slip_speed``) (m/s) times the coefficient and the force.
    """

    elastic: Loaded | Hertz
    damping: HuntCrossley | LankaraniNikravesh | None
    friction: Parameter | None
    slip_speed: Parameter | None

    def parameters(self) -> tuple[Parameter, ...]:
        damping = self.damping.parameters() if self.damping else ()
        return (*self.elastic.parameters(), *damping, *(p for p in (self.friction, self.slip_speed) if p))

    def sides(self, names: Sequence[str]) -> tuple[str, ...]:
        """Whether each contact is deep, and with damping whether it pushes."""
        return tuple(f"{name}_{kind}" for name in names for kind in (("in", "loaded") if self.damping else ("in",)))

    def switching(self, motion: Motion, pressed: Pressed) -> tuple[Expr, ...]:
        """The depth; with damping also 1 + c ḋ, below which the body would pull."""
        return (pressed.depth, self._swelling(motion, pressed)) if self.damping else (pressed.depth,)

    def latches(self, names: Sequence[str]) -> tuple[tuple[str, str], ...]:
        return self.damping.latches(names) if self.damping else ()

    def latching(self, motion: Motion, pressed: Pressed) -> tuple[Expr, ...]:
        return self.damping.latching(motion, pressed) if self.damping else ()

    def push(self, motion: Motion, pressed: Pressed) -> Expr:
        """The normal force (N)."""
        elastic = self._elastic(motion, pressed)
        if self.damping is None:
            return elastic
        loaded = motion.side(f"{pressed.name}_loaded") * self._swelling(motion, pressed)
        return motion.let(f"push_{pressed.name}", elastic * loaded)

    def drag(self, motion: Motion, pressed: Pressed) -> Expr:
        """Friction (N) in the direction of the slip."""
        from sympy import tanh

        if self.friction is None:
            return motion.value(None)
        limit = motion.value(self.friction) * self.push(motion, pressed)
        return motion.let(f"drag_{pressed.name}", -limit * tanh(pressed.slip / motion.value(self.slip_speed)))

    def stored(self, motion: Motion, pressed: Pressed) -> Expr:
        """The energy (J) of the elastic part: scale unit (d/unit)ⁿ⁺¹/(n + 1)."""
        depth = self._power_of(motion, pressed.depth) * pressed.depth / (self.elastic.exponent + 1)
        return motion.step(pressed.depth) * self.elastic.scale(motion, pressed) * depth

    def spent(self, motion: Motion, pressed: Pressed) -> Expr:
        """The power (W) of damping and friction."""
        total = self.drag(motion, pressed) * pressed.slip
        if self.damping:
            total += (self._elastic(motion, pressed) - self.push(motion, pressed)) * pressed.approach
        return total

    def outputs(self, motion: Motion, pressed: Pressed, of: str) -> list[Told]:
        """What runs tell of a contact, behind its name."""
        told: list[Told] = [(f"{of}depth", "m", pressed.depth), (f"{of}normal", "N", self.push(motion, pressed))]
        return [*told, (f"{of}friction", "N", self.drag(motion, pressed))] if self.friction else told

    def _power_of(self, motion: Motion, depth: Expr) -> Expr:
        """(d/unit)ⁿ; of a half the root of |d|, since a stage of a step may lie outside."""
        from sympy import Abs, Integer, sqrt

        part = depth / self.elastic.unit(motion)
        whole = int(self.elastic.exponent)
        found = part**whole if whole else Integer(1)
        return found if whole == self.elastic.exponent else found * sqrt(Abs(part))

    def _elastic(self, motion: Motion, pressed: Pressed) -> Expr:
        scale = self.elastic.scale(motion, pressed)
        force = motion.side(f"{pressed.name}_in") * scale * self._power_of(motion, pressed.depth)
        return motion.let(f"elastic_{pressed.name}", force)

    def _swelling(self, motion: Motion, pressed: Pressed) -> Expr:
        """1 + c ḋ."""
        assert self.damping is not None
        rate = self.damping.rate(motion, pressed.name)
        return motion.let(f"swelling_{pressed.name}", 1 + rate * pressed.approach)


def read_compliance(table: ComplianceTable, name: str, label: str, complain: Complain) -> Compliance | None:
    """The law of a table, its parameters under ``name``, symbols with ``label``; ``None`` after complaints."""
    if table.friction is None and table.slip_speed is not None:
        complain(("slip_speed",), "found it without friction, expected only with it; remove it or add friction")
    if table.restitution is None and table.slowest is not None:
        complain(("slowest",), "found it without restitution, expected only with it; remove it or add restitution")
    if table.restitution is not None and table.damping is not None:
        message = "found damping and restitution, expected one of them: restitution tells how large damping is"
        complain(("damping",), f"{message}; remove one")
    elastic = _read_elastic(table, name, label, complain)
    if elastic is None:
        return None

    def parameter(key: str, symbol: str, value: float | None, domain: Domain = NOT_NEGATIVE) -> Parameter:
        return Parameter(f"{name}.{key}", f"{symbol}_{label}", value or 0.0, domain)

    damping: HuntCrossley | LankaraniNikravesh | None = None
    if table.restitution is not None:
        slowest = parameter("slowest", "vl", table.slowest or SLOWEST, POSITIVE)
        damping = LankaraniNikravesh(parameter("restitution", "e", table.restitution, FROM_0_TO_1), slowest)
    elif table.damping is not None:
        damping = HuntCrossley(parameter("damping", "c", table.damping))
    if table.friction is None:
        return Compliance(elastic, damping, None, None)
    slip_speed = parameter("slip_speed", "vs", table.slip_speed or SLIP_SPEED, POSITIVE)
    return Compliance(elastic, damping, parameter("friction", "fr", table.friction), slip_speed)


def _read_elastic(table: ComplianceTable, name: str, label: str, complain: Complain) -> Loaded | Hertz | None:
    loaded = [key for key in ("load", "depth", "exponent") if getattr(table, key) is not None]
    if table.young is None and table.poisson is not None:
        complain(("poisson",), "found it without young, expected only with it; remove it or add young")
    if table.young is not None:
        for key in loaded:
            complain((key,), f"found {key} beside young, expected one or the other; remove one")
        return None if loaded else _read_hertz(table, name, label)
    if table.load is None:
        complain(
            (), "found neither load nor young, expected one of them; add a load, or Young's modulus of both bodies"
        )
    if table.exponent is not None and table.exponent not in EXPONENTS:
        complain(("exponent",), f"found {table.exponent:g}, expected 1, 1.5, 2, 2.5 or 3; choose one")
        return None
    if table.load is None:
        return None
    return Loaded(
        Parameter(f"{name}.load", f"K_{label}", table.load, NOT_NEGATIVE),
        Parameter(f"{name}.depth", f"d0_{label}", table.depth or DEPTH, POSITIVE),
        table.exponent or HERTZ,
    )


def _read_hertz(table: ComplianceTable, name: str, label: str) -> Hertz:
    """One parameter for both bodies where the scene gives one number."""

    def both(key: str, symbol: str, given: float | list[float] | None, domain: Domain) -> tuple[Parameter | None, ...]:
        if isinstance(given, list):
            return tuple(
                Parameter(f"{name}.{key}.{i}", f"{symbol}_{label}_{i}", x, domain) for i, x in enumerate(given)
            )
        return (Parameter(f"{name}.{key}", f"{symbol}_{label}", given, domain) if given is not None else None,) * 2

    e, f = both("young", "E", table.young, POSITIVE)
    nu, mu = both("poisson", "nu", table.poisson, FROM_0_TO_1)
    assert e is not None and f is not None
    return Hertz((e, f), (nu, mu))
