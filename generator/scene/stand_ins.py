"""What to read in place of a wrong value: a value of its kind that passes, several different ones of each.

The kind is that of the key's field, so that a table needs no list of stand-ins of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from annotated_types import MinLen
from pydantic.fields import FieldInfo

from ..effect_base.table import Named, Table, inside, kind_of_key, part_of
from ..mechanism.mechanism import Mechanism
from .errors import Path

_GOLDEN = 0.6180339887498949
"""Multiples of this, less their whole parts, lie apart from each other: no two numbers that stand in are the same."""


@dataclass(frozen=True)
class Names:
    """What texts of a scene can name, by kind."""

    joint: tuple[str, ...] = ()
    link: tuple[str, ...] = ()
    point: tuple[str, ...] = ()
    end: tuple[str, ...] = ()


def names(tables: Mapping[str, Any], mechanism: Mechanism | None) -> Names:
    """Joints, links and points of the mechanism, where there is one, and the points that the tables give to joints."""
    rows = [*_rows(tables.get("link"), "link_{}")]
    if len(rows) < 2:  # else joints that stand in do not hold links to the ground, where they touch nothing
        rows += _rows([tables.get("ground_link")], "ground")
    ends = tuple(f"{owner}.{point}" for owner, points in rows for point in points)
    if mechanism is None:
        return Names(end=ends)
    points = [f"{link.name}.{point}" for link in mechanism.links for point in link.points]
    joints = tuple(joint.name for joint in mechanism.joints)
    return Names(joints, tuple(link.name for link in mechanism.links), tuple(points), ends)


def _rows(tables: object, name: str) -> Iterator[tuple[str, list[str]]]:
    """The names of such tables, and of the points in each."""
    for index, table in enumerate(tables if isinstance(tables, list) else []):
        points = table.get("points") if isinstance(table, Mapping) else None
        if isinstance(points, Mapping):
            own = table.get("name")
            yield own if isinstance(own, str) else name.format(index), [*map(str, points)]


def stand_in(model: type[Table], place: Path, raw: object, number: int, known: Names) -> object:
    """A value for ``place``, a key of the table that is written as ``raw`` and what is below it; ``None`` where there
    is none of its kind.

    Values of different ``number`` differ, as far as there are several of a kind.
    """
    kind = kind_of_key(model, str(place[0]))
    for index, part in enumerate(place[1:], start=1):
        kind = inside(kind, part, part_of(raw, place[:index]))
    return None if kind is None else _value(kind, number, known)


def _bare(kind: Any) -> tuple[Any, list[Any]]:
    """A type without its marks, of alternatives the first; and the marks."""
    marks: list[Any] = []
    while True:
        if get_origin(kind) is Annotated:
            kind, *given = get_args(kind)
            marks += [mark for one in given for mark in (one.metadata if isinstance(one, FieldInfo) else [one])]
        elif get_origin(kind) in (Union, UnionType):
            kind = next(one for one in get_args(kind) if one is not type(None))
        else:
            return kind, marks


def _value(kind: Any, number: int, known: Names) -> object:
    kind, marks = _bare(kind)
    given = {name: getattr(mark, name) for mark in marks for name in ("ge", "gt", "le", "lt") if hasattr(mark, name)}
    least = max((mark.min_length for mark in marks if isinstance(mark, MinLen)), default=0)
    if get_origin(kind) is list:
        items = [_value(get_args(kind)[0], number + index, known) for index in range(least)]
        return None if None in items else items
    if get_origin(kind) is dict:
        count = max(least, number % 2)  # what is not found in it is another thing each time
        return {f"stand_in_{number}_{index}": _value(get_args(kind)[1], number, known) for index in range(count)}
    if isinstance(kind, type) and issubclass(kind, Table):
        keys = [key for key, field in kind.model_fields.items() if field.is_required()]
        return {key: _value(kind_of_key(kind, key), number, known) for key in (*kind.ONE_OF[:1], *keys)}
    if get_origin(kind) is Literal:
        return get_args(kind)[number % len(get_args(kind))]
    if kind is str:
        named = next((mark.kind for mark in marks if isinstance(mark, Named)), None)
        if named is None:
            return f"stand_in_{number}"
        choice = getattr(known, named)
        return choice[number % len(choice)] if choice else None
    if kind is bool:
        return bool(number % 2)
    low, high = given.get("ge", given.get("gt", 0)), given.get("le", given.get("lt"))
    if kind is int:
        return int(low) + 4 + number % 8
    if kind is float:
        if "ge" in given and number % 2:
            return float(low)
        share = 0.1 + 0.8 * (_GOLDEN * (number + 1) % 1.0)
        return low + (share if high is None else share * (high - low))
    return None
