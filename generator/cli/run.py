"""``ccgen run SCENE``: simulate, print impacts and audit, write result, plot and player."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from ..compile.compiler import CompileError
from ..package.replace import OutputError
from ..pipeline import generate
from ..program.errors import FoldError
from .detail import Detail
from .folders import MODELS, check_folder, check_results, forget_stale, record_results
from .forces import PICTURE, TABLE, force_files, print_forces, ways_to_write
from .progress import progress
from .refusal import STOPPED_EARLY, fail, refusing
from .report import print_audit, print_contacts, print_impacts, print_warnings
from .scene_file import read, tell_assembly, tell_mobility

if TYPE_CHECKING:
    from ccgen.runtime import Run

FILES = ("result.npz", "plot.png", "player.html")
"""Files of every run."""
GIF = "animation.gif"


def run(
    scene_file: Path,
    until: float | None,
    rtol: float | None,
    method: str | None,
    out: Path | None,
    gif: bool,
    fold: bool = False,
    detail: Detail = Detail.USUAL,
    csv: bool = False,
) -> None:
    """Simulate the scene into the folder ``out``; exit code 3 when the run stopped early.

    Ctrl-C stops a simulation early too: what it has is kept, drawn and printed.
    """
    check_numbers(until, rtol)
    scene = read(scene_file)
    folder = Path("results") / scene.name if out is None else out
    check_results(folder, (*FILES, *((GIF,) if gif else ()), *force_files(scene, csv)), "--out")
    check_folder(MODELS, "folder of models")
    check_method(method)
    tell_assembly(scene, detail)
    tell_mobility(scene, detail)
    from ccgen.runtime import load_model, simulate

    end = scene.run.until if until is None else until
    with progress(detail) as tell:
        with refusing(CompileError, OutputError, FoldError):
            model = load_model(generate(scene, MODELS, tell.stage, fold=fold))
        tell.stage("simulate")
        with refusing(ValueError):
            result = simulate(
                model,
                until=until,
                rtol=rtol,
                method=method,
                progress=lambda t: tell.reached(t, end),
                keep_interrupted=True,
            )
        if not result.success:
            typer.echo(f"{scene.name}: {result.message}", err=True)
        tell.stage("draw")
        with refusing(OSError):
            files, unwritten = write(result, folder, gif, csv)
    if detail is not Detail.NOTHING:
        print_impacts(model, result)
        print_contacts(model, result)
        print_forces(result)
        print_audit(result)
        typer.echo(f"written: {', '.join(str(folder / file) for file in files)}")
    print_warnings(result)
    for name, why in unwritten.items():
        typer.echo(f"{scene.name}: {name} is not written: {why}", err=True)
    if unwritten or not result.success:
        raise typer.Exit(STOPPED_EARLY)


def check_numbers(until: float | None, rtol: float | None) -> None:
    """Stop with exit code 2 unless the numbers asked for can be simulated."""
    if until is not None and not (until > 0.0 and math.isfinite(until)):
        fail(f"--until: found {until}, expected a positive number of seconds; correct it")
    if rtol is not None and not 1e-15 <= rtol < 1.0:
        fail(f"--rtol: found {rtol}, expected a number from 1e-15 to 1; correct it")


def check_method(method: str | None) -> None:
    """Stop with exit code 2 unless the runtime has the ``method``."""
    from ccgen.runtime import methods

    if method is not None and method not in methods():
        fail(f"--method: found {method!r}, expected one of {', '.join(methods())}; choose one")


def write(result: Run, folder: Path, gif: bool, csv: bool) -> tuple[list[str], dict[str, str]]:
    """Write result, plot, player, forces and, if asked, a GIF and a table into ``folder``.

    The names of the files, and of those that cannot be made of this run why not. The numbers are written first: they
    are there whatever can be drawn of them. An older file does not stay in place of one that
    cannot be made.
    """
    folder.mkdir(parents=True, exist_ok=True)
    ways: dict[str, Callable[[Path], object]] = {
        **dict(zip(FILES, (result.save, result.plot, result.animate), strict=True)),
        **({GIF: result.animate} if gif else {}),
        **ways_to_write(result, csv),
    }
    unwritten = {}
    for name, way in ways.items():
        try:
            way(folder / name)
        except ValueError as error:  # as where forces have no solution at an instant that is looked at
            unwritten[name] = str(error)
        else:
            record_results(folder, [name])
    made = [name for name in ways if name not in unwritten]
    forget_stale(folder, {*FILES, GIF, PICTURE, TABLE} - {*made})
    return made, unwritten
