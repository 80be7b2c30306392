"""Physics engines beside ccgen: error against time in five motions, and what each engine loses.

Prints a table for each motion; `--write` also puts the figures into docs/data/engines.csv, the chart into
docs/images/engines.png and the tables into docs/accuracy.md, which says how each engine is used. Engines that are not
installed are left out, and said to be. `python benchmarks/engines.py --help` lists the options.
"""

import argparse
import csv
import importlib
import importlib.metadata
import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path

import drake_linkage
import engine_audits
import exudyn_linkage
import mujoco_linkage
import numpy as np
import pymunk_linkage
from driver import ROOT
from engine_cases import CASES, Setting, prepare, strikes_of
from linkage import Linkage
from machine import machine
from workload import Array

from ccgen.runtime import simulate

Flight = Callable[[int, int], Array]


@dataclass(frozen=True)
class Engine:
    """An engine with one set of settings: the package it needs, whether its contacts have a restitution."""

    name: str
    package: str
    bounces: bool
    start: Callable[[Linkage, float], Flight]


ENGINES = (
    Engine("MuJoCo, implicitfast", "mujoco", True, partial(mujoco_linkage.start, integrator="implicitfast")),
    Engine("MuJoCo, RK4", "mujoco", True, partial(mujoco_linkage.start, integrator="RK4")),
    Engine("pymunk, 10 iterations", "pymunk", True, partial(pymunk_linkage.start, iterations=10)),
    Engine("pymunk, 100 iterations", "pymunk", True, partial(pymunk_linkage.start, iterations=100)),
    Engine("Exudyn, generalised α", "exudyn", False, partial(exudyn_linkage.start, solver="generalised alpha")),
    Engine("Exudyn, trapezoidal", "exudyn", False, partial(exudyn_linkage.start, solver="trapezoidal")),
    Engine("Drake, SAP", "drake", False, partial(drake_linkage.start, solver="kSap")),
)
MODULES = {"drake": "pydrake"}
"""Modules that are not called as their packages."""
ELSEWHERE = {
    "Siconos": "not on the package index; it treats impacts and friction in great generality, by steps or events",
}
"""Engines that `pip` does not install, and what they are made for."""
METHODS, TOLERANCES = ("gauss", "dop853"), (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
BASE = ("ccgen, gauss", 1e-8)
"""What the times of a case are compared with."""
LIMIT = 30.0
"""Seconds beyond which a run is not begun, by how long the one before took; its steps are said to be too short."""
SPENT, REPEATS = 0.3, 20
"""Seconds spent on repeating a run, the fastest of which counts."""
FEW = 100
"""A run with so many steps for every look at it is timed with those looks: they cost nothing beside it."""
DOCS = ROOT / "docs"
MARKS = ("<!-- engines -->\n", "<!-- end of engines -->\n")


@dataclass(frozen=True)
class Row:
    """One run: ``step`` is the step (s), of ccgen the tolerance; ``ratio`` is its time over that of ``BASE``.

    ``error`` is the largest in x, y (m) and angle (rad) of any link at the end, of a motion that ends at rest the
    largest height of a corner above or below the floor (m). ``gap`` (m) is the largest of a joint, ``energy`` (J) the
    largest change, and where there are impacts how far it is off at the end. ``missed`` impacts of those compared, and
    how late the others are (s). A run that its engine gave up has times and errors that are not numbers.
    """

    case: str
    tool: str
    step: float
    milliseconds: float
    ratio: float
    error: float
    gap: float
    energy: float
    missed: int
    late: float


def installed(engines: Sequence[Engine] = ENGINES) -> tuple[list[Engine], dict[str, str]]:
    """Engines that are there, and for each package that is not, why."""
    found, missing = [], {}
    for engine in engines:
        try:
            importlib.import_module(MODULES.get(engine.package, engine.package))
            found.append(engine)
        except ImportError as error:
            missing[engine.package] = str(error)
    return found, missing


def versions(engines: Sequence[Engine]) -> str:
    """Packages and their versions."""
    packages = dict.fromkeys(engine.package for engine in engines)
    return ", ".join(f"{package} {importlib.metadata.version(package)}" for package in packages)


def fastest(ready: Callable[[], Callable[[], object]]) -> float:
    """Seconds of a call, the least of several; ``ready`` makes each call, outside of the time."""
    best, spent = math.inf, 0.0
    for _ in range(REPEATS):
        call = ready()
        began = time.perf_counter()
        call()
        took = time.perf_counter() - began
        best, spent = min(best, took), spent + took
        if spent > SPENT:
            break
    return best


def judge(
    setting: Setting, tool: str, step: float, seconds: float, states: Array, found: list[engine_audits.Strike]
) -> Row:
    """The row of a motion, from its states (t, n, 6), the last at the end, and the impacts found in it."""
    linkage, case = setting.linkage, setting.case
    if case.rests:
        error = float(np.max(np.abs(engine_audits.heights(linkage, states[-1]))))
    else:
        error = float(np.max(np.abs(states[-1, :, :3] - setting.end)))
    if case.impacts:
        lost = abs(float(engine_audits.energy(linkage, states[-1])) - setting.energy)
    else:
        lost = engine_audits.drift(linkage, states)
    missed, late = engine_audits.compare(found, setting.impacts)
    return Row(case.name, tool, step, 1e3 * seconds, math.nan, error, engine_audits.gap(linkage, states),
               lost, missed, late)  # fmt: skip


def ours(setting: Setting, tolerances: Sequence[float]) -> list[Row]:
    """Whole calls of `simulate` from Python, by two methods."""
    rows = []
    for method in METHODS:
        for rtol in tolerances:

            def call(m: str = method, r: float = rtol) -> object:
                return simulate(setting.model, until=setting.until, rtol=r, method=m)

            seconds = fastest(lambda c=call: c)  # type: ignore[misc]
            run = simulate(setting.model, until=setting.until, rtol=rtol, method=method)
            found = strikes_of(run) if setting.impacts else []
            rows.append(judge(setting, f"ccgen, {method}", rtol, seconds, setting.states(run), found))
    return rows


def theirs(setting: Setting, engine: Engine, steps: Sequence[float], limit: float) -> list[Row]:
    """An engine at every step, longest first, until one would take longer than ``limit`` seconds."""
    rows: list[Row] = []
    for step in steps:
        if rows and 1e-3 * rows[-1].milliseconds * rows[-1].step / step > limit:
            break
        count = round(setting.until / step)
        every = max(1, count // setting.case.samples)
        flight, began = engine.start(setting.linkage, step), time.perf_counter()
        try:
            seen = flight(count, every)
        except Exception as error:
            print(f"{setting.case.name}, {engine.name}, {step:g} s: given up: {error}", file=sys.stderr)
            rows.append(Row(setting.case.name, engine.name, step, *[math.nan] * 5, 0, math.nan))
            continue
        seconds = time.perf_counter() - began
        if every < FEW:
            seconds = fastest(lambda s=step, c=count: partial(engine.start(setting.linkage, s), c, c))  # type: ignore[misc]
        found = engine_audits.strikes(setting.linkage, seen, step) if setting.impacts else []
        rows.append(judge(setting, engine.name, step, seconds, seen, found))
    return rows


def with_ratios(rows: Sequence[Row]) -> list[Row]:
    """The rows of a case with their times over that of ``BASE``."""
    base = next(row.milliseconds for row in rows if (row.tool, row.step) == BASE)
    return [Row(**{**vars(row), "ratio": row.milliseconds / base}) for row in rows]


def measure(quick: bool, limit: float, only: Sequence[str]) -> tuple[list[Row], str]:
    """All rows, and a line on what was left out."""
    engines, missing = installed()
    rows: list[Row] = []
    for case in CASES:
        if case.name not in only:
            continue
        setting = prepare(case, quick)
        print(f"{case.title}: reference known to {setting.doubt:.0e}", file=sys.stderr, flush=True)
        found = ours(setting, TOLERANCES)
        for engine in engines:
            if case.impacts and not engine.bounces:
                continue
            found += theirs(setting, engine, case.steps[: 2 if quick else None], limit)
        rows += with_ratios(found)
    left = [f"{package} (not installed: {why})" for package, why in missing.items()]
    left += [f"{name} ({why})" for name, why in ELSEWHERE.items()]
    return rows, f"left out: {'; '.join(left)}"


def read(path: Path) -> list[Row]:
    """Rows of a table that ``save`` has written."""
    with path.open(newline="") as file:
        return [Row(**{f.name: _typed(f.type, line[f.name]) for f in fields(Row)}) for line in csv.DictReader(file)]


def _typed(kind: object, text: str) -> object:
    return text if kind in (str, "str") else int(text) if kind in (int, "int") else float(text)


def save(rows: Sequence[Row], path: Path) -> None:
    """The rows as CSV, with as many digits as mean something."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([f.name for f in fields(Row)])
        for row in rows:
            times = (f"{row.step:.0e}", f"{row.milliseconds:.3g}", f"{row.ratio:.3g}")
            writer.writerow([row.case, row.tool, *times, *(f"{x:.1e}" for x in (row.error, row.gap, row.energy)),
                             row.missed, f"{row.late:.1e}"])  # fmt: skip


def shown(rows: Sequence[Row]) -> list[Row]:
    """Of each tool in each case the run with the longest steps, the one with the shortest, and one of a millisecond."""
    found = []
    for key in dict.fromkeys((row.case, row.tool) for row in rows):
        own = [row for row in rows if (row.case, row.tool) == key]
        kept = {own[0].step, own[-1].step, BASE[1] if own[0].tool.startswith("ccgen") else 1e-3}
        found += [row for row in own if row.step in kept]
    return found


def table(rows: Sequence[Row], case: str) -> str:
    """The rows of a case as markdown."""
    own = [row for row in rows if row.case == case]
    bounces = any(row.missed or row.late for row in own)
    heads = [
        "",
        "step, s",
        "ms",
        "of ccgen's time",
        "error",
        "joints open, m",
        "energy off at the end, J" if bounces else "energy drifts, J",
    ]
    heads += ["impacts missed", "late, s"] if bounces else []
    lines = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
    for row in own:
        step = f"rtol {row.step:.0e}" if row.tool.startswith("ccgen") else f"{row.step:.0e}"
        if math.isnan(row.error):
            lines.append("| " + " | ".join([row.tool, step, "given up", *["–"] * (len(heads) - 3)]) + " |")
            continue
        cells = [row.tool, step, f"{row.milliseconds:.3g}", f"{row.ratio:.2g}"]
        cells += [f"{x:.0e}" for x in (row.error, row.gap, row.energy)]
        cells += [str(row.missed), f"{row.late:.0e}"] if bounces else []
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def tables(rows: Sequence[Row]) -> str:
    """A heading and a table for every case that there are rows of."""
    titles = {case.name: case.title for case in CASES}
    present = dict.fromkeys(row.case for row in rows)
    return "\n\n".join(f"**{titles[case]}**\n\n{table(shown(rows), case)}" for case in present)


def write(rows: Sequence[Row], said: str) -> None:
    """The CSV, the chart, and the tables between the marks of docs/accuracy.md."""
    import engines_chart

    save(rows, DOCS / "data" / "engines.csv")
    kept = read(DOCS / "data" / "engines.csv")
    engines_chart.draw(kept, {case.name: case.title for case in CASES}, DOCS / "images" / "engines.png")
    page = DOCS / "accuracy.md"
    before, _, rest = page.read_text().partition(MARKS[0])
    _, _, after = rest.partition(MARKS[1])
    page.write_text(f"{before}{MARKS[0]}{said}\n\n{tables(kept)}\n{MARKS[1]}{after}")


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="shorter motions and the longer steps: a minute")
    parser.add_argument("--limit", type=float, default=LIMIT, metavar="S", help="seconds that one run may take")
    parser.add_argument("--cases", nargs="+", choices=[c.name for c in CASES], default=[c.name for c in CASES])
    parser.add_argument("--write", action="store_true", help="write table, chart and page into docs/")
    parser.add_argument("--csv", type=Path, metavar="PATH", help="also write all rows there")
    options = parser.parse_args()
    rows, left = measure(options.quick, options.limit, options.cases)
    engines, _ = installed()
    said = f"{machine()}; {versions(engines) or 'no engine'}"
    print(f"{said}\n{left}\n\n{tables(rows)}")
    if options.csv:
        save(rows, options.csv)
    if options.write:
        write(rows, said)


if __name__ == "__main__":
    main()
