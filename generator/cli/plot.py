"""``ccgen plot RUN NAMES``: outputs of a run that is done, by name."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from .folders import check_results, check_there, record_results
from .outputs import Wanted
from .refusal import Faults, fail, refusing

if TYPE_CHECKING:
    from ccgen.runtime import Run

RESULT = "result.npz"


def plot(file: Path, wanted: Wanted, models: Path, out: Path | None, faults: Faults) -> None:
    """Draw the ``wanted`` outputs of the run in ``file``, a folder of results or an .npz file, beside it or into the
    folder ``out``; without any print the names of all. Its model is looked for in the folder ``models``."""
    result = file / RESULT if file.is_dir() else file
    folder = result.parent if out is None else out
    faults.of(check_results, folder, wanted.files, "--out" if out else "RUN")
    run = faults.of(_load, file, result, models)
    if run is not None:
        faults.of(wanted.check, run.model)
    faults.stop_if_any()
    assert run
    if not wanted.files:
        from ccgen.runtime.record.outputs import outputs_text

        typer.echo(outputs_text(run.model))
        return
    folder.mkdir(parents=True, exist_ok=True)
    for name, way in wanted.ways_to_write(run).items():
        with refusing(OSError, ValueError):
            way(folder / name)
        record_results(folder, [name])
    typer.echo(f"written: {', '.join(str(folder / name) for name in wanted.files)}")


def _load(file: Path, result: Path, models: Path) -> Run:
    """The run in ``result``, which is in or is the ``file`` that was named, with the model that it is of."""
    check_there(file, "a folder of results, or the .npz file of a run")
    from ccgen.runtime import load_model, load_run
    from ccgen.runtime.load_run import package_of

    with refusing(FileNotFoundError, ValueError):
        package = package_of(result)
    place = models / package
    if not place.is_dir():
        fail(
            f"{result}: found a run of a model {package} that is not in {models}, expected it there; name its folder "
            "by --models, or run the scene again"
        )
    with refusing(FileNotFoundError, ImportError, ValueError):
        model = load_model(place)
    try:
        with refusing(FileNotFoundError, ValueError):
            return load_run(result, model)
    except ImportError:
        fail(
            f"{result}: found {place} made of another scene than the run, or of this one after a change, expected the "
            "model of the run; make that in a folder of its own, ccgen --scene FILE --out DIR, and name it by --models "
            "DIR, or run the scene again"
        )
