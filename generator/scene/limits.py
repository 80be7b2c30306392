"""What a scene file may hold at most, looked for before it is read: what is larger would take minutes or end in a fault
of the reader's, not of the file's."""

from __future__ import annotations

import re
import sys

MOST_BYTES = 2**26
"""Of a scene file: thirteen times what the tables that are read at most (20,000, of some 250 bytes) come to."""
LARGEST = sys.float_info.max**0.5
"""A number beyond it has no square, and one below its inverse none but zero."""
NESTED = 64
"""Arrays and tables in one another, and parts of one dotted key. Readers that call themselves have an end to that."""
DIGITS = 400
"""Digits of one number: more than any double has before or behind its point (308 and 17)."""
MOST_TABLES = 500
"""Tables of one kind of effect. Equations are written out for each, some 30 ms of work."""
MOST_LINKS, MOST_JOINTS = 2000, 6000
"""Of the general form: as many links as of the others. Assembling takes memory in proportion to their square."""

MOST_PLACED = 20_000
"""Tables that parts come to in all their places: more than all kinds of tables may be together."""

_TOKEN = re.compile(
    r'"""(?:[^\\]|\\.)*?"""' r"|'''.*?'''" r'|"(?:[^"\\\n]|\\.)*"' r"|'[^'\n]*'" r"|#[^\n]*" r"|[\[\]{}]",
    re.DOTALL,
)
_PART = r"""(?:[A-Za-z0-9_-]+|"(?:[^"\\\n]|\\.)*"|'[^'\n]*')[ \t]*"""
_KEY = re.compile(rf"^[ \t]*\[{{0,2}}[ \t]*((?:{_PART}\.[ \t]*){{{NESTED},}})", re.MULTILINE)
_NUMBER = re.compile(rf"[0-9_]{{{DIGITS + 1},}}")


def too_large(text: str) -> tuple[int, str] | None:
    """The first thing in a TOML text that is beyond the limits: its line, and a sentence."""
    if key := _KEY.search(text):
        parts = key[1].count(".") + 1
        return _line(
            text, key.start(1)
        ), f"found a key of {parts} parts, expected at most {NESTED}; write a shorter one"
    depth = 0
    for token in _TOKEN.finditer(text):
        depth += {"[": 1, "{": 1, "]": -1, "}": -1}.get(token[0], 0)
        if depth > NESTED:
            message = f"found arrays or tables more than {NESTED} deep in one another, expected a scene's few"
            return _line(text, token.start()), f"{message}; close them"
    strings = [token.span() for token in _TOKEN.finditer(text) if token[0][0] in "\"'#"]
    for number in _NUMBER.finditer(text):
        if not any(start <= number.start() < end for start, end in strings):
            digits = sum(sign.isdigit() for sign in number[0])
            message = f"found a number of {digits} digits, expected at most {DIGITS}; write it with an exponent, as 1e9"
            return _line(text, number.start()), message
    return None


def _line(text: str, at: int) -> int:
    return text.count("\n", 0, at) + 1
