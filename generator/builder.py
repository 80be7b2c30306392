"""A scene built call by call in Python, in the words of scene files: one method for every table.

The methods are made of the scene's own tables, so that a new effect has its method without a line here. Type checkers
and editors read them in table_methods.pyi, which docs/scripts/table_methods.py writes.
"""

from __future__ import annotations

import copy
import inspect
import sys
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from pathlib import Path as Folder
from typing import TYPE_CHECKING, Any

from .pipeline import generate
from .scene import TABLES, Scene, TableKind, load_scene, plain, read_tables

if TYPE_CHECKING:
    from .table_methods import TableMethods
else:
    TableMethods = object

Word = Callable[..., "Mechanism"]
Path = tuple[str | int, ...]
_Places = dict[Path, tuple[str, int]]
"""The file and line of the call that gave a value."""


class Mechanism(TableMethods):
    """A mechanism that is described call by call; each call adds a table of a scene, and gives the mechanism back.

    ``Mechanism("arm").link("rod", rod={"mass": 1.0}, points={"A": [0, 0], "B": [1, 0]}).joint(between=["ground.O",
    "rod.A"])`` has the tables of a file with ``[[link]]`` and ``[[joint]]``. Of tables that a scene has several of
    (``[[link]]``, ``[[spring]]``), every call adds one, and a text before the keys is its name. Of the others
    (``[start]``, ``[run]``), a call adds its keys, and replaces those that were given before. ``part`` takes a
    mechanism before the keys, whose tables are then those of the part. ``tables`` are those of a scene to go on from.

    Nothing is checked before :meth:`scene`, which tells all that is wrong at once.
    """

    def __init__(self, name: str | None = None, tables: Mapping[str, Any] | None = None) -> None:
        self._tables: dict[str, Any] = copy.deepcopy(dict(tables or {}))
        self._places: _Places = {(): _caller()}
        if name is not None:
            self._tables["name"] = name

    if not TYPE_CHECKING:  # table_methods.pyi has them all: what is not there is a fault before the program runs

        def __getattr__(self, key: str) -> Word:
            if key not in TABLES:
                close = get_close_matches(key, TABLES, 1)
                advice = f"write {close[0]}" if close else f"expected one of {', '.join(TABLES)}"
                raise AttributeError(f"a mechanism has no {key}; {advice}")
            return _word(self, key, TABLES[key])

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *TABLES]

    def __repr__(self) -> str:
        counts = [f"{key} ({len(table)})" if isinstance(table, list) else key for key, table in self._tables.items()]
        return f"<mechanism with {', '.join(counts) or 'nothing'}>"

    def to_dict(self) -> dict[str, Any]:
        """The tables so far, as ``load_scene`` takes them; nothing of them is checked."""
        return copy.deepcopy(self._tables)

    def to_toml(self) -> str:
        """The text of a scene file. Raises ``SceneError`` as :meth:`scene` does."""
        return self.scene().to_toml()

    def scene(self) -> Scene:
        """The scene. Raises ``SceneError`` with everything that is wrong with it, each fault with its key, and with the
        line of the call that gave it, where all calls stand in one file."""
        files = {file for file, _ in self._places.values()}
        if len(files) > 1:
            return load_scene(self._tables)
        lines = {path: line for path, (_, line) in self._places.items()}
        return read_tables(plain(self._tables), files.pop(), "scene", lines)

    def build(self, out: str | Folder = "build", **options: Any) -> Folder:
        """The folder of the compiled model, for ``load_model``; ``options`` are those of ``generate``.

        Raises ``SceneError`` as :meth:`scene` does, and otherwise what ``generate`` does.
        """
        return generate(self.scene(), out, **options)


def _word(mechanism: Mechanism, key: str, kind: TableKind) -> Word:
    """The method that adds a table ``key``."""

    def add(*before: Any, **keys: Any) -> Mechanism:
        tables, table, places = mechanism._tables, dict(keys), _Places({(): _caller()})
        if len(before) > (1 if kind.named else 0):
            allowed = "one name before its keys" if kind.named else "its keys by name"
            raise TypeError(f"{key}: found {before[kind.named :][0]!r} without a key, expected {allowed}")
        if before and isinstance(before[0], Mechanism):
            table = {**before[0].to_dict(), **table}
            places |= before[0]._places
        elif before:
            if "name" in keys:
                raise TypeError(f"{key}: found the names {before[0]!r} and {keys['name']!r}, expected one")
            table = {"name": before[0], **table}
        if kind.many:
            tables.setdefault(key, []).append(copy.deepcopy(table))
            base: Path = (key, len(tables[key]) - 1)
        else:
            tables[key] = {**tables.get(key, {}), **copy.deepcopy(table)}
            base = (key,)
            places |= {(name,): places[()] for name in table}
        mechanism._places |= {base + path: place for path, place in places.items()}
        return mechanism

    header = f"[[{key}]]" if kind.many else f"[{key}]"
    add.__name__ = add.__qualname__ = key
    add.__doc__ = "\n".join((f"Add {header}.", "", *(f"{name}: {said}" for name, said in kind.keys.items())))
    add.__signature__ = _signature(kind)  # type: ignore[attr-defined]
    return add


def _caller() -> tuple[str, int]:
    """The file and the line of the call into this module."""
    frame = sys._getframe()
    while frame.f_back and frame.f_code.co_filename == __file__:
        frame = frame.f_back
    return frame.f_code.co_filename, frame.f_lineno


def _signature(kind: TableKind) -> inspect.Signature:
    """What may be given, for those who ask: the keys of the table, in its order."""
    names = [name for name in kind.keys if name != "name"]
    first = [inspect.Parameter("name", inspect.Parameter.POSITIONAL_OR_KEYWORD, default=None)] * kind.named
    keys = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None) for name in names]
    more = [inspect.Parameter("names", inspect.Parameter.VAR_KEYWORD)] * (not names)
    return inspect.Signature([*first, *keys, *more], return_annotation=Mechanism)
