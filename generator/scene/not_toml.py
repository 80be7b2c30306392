"""A file that is no TOML: what is wrong with it, as far as it can be told without a reader."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from tomllib import TOMLDecodeError

from ..effect_base.units import read_unit
from .errors import MOST_TOLD, Fault, Path, key_text
from .kinds import TABLES
from .locate import Declared, Header, declared
from .part_tables import ROWS_OF_PARTS

MANY = {(key,) for key, kind in TABLES.items() if kind.many} | {("part", key) for key in (*ROWS_OF_PARTS, "place")}
"""Tables of which a scene, or a part, may have several."""

MOST_READ = 5_000_000
"""Letters that are read, in all rounds together, in looking for what stands twice: so of a usual scene as many are
found as are told, and one of a million letters takes some seconds."""

_BARE = re.compile(r"[=\[,]\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*([A-Za-zµ%°][^,\]}#\"]*)")
"""A number with something like a unit behind it, without quotes."""
_COMMA = re.compile(r"=\s*([-+]?\d+),(\d+)\s*(?:#.*)?$")
"""A number with a comma for its point, alone behind a key."""
_TEXTS = re.compile(r"\"[^\"]*\"|'[^']*'|#.*")
"""Comments and texts in quotes, in which anything may stand."""
_AGAIN = ("Cannot ", "Duplicate ")
"""How the reader's sentences on what is declared twice begin."""
_QUOTES = "\u201c\u201d\u201e\u2018\u2019"


def not_toml(text: str, file: str, error: TOMLDecodeError) -> tuple[tuple[Fault, ...], bool]:
    """All keys and tables that stand twice, with them all single headers of tables that there are several of, and what
    else the reader finds first, in the order of the file; and whether these are all that were to be found.

    What stands twice is mended, and the text read again, at most ``MOST_READ`` letters of it."""
    mended, read, found = _Mended(text), 0, list[Fault]()
    known: dict[str, Path] = {}
    other: TOMLDecodeError | None = error
    while other and str(other).startswith(_AGAIN):
        end = _place(mended.text, other)[1]
        read += end
        if len(found) >= MOST_TOLD or read > MOST_READ:
            return _sorted(found), False
        last, headers = declared(mended.text[:end])
        if single := [head for head in headers if head.keys in MANY]:
            found += [_single(file, head) for head in single]
            mended.replace([(place, place, sign) for head in single for place, sign in head.brackets()])
        elif last and last.before is not None:
            path = _as_written(last.path, known)
            found.append(Fault(file, last.line, key_text(path), _again(last, known)))
            name = f"again_{len(found)}_{len(text)}"
            known[name] = path
            mended.replace([(last.start, last.end, name)])
        else:
            break
        other = _wrong(mended.text)
    if found:
        end = _place(mended.text, other)[1] if other else len(mended.text)
        found += [_single(file, head) for head in declared(mended.text[:end])[1] if head.keys in MANY]
    if other:
        found.append(_unread(mended, file, other))
    return _sorted(found), True


def _sorted(faults: Iterable[Fault]) -> tuple[Fault, ...]:
    return tuple(sorted(faults, key=lambda fault: fault.line or 0))


class _Mended:
    """A text in which some is other than in the ``original``, though not where lines end."""

    def __init__(self, original: str) -> None:
        self.original = original
        self.text = original
        self._edits: list[tuple[int, int, str]] = []

    def replace(self, edits: Iterable[tuple[int, int, str]]) -> None:
        """What stands from one place of the text to another by something else, in several places."""
        self._edits += [(self.before(start), self.before(end), new) for start, end, new in edits]
        self._edits.sort()
        parts, at = list[str](), 0
        for start, end, new in self._edits:
            parts += (self.original[at:start], new)
            at = end
        self.text = "".join((*parts, self.original[at:]))

    def before(self, place: int) -> int:
        """Where in the original a place of the text is; the beginning of what is other there."""
        for start, end, new in self._edits:
            if place <= start:
                break
            if place < start + len(new):
                return start
            place -= len(new) - (end - start)
        return place


def _wrong(text: str) -> TOMLDecodeError | None:
    """What the reader finds wrong with a text."""
    try:
        tomllib.loads(text)
    except TOMLDecodeError as error:
        return error
    return None


def _single(file: str, head: Header) -> Fault:
    name = ".".join(head.keys)
    message = f"found [{name}], expected [[{name}]], of which there are several; write [[{name}]]"
    return Fault(file, head.line, "", message)


def _unread(mended: _Mended, file: str, error: TOMLDecodeError) -> Fault:
    """The reader's line, with its places in the text as it was written, and what may be meant there."""
    number, place = _place(mended.text, error)
    place = mended.before(place)
    line = mended.original[mended.original.rfind("\n", 0, place) + 1 :].partition("\n")[0]
    column = place - mended.original.rfind("\n", 0, place)
    why = re.sub(r"(at line \d+, column )\d+", rf"\g<1>{column}", str(error))
    return Fault(file, number, "", f"found no valid TOML: {why}; {_advice(line.rstrip(), why)}")


def _place(text: str, error: TOMLDecodeError) -> tuple[int, int]:
    """Line (from 1) and place in the text up to which the reader came."""
    found = re.search(r"at line (\d+), column (\d+)", str(error))
    if not found:
        return text.count("\n") + 1, len(text)
    lines = text.split("\n")[: int(found[1]) - 1]
    return int(found[1]), sum(len(line) + 1 for line in lines) + int(found[2]) - 1


def _as_written(path: Path, known: Mapping[str, Path]) -> Path:
    """The path without the names that stand for ``known`` ones."""
    for k, part in enumerate(path):
        if part in known:
            return known[str(part)] + path[k + 1 :]
    return path


def _again(found: Declared, known: Mapping[str, Path]) -> str:
    if found.within == found.path:
        return (
            f"found a second time, expected once; line {found.before} has it too; write them as one, or leave one out"
        )
    within = key_text(_as_written(found.within, known))
    if found.value:
        return (
            f"found within {within}, which line {found.before} gives as a value, expected that to be a table; write "
            "one of them with another name, or leave one out"
        )
    return f"found apart from the rest of {within}, which line {found.before} gives, expected within it; write it there"


def _advice(line: str, why: str) -> str:
    if any(quote in _TEXTS.sub("", line) for quote in _QUOTES):
        return 'write straight quotes, ", for curved ones'
    if re.search(r"[:=]\s*=", _TEXTS.sub("", line)):
        return "write one = alone between a key and its value"
    if re.match(r"[ \t]*[A-Za-z0-9_-]+[ \t]*:", line):
        return "write = for :"
    if "Expected '=' after a key" in why:
        return "write KEY = VALUE, with = between them"
    if comma := _COMMA.search(line):
        return f"write {comma[1]}.{comma[2]}, with a point for the comma"
    for bare in _BARE.finditer(line):
        if read_unit(bare[2]):
            return f'write "{bare[1]} {bare[2].strip()}", in quotes, for a number with its unit'
    if line.count('"') % 2:
        return "close the quotes, or correct the line"
    return "correct the line"
