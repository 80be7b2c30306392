"""``ccgen cost SCENE --gradient``: error of a gradient against wall time, by differences and along the run."""

from __future__ import annotations

import csv
import tempfile
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from ..compile.compiler import CompileError
from ..package.replace import OutputError
from ..pipeline import generate
from .detail import Detail
from .folders import check_results, record_results
from .progress import progress
from .refusal import Faults, fail, read_option, refusing
from .scene_file import tell_assembly
from .settings import check_parameter, read_set, with_settings

if TYPE_CHECKING:
    from ccgen.runtime.cost.gradient import Columns, Measured

    from ..scene import Scene

FILES = ("gradient.csv", "gradient.png")
COLUMNS = ("way", "rtol", "step", "error", "seconds")


def price_gradient(
    scene_file: Path,
    until: str | None,
    by: str | None,
    out: Path | None,
    detail: Detail,
    settings: Mapping[str, float],
    faults: Faults,
) -> None:
    """Measure derivatives of the scene's end, print the tables, write ``gradient.csv`` and ``gradient.png``."""
    from ccgen.runtime.simulation.arguments import check_lasting

    asked = faults.of(read_option, until, check_lasting, "s")
    scene = read_set(scene_file, settings, faults)
    if scene and by is not None:
        faults.of(_check_names, by, scene)
    folder = Path("results") / (scene.name if scene else "") if out is None else out
    if scene or out:
        faults.of(check_results, folder, FILES, "--out")
    faults.stop_if_any()
    assert scene
    tell_assembly(scene, detail)
    from ccgen.runtime import load_model, simulate
    from ccgen.runtime.cost.gradient import compare, refer
    from ccgen.runtime.cost.gradient_plot import draw_gradient
    from ccgen.runtime.precision import wider

    end, rtol = scene.run.until if asked is None else asked, scene.run.rtol
    with progress(detail) as tell, tempfile.TemporaryDirectory(prefix="ccgen-") as place:
        with refusing(CompileError, OutputError):
            models = [load_model(generate(scene, Path(place), tell.stage, derivatives=True))]
            if wider():
                models.append(load_model(generate(scene, Path(place), tell.stage, precision="wide")))
        model, *wide = (
            with_settings(one, settings, scene, Detail.NOTHING if k else detail) for k, one in enumerate(models)
        )
        run = simulate(model, until=end)
        if not run.success:
            fail(f"{scene.name}: {run.message}; choose an earlier end: --until")
        columns = _columns(model, by, end)
        tell.stage("refer")
        with refusing(ValueError):
            reference = refer(model, wide[0] if wide else None, columns.names, end)
        tell.stage("measure")
        measured = compare(model, columns.names, end, rtol, reference.jacobian, tell.counted)
    with refusing(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        table, picture = (folder / name for name in FILES)
        write_csv(measured, table)
        rows, count = reference.jacobian.shape
        title = f"{scene.name}: one number of {rows} coordinates at {end:g} s, by {count} numbers"
        draw_gradient(measured, title, rtol, reference.doubt, picture)
        record_results(folder, FILES)
    print_tables(measured)
    tell_left(columns)
    typer.echo(
        f"derived: one number, a weighted sum of {rows} coordinates at t = {end:g} s, by {count} numbers of "
        f"{', '.join(columns.names[:6])}{', …' if len(columns.names) > 6 else ''}"
    )
    typer.echo(f"reference: {reference.text} {reference.doubt:.1e}: smaller errors mean nothing")
    typer.echo(f"written: {table}, {picture}")
    for line in advice(measured, rtol):
        typer.echo(line)


def _names(by: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in by.split(","))


def _check_names(by: str, scene: Scene) -> None:
    """Stop with exit code 2 unless all are starts, inputs, or parameters of models of the scene, each of them once."""
    from ccgen.runtime.sensitivity.moving import STARTS

    known, faults = (*STARTS, *(one for effect in scene.effects for one in effect.inputs())), Faults()
    for name, times in Counter(_names(by)).items():
        if not name:
            faults.add(f'--by: found "{by}", expected names with a comma between two of them, such as u0,gravity.g')
            continue
        if times > 1:
            faults.add(f"--by: {name}: found {times} times, expected once; leave the others out")
        if name not in known:
            faults.of(check_parameter, name, scene, "--by")
    faults.stop_if_any()


def _columns(model: object, by: str | None, end: float) -> Columns:
    """All by which the run has derivatives, or what is asked for; exit code 2 where there is none."""
    from ccgen.runtime import Model, run_function
    from ccgen.runtime.cost.gradient import Columns, columns_of

    assert isinstance(model, Model)
    if by is None:
        columns = columns_of(model, end)
        if not columns.names:
            name, why = next(iter(columns.left.items()))
            fail(f"{model.name}: found nothing by which the run has derivatives; by {name}: {why}")
        return columns
    names = _names(by)
    try:
        function = run_function(model, names, "q", until=end)
        function.jacobian(function.x0)
    except (KeyError, ValueError) as error:
        fail("\n".join(f"--by {by}: {line}" for line in str(error).splitlines()))
    return Columns(names, {})


def print_tables(measured: Sequence[Measured]) -> None:
    """Errors of differences, a row for each step; and derivatives along the run, a row for each tolerance."""
    from rich.console import Console
    from rich.table import Table

    console = Console(width=140, highlight=False, soft_wrap=True)
    from ccgen.runtime.cost.gradient import DIFFERENCES, WAYS

    differences = [one for one in measured if one.way in DIFFERENCES]
    kinds = list(dict.fromkeys((one.way, one.rtol) for one in differences))
    table = Table("step", box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for way, rtol in kinds:
        table.add_column(f"{way}, rtol {rtol:.0e}", justify="right", no_wrap=True)
    errors = {(one.way, one.rtol, one.step): one.error for one in differences}
    for step in dict.fromkeys(one.step for one in differences):
        table.add_row(f"{step:.1e}", *(_number(errors[(*kind, step)]) for kind in kinds))
    console.print(table)
    console.print()
    along = WAYS[len(DIFFERENCES) :]
    table = Table("rtol", box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for way in along:
        for title in ("error", "wall time, ms"):
            table.add_column(f"{way}: {title}", justify="right", no_wrap=True)
    found = {(one.way, one.rtol): (_number(one.error), f"{1e3 * one.seconds:.2f}") for one in measured}
    for rtol in dict.fromkeys(one.rtol for one in measured if one.way in along):
        table.add_row(f"{rtol:.0e}", *(cell for way in along for cell in found[way, rtol]))
    console.print(table)


def _number(error: float) -> str:
    return f"{error:.1e}" if error < float("inf") else "-"


def tell_left(columns: Columns) -> None:
    """What is left out, with the reason of the first, in a line."""
    if columns.left:
        name, why = next(iter(columns.left.items()))
        typer.echo(f"left out: {', '.join(columns.left)}; {name}: {why}")


def advice(measured: Sequence[Measured], rtol: float) -> list[str]:
    """What each way gets at best with the scene's tolerance, and what that takes."""
    from ccgen.runtime.cost.gradient import DIFFERENCES, WAYS, best

    lines = []
    for way in WAYS:
        found = best(measured, way, rtol)
        if found.error == float("inf"):
            lines.append(f"{way} at rtol {rtol:.0e}: no derivatives")
            continue
        step = f" with steps of {found.step:.0e}" if way in DIFFERENCES else ""
        lines.append(f"{way} at rtol {rtol:.0e}: {found.error:.0e} at best{step}, {1e3 * found.seconds:.3g} ms")
    return lines


def write_csv(measured: Sequence[Measured], path: Path) -> None:
    """The table with all digits."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for one in measured:
            writer.writerow((one.way, one.rtol, one.step, one.error, one.seconds))
