"""A file that is no TOML: what is wrong with it, as far as it can be told without a reader."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from tomllib import TOMLDecodeError

from ..effect_base.units import read_unit
from .errors import MOST_TOLD, Fault, Path, key_text
from .kinds import TABLES
from .locate import Declared, last_declared
from .part_tables import ROWS_OF_PARTS

MANY = {(key,) for key, kind in TABLES.items() if kind.many} | {("part", key) for key in (*ROWS_OF_PARTS, "place")}
"""Tables of which a scene, or a part, may have several."""

_HEADER = re.compile(r"^[ \t]*\[[ \t]*([A-Za-z_.]+)[ \t]*\][ \t]*(?:#.*)?$", re.MULTILINE)
_BARE = re.compile(r"[=\[,]\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*([A-Za-zµ%°][^,\]}#\"]*)")
"""A number with something like a unit behind it, without quotes."""
_COMMA = re.compile(r"=\s*([-+]?\d+),(\d+)\s*(?:#.*)?$")
"""A number with a comma for its point, alone behind a key."""
_TEXTS = re.compile(r"\"[^\"]*\"|'[^']*'|#.*")
"""Comments and texts in quotes, in which anything may stand."""
_AGAIN = ("Cannot ", "Duplicate ")
"""How the reader's sentences on what is declared twice begin."""
_QUOTES = "\u201c\u201d\u201e\u2018\u2019"


def not_toml(text: str, file: str, error: TOMLDecodeError) -> tuple[Fault, ...]:
    """All single headers of tables that there are several of, where these are a fault, all other keys and tables that
    stand twice, and what else the reader finds first, in the order of the file."""
    headers, twice = list[Fault](), list[Fault]()
    known: dict[str, Path] = {}
    other: TOMLDecodeError | None = error
    if str(error).startswith(_AGAIN):
        text, headers = _single(text, file)
        other = _wrong(text) if headers else error
    while other and str(other).startswith(_AGAIN) and len(twice) < MOST_TOLD:
        found = last_declared(text[: _place(text, other)[1]])
        if found is None or found.before is None:
            break
        path = _as_written(found.path, known)
        twice.append(Fault(file, found.line, key_text(path), _again(found, known)))
        name = f"again_{len(twice)}_{len(text)}"
        known[name] = path
        text = f"{text[: found.start]}{name}{text[found.end :]}"
        other = _wrong(text)
    unread = [_unread(text, file, other)] if other else []
    return tuple(sorted((*headers, *twice, *unread), key=lambda fault: fault.line or 0))


def _wrong(text: str) -> TOMLDecodeError | None:
    """What the reader finds wrong with a text."""
    try:
        tomllib.loads(text)
    except TOMLDecodeError as error:
        return error
    return None


def _single(text: str, file: str) -> tuple[str, list[Fault]]:
    """The text with double headers for tables of which there are several, and the single ones that it has."""
    headers = [head for head in _HEADER.finditer(text) if tuple(head[1].split(".")) in MANY]
    faults = [
        Fault(
            file,
            text.count("\n", 0, head.start()) + 1,
            "",
            f"found [{head[1]}], expected [[{head[1]}]], of which there are several; write [[{head[1]}]]",
        )
        for head in headers
    ]
    return _HEADER.sub(lambda head: f"[[{head[1]}]]" if tuple(head[1].split(".")) in MANY else head[0], text), faults


def _unread(text: str, file: str, error: TOMLDecodeError) -> Fault:
    """The reader's line, and what may be meant there."""
    number, _ = _place(text, error)
    line = text.splitlines()[number - 1] if number <= len(text.splitlines()) else ""
    return Fault(file, number, "", f"found no valid TOML: {error}; {_advice(line, str(error))}")


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
    return f"found apart from the rest of {within}, which line {found.before} gives, expected within it; write it there"


def _advice(line: str, why: str) -> str:
    if any(quote in line for quote in _QUOTES):
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
