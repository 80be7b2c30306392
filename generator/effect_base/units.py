"""Units that scenes may write behind a number, ``"20 cm"`` or ``"5 N/mm"``, and what they measure."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

Factor = Fraction | float
"""How many of the unit in SI a unit is: exact where it can be, so that "35 mm" is 0.035 to the last digit."""


@dataclass(frozen=True)
class Dimension:
    """Exponents of kilogram, metre, second and radian.

    ``rad`` is ``None`` where it cannot be told: a product of an angular velocity and a length is a speed, without one.
    """

    kg: int = 0
    m: int = 0
    s: int = 0
    rad: int | None = 0

    def times(self, other: Dimension, power: int = 1) -> Dimension:
        """That of a product with a power of something else, angles counted."""
        rad = None if self.rad is None or other.rad is None else self.rad + power * other.rad
        return Dimension(self.kg + power * other.kg, self.m + power * other.m, self.s + power * other.s, rad)

    def fits(self, other: Dimension) -> bool:
        """Whether both can be the same, as far as is known of their angles."""
        same = (self.kg, self.m, self.s) == (other.kg, other.m, other.s)
        return same and (self.rad is None or other.rad is None or self.rad == other.rad)


@dataclass(frozen=True)
class Unit:
    """A unit as it is written: how many of the unit in SI it is, and what it measures."""

    factor: Factor
    dimension: Dimension


_MASS, _LENGTH, _TIME, _ANGLE = Dimension(kg=1), Dimension(m=1), Dimension(s=1), Dimension(rad=1)
_NUMBER = Dimension()
_FORCE = Dimension(kg=1, m=1, s=-2)
_ENERGY = Dimension(kg=1, m=2, s=-2)

_BY_DIMENSION: tuple[tuple[Dimension, Mapping[str, Factor]], ...] = (
    (_NUMBER, {"1": Fraction(1), "%": Fraction(1, 100)}),
    (_MASS, {"kg": Fraction(1), "g": Fraction("1e-3"), "mg": Fraction("1e-6"), "t": Fraction(1000),
             "lb": Fraction("0.45359237")}),
    (_LENGTH, {"m": Fraction(1), "km": Fraction(1000), "dm": Fraction("0.1"), "cm": Fraction("0.01"),
               "mm": Fraction("1e-3"), "um": Fraction("1e-6"), "µm": Fraction("1e-6"),
               "in": Fraction("0.0254"), "ft": Fraction("0.3048")}),
    (_TIME, {"s": Fraction(1), "ms": Fraction("1e-3"), "us": Fraction("1e-6"), "µs": Fraction("1e-6"),
             "min": Fraction(60), "h": Fraction(3600)}),
    (_ANGLE, {"rad": Fraction(1), "mrad": Fraction("1e-3"), "deg": math.radians(1.0), "rev": 2.0 * math.pi}),
    (Dimension(s=-1, rad=1), {"rpm": math.pi / 30.0}),
    (Dimension(s=-1), {"Hz": Fraction(1)}),
    (_FORCE, {"N": Fraction(1), "mN": Fraction("1e-3"), "kN": Fraction(1000)}),
    (_ENERGY, {"Nm": Fraction(1), "kNm": Fraction(1000), "J": Fraction(1), "kJ": Fraction(1000)}),
    (Dimension(kg=1, m=-1, s=-2), {"Pa": Fraction(1), "kPa": Fraction(1000), "MPa": Fraction(10**6),
                                   "GPa": Fraction(10**9)}),
    (Dimension(kg=1, m=2, s=-3), {"W": Fraction(1), "kW": Fraction(1000)}),
)  # fmt: skip
UNITS: Mapping[str, Unit] = {
    name: Unit(factor, dimension) for dimension, named in _BY_DIMENSION for name, factor in named.items()
}
"""All units, by dimension; a tonne is t, a turn is rev."""

KINDS: Mapping[str, tuple[str, str]] = {
    "1": ("a number", "0.5"),
    "m": ("a length", "20 cm"),
    "kg": ("a mass", "400 g"),
    "s": ("a time", "20 ms"),
    "rad": ("an angle", "30 deg"),
    "rad/s": ("an angular velocity", "20 rpm"),
    "m/s": ("a speed", "50 mm/s"),
    "m/s²": ("an acceleration", "9.81 m/s^2"),
    "N": ("a force", "2 kN"),
    "N m": ("a moment", "2 N m"),
    "kg m²": ("an inertia", "3 kg m^2"),
    "N/m": ("a stiffness", "5 N/mm"),
    "N s/m": ("a damping", "5 N s/m"),
    "N m/rad": ("a stiffness against turning", "5 N m/rad"),
    "N m s/rad": ("a damping against turning", "5 N m s/rad"),
    "N m/(rad s)": ("an integral gain against turning", "5 N m/(rad s)"),
    "N/(m s)": ("an integral gain", "5 N/(m s)"),
    "kg/m": ("a mass per length", "2 kg/m"),
    "N s²/m²": ("a quadratic drag", "0.2 N s^2/m^2"),
    "kg/m²": ("a mass per area", "8 kg/m^2"),
    "kg/m³": ("a density", "7.85 g/cm^3"),
    "m²": ("an area", "3 cm^2"),
    "1/s": ("a frequency", "10 Hz"),
    "s/m": ("a damping per speed", "0.3 s/m"),
    "W": ("a power", "2 W"),
    "Pa": ("a pressure", "210 GPa"),
}
"""What units in SI measure, and how a text of that kind may look."""

_WORD = re.compile(r"([A-Za-zµ]+|%|1)(?:\^?(-?[1-9])|([²³]))?")


def read_unit(text: str) -> Unit | None:
    """The product or quotient of units with powers: ``N/mm``, ``kg m^2``, ``N·m``, ``W/(m s)``.

    ``None`` if one is not known, or if it could be read in two ways, as ``W/m s``: several units behind a stroke stand
    in parentheses.
    """
    above, stroke, below = text.strip().partition("/")
    below = below.strip()
    grouped = re.fullmatch(r"\(([^()]*)\)", below)
    words = [(word, 1) for word in re.split(r"[\s*·]+", above.strip())]
    if stroke:
        under = re.split(r"[\s*·]+", (grouped[1] if grouped else below).strip())
        if len(under) > 1 and not grouped:
            return None
        words += [(word, -1) for word in under]
    factor: Factor = Fraction(1)
    dimension = _NUMBER
    for word, sign in words:
        found = _WORD.fullmatch(word)
        if found is None or found[1] not in UNITS:
            return None
        power = sign * int(found[2] or {"²": 2, "³": 3}.get(found[3] or "", 1))
        unit = UNITS[found[1]]
        factor *= unit.factor**power
        dimension = dimension.times(unit.dimension, power)
    return Unit(factor, dimension)


def dimension_of(unit: str) -> Dimension:
    """What a unit that is known measures. ``ValueError`` if it is not known."""
    found = read_unit(unit)
    if found is None:
        raise ValueError(f"{unit} is no unit")
    return found.dimension


def kind_of(dimension: Dimension) -> str:
    """What has this dimension, in words: ``a length``."""
    for unit, (kind, _) in KINDS.items():
        if dimension_of(unit) == dimension:
            return kind
    known = ((dimension.kg, "kg"), (dimension.m, "m"), (dimension.s, "s"), (dimension.rad or 0, "rad"))
    return "something in " + " ".join(f"{name}^{power}" if power != 1 else name for power, name in known if power)
