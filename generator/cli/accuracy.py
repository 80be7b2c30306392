"""``ccgen cost SCENE``: error against wall time for all methods and tolerances, and which to choose."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from ..compile.compiler import CompileError
from ..package.replace import OutputError
from ..pipeline import generate
from .detail import Detail
from .folders import MODELS, check_folder, check_results, record_results
from .forces import touches
from .progress import progress
from .refusal import Faults, read_option, refusing
from .scene_file import tell_assembly
from .settings import read_set, with_settings

if TYPE_CHECKING:
    from ccgen.runtime.cost.accuracy import Growth, Measured, Reference

LEVELS = (1e-4, 1e-6)
"""Errors for which a method is named besides the one asked for."""
FILES = ("cost.csv", "cost.png")
COLUMNS = (
    "precision",
    "method",
    "drift",
    "rtol",
    "error",
    "impact_error",
    "seconds",
    "us_per_second",
    "steps",
    "evaluations",
)


def price_accuracy(
    scene_file: Path,
    until: str | None,
    error: float,
    drift: bool,
    precisions: Sequence[str],
    out: Path | None,
    detail: Detail,
    settings: Mapping[str, float],
    faults: Faults,
) -> None:
    """Measure the scene, print the table and what to choose, write ``cost.csv`` and ``cost.png`` into a folder."""
    from ccgen.runtime.precision import wider
    from ccgen.runtime.simulation.arguments import check_lasting

    end = faults.of(read_option, until, check_lasting, "s")
    if "wide" in precisions and not wider():
        faults.add(
            "--precision wide: found a machine whose long double is a double, expected a wider one; leave wide out"
        )
    scene = read_set(scene_file, settings, faults)
    if scene and "float" in precisions and touches(scene):
        faults.add(
            "--precision float: found a scene with contacts, expected none: floats are too coarse to find impacts"
        )
    folder = Path("results") / (scene.name if scene else "") if out is None else out
    if scene or out:
        faults.of(check_results, folder, FILES, "--out")
    faults.of(check_folder, MODELS, "folder of models")
    faults.stop_if_any()
    assert scene
    tell_assembly(scene, detail)
    from ccgen.runtime import load_model
    from ccgen.runtime._core import DRIFTS
    from ccgen.runtime.cost.accuracy import compare, growth, refer
    from ccgen.runtime.cost.accuracy_plot import draw_cost
    from ccgen.runtime.simulate import default_method

    with progress(detail) as tell:
        with refusing(CompileError, OutputError):
            names = dict.fromkeys(("double", *precisions, *(("wide",) if wider() else ())))
            models = {name: load_model(generate(scene, MODELS, tell.stage, precision=name)) for name in names}
        models = {
            name: with_settings(model, settings, scene, detail if name == "double" else Detail.NOTHING)
            for name, model in models.items()
        }
        model = models["double"]
        tell.stage("refer")
        with refusing(ValueError):
            parting = growth(model, scene.run.until if end is None else end)
            reference = refer(models.get("wide", model), parting.until)
        tell.stage("measure")
        measured = [
            one
            for name in precisions
            for one in compare(models[name], reference.run, DRIFTS if drift else DRIFTS[:1], tell=tell.counted)
        ]
        with refusing(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            table, picture = (folder / name for name in FILES)
            write_csv(measured, parting.until, table)
            draw_cost(measured, f"{scene.name}, {parting.until:g} s", parting.until, reference.doubt, picture)
            record_results(folder, FILES)
    print_table(measured, parting.until, drift, len(precisions) > 1)
    if not all(math.isfinite(one.worst) for one in measured):
        typer.echo("-: the run ended early, or met other impacts than the reference")
    print_grounds(parting, reference)
    typer.echo(f"written: {table}, {picture}")
    if model.dof == 0 and all(one.worst <= error for one in measured if one.drift == "projected"):
        typer.echo(advice_where_driven(measured, default_method(), scene.run.rtol, parting.until))
        return
    for level in (*(level for level in LEVELS if level > error), error):
        typer.echo(advice(measured, level, parting.until))


def print_table(measured: Sequence[Measured], seconds: float, drift: bool, precision: bool = False) -> None:
    """A row for every method and tolerance."""
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    if precision:
        table.add_column("numbers", no_wrap=True)
    table.add_column("method", no_wrap=True)
    if drift:
        table.add_column("closure", no_wrap=True)
    for title in (
        "rtol",
        "error at the end",
        "of impact times, s",
        "wall time, ms",
        "µs per second",
        "steps",
        "evaluations",
    ):
        table.add_column(title, justify="right", no_wrap=True)
    for one in measured:
        cells = [
            *([one.precision] if precision else []),
            one.method,
            *([one.drift] if drift else []),
            f"{one.rtol:.0e}",
            _number(one.error),
        ]
        cells += [_number(one.impact_error), f"{1e3 * one.seconds:.3f}", f"{1e6 * one.seconds / seconds:.1f}"]
        table.add_row(*cells, str(one.steps), str(one.evaluations))
    Console(width=140, highlight=False, soft_wrap=True).print(table)


def _number(error: float) -> str:
    return f"{error:.1e}" if error < float("inf") else "-"


def print_grounds(parting: Growth, reference: Reference) -> None:
    """What the errors are measured against, and how fast errors grow by themselves."""
    from ccgen.runtime.cost.accuracy import ROUNDING, WORTH

    first, second = reference.run.method, reference.second.method
    numbers = "in wide numbers" if reference.wide else "in doubles too"
    typer.echo(
        f"reference: {first} at rtol {reference.rtol:.0e} {numbers}; {second} at rtol {reference.second_rtol:.0e}, "
        f"a method of another kind, differs from it by {reference.doubt:.1e}: smaller errors mean nothing"
    )
    typer.echo(f"growth: a small error at the start is {parting.factor:.2g} times as large by t = {parting.until:g} s")
    if parting.cut:
        typer.echo(
            f"horizon: compared at t = {parting.until:g} s; later, an error of rounding ({ROUNDING:.0e}) grows beyond "
            f"{WORTH:.0e}, or the run ends"
        )


def advice(measured: Sequence[Measured], error: float, seconds: float) -> str:
    """The sentence that says what to choose."""
    from ccgen.runtime.cost.accuracy import recommend

    best = recommend(measured, error)
    if best is None:
        least = min(measured, key=lambda one: one.worst)
        reached = f"{least.method} at rtol {least.rtol:.0e} reaches {least.worst:.1e}"
        return f"for {error:.0e}: nothing measured is that good; {reached}"
    price = 1e6 * best.seconds / seconds
    numbers = "" if best.precision == "double" else f" in {best.precision} numbers"
    return f"for {error:.0e}: {best.method} at rtol {best.rtol:.0e}{numbers}, about {price:.3g} µs per simulated second"


def advice_where_driven(measured: Sequence[Measured], method: str, rtol: float, seconds: float) -> str:
    """The sentence for a motion that is prescribed altogether, where every tolerance is good enough."""
    worst = max(one.worst for one in measured if one.drift == "projected")
    usual = [one for one in measured if (one.method, one.drift, one.precision) == (method, "projected", "double")]
    kept = min(usual, key=lambda one: abs(math.log(one.rtol / rtol)))
    price = 1e6 * kept.seconds / seconds
    return (
        f"drives and loops give the whole motion: errors are up to {worst:.0e} at every tolerance, which "
        "decides how exactly the drives' work is integrated, and how densely the run is recorded; "
        f"keep the scene's: {kept.method} at rtol {kept.rtol:.0e}, about {price:.3g} µs per simulated second"
    )


def write_csv(measured: Sequence[Measured], seconds: float, path: Path) -> None:
    """The table with all digits."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for one in measured:
            price = 1e6 * one.seconds / seconds
            row = (one.precision, one.method, one.drift, one.rtol, one.error, one.impact_error, one.seconds, price)
            writer.writerow([*row, one.steps, one.evaluations])
