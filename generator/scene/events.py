"""Events that a scene asks for: records of its ``[[event]]`` tables, checked."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Literal

from ..effect_base.arithmetic import ExpressionError, Names, NameWithoutValue, laws_among
from ..effect_base.changing import Changing
from ..effect_base.grammar_of_state import Scope, normal_form, number_or_form, plain
from ..mechanism.links import Parameter
from ..mechanism.mechanism import Mechanism
from .errors import Path, Report
from .event_table import EventTable


@dataclass(frozen=True)
class Event:
    """Instants at which ``when`` comes to zero in a ``direction``.

    ``stop``: at which of them the run ends, 0 for none. ``set`` are paths of parameters and their values from then on,
    numbers or expressions as ``when`` is one. ``on`` and ``off`` are effects that act from then on, and that do not.
    """

    name: str
    when: str
    direction: Literal["rising", "falling", "either"] = "either"
    stop: int = 0
    set: tuple[tuple[str, float | str], ...] = ()
    on: tuple[str, ...] = ()
    off: tuple[str, ...] = ()

    def describe(self) -> str:
        """What ``ccgen show`` says of it."""
        way = {"rising": "rises through zero", "falling": "falls through zero", "either": "crosses zero"}
        does = [
            f"{path} is {plain(value) if isinstance(value, str) else format(value, '.6g')}" for path, value in self.set
        ]
        does += [f"{name} is {word}" for word, names in (("on", self.on), ("off", self.off)) for name in names]
        if self.stop:
            does.append("the run ends" + (f" when it has come {self.stop} times" if self.stop > 1 else ""))
        then = f"; then {' and '.join(does)}" if does else ""
        return f"{self.name} where {plain(self.when)} {way[self.direction]}{then}"


def events_of(
    tables: Sequence[tuple[Path, EventTable]], mechanism: Mechanism, names: Names, report: Report
) -> tuple[Event, ...]:
    """The records of the tables; those with faults are left out."""
    found: list[Event] = []
    used: set[str] = set()
    for path, table in tables:
        before = len(report.found)
        number = path[-1]
        name = table.name or f"event_{number}"
        if name in used:
            report.add((*path, "name"), f'found "{name}" a second time, expected a new name; rename one of them')
        used.add(name)
        if table.times is not None and not table.stop:
            report.add((*path, "times"), f"found {table.times} without stop, expected it beside stop = true; add that")
        when = _read((*path, "when"), table.when, mechanism, names, report)
        values: list[tuple[str, float | str]] = []
        for key, value in table.set.items():
            read = _value((*path, "set", key), value, mechanism, names, report)
            values += [] if read is None else [(key, read)]
        if when is not None and len(report.found) == before:
            found.append(
                Event(
                    name,
                    when,
                    table.direction,
                    (table.times or 1) if table.stop else 0,
                    tuple(values),
                    (*table.on,),
                    (*table.off,),
                )
            )
    return tuple(found)


def check_set(
    tables: Sequence[tuple[Path, EventTable]],
    parameters: Mapping[str, Parameter],
    speeds: Collection[str],
    over_time: Mapping[str, Changing],
    report: Report,
) -> None:
    """What events set are parameters of the scene, and numbers that these may have; none of the ``speeds`` with which
    driven joints begin, and nothing that is given ``over_time``."""
    for path, table in tables:
        for key, value in table.set.items():
            place = (*path, "set", key)
            if key in over_time:
                report.add(
                    place,
                    f'found "{key}", which is given over time, {over_time[key].told}, expected the path of a '
                    "parameter; give it a number there",
                )
            elif key.endswith(".on") and key not in parameters:
                report.add(
                    place,
                    f'found "{key}", expected the path of a parameter; to switch an effect write its name in on or off',
                )
            elif key not in parameters:
                ends = [] if "." in key else [one for one in parameters if one.endswith(f".{key}")]
                near = ends[:3] or get_close_matches(key, parameters, 3) or list(parameters)[:3]
                told = " or ".join(f'"{one}"' for one in near)
                report.add(place, f'found "{key}", expected the path of a parameter, as {told}; correct it')
            elif key in speeds:
                report.add(
                    place,
                    f'found "{key}", expected another parameter: a driven joint keeps the speed with which it began; '
                    "give its speed as an expression of t or by rows, or move it by a [[motor]]",
                )
            elif isinstance(value, int | float) and (wanted := _unmet(parameters[key], float(value))):
                report.add(place, f"found {value:g}, expected {wanted}; correct it")


def _unmet(parameter: Parameter, value: float) -> str:
    """What a number outside of a parameter's domain was expected to be."""
    domain = parameter.domain
    missed = []
    if domain.minimum is not None and value < domain.minimum:
        missed.append(f"at least {domain.minimum:g}")
    if domain.above is not None and value <= domain.above:
        missed.append(f"more than {domain.above:g}")
    if domain.maximum is not None and value > domain.maximum:
        missed.append(f"at most {domain.maximum:g}")
    return f"a number that is {' and '.join(missed)}" if missed else ""


def _read(path: Path, text: str, mechanism: Mechanism, names: Names, report: Report) -> str | None:
    try:
        return normal_form(text, Scope(names, mechanism, laws_among(names)))
    except NameWithoutValue:
        return None
    except ExpressionError as error:
        report.add(path, f'found "{text}", expected an expression of the time and the state; {error}')
    return None


def _value(path: Path, value: float | str, mechanism: Mechanism, names: Names, report: Report) -> float | str | None:
    if not isinstance(value, str):
        return float(value)
    try:
        found = number_or_form(value, Scope(names, mechanism, laws_among(names)))
    except NameWithoutValue:
        return None
    except ExpressionError as error:
        report.add(path, f'found "{value}", expected a number, or an expression of the time and the state; {error}')
        return None
    return found if isinstance(found, str) or math.isfinite(found) else None
