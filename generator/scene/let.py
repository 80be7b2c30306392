"""``[let]``: names that a scene gives to numbers, for use in all its others."""

from __future__ import annotations

import keyword
import re
from collections.abc import Iterator, Mapping
from typing import Any

from ..effect_base.arithmetic import RESERVED, ExpressionError, Names, NameWithoutValue, calculate, free_names, parsed
from ..effect_base.table import NAME
from ..effect_base.written_numbers import read_quantity
from .check import show
from .errors import Report

KEY = "let"
MOST_NAMES = 500
"""Names of one scene: more than a person gives."""
_EXPECTED = 'a number, or a text such as "20 cm" or "2*rho*l"'


def read_names(raw: object, report: Report) -> Names:
    """The numbers (SI) that the table ``[let]`` gives names to, in its order, which need not be that of their use.

    What is wrong goes to ``report``; a name whose own value is wrong, or hangs on one that is, stands for ``None``.
    """
    if not isinstance(raw, Mapping):
        report.add((KEY,), f"found {show(raw)}, expected a table of names and numbers; write [{KEY}]")
        return {}
    if len(raw) > MOST_NAMES:
        report.add((KEY,), f"found {len(raw)} names, expected at most {MOST_NAMES}; leave out what is not needed")
        return dict.fromkeys(raw)
    found: dict[str, float | None] = dict.fromkeys(raw)
    needs: dict[str, list[str]] = {}
    for name, value in raw.items():
        if wrong := wrong_name(name):
            report.add((KEY, name), f'found "{name}", expected {wrong}; rename it')
            continue
        try:
            found[name], needs[name] = _read(value, found)
        except ExpressionError as error:
            report.add((KEY, name), f"found {show(value)}, expected {_EXPECTED}; {error}")
    _tell_rings(raw, needs, report)
    while ready := [name for name, needed in needs.items() if found[name] is None and _known(needed, found)]:
        for name in ready:
            try:
                found[name] = calculate(raw[name], found)
            except NameWithoutValue:
                pass
            except ExpressionError as error:
                report.add((KEY, name), f"found {show(raw[name])}, expected {_EXPECTED}; {error}")
            del needs[name]
    return found


def wrong_name(name: str) -> str:
    """What is expected in place of a name that cannot be one; nothing where it can."""
    if name in RESERVED:
        return "a name that means nothing else in expressions"
    if keyword.iskeyword(name):
        return "a name that is no word of Python's own"
    return "" if re.fullmatch(NAME, name) else "letters, digits and _, beginning with a letter"


def _read(value: Any, names: Mapping[str, object]) -> tuple[float | None, list[str]]:
    """A number that needs no other, or ``None`` and the names that it needs. Raises ``ExpressionError``."""
    if isinstance(value, str):
        quantity = read_quantity(value, None)
        needed = [] if quantity is not None else [one for one in free_names(parsed(value)) if one in names]
        return quantity, list(dict.fromkeys(needed))
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ExpressionError("correct it")
    try:
        finite = abs(float(value)) < float("inf")
    except OverflowError:
        finite = False
    if not finite:
        raise ExpressionError("write a finite number")
    return value, []


def _known(needed: list[str], found: Mapping[str, float | None]) -> bool:
    return all(found[name] is not None for name in needed)


def _tell_rings(raw: Mapping[str, Any], needs: Mapping[str, list[str]], report: Report) -> None:
    """Names that need themselves, by way of others or at once: each ring is told where its first name stands."""
    told: set[str] = set()
    for name in raw:
        found = [] if name in told else ring(name, needs)
        if found and not told & {*found}:
            way = " -> ".join((*found, name))
            message = f"found {show(raw[name])}, which needs its own value ({way}), expected {_EXPECTED}"
            report.add((KEY, name), f"{message}; give one of them a number", also=[(KEY, one) for one in found])
        told |= {*found}


def ring(name: str, needs: Mapping[str, list[str]]) -> list[str]:
    """The shortest way from a name through what it needs back to it, without the last; nothing where there is none."""
    ways: dict[str, str] = {}
    waiting = [name]
    for one in waiting:
        for needed in needs.get(one, ()):
            if needed == name:
                return [*_back(one, name, ways)][::-1]
            if needed not in ways:
                ways[needed] = one
                waiting.append(needed)
    return []


def _back(end: str, start: str, ways: Mapping[str, str]) -> Iterator[str]:
    while end != start:
        yield end
        end = ways[end]
    yield start
