"""In which line of a TOML text each key stands; ``tomllib`` reads values but forgets their places.

The text has already been read by ``tomllib``, so it is known to be valid and only its shape is followed here.
"""

from __future__ import annotations

import json
import re
from bisect import bisect_right
from typing import NamedTuple

from .errors import Path

_BLANK = re.compile(r"(?:[ \t]|\r?\n|#[^\n]*)*")
_STRING = re.compile(
    r'"""(?:[^\\]|\\.)*?"""(?:"{0,2})' r"|'''.*?'''(?:'{0,2})" r'|"(?:[^"\\\n]|\\.)*"' r"|'[^'\n]*'",
    re.DOTALL,
)
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_BARE_VALUE = re.compile(r"[^,\]}\n#]*")


def locate(text: str) -> dict[Path, int]:
    """Line (from 1) of every table, key, array element and inline-table key of the TOML ``text``."""
    return _Locator(text).run()


class Declared(NamedTuple):
    """A key or a table that a text declares: its ``path``, the ``line`` (from 1), and where the key itself stands in
    the text. ``before`` is the line in which the path, or the closest table above it, ``within``, was declared before,
    ``None`` where none was; ``value`` is whether that was a value without tables."""

    path: Path
    line: int
    start: int
    end: int
    within: Path
    before: int | None
    value: bool


class Header(NamedTuple):
    """A header of a table with single brackets: its keys, its line (from 1), and where what is in them stands."""

    keys: tuple[str, ...]
    line: int
    start: int
    end: int

    def brackets(self) -> tuple[tuple[int, str], tuple[int, str]]:
        """What makes it one with double brackets, and where."""
        return (self.start, "["), (self.end, "]")


def declared(text: str) -> tuple[Declared | None, list[Header]]:
    """The last key or table that the beginning of a TOML text declares, which may end inside of lists and tables, and
    all its single headers."""
    locator = _Locator(text)
    locator.run()
    return locator.last, locator.headers


class _Locator:
    def __init__(self, text: str) -> None:
        self._text = text
        self._at = 0
        self._ends = [match.start() for match in re.finditer("\n", text)]
        self._count: dict[Path, int] = {}
        self._declared: dict[Path, int] = {}
        self._whole = True
        self.lines: dict[Path, int] = {}
        self._values: set[Path] = set()
        self.last: Declared | None = None
        self.headers: list[Header] = []

    def run(self) -> dict[Path, int]:
        table: Path = ()
        self._blank()
        while self._at < len(self._text):
            if self._next("["):
                table = self._header()
            else:
                self._pair(table)
            self._blank()
        return self.lines

    def _header(self) -> Path:
        """``[a.b]`` or ``[[a.b]]``: the path of the table that begins here."""
        line = self._line()
        many = self._text.startswith("[[", self._at)
        self._at += 2 if many else 1
        start, keys, end = self._at, self._keys(), self._at
        if not many:
            self.headers.append(Header(tuple(keys), line, start, end))
        self._at += 2 if many else 1
        path: Path = ()
        above: list[Path] = []
        for depth, key in enumerate(keys):
            path += (key,)
            above.append(path)
            if many and depth == len(keys) - 1:
                self._count[path] = self._count.get(path, -1) + 1
            if path in self._count:
                path += (self._count[path],)
        declared = self._declare(path, line, start, end)
        for one in (*above, path):
            self.lines.setdefault(one, line)
        self._note(declared)
        return path

    def _pair(self, table: Path) -> None:
        """``a.b = value`` inside ``table``."""
        line, start, keys, end = self._line(), self._at, self._keys(), self._at
        declared = self._declare((*table, *keys), line, start, end)
        for key in keys:
            table += (key,)
            self.lines.setdefault(table, line)
        self._at += 1  # =
        self._blank()
        if self._value(table):
            self._values.add(table)
        if self._whole:
            self._note(declared)

    def _declare(self, path: Path, line: int, start: int, end: int) -> Declared:
        """What is declared, and what was before that."""
        if path not in self._declared and path in self.lines:
            return Declared(path, line, start, end, path, self.lines[path], False)
        above = next((path[:k] for k in range(len(path), 0, -1) if path[:k] in self._declared), path)
        return Declared(path, line, start, end, above, self._declared.get(above), above in self._values)

    def _note(self, declared: Declared) -> None:
        self.last = declared
        self._declared.setdefault(declared.path, declared.line)

    def _keys(self) -> list[str]:
        """``a."b c".d``, leaving the position at what follows."""
        keys: list[str] = []
        while True:
            self._blank()
            quoted = _STRING.match(self._text, self._at)
            match = quoted or _BARE_KEY.match(self._text, self._at)
            if match is None:
                return keys
            self._at = match.end()
            keys.append(_unquote(match.group()) if quoted else match.group())
            self._blank()
            if not self._next("."):
                return keys
            self._at += 1

    def _value(self, path: Path) -> bool:
        """Whether it is one without tables."""
        self.lines.setdefault(path, self._line())
        if self._next("["):
            return self._list(path)
        if self._next("{"):
            self._inline_table(path)
            return False
        string = _STRING.match(self._text, self._at)
        match = string or _BARE_VALUE.match(self._text, self._at)
        self._at = match.end() if match else self._at + 1
        return True

    def _list(self, path: Path) -> bool:
        """Whether it is one without tables."""
        self._at += 1
        self._blank()
        index, plain = 0, True
        while not self._next("]") and self._at < len(self._text):
            plain = self._value((*path, index)) and plain
            index += 1
            self._skip_comma()
        self._close("]")
        return plain

    def _inline_table(self, path: Path) -> None:
        self._at += 1
        self._blank()
        while not self._next("}") and self._at < len(self._text):
            self._pair(path)
            self._skip_comma()
        self._close("}")

    def _close(self, sign: str) -> None:
        """Go behind the end of a list or table; a text that ends inside of it has no more whole ones around that."""
        self._whole = self._whole and self._next(sign)
        self._at += 1

    def _skip_comma(self) -> None:
        self._blank()
        if self._next(","):
            self._at += 1
        self._blank()

    def _blank(self) -> None:
        match = _BLANK.match(self._text, self._at)
        self._at = match.end() if match else self._at

    def _next(self, sign: str) -> bool:
        return self._text.startswith(sign, self._at)

    def _line(self) -> int:
        return bisect_right(self._ends, self._at - 1) + 1


def _unquote(text: str) -> str:
    """A quoted key without its quotes; escapes are read as JSON does, which covers all but ``\\U``."""
    if text.startswith("'"):
        return text[1:-1]
    try:
        return str(json.loads(text))
    except ValueError:
        return text[1:-1]
