"""Texts in tables by what they stand for, as the schema marks it: names of things, numbers, words."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from types import UnionType
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin

from ..effect_base.expression_of_state import InLaw, InLoad
from ..effect_base.expression_of_time import InTime
from ..effect_base.table import Columns, Named, Table, inside, kind_of_key
from ..effect_base.written_numbers import Measured

Place = tuple[str | int, ...]
OnName = Callable[[Named, str, Place], str]
OnNumber = Callable[[str], str]


class Rewriting(NamedTuple):
    """What becomes of a text that ``names`` something, given with its place in the table, of one that stands for a
    ``number``, and of one that may be an expression of the ``state``."""

    name: OnName
    number: OnNumber
    state: OnNumber


def rewritten(model: type[Table], table: Mapping[str, Any], by: Rewriting) -> dict[str, Any]:
    """A copy of a ``table`` of the kind ``model`` with its texts as they become."""
    return {key: _value(kind_of_key(model, str(key)), value, (key,), by) for key, value in table.items()}


def _value(kind: Any, value: Any, place: Place, by: Rewriting) -> Any:
    options = [*_options(kind)] if kind is not None else []
    if isinstance(value, list):
        inner = next((found for one, marks in options for found in _items(one, marks, len(value))), None)
        kinds = inner if inner else [None] * len(value)
        items = zip(kinds, value, strict=True)
        return [_value(one, item, (*place, index), by) for index, (one, item) in enumerate(items)]
    if isinstance(value, Mapping):
        return {key: _value(inside(kind, str(key), value), item, (*place, str(key)), by) for key, item in value.items()}
    if isinstance(value, str):
        marks = [mark for one, marks in options if get_origin(one) not in (list, dict) for mark in marks]
        named = next((mark for mark in marks if isinstance(mark, Named)), None)
        if named:
            return by.name(named, value, place)
        if any(isinstance(mark, InLaw | InLoad) for mark in marks):
            return by.state(value)
        if any(isinstance(mark, Measured | InTime) for mark in marks):
            return by.number(value)
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
