"""Tables checked against their schema, every fault turned into a sentence."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any, TypeVar

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from ..effect_base.arithmetic import Names
from ..effect_base.table import Table, innermost, part_of
from ..effect_base.written_numbers import TOLD
from .angles import judge_angles
from .errors import Path, Report
from .meant import kinds_of, meant_key, required_keys, unknown_key
from .schema import TAGS

T = TypeVar("T", bound=Table)

MEANT = {
    **dict.fromkeys(("pin", "hinge", "rotational", "rotary", "pivot"), "revolute"),
    **dict.fromkeys(("slider", "slide", "translational", "linear"), "prismatic"),
    **dict.fromkeys(("fixed", "rigid", "welded"), "weld"),
    **dict.fromkeys(("slot", "pin_in_slot", "pin in slot"), "pin-in-slot"),
}
"""Other words for kinds of joints."""
_LONG = 10**40
"""Whole numbers from here on are told by their length."""


def check(model: type[T], raw: object, path: Path, names: Names, report: Report) -> T | None:
    """The table ``raw`` as ``model``, ``names`` standing for numbers in it; faults go to ``report``.

    A table with faults gives ``None``; what else is wrong with it is found by reading it again (``behind.py``).
    """
    if not isinstance(raw, Mapping):
        report.add(path, f"found {show(raw)}, expected a table; write {_header(path)}")
        return None
    fine = judge_angles(model, raw, path, names, report)
    try:
        table = model.model_validate(dict(raw), context=names)
        return table if fine else None
    except ValidationError as error:
        faults = error.errors(include_url=False)
    unknown = {str(fault["loc"][0]) for fault in faults if fault["type"] == "extra_forbidden"}
    elsewhere_given = set[Path]()  # keys that lack because their values stand at an unknown key, which is told
    for fault in sorted(faults, key=lambda fault: fault["type"] != "extra_forbidden"):
        place = _place(fault["loc"])
        owner, inner = innermost(model, place, raw)
        if fault["type"] == "missing" and place in elsewhere_given:
            continue
        if fault["type"] == "extra_forbidden":
            key = str(inner[-1])
            elsewhere = owner.INSTEAD.get(key) or owner.MISPLACED.get(key)
            message = f"found {key}, expected it elsewhere: {elsewhere}" if elsewhere else ""
            beside = part_of(raw, place[:-1])
            given = beside if isinstance(beside, Mapping) else {}
            about = (key, given.get(key), kinds_of(owner), given, required_keys(owner))
            report.add(path + place, message or unknown_key(*about))
            if not message and (meant := meant_key(*about)):
                elsewhere_given.add((*place[:-1], meant))
        elif fault["type"] != TOLD and not unknown & model.INSTEAD.keys():
            report.add(path + place, _sentence(owner, inner, fault, part_of(raw, place)))
    return None


def show(value: object, deep: bool = False) -> str:
    """A value as it stands in a scene file, shortened: of lists in lists the outer ones."""
    if isinstance(value, str):
        return f'"{value}"' if len(value) < 40 else f'"{value[:36]}..."'
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, list):
        inside = ", ".join("[...]" if isinstance(v, list) and deep else show(v, deep=True) for v in value[:4])
        return f"[{inside}{', ...' if len(value) > 4 else ''}]"
    if isinstance(value, int) and abs(value) >= _LONG:
        return f"a number of {int(value.bit_length() * math.log10(2.0)) + 1} digits"
    return f"{value:.12g}" if isinstance(value, float) else str(value)


def _place(loc: tuple[int | str, ...]) -> Path:
    """pydantic's place of a fault without the marks of alternatives."""
    return tuple(part for part in loc if part not in TAGS)


def _sentence(model: type[Table], place: Path, fault: ErrorDetails, written: object) -> str:
    """``written``: what stands in the file, of which the fault may name the number."""
    field = model.model_fields[str(place[0])]
    expected = field.description or "another value"
    if fault["type"] == "missing" and len(place) == 1:
        return f"missing, expected {expected}; add it"
    found = fault["input"]
    text = repr(found) if fault["type"] == "int_type" and isinstance(found, float) else show(found)
    if isinstance(written, str) and isinstance(found, float):
        text = f"{show(written)} ({text})"
    return f"found {text}, expected {expected}; {_advice(fault)}"


def _advice(fault: ErrorDetails) -> str:
    value, kind = fault["input"], fault["type"]
    if "advice" in fault.get("ctx", {}):
        return str(fault["ctx"]["advice"])
    if isinstance(value, str) and kind == "literal_error" and (meant := MEANT.get(value.lower())):
        return f'write "{meant}"'
    if isinstance(value, str) and kind == "literal_error" and (meant := _same_letters(value, fault)):
        return f'write "{meant}"'
    if isinstance(value, str) and kind == "list_type" and "," in value:
        return "write " + str([part.strip() for part in value.split(",")]).replace("'", '"')
    if isinstance(value, list) and kind == "float_type" and value and all(map(_is_number, value)):
        return "write one number"
    if isinstance(value, float) and not math.isfinite(value):
        return "write a finite number"
    if kind == "int_type" and isinstance(value, float):
        return "write it without a decimal point"
    if kind in ("too_short", "too_long"):
        context = fault.get("ctx", {})
        limit: Any = context.get("min_length", context.get("max_length"))
        return f"write {limit} value{'s' * (limit != 1)}"
    return "correct it"


def _same_letters(value: str, fault: ErrorDetails) -> str:
    """Of the words that may stand there the one that differs from what is written by spaces and signs of products."""
    options = re.findall(r"'([^']*)'", str(fault.get("ctx", {}).get("expected", "")))
    return next((one for one in options if _SPACES.sub("", one) == _SPACES.sub("", value)), "")


_SPACES = re.compile(r"[\s*·.]+")


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _header(path: Path) -> str:
    name = ".".join(str(part) for part in path if isinstance(part, str))
    return f"[[{name}]]" if path and isinstance(path[-1], int) else f"[{name}]"
