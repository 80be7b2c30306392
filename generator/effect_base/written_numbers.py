"""Numbers as scenes write them: plain ones in SI units, or a text with a unit (``"20 cm"``) or arithmetic (``"2*l"``).

This is the one way in which a table reads a number. Each key says by :class:`Measured` what its number measures.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from typing import Annotated, Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationInfo, ValidatorFunctionWrapHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from .arithmetic import LONGEST, NO_NAMES, ExpressionError, Names, NameWithoutValue, Written, calculate
from .units import KINDS, UNITS, Unit, dimension_of, kind_of, read_unit

TOLD = "told"
"""Type of a fault that is told elsewhere: the value of a name that is used here."""

_DIGITS = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_QUANTITY = re.compile(rf"\s*((?>{_DIGITS}))\s*([A-Za-zµ%°].*?|1/.*?)\s*")
_COMMA = re.compile(r"\s*([-+]?\d*),(\d+)(\s.*)?")
_WITHIN = re.compile(rf"(?<![\w.]){_DIGITS}\s+([A-Za-zµ]+)")
_UNIT_NAMES = ", ".join(name for name in UNITS if name != "1")
_ALONE = "units stand behind a single number, not in arithmetic; give {} a name in [let], and write that here"


class Measured:
    """Marks a number that measures something: ``Annotated[float, Measured("m")]`` is a length in m.

    Several ``units`` where that hangs on something else, as on the kind of a joint. A number is in the unit itself; a
    text is read by :func:`read_number`, with the names that the scene gives to numbers as the context of validation.
    """

    def __init__(self, *units: str) -> None:
        self.units = units

    def __repr__(self) -> str:
        return f"Measured({', '.join(self.units)})"

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        read = self._read_whole if source is int else self._read
        return core_schema.with_info_wrap_validator_function(read, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return {"anyOf": [handler(schema), {"type": "string"}]}

    def _read(self, value: Any, number: ValidatorFunctionWrapHandler, info: ValidationInfo) -> float:
        if not isinstance(value, str):
            plain: float = number(value)
            return plain
        written = self._text(value, info)
        number(float(written))
        return written

    def _read_whole(self, value: Any, number: ValidatorFunctionWrapHandler, info: ValidationInfo) -> int:
        given = self._text(value, info) if isinstance(value, str) else value
        whole: int = number(int(given) if isinstance(given, Written) and given.is_integer() else given)
        return whole

    def _text(self, text: str, info: ValidationInfo) -> Written:
        with faults_as_advice():
            return read_number(text, self.units, info.context or NO_NAMES)


class Anything(Measured):
    """Marks a number that may measure anything."""

    def __init__(self) -> None:
        super().__init__("1")

    def __repr__(self) -> str:
        return "Anything()"

    def _text(self, text: str, info: ValidationInfo) -> Written:
        with faults_as_advice():
            names = info.context or NO_NAMES
            return read_quantity(text, None) or calculate(text, names)


@contextmanager
def faults_as_advice() -> Iterator[None]:
    """Faults of texts become faults of pydantic's, which carry the advice."""
    try:
        yield
    except NameWithoutValue as error:
        raise PydanticCustomError(TOLD, "told elsewhere") from error
    except ExpressionError as error:
        raise PydanticCustomError("written", "{advice}", {"advice": str(error)}) from error


def read_number(text: str, units: Sequence[str], names: Names = NO_NAMES) -> Written:
    """The number (SI) that a text stands for, which measures what one of ``units`` does.

    Raises ``ExpressionError`` with a sentence, ``NameWithoutValue`` where what is wrong is told elsewhere.
    """
    found = read_quantity(text, units)
    if found is None:
        found = calculate(text, names)
        check_dimension(found, units)
    return found


def read_quantity(text: str, units: Sequence[str] | None) -> Written | None:
    """A number with its unit, in SI; ``None`` if the text is something else, which may be arithmetic.

    ``units``: what it may measure; ``None`` for anything. Raises ``ExpressionError`` with a sentence.
    """
    if len(text) > LONGEST:
        raise ExpressionError(f"it has {len(text)} characters; write one of at most {LONGEST}")
    text = text.replace("\u03bc", "µ")
    if comma := _COMMA.fullmatch(text):
        whole, unit = f"{comma[1]}.{comma[2]}", comma[3] or ""
        raise ExpressionError(f'it has a comma; write "{whole}{unit}"' if unit else f"it has a comma; write {whole}")
    found = _QUANTITY.fullmatch(text)
    if found is None:
        if mixed := next((part[0] for part in _WITHIN.finditer(text) if part[1] in UNITS), ""):
            raise ExpressionError(_ALONE.format(mixed))
        return None
    unit = read_unit(found[2])
    if unit is None:
        raise ExpressionError(_unknown(found[1], found[2], units))
    number = Written(_in_si(found[1], unit), text, unit.dimension)
    if not math.isfinite(number):
        raise ExpressionError("it has no finite value, because it is too large; change it")
    if units is not None:
        check_dimension(number, units)
    return number


def check_dimension(number: float, units: Sequence[str]) -> None:
    """Raises ``ExpressionError`` if the number measures something else than all of ``units``, as far as it says."""
    measured = number.dimension if isinstance(number, Written) else None
    if measured is None or any(measured.fits(dimension_of(unit)) for unit in units):
        return
    if measured == dimension_of("Hz") and "rad/s" in units:
        raise ExpressionError("Hz may mean turns or radians per second; write rpm, rev/s or rad/s")
    kinds = " or ".join(KINDS[unit][0] + (f" in {unit}" if unit != "1" else " without a unit") for unit in units)
    instead = f'write one such as "{KINDS[units[0]][1]}"' if units[0] != "1" else "write it without a unit"
    raise ExpressionError(f"that is {kind_of(measured)}, not {kinds}; {instead}")


def wrong_kind(number: object, unit: str) -> str:
    """What is wrong with a number whose key may measure several things and is ``unit`` here; nothing if it fits."""
    measured = number.dimension if isinstance(number, Written) else None
    if not isinstance(number, Written) or measured is None or measured.fits(dimension_of(unit)):
        return ""
    kind, example = KINDS[unit]
    return f'found "{number.text}", {kind_of(measured)}, expected {kind} in {unit}; write one such as "{example}"'


def as_written(number: float, unit: str) -> str:
    """The number as a scene has it, for sentences: ``0.5 rad``, or ``"30 deg" (0.523599 rad)``."""
    return f'"{number.text}" ({number:.6g} {unit})' if isinstance(number, Written) else f"{number:.6g} {unit}"


def _in_si(number: str, unit: Unit) -> float:
    """The number of units in SI, rounded once where the unit is a fraction of that; ``inf`` where it is too large."""
    plain = float(number)
    if not plain or not math.isfinite(plain):
        return plain
    try:
        exact = Fraction(number) if isinstance(unit.factor, Fraction) else plain
        return float(exact * unit.factor)
    except OverflowError:
        return math.inf


WORDS = {
    **dict.fromkeys(("gram", "gramm", "gramme", "gr"), "g"),
    **dict.fromkeys(("kilogram", "kilogramm", "kilo"), "kg"),
    **dict.fromkeys(("sec", "second"), "s"),
    **dict.fromkeys(("meter", "metre"), "m"),
    **dict.fromkeys(("millimeter", "millimetre"), "mm"),
    **dict.fromkeys(("centimeter", "centimetre"), "cm"),
    **dict.fromkeys(("inch", "inche"), "in"),
    **dict.fromkeys(("foot", "feet"), "ft"),
    **dict.fromkeys(("radian", "rd"), "rad"),
    **dict.fromkeys(("turn", "revolution", "u"), "rev"),
    "minute": "min",
    "hour": "h",
    "millisecond": "ms",
    "newton": "N",
    "joule": "J",
    "watt": "W",
    "hertz": "Hz",
    "pascal": "Pa",
    "pound": "lb",
    "percent": "%",
}
"""Units as some write them, in the singular and in small letters, and as they are written here."""


def _unknown(number: str, unit: str, units: Sequence[str] | None) -> str:
    """What to write for a number with a unit that is not known."""
    if unit == "°":
        return f'write "{number} deg"'
    if re.fullmatch(r"deg\w+|°\w*", unit) and (units is None or "rad" in units):
        return f'write "{number} deg", or a number of rad without quotes'
    small = unit.lower()
    single = small.removesuffix("s")
    meant = small if small in UNITS else single if single in UNITS else WORDS.get(single)
    if meant:
        return f'write "{number} {meant}"'
    over_time = re.fullmatch(r"(.+?)\s*\*\s*t", unit)
    if over_time and (known_one := read_unit(over_time[1])):
        value = f"{_in_si(number, known_one):.9g}*t"
        return f'a unit stands behind a number alone, not in an expression of t; write "{value}", in SI units'
    several = re.fullmatch(r"([^/]*)/\s*([^()/]+)", unit)
    if several and read_unit(f"{several[1]}/({several[2]})"):
        return f'"{unit}" could be read in two ways; write "{several[1]}/({several[2]})" for all of it below the stroke'
    first = re.match(r"[A-Za-zµ%]+", unit)
    if first and first[0] in UNITS and re.search(r"[-+*(]|/\s*[\d.]", unit):
        return _ALONE.format(f"{number} {first[0]}")
    product = "*".join((number, *unit.split()))
    known = f"the units are {_UNIT_NAMES}, their products and quotients"
    return f'"{unit}" is no unit that is known; {known}; write "{product}" for a product'


Number = Annotated[float, Measured("1")]
Whole = Annotated[int, Measured("1")]
Length = Annotated[float, Measured("m")]
Angle = Annotated[float, Measured("rad")]
