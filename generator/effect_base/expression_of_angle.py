"""Expressions of a cam's angle as scenes write them (``"0.01*(1 - cos(angle))"``): those of time with another name."""

from __future__ import annotations

import ast
import re
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationInfo
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from .arithmetic import NO_NAMES, ExpressionError, Names, NameWithoutValue, parsed
from .expression_of_time import Expression, InTime, parse
from .written_numbers import faults_as_advice, read_quantity

ANGLE = "angle"
"""What the variable is called in a scene; the expression has it as t."""


def parse_of_angle(text: str, names: Names = NO_NAMES) -> Expression | float:
    """The expression, or its value if it does not depend on the angle.

    Raises ``ExpressionError`` with a sentence, ``NameWithoutValue`` where what is wrong is told elsewhere.
    """
    tree = parsed(text)
    if any(isinstance(node, ast.Name) and node.id == "t" for node in ast.walk(tree)):
        raise ExpressionError("t is the time, and a cam has its shape at all times; write angle for the cam's angle")
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and node.id == ANGLE:
            node.id = "t"
    try:
        found = parse(ast.unparse(tree), names)
    except NameWithoutValue:
        raise
    except ExpressionError as error:
        raise ExpressionError(re.sub(r"\bt\b", ANGLE, str(error)).replace(", where runs begin", "")) from error
    if isinstance(found, Expression) and not found.has_rate():
        raise ExpressionError("abs(...) has a kink, and a cam is smooth; write what it is in pieces")
    return found


class InAngle(InTime):
    """Marks a length that is a number or an expression of the angle."""

    def __init__(self) -> None:
        super().__init__("m")

    def __repr__(self) -> str:
        return "InAngle()"

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.with_info_plain_validator_function(self._read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return {"type": ["number", "string"]}

    def _read(self, value: object, info: ValidationInfo) -> float | Expression:
        if isinstance(value, str):
            with faults_as_advice():
                if (quantity := read_quantity(value, ("m",))) is not None:
                    return quantity
                return parse_of_angle(value, info.context or NO_NAMES)
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < float("inf"):
            advice = 'write a finite number or a text such as "0.01*(1 - cos(angle))"'
            raise PydanticCustomError("expression", "{advice}", {"advice": advice})
        return float(value)
