"""Many runs of one model that differ in starts, parameters and inputs, and a table of what is observed of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from numpy.typing import ArrayLike

from ..faults import Faults
from ..model.model import Model, check_model
from ..model.numbers import told
from ..simulation.arguments import check_calls
from ..simulation.one_run import options_of
from ..simulation.threads import processors
from .compiled import CompiledRuns, can
from .numbers import Numbers, read_numbers_of_runs
from .observed import read_observed
from .reduction import Reduction
from .singly import SingleRuns
from .table import TOLD, Ensemble, joined


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

    Runs are made by the compiled core, without Python, with what ``[[event]]`` tables set, switch and end, but for
    models with ``[[release]]`` or ``[[hold]]``, with a controller in Python, and where impulses or extremes over rows
    are observed: these are made one by one, by threads that share Python.

    Raises ``ValueError`` for names that are none, parameters that cannot be changed, lengths that do not fit and
    settings that are wrong for all runs, before the first, with all that is wrong.
    """
    check_model(model)
    if reduction is not None and not isinstance(reduction, Reduction):
        raise TypeError(f"reduction: found {told(reduction)}, expected a Reduction, or None")
    model, faults = model.as_it_is(), Faults()
    asked: dict[str, Any] = {"until": until, "rtol": rtol, "atol": atol, "method": method, "step": step, "drift": drift}
    asked["on_gain"] = on_gain
    numbers = options = observed = None
    with faults.collecting():
        numbers = read_numbers_of_runs(model, params, q0, u0, inputs)
    with faults.collecting():
        check_calls(progress, keep_interrupted)
    with faults.collecting():
        _check_others(reduce, threads)
    with faults.collecting():
        whole = inputs if callable(inputs) or (isinstance(inputs, Mapping) and "t" in inputs) else None
        options = options_of(model, inputs=whole, progress=None, keep_interrupted=True, **asked)
        observed = read_observed(model, observe, at, options.settings.until)
    with faults.collecting():
        _check_names(model, observed.names if observed else (), params, reduction)
    faults.stop_if_any()
    assert numbers is not None and options is not None and observed is not None
    singly = SingleRuns(model, observed, asked)
    runs: CompiledRuns | SingleRuns = singly
    if can(model, numbers, observed, options.settings.until):
        runs = CompiledRuns(model, observed, options, reduction, asked)
    elif reduction is not None:
        raise ValueError("reduction: found runs that the compiled core cannot make alone, expected others; use observe")
    tables = _tables(runs, singly, numbers, threads or processors(), progress, keep_interrupted)
    if reduce is None:
        return joined(list(tables))
    found = initial
    for table in tables:
        found = reduce(found, table)
    return found


def _tables(
    runs: CompiledRuns | SingleRuns,
    singly: SingleRuns,
    numbers: Numbers,
    workers: int,
    progress: Callable[[int, int], object] | None,
    keep_interrupted: bool,
) -> Iterator[Ensemble]:
    """The tables of some runs after the others; at Ctrl-C, where that is kept, the last one of those not made."""
    size = runs.size(numbers)
    for first in range(0, numbers.count, size):
        last = min(first + size, numbers.count)

        def told(done: int, before: int = first) -> None:
            assert progress is not None
            progress(before + done, numbers.count)

        part, finished = numbers.part(first, last), False
        try:
            table, finished = runs.make(part, workers, told if progress is not None else None)
        except KeyboardInterrupt:  # while Python prepared the part, or read it: none of it is kept
            table = singly.left(part)
        if not finished and not keep_interrupted:
            raise KeyboardInterrupt
        yield table
        if not finished and last < numbers.count:
            yield singly.left(numbers.part(last, numbers.count))
        if not finished:
            return


def _check_others(reduce: object, threads: object) -> None:
    """Raise ``TypeError`` or ``ValueError`` for a reduction or threads that are none."""
    if reduce is not None and not callable(reduce):
        raise TypeError(f"reduce: found {reduce!r}, expected a function of what was found so far and a table")
    if threads is not None and (isinstance(threads, bool) or not isinstance(threads, int) or threads < 1):
        raise ValueError(f"threads: found {threads!r}, expected a number of threads, at least 1")


def _check_names(model: Model, names: Sequence[str], params: object, reduction: Reduction | None) -> None:
    """Raise ``ValueError`` where two columns would have one name, and for a function that cannot read the rows."""
    taken = dict.fromkeys(params if isinstance(params, Mapping) else (), "the column of that parameter")
    taken |= {name: "a column of every table" for name in TOLD if name != "impacts"}
    for name in [*names, *([reduction.name] if reduction else ())]:
        if name in taken:
            raise ValueError(f"observe: found {name!r}, which is {taken[name]}, expected another name")
        taken[name] = "there already"
    if reduction is not None:
        reduction.address  # noqa: B018
        if model.precision != "double":
            raise ValueError(
                f"reduction: found a model in {model.precision} numbers, expected one in doubles, which it reads"
            )
