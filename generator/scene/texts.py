"""Texts in tables by what they stand for, as the schema marks it: names of things, numbers, words."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin

from ..effect_base.expression_of_time import InTime
from ..effect_base.table import Columns, Named, Table, inside, kind_of_key
from ..effect_base.written_numbers import Measured

Place = tuple[str | int, ...]
OnName = Callable[[Named, str, Place], str]
OnNumber = Callable[[str], str]


def rewritten(model: type[Table], table: Mapping[str, Any], on_name: OnName, on_number: OnNumber) -> dict[str, Any]:
    """A copy of a ``table`` of the kind ``model`` in which every text that names something is what ``on_name`` gives
    for it (with its place in the table), and every text that stands for a number what ``on_number`` gives."""
    return {
        key: _value(kind_of_key(model, str(key)), value, (key,), on_name, on_number) for key, value in table.items()
    }


def _value(kind: Any, value: Any, place: Place, on_name: OnName, on_number: OnNumber) -> Any:
    options = [*_options(kind)] if kind is not None else []
    if isinstance(value, list):
        inner = next((found for one, marks in options for found in _items(one, marks, len(value))), None)
        kinds = inner if inner else [None] * len(value)
        items = zip(kinds, value, strict=True)
        return [_value(one, item, (*place, index), on_name, on_number) for index, (one, item) in enumerate(items)]
    if isinstance(value, Mapping):
        return {
            key: _value(inside(kind, str(key), value), item, (*place, str(key)), on_name, on_number)
            for key, item in value.items()
        }
    if isinstance(value, str):
        marks = [mark for one, marks in options if get_origin(one) not in (list, dict) for mark in marks]
        named = next((mark for mark in marks if isinstance(mark, Named)), None)
        if named:
            return on_name(named, value, place)
        if any(isinstance(mark, Measured | InTime) for mark in marks):
            return on_number(value)
    return value


def leaves(model: type[Table], table: Mapping[str, Any]) -> Iterator[tuple[Place, Any, tuple[Any, ...]]]:
    """Values in a ``table`` of the kind ``model`` that are no lists or tables: where, what, and how the schema marks
    it."""
    for key, value in table.items():
        yield from _leaves(kind_of_key(model, str(key)), value, (str(key),))


def _leaves(kind: Any, value: Any, place: Place) -> Iterator[tuple[Place, Any, tuple[Any, ...]]]:
    options = [*_options(kind)] if kind is not None else []
    if isinstance(value, list):
        inner = next((found for one, marks in options for found in _items(one, marks, len(value))), None)
        for index, (one, item) in enumerate(zip(inner or [None] * len(value), value, strict=True)):
            yield from _leaves(one, item, (*place, index))
    elif isinstance(value, Mapping):
        for key, item in value.items():
            yield from _leaves(inside(kind, str(key), value), item, (*place, str(key)))
    else:
        marks = [mark for one, marks in options if get_origin(one) not in (list, dict) for mark in marks]
        yield place, value, (*marks,)


def _options(kind: Any, marks: tuple[Any, ...] = ()) -> Iterator[tuple[Any, tuple[Any, ...]]]:
    """All alternatives of a type, each with its marks and those of what it stands in."""
    if get_origin(kind) is Annotated:
        first, *own = get_args(kind)
        yield from _options(first, (*marks, *own))
    elif get_origin(kind) in (Union, UnionType):
        for one in get_args(kind):
            yield from _options(one, marks)
    else:
        yield kind, marks


def _items(kind: Any, marks: tuple[Any, ...], count: int) -> Iterator[list[Any]]:
    """The types of ``count`` items of a list of this type."""
    if get_origin(kind) is list:
        columns = next((mark.kinds for mark in marks if isinstance(mark, Columns)), ())
        yield [*columns] if len(columns) == count else [*get_args(kind)] * count
