"""``ccgen run SCENE``: simulate, print impacts and audit, write result, plot and player."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from ..compile.compiler import CompileError
from ..package.replace import OutputError
from ..pipeline import generate
from ..program.errors import FoldError
from .contact_files import IMPACTS, PHASES, contact_files, ways_to_write_contacts
from .detail import Detail
from .folders import MODELS, RECORD, check_folder, check_results, forget_stale, record_results
from .forces import PICTURE, TABLE, Told, force_files, print_drives, print_forces, ways_to_write
from .outputs import PICTURE as OUTPUTS_PICTURE
from .outputs import TABLE as OUTPUTS_TABLE
from .outputs import Wanted
from .progress import progress
from .refusal import STOPPED_EARLY, Faults, fail, read_option, refusing, refusing_options, told
from .remarks import print_remarks
from .report import (
    print_audit,
    print_contacts,
    print_events,
    print_impacts,
    print_missing,
    print_trace,
    print_warnings,
)
from .scene_file import tell_assembly, tell_mobility
from .settings import read_set, with_settings

if TYPE_CHECKING:
    from ccgen.runtime import Run

    from ..scene.scene import Scene

FILES = ("result.npz", "plot.png", "player.html")
"""Files of every run."""
GIF, VIDEO = "animation.gif", "animation.mp4"
MOVING = (GIF, VIDEO)
"""Those of them that are asked for."""
INTERRUPTED = "interrupted"
"""Why a file is not written, where Ctrl-C has left it out."""


@dataclass(frozen=True)
class Asked:
    """How a run is to go, as its options say."""

    until: str | None
    rtol: str | None
    method: str | None
    step: str | None
    trace: bool = False

    def read(self, faults: Faults) -> dict[str, Any]:
        """The arguments of :func:`ccgen.runtime.simulate` for that; ``faults`` get what is wrong with them."""
        from ccgen.runtime.simulation.arguments import check_method, check_positive, check_rtol, check_until

        def check_length(step: object) -> None:
            check_positive("step", step, " of seconds")

        def check_name() -> None:
            if self.method is not None:
                with refusing_options():
                    check_method(self.method, self.step)

        until = faults.of(read_option, self.until, check_until, "s")
        rtol = faults.of(read_option, self.rtol, check_rtol)
        faults.of(check_name)
        step = faults.of(read_option, self.step, check_length, "s")
        return {"until": until, "rtol": rtol, "method": self.method, "step": step}


def run(
    scene_file: Path,
    asked: Asked,
    out: Path | None,
    moving: Sequence[str],
    fold: bool,
    detail: Detail,
    wanted: Wanted,
    csv: bool,
    settings: Mapping[str, float],
    faults: Faults,
) -> None:
    """Simulate the scene into the folder ``out``, with those of the ``MOVING`` pictures; exit code 3 when the run
    stopped early.

    Ctrl-C stops a simulation early too: what it has is kept, drawn and printed.
    """
    arguments = asked.read(faults)
    scene = read_set(scene_file, settings, faults, fold=fold)
    folder = Path("results") / (scene.name if scene else "") if out is None else out
    wanted = wanted.beside(scene, scene_file) if scene else wanted
    names = (
        *FILES,
        *moving,
        *wanted.files,
        *(force_files(scene, csv) + contact_files(scene, csv) if scene else ()),
    )
    if scene or out:
        faults.of(check_results, folder, names, "--out")
    faults.of(check_folder, MODELS, "folder of models")
    if VIDEO in moving:
        faults.of(check_video)
    end = scene.run.until if scene and asked.until is None else arguments["until"]
    if arguments["step"] is not None and end is not None:
        faults.of(check_reach, arguments["step"], end)
    if scene:
        faults.of(wanted.check_scene, scene)
    faults.stop_if_any()
    assert scene
    tell_assembly(scene, detail)
    shared = tell_mobility(scene, detail)
    from ccgen.runtime import load_model, simulate

    with progress(detail) as tell:
        with refusing(CompileError, OutputError, FoldError):
            model = load_model(generate(scene, MODELS, tell.stage, fold=fold))
        model = with_settings(model, settings, scene, detail)
        wanted.check(model)
        tell.stage("simulate")
        with refusing(ValueError):
            result = simulate(
                model,
                **arguments,
                progress=lambda t: tell.reached(t, end),
                keep_interrupted=True,
            )
        if not result.success:
            typer.echo(f"{scene.name}: {result.message}", err=True)
        if detail is not Detail.NOTHING and result.message.endswith("interrupted"):
            typer.echo("what there is is written now; Ctrl-C again leaves out forces and pictures", err=True)
        tell.stage("draw")
        with refusing(OSError):
            forces = Told(result, shared, detail is Detail.ALL)
            tables = contact_files(scene, csv)
            files, unwritten, removed = write(result, folder, moving, wanted, csv, forces, tables, titled(settings))
    if detail is not Detail.NOTHING:
        print_results(scene, None if INTERRUPTED in unwritten.values() else forces, result, asked.trace)
        typer.echo(f"written: {', '.join(str(folder / file) for file in files) or 'nothing'}")
        if removed:
            typer.echo(f"removed, as of the run before: {', '.join(str(folder / file) for file in removed)}")
    print_warnings(result)
    if detail is not Detail.NOTHING:
        print_remarks(scene, result)
    for name, why in unwritten.items():
        typer.echo(f"{scene.name}: {name} is not written: {why}", err=True)
    if unwritten or not result.success:
        raise typer.Exit(STOPPED_EARLY)


def print_results(scene: Scene, forces: Told | None, result: Run, trace: bool) -> None:
    """What has come, in what order, with what ``forces`` if these are told, how exact that is, and if asked its
    ``trace``."""
    print_impacts(result.model, result)
    print_events(result)
    print_missing(scene, result)
    print_contacts(result.model, result)
    if forces is None:
        typer.echo("forces: interrupted")
    else:
        print_forces(forces)
        print_drives(forces)
    print_audit(result)
    print_trace(result, trace)


def titled(settings: Mapping[str, float]) -> dict[str, object]:
    """What was set, each number as it was written."""
    return {path: getattr(value, "text", value) for path, value in settings.items()}


def check_video() -> None:
    """Stop with exit code 2 where nothing writes videos."""
    from ccgen.runtime.pictures.video import no_ffmpeg

    if missing := no_ffmpeg():
        fail(f"--video: {missing}")


def check_reach(step: float, until: float) -> None:
    """Stop with exit code 2 unless steps of this length reach the end of a run within its budget."""
    from ccgen.runtime.simulation.arguments import check_step

    with refusing_options():
        check_step(step, until)


def write(
    result: Run,
    folder: Path,
    moving: Sequence[str],
    wanted: Wanted,
    csv: bool,
    forces: Told,
    tables: Sequence[str],
    settings: Mapping[str, object],
) -> tuple[list[str], dict[str, str], list[str]]:
    """Write result, plot, player, forces and, if asked, moving pictures, outputs and tables into ``folder``, of
    impacts and phases those that ``tables`` names. Pictures name the ``settings``.

    The names of the files, of those that cannot be made of this run why not, and those of an older run that are gone:
    what ccgen wrote into the folder before and has not written now. The numbers are written first: they
    are there whatever can be drawn of them. An older file does not stay in place of one that
    cannot be made.
    """
    from ccgen.runtime.pictures.player import write_player
    from ccgen.runtime.pictures.plot import draw
    from ccgen.runtime.record.outputs import with_places

    folder.mkdir(parents=True, exist_ok=True)
    plotted = with_places(result.model, [name for _, name in wanted.plot])
    plot = partial(draw, result, settings=settings)
    player = partial(write_player, result, outputs=plotted or None, settings=settings)
    ways: dict[str, Callable[[Path], object]] = {
        **dict(zip(FILES, (result.save, plot, player), strict=True)),
        **{name: {GIF: result.animate, VIDEO: result.save_video}[name] for name in moving},
        **wanted.ways_to_write(result, settings),
        **ways_to_write_contacts(result, tables),
    }
    unwritten: dict[str, str] = {}
    interrupted = False
    try:
        ways |= ways_to_write(forces, csv, wanted.times, settings)
    except KeyboardInterrupt:
        interrupted = True
    for name, way in ways.items():
        try:
            if interrupted and name != FILES[0]:
                raise KeyboardInterrupt
            way(folder / name)
            record_results(folder, [name])
        except ValueError as error:  # as where forces have no solution at an instant that is looked at
            unwritten[name] = str(error)
        except OSError as error:  # as of a full disk: a smaller file may still find room
            unwritten[name] = told(error)
        except KeyboardInterrupt:
            interrupted = True
            unwritten[name] = INTERRUPTED
    made = [name for name in ways if name not in unwritten]
    removed: list[str] = []
    try:
        removed = forget_stale(
            folder, {*FILES, *MOVING, PICTURE, TABLE, IMPACTS, PHASES, OUTPUTS_PICTURE, OUTPUTS_TABLE} - {*made}
        )
    except OSError as error:
        unwritten[RECORD] = told(error)
    return made, unwritten, removed
