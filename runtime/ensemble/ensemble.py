"""Many runs of one model that differ in starts, parameters and inputs, and a table of what is observed of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from numpy.typing import ArrayLike

from ..faults import Faults
from ..model.model import Model
from ..simulation.arguments import check_calls
from ..simulation.one_run import options_of
from .compiled import CompiledRuns, can
from .numbers import read_numbers_of_runs
from .observed import read_observed
from .reduction import Reduction
from .singly import SingleRuns
from .table import Ensemble, joined
from .threads import processors


def ensemble(
    model: Model,
    params: Mapping[str, ArrayLike] | None = None,
    q0: ArrayLike | None = None,
    u0: ArrayLike | None = None,
    inputs: Any = None,
    *,
    observe: Sequence[str] = (),
    at: ArrayLike | None = None,
    until: float | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    method: str | None = None,
    step: float | None = None,
    drift: str | None = None,
    on_gain: str | None = None,
    threads: int | None = None,
    reduction: Reduction | None = None,
    reduce: Callable[[Any, Ensemble], Any] | None = None,
    initial: Any = None,
    progress: Callable[[int, int], object] | None = None,
    keep_interrupted: bool = False,
) -> Any:
    """Make many runs of ``model`` and give an :class:`Ensemble`, a table with a row for each, in the order given.

    ``params`` are values (b,) by scene path, ``q0`` (b, nq) and ``u0`` (b, nu) starts, ``inputs`` constants by name,
    each a number or (b,), or what :func:`simulate` takes, for all; a number, or one start, is for all runs. Each run
    is to the bit what :func:`simulate` gives with its numbers, whatever the number of threads. A run that cannot begin
    or that stops is a row too, with its status and the reason in a sentence.

    ``observe`` names what is kept: outputs as ``crank.angle`` (docs/model.md, "Outputs by name") at the times ``at``
    (m,) in s, a column (b, m), or without these at the end of each run, (b,); ``max(NAME)`` and ``min(NAME)`` over the
    times ``at``, or over the rows of the run; ``impacts``, how many, and ``impact_times(16)``, the first of them; ``q``
    and ``u`` at the end. Not a number where a run did not come so far. A :class:`Reduction` is a function in machine
    code that reads all rows of each run.

    ``reduce`` is called as ``reduce(found, table)`` with the tables of some runs after the others, ``found`` being
    ``initial`` at first; what it gives at last is returned, and no table is kept. ``threads``: as many as there are
    processors unless given. ``progress`` is called as ``progress(done, count)`` now and then. The other arguments are
    those of :func:`simulate`. Ctrl-C raises ``KeyboardInterrupt``, or with ``keep_interrupted`` keeps the rows that are
    done; the others say that they are not.

    Runs are made by the compiled core, without Python, but for models with ``[[event]]``, ``[[release]]`` or
    ``[[hold]]``, with a controller in Python, and where impulses or extremes over rows are observed: these are made one
    by one, by threads that share Python.

    Raises ``ValueError`` for names that are none, parameters that cannot be changed, lengths that do not fit and
    settings that are wrong for all runs, before the first, with all that is wrong.
    """
    if not isinstance(model, Model):
        raise TypeError(f"model: found {type(model).__name__}, expected a Model; load one with load_model(folder)")
    model, faults = model.as_it_is(), Faults()
    asked: dict[str, Any] = {"until": until, "rtol": rtol, "atol": atol, "method": method, "step": step, "drift": drift}
    asked["on_gain"] = on_gain
    numbers = options = observed = None
    with faults.collecting():
        numbers = read_numbers_of_runs(model, params, q0, u0, inputs)
    with faults.collecting():
        check_calls(progress, keep_interrupted)
        if reduce is not None and not callable(reduce):
            raise TypeError(f"reduce: found {reduce!r}, expected a function of what was found so far and a table")
        if reduction is not None:
            reduction.address  # noqa: B018
    with faults.collecting():
        if threads is not None and (isinstance(threads, bool) or not isinstance(threads, int) or threads < 1):
            raise ValueError(f"threads: found {threads!r}, expected a number of threads, at least 1")
    with faults.collecting():
        whole = inputs if callable(inputs) or (isinstance(inputs, Mapping) and "t" in inputs) else None
        options = options_of(model, inputs=whole, progress=None, keep_interrupted=True, **asked)
        observed = read_observed(model, observe, at, options.settings.until)
    faults.stop_if_any()
    assert numbers is not None and options is not None and observed is not None
    compiled = can(model, numbers, observed, options.settings.until)
    if reduction is not None and not compiled:
        raise ValueError("reduction: found runs that the compiled core cannot make alone, expected others; use observe")
    runs = CompiledRuns(model, observed, options, reduction) if compiled else SingleRuns(model, observed, asked)
    size, workers, parts = runs.size(numbers), threads or processors(), list[Ensemble]()
    found = initial
    for first in range(0, numbers.count, size):

        def told(done: int, before: int = first) -> None:
            assert progress is not None
            progress(before + done, numbers.count)

        part = numbers.part(first, min(first + size, numbers.count))
        table, finished = runs.make(part, workers, told if progress is not None else None)
        if not finished and not keep_interrupted:
            raise KeyboardInterrupt
        if reduce is not None:
            found = reduce(found, table)
        else:
            parts.append(table)
        if not finished:
            break
    if reduce is not None:
        return found
    made = sum(map(len, parts))
    if made < numbers.count:  # Ctrl-C: the rest are rows too
        rest = SingleRuns(model, observed, asked).left(numbers.part(made, numbers.count))
        parts.append(rest)
    return joined(parts)
