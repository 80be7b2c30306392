"""``sweep``: makes the runs of a plan, part by part, here or by an executor, into a folder that can be gone on with."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, wait
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ..extras import needed
from ..model.model import Model
from .chunk import make_chunk
from .folder import SweepError, SweepFolder, manifest_of
from .plan import Plan, plan_of, read_plan
from .results import Results

SECONDS = 2.0
"""How long a chunk is meant to take: long against what it costs to send, short against what is lost with a worker."""
FIRST = 16
"""Runs of the first chunk, which tells how long they take."""
TRIES = 4
"""How often a chunk is sent, where workers die with it."""
AHEAD = 3
"""Chunks for every worker that are sent before the first is back."""
Told = Callable[[int], None]
"""Called with how many runs more are made."""
Parts = Iterator[tuple[int, dict[str, Any]]]
"""Parts by number, and their columns."""


def sweep(
    model: Model,
    plan: Plan | str | PathLike[str] | dict[str, Any],
    out: str | PathLike[str],
    *,
    threads: int | None = None,
    chunk: int | None = None,
    executor: Any = None,
    progress: Callable[[int, int], object] | None = None,
) -> Results:
    """Make the runs of a ``plan`` (a file, its tables, or one that has been read) into the folder ``out``.

    What is there already is kept: killed at any instant and called again, it goes on, and the files are byte for byte
    those of one that was never stopped, whatever ``threads``, ``chunk`` (runs that are made at a time; chosen by what
    they take unless given) and ``executor`` are. That is a ``dask.distributed.Client``, or an executor of
    ``concurrent.futures``; chunks whose workers die are sent again, runs that stop are rows. ``progress`` is called as
    ``progress(done, count)`` with runs. docs/sweep.md has the plan and the files.

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
    folder = SweepFolder.begin(Path(out), manifest_of(model, plan))
    with folder.held():
        missing = folder.missing()
        folder.check_room(_row_bytes(model, plan))
        done = plan.count - sum(last - first for first, last in map(folder.rows, missing))

        def told(made: int) -> None:
            nonlocal done
            done += made
            if progress is not None:
                progress(done, plan.count)

        told(0)
        way = _Here(model, plan, threads) if executor is None else _Elsewhere(model, plan, executor, threads)
        for part, columns in way.parts(folder, missing, chunk, told):
            folder.write_part(part, columns)
    return Results(folder.path)


def _longer(size: int, made: int, seconds: float) -> int:
    """Runs in the next chunk, from what so many took."""
    wanted = int(made * SECONDS / max(seconds, 1e-6))
    return max(1, min(wanted, 4 * size))


def _row_bytes(model: Model, plan: Plan) -> int:
    times = len(plan.at) if plan.at is not None else 1
    numbers = sum(1 if "(" in name and "_times" not in name else times for name in plan.observe)
    listed = sum(int(name[13:-1]) for name in plan.observe if name.startswith("impact_times("))
    return 8 * (len(plan.names) + numbers + listed + 6 + 2 * len(model.q_names))


def _joined(pieces: list[dict[str, Any]]) -> dict[str, Any]:
    """Columns of several chunks, one after the other."""

    def one(name: str) -> Any:
        parts = [piece[name] for piece in pieces]
        return [x for part in parts for x in part] if isinstance(parts[0], list) else np.concatenate(parts)

    return {name: one(name) for name in pieces[0]}


class _Here:
    """Runs by threads of this process."""

    def __init__(self, model: Model, plan: Plan, threads: int | None) -> None:
        self.model, self.plan, self.threads = model, plan, threads

    def parts(self, folder: SweepFolder, missing: list[int], chunk: int | None, told: Told) -> Parts:
        """Each of the missing parts in turn."""
        size = chunk or FIRST
        for part in missing:
            (first, last), pieces = folder.rows(part), []
            while first < last:
                end, began = min(first + size, last), time.monotonic()
                pieces.append(make_chunk(self.model, self.plan, first, end, self.threads))
                size = chunk or _longer(size, end - first, time.monotonic() - began)
                told(end - first)
                first = end
            yield part, _joined(pieces)


class _Elsewhere:
    """Runs by the workers of an executor."""

    def __init__(self, model: Model, plan: Plan, executor: Any, threads: int | None) -> None:
        self.model, self.plan, self.executor, self.threads = model, plan, executor, threads or 1
        self.dask = type(executor).__module__.startswith("distributed")
        self.given = executor.scatter([model, plan], broadcast=True) if self.dask else [model, plan]

    def _send(self, first: int, last: int) -> Any:
        if self.dask:
            return self.executor.submit(make_chunk, *self.given, first, last, self.threads, pure=False)
        return self.executor.submit(make_chunk, *self.given, first, last, self.threads)

    def _workers(self) -> int:
        if self.dask:
            return max(1, int(sum(self.executor.nthreads().values())))
        return int(getattr(self.executor, "_max_workers", 1))

    def parts(self, folder: SweepFolder, missing: list[int], chunk: int | None, told: Told) -> Parts:
        """Each of the missing parts once all of its chunks are back, in their order."""
        waiting: dict[Any, tuple[int, int, int, int, float]] = {}
        back: dict[int, dict[int, dict[str, Any]]] = {}
        wanted = {part: folder.rows(part) for part in missing}
        left = self._pieces(folder, missing)
        size, ahead = chunk or FIRST, AHEAD * self._workers()
        rest = next(left, None)
        while rest is not None or waiting:
            while rest is not None and len(waiting) < ahead:
                part, first, last = rest
                end = min(first + size, last)
                waiting[self._send(first, end)] = part, first, end, 1, time.monotonic()
                rest = (part, end, last) if end < last else next(left, None)
            future = self._next(waiting)
            part, first, end, tries, began = waiting.pop(future)
            try:
                columns = future.result()
            except Exception as error:
                if not self._died(error):
                    raise
                if tries >= TRIES or isinstance(error, BrokenExecutor):
                    raise SweepError(
                        f"{folder.path}: workers died with the runs {first} to {end - 1} ({type(error).__name__}); "
                        "start again: it goes on with what is done"
                    ) from error
                waiting[self._send(first, end)] = part, first, end, tries + 1, time.monotonic()
                continue
            if not chunk and len(waiting) < ahead:
                size = _longer(size, end - first, (time.monotonic() - began) / max(1, AHEAD))
            back.setdefault(part, {})[first] = columns
            told(end - first)
            begin, stop = wanted[part]
            if sum(len(one["run"]) for one in back[part].values()) == stop - begin:
                pieces = back.pop(part)
                yield part, _joined([pieces[first] for first in sorted(pieces)])

    def _pieces(self, folder: SweepFolder, missing: list[int]) -> Iterator[tuple[int, int, int]]:
        for part in missing:
            yield (part, *folder.rows(part))

    def _next(self, waiting: dict[Any, Any]) -> Any:
        """One that is back."""
        if self.dask:
            wait_for_workers = needed("distributed", "a sweep by Dask").wait
            return next(iter(wait_for_workers(list(waiting), return_when=FIRST_COMPLETED).done))
        return next(iter(wait(waiting, return_when=FIRST_COMPLETED).done))

    def _died(self, error: BaseException) -> bool:
        """Whether it was the worker, and not the work, that failed."""
        names = {kind.__name__ for kind in type(error).__mro__}
        return isinstance(error, BrokenExecutor | CancelledError | ConnectionError) or bool(
            names & {"KilledWorker", "FutureCancelledError", "CommClosedError"}
        )
