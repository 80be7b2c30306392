"""Which key is meant by one that nobody knows: its spelling, its value and what stands beside it say so."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from difflib import get_close_matches
from types import NoneType
from typing import Any, Literal, get_args, get_origin

from ..effect_base.table import Table, alternatives, kind_of_key

Kinds = Mapping[str, Any]
"""The type of the value of every key of a table, with all its marks."""


def kinds_of(model: type[Table]) -> dict[str, Any]:
    """Those of a table that is checked against a model."""
    return {key: kind_of_key(model, key) for key in model.model_fields}


def required_keys(model: type[Table]) -> tuple[str, ...]:
    return tuple(key for key, field in model.model_fields.items() if field.is_required())


def meant_key(
    key: str, value: object, kinds: Kinds, given: Collection[str] = (), required: Collection[str] = ()
) -> str | None:
    """The key to which a value belongs that stands at an unknown one, or ``None``.

    One that is spelt much the same and may have such a value, else the only one that the table lacks and that may.
    What is ``given`` already is never meant: a table has each key once.
    """
    for one in _close(key, value, kinds):
        return None if one in given else one
    lacking = [one for one in required if one not in given and holds(kinds[one], value)]
    return lacking[0] if len(lacking) == 1 else None


def unknown_key(
    key: str, value: object, kinds: Kinds, given: Collection[str] = (), required: Collection[str] = ()
) -> str:
    """The sentence for a key that no table of this kind has."""
    meant = meant_key(key, value, kinds, given, required)
    there = next((one for one in _close(key, value, kinds) if one in given), None)
    advice = f'write "{meant}"' if meant else f'remove it, "{there}" is there already' if there else "remove it"
    return f"found an unknown key, expected one of {', '.join(kinds)}; {advice}"


def holds(kind: Any, value: object) -> bool:
    """Whether a key of this kind may have such a value, by its shape alone: a text may be a number with its unit."""
    return any(_is_one(one, value) for one in alternatives(kind))


def _close(key: str, value: object, kinds: Kinds) -> list[str]:
    return [one for one in get_close_matches(key, kinds, len(kinds) or 1) if holds(kinds[one], value)]


def _is_one(kind: Any, value: object) -> bool:
    origin = get_origin(kind)
    if origin is Literal:
        return type(value) in {type(one) for one in get_args(kind)}
    if origin is list or kind is list:
        items = get_args(kind)
        return isinstance(value, list | tuple) and all(holds(items[0], item) for item in value if items)
    if kind is NoneType:
        return value is None
    if kind is bool:
        return isinstance(value, bool)
    if kind in (int, float):
        return isinstance(value, int | float | str) and not isinstance(value, bool)
    if kind is str:
        return isinstance(value, str)
    if origin is dict or (isinstance(kind, type) and issubclass(kind, Table)):
        return isinstance(value, Mapping)
    return kind is Any or isinstance(value, str | Mapping)  # values over time: an expression, or rows
