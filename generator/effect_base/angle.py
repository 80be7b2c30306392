"""Angles as scenes write them: numbers of rad, or text such as ``"10 deg"``."""

from __future__ import annotations

import math
import re
from typing import Annotated

from pydantic import BeforeValidator
from pydantic_core import PydanticCustomError

_NUMBER = re.compile(r"\s*[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_ANGLE = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(deg|rad)\s*")


def read_angle(value: object) -> object:
    """``"10 deg"`` or ``"0.2 rad"`` as radians; anything but text as it is."""
    if not isinstance(value, str):
        return value
    match = _ANGLE.fullmatch(value)
    if match is None:
        found = _NUMBER.match(value)
        advice = f'write "{found[0].strip()} deg", or a number of rad without quotes' if found else "correct it"
        raise PydanticCustomError("angle", "{advice}", {"advice": advice})
    number = float(match[1])
    return math.radians(number) if match[2] == "deg" else number


Angle = Annotated[float, BeforeValidator(read_angle)]
