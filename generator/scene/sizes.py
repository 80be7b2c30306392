"""Numbers of a scene that are too large or too small to work with, as they are in SI units, whatever they are written
as."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any

from ..effect_base.arithmetic import ExpressionError, Names, free_names, parsed
from ..effect_base.table import Table
from ..effect_base.written_numbers import Measured, read_number
from ..mechanism.links import Parameter
from .check import show
from .errors import Path, Report
from .limits import LARGEST
from .texts import leaves

SQUARES = f"of {1.0 / LARGEST:.0e} to {LARGEST:.0e}, so that its square is one too; take other units"


def check_lengths(
    parameters: Iterable[Parameter],
    tables: Mapping[str, Any],
    models: Mapping[str, type[Table]],
    names: Names,
    report: Report,
) -> bool:
    """Whether all lengths (m) have squares, of which distances are made, where some of the ``parameters`` that come of
    the tables have none. A length that has none is a fault at its key, or at the name in ``[let]`` that makes it so
    large. Small ones vanish beside others, and are none."""
    if all(abs(one.value) <= LARGEST for one in parameters):
        return True
    return not _note(_numbers(tables, models, names, ("m",)), tables.get("let"), names, report, 0.0)


def tell_beyond(tables: Mapping[str, Any], models: Mapping[str, type[Table]], names: Names, report: Report) -> bool:
    """Whether any number that measures something has no square, or one of zero; these are faults, likewise."""
    return _note(_numbers(tables, models, names, ()), tables.get("let"), names, report, 1.0 / LARGEST)


def _note(
    numbers: Iterator[tuple[Path, object, float]], let: object, names: Names, report: Report, least: float
) -> bool:
    """Whether some of the numbers are beyond; these are faults, each at its key or at names that make it so."""
    beyond = {name for name, one in names.items() if one and not least <= abs(one) <= LARGEST}
    found = False
    for path, written, number in numbers:
        if number and not least <= abs(number) <= LARGEST:
            found = True
            own = list(_first(written, let if isinstance(let, Mapping) else {}, beyond))
            for name in own:
                report.add(("let", name), f"found {names[name]:g}, expected a number {SQUARES}")
            if not own:
                text = f"{show(written)} ({number:g})" if isinstance(written, str) else f"{number:g}"
                report.add(path, f"found {text}, expected a number {SQUARES}")
    return found


def _first(written: object, let: Mapping[str, object], beyond: Collection[str]) -> Iterator[str]:
    """Names ``beyond`` that a text uses, or in place of such a name those that its own text uses."""
    waiting = _used(written, beyond)
    for name in waiting:
        deeper = _used(let.get(name), beyond)
        waiting += [one for one in deeper if one not in waiting]
        if not deeper:
            yield name


def _used(written: object, beyond: Collection[str]) -> list[str]:
    try:
        used = free_names(parsed(written)) if isinstance(written, str) else ()
        return [name for name in dict.fromkeys(used) if name in beyond]
    except ExpressionError:  # a number with a unit
        return []


def _numbers(
    tables: Mapping[str, Any], models: Mapping[str, type[Table]], names: Names, units: Collection[str]
) -> Iterator[tuple[Path, object, float]]:
    """Numbers in tables that measure these ``units`` alone, or anything where there are none: where each stands, as it
    is written and in SI units. Texts that are no numbers are told elsewhere."""
    for key, model in models.items():
        given = tables.get(key)
        many = enumerate(given) if isinstance(given, list) else [(None, given)]
        for index, table in many:
            path: Path = (key,) if index is None else (key, index)
            for place, value, marks in leaves(model, table) if isinstance(table, Mapping) else ():
                measured = next((mark for mark in marks if isinstance(mark, Measured)), None)
                if measured is None or (units and (*measured.units,) != (*units,)):
                    continue
                number = _read(value, measured, names)
                if number is not None:
                    yield (*path, *place), value, number


def _read(value: object, measured: Measured, names: Names) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return None
    try:
        return float(read_number(value, measured.units, names) if isinstance(value, str) else value)
    except (ExpressionError, OverflowError):
        return None
