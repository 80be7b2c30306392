"""What every table of a scene file has in common: strict types, no unknown keys, finite numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import UnionType
from typing import Annotated, Any, ClassVar, Literal, Union, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Discriminator, Field, GetCoreSchemaHandler, Tag
from pydantic_core import CoreSchema, core_schema

from .written_numbers import Length, Number

NAME = r"^[A-Za-z][A-Za-z0-9_]*$"
"""Names of links, points, joints and effects."""


class Table(BaseModel):
    """A table of a scene file. Each field's description says what is expected, for editors and for fault sentences."""

    MISPLACED: ClassVar[Mapping[str, str]] = {}
    """Keys that are often looked for here, each with where it belongs."""
    INSTEAD: ClassVar[Mapping[str, str]] = {}
    """Keys that show that another table is meant, each with that: nothing else of such a table is judged."""

    ONE_OF: ClassVar[tuple[str, ...]] = ()
    """Keys of which a table of this kind has to have exactly one."""
    NAMED: ClassVar[Any] = None
    """The kind of values in a table whose keys are names that the scene gives."""

    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False, frozen=True)


def kind_of_key(model: type[Table], key: str) -> Any:
    """The type of a key's value with all its marks; ``None`` of a key that the table does not know."""
    field = model.model_fields.get(key)
    if field is None:
        return model.NAMED
    return Annotated[(field.annotation, *field.metadata)] if field.metadata else field.annotation


def alternatives(kind: Any) -> Iterator[Any]:
    """All alternatives of a type, without their marks."""
    if get_origin(kind) is Annotated:
        yield from alternatives(get_args(kind)[0])
    elif get_origin(kind) in (Union, UnionType):
        for one in get_args(kind):
            yield from alternatives(one)
    else:
        yield kind


def part_of(written: object, place: Sequence[str | int]) -> object:
    """What a table or list as it is written has at a place; ``None`` where it has nothing there."""
    for part in place:
        there = part in written if isinstance(written, Mapping) else _has_item(written, part)
        if not there:
            return None
        written = written[part]  # type: ignore[index]
    return written


def _has_item(written: object, part: str | int) -> bool:
    return isinstance(written, list) and isinstance(part, int) and part in range(len(written))


def inside(kind: Any, part: str | int, written: object) -> Any:
    """The type of an item of a list, of a value in a mapping, or of a key of a table, of which ``written`` says which
    alternative is meant; ``None`` where there is none."""
    wanted = list if isinstance(part, int) else dict
    if isinstance(part, str) and (table := _table_with(kind, part, written)):
        return kind_of_key(table, part)
    for one in _meant(kind, written):
        if get_origin(one) is wanted:
            return get_args(one)[-1]
    return None


def _meant(kind: Any, written: object) -> Iterator[Any]:
    """The alternatives of a type, without their marks, that pydantic reads ``written`` by: those with the tag that the
    discriminator gives it. All where there is no discriminator, or nothing is written."""
    tag = None
    while get_origin(kind) is Annotated:
        kind, *marks = get_args(kind)
        for mark in marks:
            if isinstance(mark, Discriminator) and callable(mark.discriminator) and written is not None:
                tag = Tag(str(mark.discriminator(written)))
    if get_origin(kind) not in (Union, UnionType):
        yield kind
        return
    for one in get_args(kind):
        if tag is None or tag in getattr(one, "__metadata__", ()):
            yield from _meant(one, written)


def _table_with(kind: Any, key: str, written: object) -> type[Table] | None:
    """Of the tables among a type's alternatives that are meant the one which has a key, else the first."""
    tables = [one for one in _meant(kind, written) if isinstance(one, type) and issubclass(one, Table)]
    return next((one for one in tables if key in one.model_fields), tables[0] if tables else None)


def innermost(model: type[Table], place: Sequence[str | int], raw: object) -> tuple[type[Table], tuple[str | int, ...]]:
    """The table in ``model``, written as ``raw``, that the last part of a place belongs to, however deep, and the place
    in that."""
    owner, since, kind = model, 0, kind_of_key(model, str(place[0]))
    for index, part in enumerate(place[1:], start=1):
        written = part_of(raw, place[:index])
        if isinstance(part, str) and (table := _table_with(kind, part, written)):
            owner, since = table, index
        kind = inside(kind, part, written)
    return owner, tuple(place[since:])


def number_or_list(value: Any) -> str:
    """Which alternative of such a value is meant, as pydantic's tag."""
    return "<list>" if isinstance(value, list) else "<number>"


def text_or_list(value: Any) -> str:
    """The same of a name or a place."""
    return "<list>" if isinstance(value, list) else "<text>"


NameKind = Literal["joint", "link", "point", "end"]


@dataclass(frozen=True)
class Named:
    """Marks a text that is the name of something: a joint, a link, a point (``link.point`` or a joint), or an end of a
    joint (``link.point``)."""

    kind: NameKind


class Columns:
    """Marks a list whose values are of these kinds, in this order: ``Columns(Length, Length, Angle)``."""

    def __init__(self, *kinds: Any) -> None:
        self.kinds = kinds

    def __repr__(self) -> str:
        return f"Columns{self.kinds}"

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        count = len(self.kinds)
        row = core_schema.tuple_schema([handler.generate_schema(kind) for kind in self.kinds], strict=False)
        whole = core_schema.chain_schema([core_schema.list_schema(min_length=count, max_length=count), row])
        return core_schema.no_info_after_validator_function(list, whole)


JointName = Annotated[str, Named("joint")]
LinkName = Annotated[str, Named("link")]
PointName = Annotated[str, Named("point")]
EndName = Annotated[str, Named("end")]

Name = Annotated[str, Field(pattern=NAME)]
Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Position = Annotated[list[Length], Field(min_length=2, max_length=2)]
Direction = Annotated[list[Number], Field(min_length=2, max_length=2)]
