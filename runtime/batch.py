"""Many runs of one model, from many starts, side by side on the machine's processors."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from threading import Event
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .model import Model
from .run import Run


def simulate_batch(
    model: Model, q0: ArrayLike, u0: ArrayLike | None, *, progress: Callable[[float], object] | None, **options: Any
) -> list[Run]:
    """A run from every start: ``q0`` (b, nq), ``u0`` (b, nu) or (nu,), the scene's velocities where it is ``None``.

    Runs work without the GIL, each on its own, so each is what :func:`simulate` gives for its start alone. ``options``
    are those of :func:`simulate`; ``progress`` is called with the time that a run has reached. When a run raises, the
    others stop.
    Raises ``ValueError`` for shapes that do not fit and for starts that cannot be simulated.
    """
    from .simulate import simulate

    qs = np.array(q0, dtype=model.core.REAL)
    us = np.array(model.start()[1] if u0 is None else u0, dtype=model.core.REAL)
    if us.ndim == 1:
        us = np.tile(us, (len(qs), 1))
    n = len(model.q_names)
    if not len(qs) or qs.shape[1:] != (n,) or us.shape != (len(qs), n):
        raise ValueError(
            f"q0, u0: found shapes {qs.shape} and {us.shape}, expected (starts, {n}) for q0, and that or ({n},) for u0"
        )
    model = model.with_parameters(options.pop("params")).as_it_is()  # all runs have the values of now
    failed = Event()

    def reached(t: float) -> None:
        if failed.is_set():
            raise InterruptedError("another run of the batch has failed")
        if progress is not None:
            progress(t)

    runs: list[Run | None] = [None] * len(qs)
    waiting = iter(range(len(qs)))  # each thread takes the next start that is left

    def work() -> None:
        try:
            for index in waiting:
                runs[index] = simulate(model, qs[index], us[index], progress=reached, **options)
        except BaseException:
            failed.set()
            raise

    workers = min(os.cpu_count() or 1, len(qs))
    with ThreadPoolExecutor(workers) as pool:
        tasks = [pool.submit(work) for _ in range(workers)]
        errors = [error for error in (task.exception() for task in tasks) if error is not None]
    for error in sorted(errors, key=lambda error: isinstance(error, InterruptedError)):
        raise error
    return [run for run in runs if run is not None]
