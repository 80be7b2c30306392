"""Tables checked against their schema, every fault turned into a sentence."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from ..effects.table import Table
from .errors import Path, Report
from .schema import TAGS

T = TypeVar("T", bound=Table)


def check(model: type[T], raw: object, path: Path, report: Report) -> T | None:
    """The table ``raw`` as ``model``; faults go to ``report``.

    Unknown keys are left out once they are reported, and wrong values replaced by the table's stand-ins, so that what
    depends on the table is still checked; a table without stand-ins for what is wrong gives ``None``.
    """
    if not isinstance(raw, Mapping):
        report.add(path, f"found {show(raw)}, expected a table; write {_header(path)}")
        return None
    try:
        return model.model_validate(dict(raw))
    except ValidationError as error:
        faults = error.errors(include_url=False)
    unknown = {str(fault["loc"][0]) for fault in faults if fault["type"] == "extra_forbidden"}
    wrong = {str(fault["loc"][0]) for fault in faults} - unknown
    for fault in faults:
        if fault["type"] == "extra_forbidden":
            report.add((*path, *map(str, fault["loc"])), unknown_key(str(fault["loc"][0]), model.model_fields))
        else:
            report.add(path + _place(fault["loc"]), _sentence(model, fault))
    if not wrong <= model.STAND_INS.keys():
        return None
    right = {key: value for key, value in raw.items() if key not in unknown | wrong}
    return model.model_validate(right | {key: model.STAND_INS[key] for key in wrong})


def unknown_key(key: str, known: Iterable[str]) -> str:
    """The sentence for a key that no table of this kind has."""
    import difflib

    known = list(known)
    close = difflib.get_close_matches(key, known, 1)
    advice = f'write "{close[0]}"' if close else "remove it"
    return f"found an unknown key, expected one of {', '.join(known)}; {advice}"


def show(value: object) -> str:
    """A value as it stands in a scene file, shortened."""
    if isinstance(value, str):
        return f'"{value}"' if len(value) < 40 else f'"{value[:36]}..."'
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, list):
        inside = ", ".join(show(v) for v in value[:4])
        return f"[{inside}{', ...' if len(value) > 4 else ''}]"
    return f"{value:.12g}" if isinstance(value, float) else str(value)


def _place(loc: tuple[int | str, ...]) -> Path:
    """pydantic's place of a fault without the marks of alternatives."""
    return tuple(part for part in loc if part not in TAGS)


def _sentence(model: type[Table], fault: ErrorDetails) -> str:
    field = model.model_fields[str(fault["loc"][0])]
    expected = field.description or "another value"
    if fault["type"] == "missing" and len(fault["loc"]) == 1:
        return f"missing, expected {expected}; add it"
    found = fault["input"]
    text = repr(found) if fault["type"] == "int_type" and isinstance(found, float) else show(found)
    return f"found {text}, expected {expected}; {_advice(fault)}"


def _advice(fault: ErrorDetails) -> str:
    value, kind = fault["input"], fault["type"]
    if "advice" in fault.get("ctx", {}):
        return str(fault["ctx"]["advice"])
    if isinstance(value, str) and kind in ("float_type", "int_type"):
        return "write a number without quotes"
    if isinstance(value, float) and not math.isfinite(value):
        return "write a finite number"
    if kind == "int_type" and isinstance(value, float):
        return "write it without a decimal point"
    if kind in ("too_short", "too_long"):
        context = fault.get("ctx", {})
        limit: Any = context.get("min_length", context.get("max_length"))
        return f"write {limit} value{'s' * (limit != 1)}"
    return "correct it"


def _header(path: Path) -> str:
    name = ".".join(str(part) for part in path if isinstance(part, str))
    return f"[[{name}]]" if path and isinstance(path[-1], int) else f"[{name}]"
