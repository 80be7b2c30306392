"""``sweep``: makes the runs of a plan, chunk by chunk, here or elsewhere, into a folder that can be gone on with."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import closing, suppress
from os import PathLike
from pathlib import Path
from typing import Any

from ..ensemble.observed import column_of
from ..model.model import Model
from ..simulation.threads import processors
from .chunk import chunk_of, make_chunk
from .collected import Collected
from .elsewhere import Elsewhere, Made
from .folder import SweepError, SweepFolder, manifest_of
from .plan import Plan, plan_of, read_plan
from .results import Results
from .sizes import Sizes, cut
from .source import Rebuild, source_of


def sweep(
    model: Model,
    plan: Plan | str | PathLike[str] | dict[str, Any],
    out: str | PathLike[str],
    *,
    threads: int | None = None,
    chunk: int | None = None,
    executor: Any = None,
    rebuild: Rebuild | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Results:
    """Make the runs of a ``plan`` (a file, its tables, or one that has been read) into the folder ``out``.

    What is there already is kept: killed at any instant and called again, it goes on, and the files are byte for byte
    those of one that was never stopped, whatever ``threads``, ``chunk`` (runs that are made at a time; chosen by what
    they take unless given) and ``executor`` are. At Ctrl-C, and where it cannot go on, what is done is kept.

    ``executor`` is a ``dask.distributed.Client``, an executor of ``concurrent.futures``, or a function that makes one,
    again where all workers of the first are gone. Chunks whose workers die are sent again, runs that stop are rows.
    Workers load the model from its folder; with ``rebuild``, :func:`ccgen.generator.rebuild`, those who cannot, as on
    another machine, compile it from the files of its package, once on each machine. ``threads`` are those of a worker
    then, one unless given. ``progress`` is called as ``progress(done, count)`` with runs. docs/sweep.md has the plan
    and the files.

    Raises :class:`~.plan.PlanError` for a plan that cannot be carried out, before the first run, and for a folder of
    another sweep; :class:`~.folder.SweepError` where it cannot go on, with what is done kept.
    """
    if not isinstance(model, Model):
        raise TypeError(f"model: found {type(model).__name__}, expected a Model; load one with load_model(folder)")
    model = model.as_it_is()
    if isinstance(plan, dict):
        plan = plan_of(plan, model, "plan", repr(sorted(plan.items(), key=str)), Path())
    elif not isinstance(plan, Plan):
        plan = read_plan(plan, model)
    with SweepFolder.held(Path(out), manifest_of(model, plan)) as folder:
        folder.check_room(_row_bytes(model, plan))
        collected = Collected(folder)

        def told() -> None:
            if progress is not None:
                progress(collected.done, plan.count)

        told()
        sizes = Sizes(chunk, 1 if executor is not None else threads or processors())
        chunks = cut(collected.gaps(), sizes)
        if executor is None:
            made: Made = _here(model, plan, threads, chunks, sizes)
        else:
            made = Elsewhere(source_of(model, rebuild), plan, executor, threads, folder.built).made(chunks, sizes)
        try:
            with closing(made):
                for first, columns in made:
                    collected.add(first, columns)
                    told()
        except SweepError:
            with suppress(SweepError):
                collected.save()
            raise
        except BaseException:
            collected.save()
            raise
    return Results(folder.path)


def _here(model: Model, plan: Plan, threads: int | None, chunks: Iterator[tuple[int, int]], sizes: Sizes) -> Made:
    """Chunks made by threads of this process."""
    for first, last in chunks:
        began = time.perf_counter()
        columns = make_chunk(model, chunk_of(plan, first, last), threads)
        sizes.took(last - first, time.perf_counter() - began)
        yield first, columns


TOLD = 6
"""Numbers that a row takes beside what varies and is observed: run, status, reason, t, steps and impacts."""


def _row_bytes(model: Model, plan: Plan) -> int:
    times = len(plan.at) if plan.at is not None else 1
    columns = [column_of(name) for name in plan.observe]
    sizes = {"output": times, "q": len(model.q_names), "u": len(model.u_names)}
    numbers = sum(column.count or sizes.get(column.kind, 1) for column in columns)
    return 8 * (len(plan.names) + numbers + TOLD)
