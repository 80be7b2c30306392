"""``ccgen sweep SCENE PLAN`` and ``ccgen replay FOLDER RUN``: the runs of a plan, and one of them again."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from ..rebuild import rebuild
from ..scene.locate import locate
from .compiled import compiled
from .detail import Detail
from .folders import MODELS, check_folder, check_results, check_there, record_results
from .plan_numbers import written
from .progress import Silence, progress
from .refusal import STOPPED_EARLY, Faults, fail, refusing
from .run import FILES
from .settings import read_set, with_settings

if TYPE_CHECKING:
    from ccgen.runtime.sweep.results import Results

PLAN = "a plan (TOML)"


def sweep(
    scene_file: Path,
    plan_file: Path,
    out: Path | None,
    threads: str | None,
    chunk: str | None,
    dask: str | None,
    plot: bool,
    netcdf: Path | None,
    zarr: Path | None,
    detail: Detail,
    settings: Mapping[str, float],
    faults: Faults,
) -> None:
    """Make the runs of a plan into the folder ``out``, or go on with it; exit code 3 where it stops before its end."""
    workers = faults.of(read_count, threads, "--threads")
    size = faults.of(read_count, chunk, "--chunk")
    scene = read_set(scene_file, settings, faults)
    faults.of(check_there, plan_file, PLAN, ".toml")
    folder = Path("results") / f"{plan_file.stem}-sweep" if out is None else out
    faults.of(check_folder, MODELS, "folder of models")
    faults.of(check_folder, folder, "--out")
    for file, check in ((netcdf, _check_netcdf), (zarr, _check_zarr)):
        if file is not None:
            faults.of(check, file)
    faults.stop_if_any()
    assert scene
    model = with_settings(compiled(scene, detail), settings, scene, detail)
    from ccgen.runtime.sweep.folder import SweepError
    from ccgen.runtime.sweep.plan import PlanError, read_plan
    from ccgen.runtime.sweep.sweep import sweep as work

    with refusing(PlanError, ImportError):
        plan = read_plan(plan_file, model, partial(written, scene=scene), locate)
    try:
        with progress(detail) as tell, executor_of(dask) as executor:
            tell.stage("simulate")
            told = told_of(tell)
            with refusing(PlanError, ImportError):
                results = work(
                    model,
                    plan,
                    folder,
                    threads=workers,
                    chunk=size,
                    executor=executor,
                    rebuild=rebuild,
                    progress=told,
                )
    except SweepError as error:
        fail(f"ccgen: {error}", STOPPED_EARLY)
    except KeyboardInterrupt:
        fail(f"{folder}: interrupted; start again: it goes on with what is done", STOPPED_EARLY)
    files = [str(file) for file in results.files]
    with refusing(ImportError, OSError, ValueError):
        if plot:
            from ccgen.runtime.sweep.chart import CHART, draw_sweep

            draw_sweep(results, folder / CHART)
            files.append(str(folder / CHART))
        if netcdf is not None:
            results.to_netcdf(netcdf)
            files.append(str(netcdf))
        if zarr is not None:
            results.to_zarr(zarr)
            files.append(str(zarr))
    if detail is not Detail.NOTHING:
        tell_ends(results)
        shown = [*files[:3], "..."] if len(files) > 4 else files
        typer.echo(f"written: {', '.join(shown)}")


def _check_netcdf(file: Path) -> None:
    """Stop with exit code 2 unless a table can be written there as NetCDF."""
    from ccgen.runtime.extras import needed
    from ccgen.runtime.sweep.results import check_netcdf

    _check_file("--netcdf", partial(needed, "xarray", "a table as NetCDF"), partial(check_netcdf, file))


def _check_zarr(folder: Path) -> None:
    """Stop with exit code 2 unless a table can be written there as Zarr."""
    from ccgen.runtime.extras import needed
    from ccgen.runtime.sweep.zarr_folder import check_zarr

    _check_file("--zarr", partial(needed, "zarr", "a table as Zarr"), partial(check_zarr, folder))


def _check_file(option: str, *checks: Callable[[], object]) -> None:
    try:
        for check in checks:
            check()
    except (ValueError, ImportError) as error:
        fail(f"{option}: {error}")


def replay(
    folder: Path,
    scene_file: Path,
    plan_file: Path,
    run: int,
    out: Path | None,
    detail: Detail,
    settings: Mapping[str, float],
    faults: Faults,
) -> None:
    """Make one run of a sweep again, whole, and write its result, plot and player."""
    scene = read_set(scene_file, settings, faults)
    faults.of(check_there, plan_file, PLAN, ".toml")
    faults.of(check_there, folder, "the folder of a sweep")
    place = folder / f"run-{run}" if out is None else out
    faults.of(check_folder, MODELS, "folder of models")
    faults.of(check_results, place, FILES, "--out")
    faults.stop_if_any()
    assert scene
    model = with_settings(compiled(scene, detail), settings, scene, detail)
    from ccgen.runtime.sweep.plan import read_plan
    from ccgen.runtime.sweep.results import Results

    with refusing(ValueError, ImportError):
        made = Results(folder).run(model, read_plan(plan_file, model, partial(written, scene=scene), locate), run)
    place.mkdir(parents=True, exist_ok=True)
    with refusing(OSError):
        ways: tuple[Callable[[Path], object], ...] = (made.save, made.plot, made.save_player)
        for name, way in zip(FILES, ways, strict=True):
            way(place / name)
            record_results(place, [name])
    typer.echo(f"run {run}: {made.message}")
    typer.echo(f"written: {', '.join(str(place / name) for name in FILES)}")


def told_of(tell: Silence) -> Callable[[int, int], None]:
    """Tell how many runs are done, and how long the rest will take, from what those since the beginning took."""
    before: list[tuple[int, float]] = []

    def told(done: int, count: int) -> None:
        if not before:
            before.append((done, time.monotonic()))
        made, seconds = done - before[0][0], time.monotonic() - before[0][1]
        tell.counted(done, count, seconds * (count - done) / made if made else None)

    return told


def tell_ends(results: Results) -> None:
    """How runs have ended, and the commonest reasons of those that did not come to their end."""
    table = results.to_arrow(["status", "reason"])
    statuses, reasons = table["status"].to_pylist(), table["reason"].to_pylist()
    counts = {status: statuses.count(status) for status in dict.fromkeys(statuses)}
    typer.echo(f"{len(statuses)} runs: {', '.join(f'{n} {status}' for status, n in counts.items())}")
    why = {reason: 0 for reason in reasons if reason}
    for reason in filter(None, reasons):
        why[reason] += 1
    for reason, count in sorted(why.items(), key=lambda one: -one[1])[:3]:
        typer.echo(f"  {count}: {reason}")


@contextmanager
def executor_of(address: str | None) -> Iterator[Any]:
    """The workers of a Dask scheduler, or none."""
    if address is None:
        yield None
        return
    from ccgen.runtime.extras import needed

    with refusing(ImportError):
        distributed = needed("distributed", "a sweep by Dask")
    try:
        client = distributed.Client(address, timeout=10)
    except (OSError, ValueError) as error:
        fail(f"--dask {address}: found no scheduler there, expected one ({error}); start it, or correct the address")
    with client:
        yield client


def read_count(text: str | None, option: str) -> int | None:
    """A whole number from 1 on; exit code 2 for what is none."""
    if text is None:
        return None
    if not text.isdigit() or int(text) < 1:
        fail(f"{option}: found {text!r}, expected a whole number, at least 1")
    return int(text)
