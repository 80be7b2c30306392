"""``ccgen cost SCENE --effects``: each effect's price, from the scene built with it and without it."""

from __future__ import annotations

import csv
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import typer

from ..compile.compiler import CompileError
from ..package.replace import OutputError
from ..pipeline import generate
from ..program.errors import FoldError
from ..scene import Scene
from ..stages import fold_price, less_effect, plan_scene, prices
from .detail import Detail
from .folders import record_results
from .progress import Silence, progress
from .refusal import refusing

if TYPE_CHECKING:
    from ccgen.runtime import Model, Run
    from ccgen.runtime.cost.timing import Price as Measured

    from ..program.prices import Price as Counted
    from ..program.program import Counts

FILE = "effects.csv"
SAME = 1e-6
"""Runs whose ends differ by less than this (m, rad) are the same motion."""
NANO, MICRO = 1e9, 1e6
ROOM = 400
"""Signs that a row may take: no cell is cut."""


@dataclass(frozen=True)
class Priced:
    """One row: operations added, nanoseconds per evaluation, microseconds per simulated second, and what moves."""

    counted: Counted
    evaluation: Measured
    run: Measured
    motion: str


def price_effects(scene: Scene, fold: bool, out: Path | None, detail: Detail = Detail.USUAL) -> None:
    """Measure every effect and folding; print the table, and write it to ``out`` where there is a folder."""
    with progress(detail) as tell, refusing(CompileError, OutputError, FoldError, ValueError):
        rows = measure(scene, fold, tell)
    typer.echo(
        f"{scene.name}{', folded' if fold else ''}: what each effect adds, and what folding changes.\n"
        "Times: the least of all rounds; added: the median difference within a round ± half of the middle half."
    )
    print_prices(rows)
    if out is not None:
        with refusing(OSError):
            write(rows, out)
            record_results(out, [FILE])
        typer.echo(f"written: {out / FILE}")


def measure(scene: Scene, fold: bool, tell: Silence) -> list[Priced]:
    """One row per effect, in the order of the scene, and one for folding."""
    from ccgen.runtime.cost.timing import evaluation_times, price, run_times

    tell.stage("counting operations")
    counted = [*prices(scene, fold), fold_price(scene, fold)]
    with tempfile.TemporaryDirectory(prefix="ccgen-") as folder:
        models = list(_build(scene, fold, Path(folder), tell))
    tell.stage("timing runs")
    runs, seconds = run_times(models)
    reached = np.array([[run.t[-1] or np.nan] for run in runs])
    tell.stage("timing evaluations")
    evaluation, simulated = NANO * evaluation_times(models, runs[0]), MICRO * seconds / reached
    rows = []
    for index, operations in enumerate(counted):
        # the last pair is the model and its other form; whichever of them is folded is the one with the fold
        pair = (index + 1, 0) if index + 1 < len(counted) or fold else (0, index + 1)
        times = [price(figures[pair[0]], figures[pair[1]]) for figures in (evaluation, simulated)]
        rows.append(Priced(operations, times[0], times[1], _motion(runs[0], runs[index + 1])))
    return rows


def _build(scene: Scene, fold: bool, folder: Path, tell: Silence) -> Iterator[Model]:
    """The model, those without one effect each, and the model folded the other way, all by the plan of the model."""
    from ccgen.runtime import load_model

    choice = plan_scene(scene, fold=fold)[1]
    variants = [("the model", scene, choice, fold)]
    variants += [
        (f"without {e.title}", *less_effect(scene, index, choice, fold), fold) for index, e in enumerate(scene.effects)
    ]
    variants.append(("not folded" if fold else "folded", scene, choice, not fold))
    for number, (what, variant, same, folded) in enumerate(variants):
        tell.stage(f"building {number + 1} of {len(variants)}, {what}")
        own = plan_scene(variant, fold=folded)[1]
        plan = None if own.plan == same.plan else same.plan.name
        yield load_model(generate(variant, folder / str(number), fold=folded, plan=plan))


def _motion(run: Run, other: Run) -> str:
    """Whether the other run is the same motion, and whether it stopped early."""
    if not other.success:
        return f"another, stops at {other.t[-1]:.4g} s"
    own = [run.model.q_names.index(name) for name in other.model.q_names]  # less what the effect integrates
    if run.t[-1] == other.t[-1] and float(np.max(np.abs(run.q[-1, own] - other.q[-1]))) <= SAME:
        return "the same"
    return "another"


def print_prices(rows: Sequence[Priced]) -> None:
    """The rows as a table."""
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column("\neffect", no_wrap=True)
    for title in (*("operations of\nacceleration", "\nenergy, power", "\nevents"), "ns per evaluation\nwithout"):
        table.add_column(title, justify="right", no_wrap=True)
    for title in ("\nwith", "\nadds", "µs per simulated s\nwithout", "\nwith", "\nadds"):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("motion\nwithout it", no_wrap=True)
    for row in rows:
        operations = [_operations(counts) for counts in row.counted.added.values()]
        times = [cell for measured in (row.evaluation, row.run) for cell in _cells(measured)]
        table.add_row(row.counted.title, *operations, *times, row.motion)
    Console(width=ROOM, highlight=False, soft_wrap=True).print(table)


def _operations(counts: Counts) -> str:
    """Operations, then sines and other functions where there are any."""
    others = [f"{number:+d} {what}" for number, what in ((counts.angles, "sin"), (counts.functions, "fn")) if number]
    return ", ".join([f"{counts.total:+d}" if counts.total else "0", *others])


def _cells(measured: Measured) -> tuple[str, ...]:
    if not np.isfinite(measured.added):
        return ("-", "-", "-")
    digits = max(0, 1 - int(np.floor(np.log10(max(measured.spread, 0.01)))))
    added = f"{measured.added:+.{digits}f} ± {measured.spread:.{digits}f}"
    return (f"{measured.without:.{digits}f}", f"{measured.with_:.{digits}f}", added)


def write(rows: Sequence[Priced], folder: Path) -> None:
    """The rows as ``effects.csv`` in the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    kinds = ("sums", "products", "quotients", "sines", "functions")
    groups = [group.replace(" ", "_") for group in rows[0].counted.added]
    columns = ["effect", *(f"{group}_{kind}" for group in groups for kind in kinds)]
    columns += [f"{unit}_{what}" for unit in ("ns", "us_per_s") for what in ("without", "with", "added", "spread")]
    with (folder / FILE).open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow([*columns, "motion"])
        for row in rows:
            operations = [number for counts in row.counted.added.values() for number in astuple(counts)]
            times = [f"{value:.6g}" for m in (row.evaluation, row.run) for value in vars(m).values()]
            table.writerow([row.counted.title, *operations, *times, row.motion])
