"""Numbers that a scene gives with a unit, in quotes: what to write instead."""

from __future__ import annotations

import math
import re

UNITS = {
    "kg": 1.0, "g": 1e-3, "mg": 1e-6, "t": 1e3, "lb": 0.45359237,
    "m": 1.0, "mm": 1e-3, "cm": 1e-2, "dm": 0.1, "km": 1e3, "um": 1e-6, "µm": 1e-6, "in": 0.0254, "ft": 0.3048,
    "s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0,
    "N": 1.0, "kN": 1e3, "mN": 1e-3, "Nm": 1.0, "kNm": 1e3, "J": 1.0, "W": 1.0, "kW": 1e3,
    "rad": 1.0, "deg": math.radians(1.0), "°": math.radians(1.0), "rpm": math.pi / 30.0, "Hz": 1.0, "1": 1.0,
}  # fmt: skip
"""Units in SI, as factors."""
ANGLES = ("deg", "°", "rad")
"""Keys that expect an angle take it with its unit: elsewhere it is a slip."""

_NUMBER = re.compile(r"\s*([-+]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][-+]?\d+)?)\s*(\S.*?)?\s*")
_PART = re.compile(r"([A-Za-zµ°1]+?)(?:\^?(-?\d)|([²³]))?")


def without_unit(text: str) -> str:
    """What to write for a number in quotes: the number in SI units, where its unit is known."""
    found = _NUMBER.fullmatch(text)
    if found is None:
        return "write a number without quotes"
    value = float(found[1].replace(",", "."))
    if found[2] is None:
        return f"write {value:.12g} without quotes"
    if found[2] in ANGLES:
        return "write a number without quotes; an angle is not expected here"
    factor = _factor(found[2])
    if factor is None:
        return f"write a number without quotes and unit; scenes are in SI units: {value:.12g} if that is one"
    return f"write {value * factor:.12g}, in SI units and without quotes"


def _factor(unit: str) -> float | None:
    """Of a product or quotient of units with powers, such as ``N/mm`` or ``kg m^2``; ``None`` if one is not known."""
    total = 1.0
    for place, part in enumerate(unit.split("/")):
        for word in re.split(r"[\s*·]+", part.strip()):
            found = _PART.fullmatch(word)
            if found is None or found[1] not in UNITS:
                return None
            power = int(found[2] or {"²": 2, "³": 3}.get(found[3] or "", 1))
            total *= float(UNITS[found[1]] ** (power if place == 0 else -power))
    return total
