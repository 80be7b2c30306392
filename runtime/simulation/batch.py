"""Many runs of one model, from many starts, side by side on the machine's processors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..faults import Faults
from ..model.model import Model
from ..model.numbers import read_numbers
from ..run import Run
from .one_run import options_of
from .threads import processors, share


def simulate_batch(
    model: Model,
    q0: ArrayLike,
    u0: ArrayLike | None,
    make: Callable[..., Run],
    *,
    progress: Callable[[float], object] | None,
    **options: Any,
) -> list[Run]:
    """A run from every start: ``q0`` (b, nq), ``u0`` (b, nu) or (nu,), the scene's velocities where it is ``None``.

    Runs work without the GIL, each on its own, so each is what ``make``, as :func:`~.one_run.simulate_one`, gives for
    its start alone. ``options`` are those of it; ``progress`` is called with the time that a run has reached. When a
    run raises, the others stop. So they do at Ctrl-C; with ``keep_interrupted`` the runs that were begun are given
    then, of the first starts, those in progress as far as they came.
    Raises ``ValueError`` for shapes that do not fit and for starts that cannot be simulated.
    """
    faults = Faults()
    with faults.collecting():
        model = model.with_parameters(options.pop("params")).as_it_is()  # all runs have the values of now
    with faults.collecting():
        options_of(model, progress=progress, **options)
    with faults.collecting():
        qs, us = _starts(model, q0, u0)
    faults.stop_if_any()
    ended_by: list[BaseException] = []  # the first is what the runs in progress end with

    def reached(t: float) -> None:
        if ended_by:
            raise ended_by[0]
        if progress is not None:
            try:
                progress(t)
            except KeyboardInterrupt as error:
                ended_by.append(error)
                raise

    runs: list[Run | None] = [None] * len(qs)
    waiting = iter(range(len(qs)))  # each thread takes the next start that is left

    def work() -> None:
        try:
            while not ended_by and (index := next(waiting, None)) is not None:
                runs[index] = make(model, qs[index], us[index], params=None, progress=reached, **options)
        except AnotherFailed:
            return  # which is raised by the thread that it failed in
        except BaseException:
            ended_by.append(AnotherFailed())
            raise

    whole = share(work, min(processors(), len(qs)), lambda: ended_by.insert(0, KeyboardInterrupt()), None)
    if not whole and not options["keep_interrupted"]:
        raise KeyboardInterrupt
    return [run for run in runs if run is not None]


class AnotherFailed(Exception):
    """What runs end with when another one has raised."""


def _starts(model: Model, q0: ArrayLike, u0: ArrayLike | None) -> tuple[FloatArray, FloatArray]:
    """A state for every run. Raises ``ValueError`` for shapes that do not fit."""
    kind, n, faults = model.core.REAL, len(model.q_names), Faults()
    with faults.collecting():
        qs = np.array(read_numbers(q0, "q0", kind))
    with faults.collecting():
        us = np.array(read_numbers(model.start()[1] if u0 is None else u0, "u0", kind))
    faults.stop_if_any()
    if us.ndim == 1:
        us = np.tile(us, (len(qs), 1))
    if not len(qs) or qs.shape[1:] != (n,) or us.shape != (len(qs), n):
        raise ValueError(
            f"q0, u0: found shapes {qs.shape} and {us.shape}, expected (starts, {n}) for q0, and that or ({n},) for u0"
        )
    return qs, us
