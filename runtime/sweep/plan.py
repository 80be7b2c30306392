"""What a sweep is to do: which numbers vary and how, what is observed, how runs go (docs/sweep.md)."""

from __future__ import annotations

import csv
import math
import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..ensemble.observed import read_observed
from ..extras import needed
from ..faults import sentence
from ..files import read_path
from ..model.model import Model
from ..simulation.one_run import options_of
from .samples import SAMPLERS, Samples
from .starts import AT_START, start_names
from .written import Plain, Written

RUN = ("until", "rtol", "atol", "method", "step", "drift", "on_gain")
"""Keys of ``[run]``: arguments of ``simulate``."""
KEYS = ("observe", "at", "times", "part", "combine", "run", "vary", "table", "sample")
VARY = ("parameter", "start", "values", "from", "to", "count", "scale", "mean", "deviation")
PART = 10_000
"""Runs in a file of results unless a plan says otherwise."""
MOST = 10**9
"""Runs of a plan."""
SCALES = ("linear", "log")


Locate = Callable[[str], Mapping[tuple[str | int, ...], int]]
"""The lines (from 1) at which keys stand in a TOML text, by their paths, as ``("vary", 0, "count")``."""
STEP = re.compile(r"([\w-]+)((?:\[\d+\])*)")
"""A part of a key as faults write it, ``vary[0]``."""


class PlanError(ValueError):
    """A plan that cannot be carried out, with all that is wrong, a line each."""


@dataclass(frozen=True)
class Distribution:
    """How a coordinate of the unit cube becomes a value: uniform or logarithmic between two, or normal."""

    kind: str
    one: float
    two: float

    def of(self, x: FloatArray) -> FloatArray:
        """The values at x (n,) in the unit interval."""
        if self.kind == "linear":
            return self.one + x * (self.two - self.one)
        if self.kind == "log":
            return np.asarray(np.exp(math.log(self.one) + x * (math.log(self.two) - math.log(self.one))))
        return np.asarray(self.one + self.two * needed("scipy.special", "a normal distribution").ndtri(x))


@dataclass(frozen=True, eq=False)
class Axis:
    """Numbers that vary together: ``columns`` of values by name, or ``drawn`` from ``samples`` by distributions."""

    size: int
    columns: Mapping[str, FloatArray]
    drawn: Mapping[str, Distribution]
    samples: Samples | None = None

    def rows(self, rows: Any) -> dict[str, FloatArray]:
        """Values of the columns in some rows (n,)."""
        if self.samples is None:
            return {name: values[rows] for name, values in self.columns.items()}
        low, high = int(rows.min()), int(rows.max()) + 1
        points = self.samples.rows(low, high)[rows - low]
        return {name: one.of(points[:, k]) for k, (name, one) in enumerate(self.drawn.items())}


@dataclass(frozen=True, eq=False)
class Plan:
    """A plan that has been read and fits a model: ``count`` runs, whose numbers :meth:`rows` gives."""

    file: str
    text: str
    axes: tuple[Axis, ...]
    grid: bool
    names: tuple[str, ...]
    observe: tuple[str, ...]
    at: tuple[float, ...] | None
    run: Mapping[str, Any]
    part: int
    count: int

    def rows(self, first: int, last: int) -> dict[str, FloatArray]:
        """Numbers of the runs ``first`` to ``last`` by name, (last - first,) each.

        Of a grid the last axis moves from run to run."""
        runs = np.arange(first, last)
        shape = tuple(axis.size for axis in self.axes)
        places = np.unravel_index(runs, shape) if self.grid else (runs,) * len(self.axes)
        found: dict[str, FloatArray] = {}
        for axis, place in zip(self.axes, places, strict=True):
            found |= axis.rows(place)
        return {name: found[name] for name in self.names}


def read_plan(path: Any, model: Model, written: Written | None = None, locate: Locate | None = None) -> Plan:
    """The plan in a TOML file, for runs of ``model``; numbers that are texts, as "20 deg", are read by ``written``, and
    faults have the lines that ``locate`` finds.

    Raises :class:`PlanError` with all that is wrong with it."""
    file = read_path(path, "a plan")
    try:
        text = file.read_text(encoding="utf-8")
        tables = tomllib.loads(text)
    except FileNotFoundError:
        raise PlanError(f"{file}: found no file, expected a plan; correct the name") from None
    except (OSError, UnicodeDecodeError) as error:
        raise PlanError(f"{file}: cannot be read: {error}") from error
    except tomllib.TOMLDecodeError as error:
        raise PlanError(f"{file}: found no TOML: {error}; correct it") from error
    return plan_of(tables, model, str(file), text, file.parent, written, locate)


def plan_of(
    tables: Mapping[str, Any],
    model: Model,
    file: str,
    text: str,
    beside: Path,
    written: Written | None = None,
    locate: Locate | None = None,
) -> Plan:
    """The plan that ``tables`` are; files that it names are found from the folder ``beside``."""
    reader = _Reader(tables, model, file, beside, written)
    plan = reader.read(text)
    if reader.faults:
        lines = locate(text) if locate is not None else {}
        raise PlanError("\n".join(f"{file}{_place(fault, lines)}: {fault}" for fault in reader.lines()))
    assert plan is not None
    return plan


def _place(fault: str, lines: Mapping[tuple[str | int, ...], int]) -> str:
    """``:12`` where the key that a fault begins with, or the closest table of it, stands in line 12; nothing where it
    begins with none, as with the name of a CSV file."""
    path: tuple[str | int, ...] = ()
    place = ""
    key, _, rest = fault.partition(": ")
    argument = rest.partition(":")[0]
    for step in (*key.split("."), *([argument] if key == "run" else [])):
        match = STEP.fullmatch(step)
        if match is None:
            break
        for part in (match[1], *map(int, re.findall(r"\d+", match[2]))):
            path += (part,)
            place = f":{lines[path]}" if path in lines else place
    return place


class _Reader:
    """Reads tables key by key and collects what is wrong."""

    def __init__(
        self, tables: Mapping[str, Any], model: Model, file: str, beside: Path, written: Written | None
    ) -> None:
        plain = None if written is None else Plain(written)
        self.tables = tables if plain is None else plain.of(tables)
        self.model, self.file, self.beside = model, file, beside
        self.told: dict[str, str] = {} if plain is None else plain.faults
        self.found: list[str] = list(self.told.values())
        self.starts = start_names(model)
        self.names: list[str] = []

    @property
    def faults(self) -> bool:
        return bool(self.found)

    def lines(self) -> list[str]:
        return list(dict.fromkeys(self.found))

    def add(self, key: str, found: Any, expected: str) -> None:
        self.found.append(self.told.get(key) or f"{key}: found {found!r}, expected {expected}")

    def collect(self, key: str, call: Any, *given: Any, **named: Any) -> Any:
        try:
            return call(*given, **named)
        except (ValueError, TypeError, KeyError, OSError) as error:
            for line in sentence(error).splitlines():
                self.found.append(f"{key}: {line}" if key else line)
            return None

    def known(self, table: Mapping[str, Any], keys: Sequence[str], where: str) -> None:
        for key in table:
            if key not in keys:
                self.found.append(f"{where}{key}: found an unknown key, expected one of {', '.join(keys)}")

    def read(self, text: str) -> Plan | None:
        tables = self.tables
        self.known(tables, KEYS, "")
        run = self.table("run")
        self.known(run, RUN, "run.")
        options = self.collect(
            "run",
            options_of,
            self.model,
            inputs=None,
            progress=None,
            keep_interrupted=True,
            **{key: run.get(key) for key in RUN},
        )
        observe = tables.get("observe", [])
        if not isinstance(observe, list) or not all(isinstance(name, str) for name in observe):
            self.add("observe", observe, 'a list of names, as ["crank.angle", "impacts"]')
            observe = []
        at = self.at(options.settings.until) if options is not None else None
        if options is not None:
            self.collect("", read_observed, self.model, observe, at, options.settings.until)
        part = tables.get("part", PART)
        if isinstance(part, bool) or not isinstance(part, int) or part < 1:
            self.add("part", part, "a number of runs, at least 1")
        axes = self.axes()
        combine = tables.get("combine", "grid")
        if combine not in ("grid", "rows"):
            self.add(
                "combine", combine, "grid, all combinations, or rows, the first of each, then the second, and so on"
            )
        if not axes and not self.found:
            self.found.append("vary: found nothing that varies, expected [[vary]] or [table]")
        sizes = [axis.size for axis in axes]
        if combine == "rows" and len(set(sizes)) > 1:
            sized = ", ".join(f"{' and '.join([*axis.columns, *axis.drawn])} of {axis.size}" for axis in axes)
            self.found.append(f"combine: found rows beside {sized}, expected equally many of all")
        count = math.prod(sizes) if combine == "grid" else max(sizes, default=0)
        if count > MOST:
            self.found.append(f"vary: found {count} runs, expected at most {MOST}")
        if self.found:
            return None
        times = None if at is None else tuple(float(t) for t in at)
        names = tuple(self.names)
        return Plan(self.file, text, tuple(axes), combine == "grid", names, tuple(observe), times, run, part, count)

    def table(self, key: str) -> Mapping[str, Any]:
        found = self.tables.get(key, {})
        if isinstance(found, Mapping):
            return found
        self.add(key, found, f"a table [{key}]")
        return {}

    def at(self, until: float) -> Any:
        given, times = self.tables.get("at"), self.tables.get("times")
        if given is not None and times is not None:
            self.found.append("at, times: found both, expected one: times in s, or how many even ones")
        if times is not None and (isinstance(times, bool) or not isinstance(times, int) or times < 2):
            self.add("times", times, "a number of even times from 0 to the end, at least 2")
        elif times is not None:
            return np.linspace(0.0, until, times)
        if given is not None and not (isinstance(given, list) and given and all(map(_is_number, given))):
            self.add("at", given, "a list of times in s")
            return None
        return given

    # -- what varies ----------------------------------------------------------------------------------------------

    def axes(self) -> list[Axis]:
        vary = self.tables.get("vary", [])
        if not isinstance(vary, list) or not all(isinstance(one, Mapping) for one in vary):
            self.add("vary", vary, "tables [[vary]]")
            vary = []
        sampled = "sample" in self.tables
        axes, drawn = [], dict[str, Distribution]()
        for number, one in enumerate(vary):
            where = f"vary[{number}]"
            self.known(one, VARY, f"{where}.")
            name = self.name(one, where)
            if sampled and "values" not in one and "count" not in one:
                distribution = self.distribution(one, where)
                if name and distribution:
                    drawn[name] = distribution
                continue
            values = self.values(one, where)
            if name and values is not None:
                self.check(name, values, where)
                axes.append(Axis(len(values), {name: values}, {}))
        if "table" in self.tables and (axis := self.from_file()):
            axes.append(axis)
        if sampled and (axis := self.sample(drawn)):
            axes.append(axis)
        return axes

    def name(self, one: Mapping[str, Any], where: str) -> str | None:
        given = [key for key in ("parameter", "start") if key in one]
        if len(given) != 1:
            self.found.append(
                f"{where}: found {' and '.join(given) or 'no name'}, expected parameter, a path as crank.mass, or "
                "start, a coordinate or speed of the start"
            )
            return None
        return self.column(one[given[0]], f"{where}.{given[0]}", given[0])

    def column(self, name: Any, where: str, kind: str = "") -> str | None:
        """A parameter's path or a name of the start's, once."""
        if not isinstance(name, str):
            self.add(where, name, "a name")
        elif name in self.names or f"{name}{AT_START}" in self.names:
            self.add(where, name, "each name once")
        elif kind != "start" and name in self.model.data["rests_on"]:
            holds = self.model.data["rests_on"][name]
            self.add(where, name, f"another parameter: only with its value {holds} holds what other joints hold")
        elif kind != "start" and name in self.model.parameters:
            if self.collect(where, self.model.with_parameters, {name: self.model.parameters[name]}) is not None:
                self.names.append(name)
                return name
        elif kind != "parameter" and f"{name}{AT_START}" in self.starts:
            self.names.append(f"{name}{AT_START}")
            return self.names[-1]
        elif kind == "start":
            known = (one.removesuffix(AT_START) for one in self.starts)
            self.add(where, name, f"one of {', '.join(known)}")
        else:
            self.collect(where, self.model.parameters.__getitem__, name)
        return None

    def check(self, name: str, values: FloatArray, where: str) -> None:
        """Values that a parameter cannot have are told at once, not run by run."""
        if name not in self.model.parameters:
            return
        for value in (values.min().item(), values.max().item()):
            self.collect(where, self.model.parameters._checked, name, value)

    def values(self, one: Mapping[str, Any], where: str) -> FloatArray | None:
        if "values" in one:
            given = one["values"]
            if not (isinstance(given, list) and given and all(map(_is_number, given))):
                self.add(f"{where}.values", given, "a list of finite numbers")
                return None
            for key in ("from", "to", "count", "scale", "mean", "deviation"):
                if key in one:
                    self.found.append(f"{where}.{key}: found beside values, expected one of both")
            return np.array(given, dtype=float)
        distribution, count = self.distribution(one, where), one.get("count")
        if isinstance(count, bool) or not isinstance(count, int) or count < 1:
            self.found.append(
                f"{where}.count: found {count!r}, expected how many values there are from the first to the last, or "
                "values, or [sample]"
            )
            return None
        if distribution is None:
            return None
        if distribution.kind == "normal":
            self.found.append(f"{where}.mean: found without [sample], expected from and to")
            return None
        if distribution.kind == "log":
            return np.geomspace(distribution.one, distribution.two, count)
        return np.linspace(distribution.one, distribution.two, count)

    def distribution(self, one: Mapping[str, Any], where: str) -> Distribution | None:
        normal = "mean" in one or "deviation" in one
        keys, before = (("mean", "deviation") if normal else ("from", "to")), len(self.found)
        for key in keys:
            if not _is_number(one.get(key)):
                self.add(f"{where}.{key}", one.get(key), "a finite number")
        for key in ("from", "to", "scale") if normal else ():
            if key in one:
                self.found.append(f"{where}.{key}: found beside mean and deviation, expected one of both")
        scale = one.get("scale", "linear")
        if scale not in SCALES:
            self.add(f"{where}.scale", scale, f"one of {', '.join(SCALES)}")
        if len(self.found) > before:
            return None
        first, second = (float(one[key]) for key in keys)
        if scale == "log" and not (first > 0.0 and second > 0.0):
            self.add(f"{where}.scale", scale, "linear, or from and to above zero")
            return None
        return Distribution("normal" if normal else scale, first, second)

    def sample(self, drawn: Mapping[str, Distribution]) -> Axis | None:
        table, before = self.table("sample"), len(self.found)
        self.known(table, ("by", "count", "seed"), "sample.")
        by, count, seed = table.get("by", "sobol"), table.get("count"), table.get("seed", 0)
        if by not in SAMPLERS:
            self.add("sample.by", by, f"one of {', '.join(SAMPLERS)}")
        for key, value, least in (("count", count, 1), ("seed", seed, 0)):
            if isinstance(value, bool) or not isinstance(value, int) or value < least:
                self.add(f"sample.{key}", value, f"a whole number, at least {least}")
        if not drawn and len(self.found) == before:
            self.found.append(
                "sample: found no [[vary]] with from and to, or mean and deviation, expected at least one"
            )
        for name, one in drawn.items():
            if name in self.model.parameters and one.kind != "normal":
                for value in (one.one, one.two):
                    self.collect("vary", self.model.parameters._checked, name, value)
        if len(self.found) > before:
            return None
        assert isinstance(count, int)
        return Axis(count, {}, drawn, Samples(by, len(drawn), count, seed))

    def from_file(self) -> Axis | None:
        """Columns of a CSV file, whose heading has their names."""
        table = self.table("table")
        self.known(table, ("file",), "table.")
        name = table.get("file")
        if not isinstance(name, str):
            self.add("table.file", name, "the name of a CSV file")
            return None
        file = self.beside / name
        try:
            with file.open(newline="", encoding="utf-8") as opened:
                heading, *rows = [row for row in csv.reader(opened) if row]
        except (OSError, UnicodeDecodeError, csv.Error, ValueError) as error:
            self.add("table.file", name, f"a CSV file with a heading and rows ({error})")
            return None
        names, before = [self.column(one.strip(), f"{file}: heading") for one in heading], len(self.found)
        if not rows:
            self.found.append(f"{file}: found no rows below the heading, expected at least one")
        columns: list[list[float]] = [[] for _ in heading]
        for number, row in enumerate(rows, start=2):
            if len(row) != len(heading):
                self.found.append(f"{file}, row {number}: found {len(row)} values, expected {len(heading)}")
                continue
            for column, value in zip(columns, row, strict=True):
                try:
                    column.append(float(value))
                except ValueError:
                    self.add(f"{file}, row {number}", value, "a number")
                if column and not math.isfinite(column[-1]):
                    self.add(f"{file}, row {number}", value, "a finite number")
        if len(self.found) > before or None in names:
            return None
        found = {name: np.array(column) for name, column in zip(names, columns, strict=True) if name}
        for one, values in found.items():
            self.check(one, values, str(file))
        return Axis(len(rows), found, {})


def _is_number(x: Any) -> bool:
    return isinstance(x, int | float) and not isinstance(x, bool) and math.isfinite(x)
