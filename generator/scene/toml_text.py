"""Tables of a scene from Python and to TOML: plain values in, and a text that reads back to the same values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .limits import NESTED

WIDTH = 110
"""Characters of a line, up to which a table inside another is written in it."""


def plain(value: Any, depth: int = 0) -> Any:
    """A value of a scene as TOML would give it: tuples and arrays as lists, numbers of NumPy as Python's.

    Keys whose value is ``None`` are left out. Raises ``TypeError`` for keys that are no texts, ``ValueError`` for
    tables in one another without end.
    """
    if depth > NESTED:
        raise ValueError(f"found arrays or tables more than {NESTED} deep in one another, expected a scene's few")
    if isinstance(value, Mapping):
        for key in value:
            if not isinstance(key, str):
                raise TypeError(f"found {key!r} as a key of a table, expected a text")
        return {str(key): plain(item, depth + 1) for key, item in value.items() if item is not None}
    if isinstance(value, list | tuple):
        return [plain(item, depth + 1) for item in value]
    if isinstance(value, bool | str):
        return value
    if isinstance(value, int | float):
        return float(value) if isinstance(value, float) else int(value)
    return plain(value.tolist(), depth + 1) if hasattr(value, "tolist") else value


def toml_text(tables: Mapping[str, Any]) -> str:
    """The TOML text of a scene's tables; read back, it gives the same tables, order of keys apart."""
    import tomlkit

    document = tomlkit.document()
    for key, value in sorted(tables.items(), key=lambda item: _rank(item[1])):
        document.add(key, _item(value, outer=True))
    return tomlkit.dumps(document).lstrip("\n")


def _rank(value: Any) -> int:
    """Values come before tables, as those of a table would else be taken for the last one's inside it."""
    return 2 if _is_array_of_tables(value) else isinstance(value, Mapping)


def _is_array_of_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(one, Mapping) for one in value)


def _item(value: Any, outer: bool = False) -> Any:
    """A table or an array of tables with headers where it is ``outer`` or too long for a line, or else in one line."""
    import tomlkit

    if _is_array_of_tables(value) and outer:
        array = tomlkit.aot()
        for one in value:
            array.append(_table(one))
        return array
    if isinstance(value, Mapping):
        inline = tomlkit.inline_table()
        for key, item in value.items():
            inline.add(key, _item(item))
        return _table(value) if outer else inline
    if isinstance(value, list):
        items = tomlkit.array()
        items.extend([_item(one) for one in value])
        return items
    return tomlkit.item(value)


def _table(table: Mapping[str, Any]) -> Any:
    """A table with a header; those inside it that are too long for a line have their own."""
    import tomlkit

    found, later = tomlkit.table(), {}
    for key, value in table.items():
        inline = _item(value)
        if (isinstance(value, Mapping) or _is_array_of_tables(value)) and len(inline.as_string()) > WIDTH:
            later[key] = value
        else:
            found.add(key, inline)
    for key, value in sorted(later.items(), key=lambda item: _rank(item[1])):
        found.add(key, _item(value, outer=True))
    return found
