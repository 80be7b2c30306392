"""The law of impact: one for the whole model, wherever a scene names it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from ..effect_base.contact import LAWS, Law
from ..effect_base.table import Table
from .errors import Path, Report, key_text

KEY = "law"


def law_of_all(tables: Mapping[str, Any], models: Mapping[str, type[Table]], report: Report) -> Law:
    """The law that all impacts of a scene follow: ``[run]`` names it, or any table that has the key; else the first.

    Contacts that are struck together have impulses by one law, so tables that name different ones are at fault. Tables
    are taken as they stand, that wrong values beside a law do not hide what disagrees with it.
    """
    named: dict[Law, list[Path]] = {}
    for path, law in _named(tables, models):
        named.setdefault(law, []).append(path)
    if len(named) > 1:
        _, (second, *_), *_ = named.values()
        found = ", ".join(f'"{law}" at {" and ".join(map(key_text, paths))}' for law, paths in named.items())
        told = f"found {found}, expected one law for all impacts; write it once, as {KEY} in [run]"
        report.add(second, told, also=[path for paths in named.values() for path in paths])
    return next(iter(named), LAWS[0])


def _named(tables: Mapping[str, Any], models: Mapping[str, type[Table]]) -> Iterator[tuple[Path, Law]]:
    """The laws that tables name, ``[run]`` first, with their places; what is no law has a fault of its own."""
    for key in (key for key, model in models.items() if KEY in model.model_fields):
        given = tables.get(key)
        rows = enumerate(given) if isinstance(given, list) else ()
        for path, table in [((key,), given), *(((key, index), row) for index, row in rows)]:
            value = table.get(KEY) if isinstance(table, Mapping) else None
            yield from (((*path, KEY), law) for law in LAWS if law == value)
