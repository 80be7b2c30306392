"""Angles as scenes write them: what is taken as radians although degrees may be meant, and what has lost its digits."""

from __future__ import annotations

import ast
import math
import sys
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, get_args, get_origin

from pydantic.fields import FieldInfo

from ..effect_base.arithmetic import NO_NAMES, ExpressionError, Names, Written, parsed
from ..effect_base.expression_of_time import InTime
from ..effect_base.table import Columns, Table, alternatives
from ..effect_base.written_numbers import Measured, read_number
from .errors import Path, Report

OF_PLACES = ("poses", "points")
"""Keys whose values are lists that end with an angle, as of a place and an angle, or a radius and an angle."""
OF_CHANGES, TURNING = "when", ("angle", "direction")
"""The key whose table has limits of angles where one of these is watched."""

KNOWN = 1e-6
"""Angles are states if they are known to this (rad); joints of a state may miss by as much (m)."""
LARGEST = KNOWN / sys.float_info.epsilon
"""The largest such angle (rad): the last place of one beyond it is larger than that."""


@cache
def angle_keys(model: type[Table]) -> tuple[str, ...]:
    """The keys of a table whose values are angles, or hold some: those that measure rad and nothing else."""
    return tuple(key for key, field in model.model_fields.items() if _in_rad(field))


def _in_rad(marked: object) -> bool:
    """Whether an annotation, a field, or what it is made of, is marked as a number in rad."""
    if isinstance(marked, FieldInfo):
        return _in_rad(marked.annotation) or any(map(_in_rad, marked.metadata))
    if isinstance(marked, Measured | InTime):
        return marked.units == ("rad",)
    if isinstance(marked, Columns):
        return any(map(_in_rad, marked.kinds))
    return any(map(_in_rad, (*get_args(marked), *getattr(marked, "__metadata__", ()))))


def judge_angles(model: type[Table], raw: Mapping[str, object], path: Path, names: Names, report: Report) -> bool:
    """Note angles in the table ``raw``, a ``model``, that are too large to have digits, and remark on those that have
    no unit and are larger than a full turn. Whether none is too large; what is no finite number is told with the others
    of a table.
    """
    fine = True
    for key in (*angle_keys(model), *({OF_CHANGES} & model.model_fields.keys())):
        for where, given in _angles_in(key, raw.get(key)):
            fine = judge_angle(given, (*path, *where), names, report) and fine
    for key, kind, given in ((key, field.annotation, raw.get(key)) for key, field in model.model_fields.items()):
        for where, inner, table in _tables_in(kind, given):
            fine = judge_angles(inner, table, (*path, key, *where), names, report) and fine
    return fine


def judge_angle(given: object, path: Path, names: Names, report: Report) -> bool:
    """The same of one angle, as it is written or read."""
    try:
        angle = read_number(given, ("rad",), names) if isinstance(given, str) else given
    except ExpressionError:
        return True
    if isinstance(angle, bool) or not isinstance(angle, int | float) or not _finite(angle):
        return True
    if abs(angle) > LARGEST:
        message = f"expected at most {LARGEST:.2g} rad, beyond which no digits are left of where links point"
        report.add(path, f"found an angle of {angle:.3g} rad, {message}; leave out full turns")
        return False
    if remark := taken_as_rad(angle, given.text if isinstance(given, Written) else given, names):
        report.remark(path, remark)
    return True


def taken_as_rad(angle: float, given: object, names: Names = NO_NAMES) -> str:
    """What to say of an angle (rad) beyond a full turn that is ``given`` without a unit; nothing of others."""
    if abs(angle) <= 2.0 * math.pi or _says_its_unit(angle, names):
        return ""
    turns = f"{abs(angle) / (2.0 * math.pi):.3g} turns"
    what = f'"{given}", {angle:g},' if isinstance(given, str) else f"{angle:g}"
    return f'{what} is taken as rad, {turns}; write "{angle:g} deg" for degrees'


def _tables_in(kind: Any, value: object) -> Iterator[tuple[Path, type[Table], Mapping[str, object]]]:
    """Tables that stand at a key: one, or those of a list, with their numbers."""
    for one in alternatives(kind):
        if isinstance(one, type) and issubclass(one, Table) and isinstance(value, Mapping):
            yield (), one, value
        elif get_origin(one) is list and isinstance(value, list):
            for number, table in enumerate(value):
                for where, inner, found in _tables_in(get_args(one)[0], table):
                    yield (number, *where), inner, found


def _says_its_unit(angle: float, names: Names) -> bool:
    """Whether an angle has a unit, or comes from numbers that have one, or is a multiple of pi."""
    if not isinstance(angle, Written):
        return False
    if angle.dimension is not None:
        return True
    used = [node.id for node in ast.walk(parsed(angle.text)) if isinstance(node, ast.Name)]
    return "pi" in used or any(isinstance(names.get(name), Written) for name in used)


def _finite(number: float) -> bool:
    return abs(number) <= sys.float_info.max


def _angles_in(key: str, value: object) -> Iterator[tuple[Path, object]]:
    """The angles in the value of a key, and where they stand; of a list of a place and an angle the angle alone."""
    if key == OF_CHANGES:
        if isinstance(value, Mapping) and any(name in value for name in TURNING):
            yield from (((key, limit), value[limit]) for limit in ("above", "below") if limit in value)
    elif isinstance(value, Mapping):
        for name, one in value.items():
            if key == "angles":
                yield (key, str(name)), one
            elif key in OF_PLACES and isinstance(one, list) and len(one) in (2, 3):
                yield (key, str(name), len(one) - 1), one[-1]
            elif name == "rows" and isinstance(one, list):
                rows = ((number, row) for number, row in enumerate(one) if isinstance(row, list) and len(row) == 2)
                yield from (((key, "rows", number, 1), row[1]) for number, row in rows)
    elif isinstance(value, list):
        yield from (((key, index), one) for index, one in enumerate(value) if key == "angles")
    elif value is not None:
        yield (key,), value
