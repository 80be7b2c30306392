"""A file that is no TOML: what is wrong with it, as far as it can be told without a reader."""

from __future__ import annotations

import re
from tomllib import TOMLDecodeError

from ..effect_base.units import read_unit
from ..effects import REGISTRY
from .errors import Fault

MANY = ("link", "joint", "part", "place", *(entry.key for entry in REGISTRY if entry.many))
"""Tables of which a scene may have several."""

_HEADER = re.compile(r"^[ \t]*\[[ \t]*([A-Za-z_]+)[ \t]*\][ \t]*(?:#.*)?$", re.MULTILINE)
_BARE = re.compile(r"[=\[,]\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*([A-Za-zµ%°][^,\]}#\"]*)")
"""A number with something like a unit behind it, without quotes."""
_COMMA = re.compile(r"=\s*([-+]?\d+),(\d+)\s*(?:#.*)?$")
"""A number with a comma for its point, alone behind a key."""
_TEXTS = re.compile(r"\"[^\"]*\"|'[^']*'|#.*")
"""Comments and texts in quotes, in which anything may stand."""
_QUOTES = "\u201c\u201d\u201e\u2018\u2019"


def not_toml(text: str, file: str, error: TOMLDecodeError) -> tuple[Fault, ...]:
    """All single headers of tables that there are several of, where those are the fault, or else the reader's line."""
    if "Cannot" in str(error) and (headers := [head for head in _HEADER.finditer(text) if head[1] in MANY]):
        return tuple(
            Fault(
                file,
                text.count("\n", 0, head.start()) + 1,
                "",
                f"found [{head[1]}], expected [[{head[1]}]], of which there are several; write [[{head[1]}]]",
            )
            for head in headers
        )
    found = re.search(r"at line (\d+)", str(error))
    number = int(found[1]) if found else text.count("\n") + 1
    line = text.splitlines()[number - 1] if number <= len(text.splitlines()) else ""
    return (Fault(file, number, "", f"found no valid TOML: {error}; {_advice(line, str(error))}"),)


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
