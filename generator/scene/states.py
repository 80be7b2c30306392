"""Expressions of the state in tables of effects, read when the mechanism is known, and laws, which they may name."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from graphlib import TopologicalSorter
from typing import Any, NamedTuple

from ..effect_base.arithmetic import ExpressionError, Names, NamesAndLaws, NameWithoutValue, laws_among
from ..effect_base.expression_of_state import OfState, Unread
from ..effect_base.grammar_of_state import WORDS, Scope, free_in, laws_in, normal_form
from ..effect_base.piecewise_in_time import Piecewise
from ..effect_base.table import Table
from ..effects.law import LawTable
from ..mechanism.mechanism import Mechanism
from .errors import Path, Report
from .let import ring, wrong_name

KEY = "law"
DEEPEST = 20
"""Laws of which each names the next."""
OUTPUTS = ("energy", "kinetic_energy", "potential_energy")
"""Names of what every run tells."""


class Row(NamedTuple):
    """A table of an effect, its number among those of its kind, and where it stands."""

    path: Path
    number: int
    table: Table


def with_laws(names: Names, tables: Mapping[str, Any]) -> Names:
    """The names of numbers, and beside them those of the laws in ``tables``; the same where there are none."""
    given = tables.get(KEY)
    rows = given if isinstance(given, list) else [given]
    named = [row for row in rows if isinstance(row, Mapping) and isinstance(row.get("name"), str)]
    laws = {row["name"]: [*own] if isinstance(own := row.get("parameters"), Mapping) else [] for row in named}
    return NamesAndLaws(names, laws) if laws else names


def read_states(rows: Sequence[Row], mechanism: Mechanism, names: Names, report: Report) -> list[Table | None]:
    """The tables with what they have of the state read; ``None`` in place of one with faults."""
    joints = {joint.name for joint in (*mechanism.joints, *mechanism.open)}
    _check_names([row for row in rows if isinstance(row.table, LawTable)], names, joints, report)
    found = [_read(row, mechanism, names, report) for row in rows]
    _tell_rings(rows, found, report)
    return found


def _read(row: Row, mechanism: Mechanism, names: Names, report: Report) -> Table | None:
    table = row.table
    own: dict[str, str] = {}
    curves: dict[str, Piecewise] = {}
    if law := isinstance(table, LawTable):
        own = {name: f"p_law_{row.number}_{name}" for name in sorted(table.parameters)}
        curves = {name: table.curves[name].curve() for name in sorted(table.curves)}
    scope = Scope(names, mechanism, laws_among(names), own if law else None, curves, loads=True)
    label = f"law_{row.number}" if law else ""
    changed: dict[str, Any] = {}
    sound = _are_used(row, {"parameters": own, "curves": curves}, report)
    for place, value in _unread(table, law):
        try:
            text = normal_form(value.text, scope)
        except ExpressionError as error:
            sound = False
            if not isinstance(error, NameWithoutValue):
                message = f'found "{value.text}", expected an expression of the time and the state; {error}'
                report.add((*row.path, *place), message)
            continue
        read = OfState(text, tuple(own.items()), label, tuple(curves.items()))
        key, *inside = place
        if inside:
            changed.setdefault(str(key), [*getattr(table, str(key))])[int(inside[0])] = read
        else:
            changed[str(key)] = read
    if not sound:
        return None
    return table.model_copy(update=changed) if changed else table


def _are_used(row: Row, own: Mapping[str, Collection[str]], report: Report) -> bool:
    """Whether the value of a law, where it is written, has all names that are given at the keys of ``own``."""
    value = getattr(row.table, "value", None)
    if not isinstance(value, Unread):
        return True
    named, sound = free_in(value.text), True
    if named is None:
        return True  # what is wrong with it is told
    for key, name in ((key, name) for key, names in own.items() for name in names):
        if name not in named and not _wrong_name(name):
            message = f"found {name}, which value does not have, expected names that it has; use it there, or remove it"
            report.add((*row.path, key, name), message)
            sound = False
    return sound


def _unread(table: Table, law: bool) -> Iterator[tuple[Path, Unread]]:
    """What a table has of the state, and where; of a law its value, a number too."""
    for key in type(table).model_fields:
        value = getattr(table, key)
        if law and key == "value" and isinstance(value, int | float):
            yield (key,), Unread(repr(float(value)))
        if isinstance(value, Unread):
            yield (key,), value
        if isinstance(value, list):
            yield from (((key, index), one) for index, one in enumerate(value) if isinstance(one, Unread))


def _check_names(laws: Sequence[Row], names: Names, joints: Collection[str], report: Report) -> None:
    """Names of laws, of their parameters and curves mean nothing else where they may stand."""
    known = laws_among(names)
    for row in laws:
        assert isinstance(row.table, LawTable)
        name = row.table.name
        wrong = _wrong_name(name)
        if name in OUTPUTS:
            wrong = "a name that no other output of a run has"
        if name in joints:
            wrong = "a name that no joint has"
        if name in names:
            wrong = "a name that is none of [let]"
        if wrong:
            report.add((*row.path, "name"), f'found "{name}", expected {wrong}; rename it')
        every = [("parameters", own) for own in row.table.parameters] + [("curves", own) for own in row.table.curves]
        for key, own in every:
            wrong = _wrong_name(own)
            if own in names:
                wrong = "a name that is none of [let]"
            if own in known:
                wrong = "a name that is no law's"
            if key == "curves" and own in row.table.parameters:
                wrong = "a name that is no parameter's"
            if wrong:
                report.add((*row.path, key, own), f'found "{own}", expected {wrong}; rename it')


def _wrong_name(name: str) -> str:
    return "a name that means nothing else in expressions" if name in WORDS else wrong_name(name)


def _tell_rings(rows: Sequence[Row], found: Sequence[Table | None], report: Report) -> None:
    """Laws that need their own value, by way of others or at once: each ring is told where its first law stands; and
    rows of laws that are too long."""
    laws = {table.name: row for row, table in zip(rows, found, strict=True) if isinstance(table, LawTable)}
    values = {table.name: table.value for table in found if isinstance(table, LawTable)}
    needs = {name: laws_in(value.text) for name, value in values.items() if isinstance(value, OfState)}
    told: set[str] = set()
    deep: dict[str, int] = {}
    for name, row in laws.items():
        way = [] if name in told else ring(name, needs)
        if way:
            message = f"found a law that needs its own value ({' -> '.join((*way, name))}), expected laws that do not"
            also = [(*laws[one].path, "value") for one in way]
            report.add((*row.path, "value"), f"{message}; take it out of one of them", also=also)
        told |= {*way}
    if told:
        return
    for name in TopologicalSorter(needs).static_order():
        deep[name] = 1 + max((deep.get(one, 0) for one in needs.get(name, ())), default=0)
        if deep[name] == DEEPEST + 1:
            message = f"found a law behind {DEEPEST} others that name one another, expected at most {DEEPEST} in a row"
            report.add((*laws[name].path, "value"), f"{message}; write the values of some of them in its place")
