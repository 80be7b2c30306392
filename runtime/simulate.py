"""Simulates a model through flight and impact: one run, or many side by side."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, overload

from numpy.typing import ArrayLike

from .arrays import Starts
from .model.inputs import Given
from .model.model import Model, check_model
from .model.numbers import dimensions
from .record.hybrid_state import HybridState
from .run import Run
from .simulation.arguments import default_method
from .simulation.batch import simulate_batch
from .simulation.events import OnEvent, check_functions, simulate_with_events
from .simulation.interruption import marked, noting
from .simulation.one_run import simulate_one

__all__ = ["default_method", "simulate"]


@overload
def simulate(
    model: Model,
    q0: Sequence[float] | None = None,
    u0: ArrayLike | None = None,
    until: float | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    method: str | None = None,
    params: Mapping[str, float] | None = None,
    inputs: Given = None,
    *,
    on_event: OnEvent | None = None,
    step: float | None = None,
    drift: str | None = None,
    on_gain: str | None = None,
    state: HybridState | None = None,
    progress: Callable[[float], object] | None = None,
    keep_interrupted: bool = False,
) -> Run: ...
@overload
def simulate(
    model: Model,
    q0: Starts,
    u0: ArrayLike | None = None,
    until: float | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    method: str | None = None,
    params: Mapping[str, float] | None = None,
    inputs: Given = None,
    *,
    on_event: OnEvent | None = None,
    step: float | None = None,
    drift: str | None = None,
    on_gain: str | None = None,
    state: HybridState | None = None,
    progress: Callable[[float], object] | None = None,
    keep_interrupted: bool = False,
) -> list[Run]: ...
@overload
def simulate(
    model: Model,
    q0: ArrayLike | Starts | None,
    u0: ArrayLike | None = None,
    until: float | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    method: str | None = None,
    params: Mapping[str, float] | None = None,
    inputs: Given = None,
    *,
    on_event: OnEvent | None = None,
    step: float | None = None,
    drift: str | None = None,
    on_gain: str | None = None,
    state: HybridState | None = None,
    progress: Callable[[float], object] | None = None,
    keep_interrupted: bool = False,
) -> Any: ...
def simulate(
    model: Model,
    q0: ArrayLike | Starts | None = None,
    u0: ArrayLike | None = None,
    until: float | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    method: str | None = None,
    params: Mapping[str, float] | None = None,
    inputs: Given = None,
    *,
    on_event: OnEvent | None = None,
    step: float | None = None,
    drift: str | None = None,
    on_gain: str | None = None,
    state: HybridState | None = None,
    progress: Callable[[float], object] | None = None,
    keep_interrupted: bool = False,
) -> Run | Any:
    """Integrate ``model`` from (``q0``, ``u0``) at t = 0, or from the ``state`` of another run, to ``until`` (s).

    ``state=run.state`` goes on by the same bits as a run to the later end with a stop there: with the method of that
    run, and with its drift, step, tolerances and ``on_gain`` unless others are given. Its rows begin at ``state.t``.

    A batch of starts, ``q0`` (b, nq) and ``u0`` (b, nu) or one for all, gives a list of runs, made side by side on the
    machine's processors and equal to single runs in every bit. Where Ctrl-C ends it and ``keep_interrupted`` is set,
    the list holds the runs of the first starts: those done, and those in progress as far as they came.

    Start, end and tolerances come from the scene unless given; ``atol`` is ``rtol`` unless given. Where the scene's
    ``rtol`` is less than the model's numbers allow, as 1e-9 is in floats, the least that they allow is taken: 1e-6 in
    floats, 1e-15 in doubles, 1e-18 in wide numbers. ``params`` are values by scene path for this run only.
    ``step`` (s) fixes the step size instead of choosing it by the error estimate, and is needed where the method has
    none; a run has at most ten million steps.
    ``method`` is one of :func:`ccgen.runtime.methods`, as "radau" for stiff scenes; unless given,
    :func:`default_method`. "moreau" steps over impacts instead of finding them (theory, 5.11): of first order, for
    comparison. ``drift`` says how the loops are kept shut: "projected" after every step; for
    comparison, "left" as the integration leaves them, or "damped" by Baumgarte's stabilisation. While contacts are
    held, loops and contacts are projected in any case.
    ``on_gain`` says what becomes of an impact that would gain energy, as Newton's law of impact may where there is
    friction: "reduce" gives its contacts the largest part of their restitution that gains none, "stop" ends the run
    before it; the scene's unless given.
    ``progress`` is called with the time reached, now and then. The start is projected onto the closure. Ctrl-C raises
    ``KeyboardInterrupt``, or with ``keep_interrupted`` ends the run there and keeps it; a run that was at its end when
    it came says that it was interrupted, too.

    ``inputs`` are values of the model's inputs: constants by name or in order; a table ``{"t": [...], name: [...]}``,
    interpolated linearly and constant outside; or a controller, called as ``inputs(t, q, u)`` whenever accelerations
    are needed. What a controller raises ends the run and is raised here.

    ``on_event`` are functions by names of the scene's ``[[event]]`` tables, called as ``function(event)`` where one
    comes, with its ``t``, ``name``, ``direction``, ``number``, ``q`` and ``u``. They answer ``None``, values of
    parameters by scene path, which hold from then on, or ``"stop"``. Values that cannot be set end the run, with a
    ``message``; what a function raises is raised here. ``run.events`` has all that came.

    The run's ``success`` is false when it stopped before the end; ``message`` then says where, why, and what to try,
    and the run holds everything up to there. Raises ``ValueError`` for arguments that cannot be simulated: wrong
    shapes, numbers that are not finite, an unknown method, too short a ``step``, a start inside a ground; it says all
    that is wrong with them.
    """
    check_model(model)
    options: dict[str, Any] = {
        "until": until,
        "rtol": rtol,
        "atol": atol,
        "method": method,
        "params": params,
        "inputs": inputs,
        "step": step,
        "drift": drift,
        "on_gain": on_gain,
        "keep_interrupted": keep_interrupted,
    }
    with noting(keep_interrupted is True) as note:
        made = _simulated(model, q0, u0, on_event, state, progress, options)
    return marked(made, note)


def _simulated(
    model: Model,
    q0: Any,
    u0: ArrayLike | None,
    on_event: OnEvent | None,
    state: HybridState | None,
    progress: Callable[[float], object] | None,
    options: dict[str, Any],
) -> Run | Any:
    make: Callable[..., Run] = simulate_one
    if model.data.get("events") or model.data.get("switching") is not None:
        make = partial(simulate_with_events, on_event=on_event)
    elif on_event is not None:
        check_functions(model, on_event)
    if state is None and q0 is not None and dimensions(q0) == 2:
        return simulate_batch(model, q0, u0, make, progress=progress, **options)
    return make(model, q0, u0, state=state, progress=progress, **options)
