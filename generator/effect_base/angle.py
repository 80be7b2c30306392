"""Angles as scenes write them: numbers of rad, or text such as ``"10 deg"``."""

from __future__ import annotations

import math
import re
from typing import Annotated, Any

from pydantic import ValidatorFunctionWrapHandler, WrapValidator
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


class TextAngle(float):
    """An angle (rad) that a scene gives as the text ``text``."""

    text: str

    def __new__(cls, value: float, text: str) -> TextAngle:
        angle = super().__new__(cls, value)
        angle.text = text
        return angle

    def __reduce__(self) -> tuple[type[TextAngle], tuple[float, str]]:
        return TextAngle, (float(self), self.text)


def _angle(value: Any, number: ValidatorFunctionWrapHandler) -> float:
    angle: float = number(read_angle(value))
    return TextAngle(angle, value) if isinstance(value, str) else angle


def as_written(angle: float) -> str:
    """The angle as a scene has it, for sentences: ``0.5 rad``, or ``"30 deg" (0.523599 rad)``."""
    return f'"{angle.text}" ({angle:.6g} rad)' if isinstance(angle, TextAngle) else f"{angle:.6g} rad"


Angle = Annotated[float, WrapValidator(_angle)]
