"""One run: arguments that are checked, the compiled run, and what stopped it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..faults import Faults
from ..model.inputs import Given, supply_of
from ..model.model import Model, with_params
from ..record.hybrid_state import HybridState
from ..run import Run
from .advance import Advance, Latched
from .arguments import RATE_BUDGET, STEP_BUDGET, Settings, check_calls, checked_start, read_start, settings_of, stops_of
from .dead_point import Way, cut, dead_point
from .going_on import check_end, check_left, check_state
from .interruption import checking
from .result import run_of
from .watch import Watch

if TYPE_CHECKING:
    from .._core import Supply

GOES_ON = ("done", "interrupted", "no_memory", "turned_far")
"""Ends of a run that say nothing of the motion after it."""


class Options(NamedTuple):
    """What a run is asked for beside its start: ``kinks`` are times at which the ``supply`` of its inputs has some."""

    settings: Settings
    supply: Supply | None
    kinks: FloatArray


def options_of(
    model: Model,
    *,
    until: float | None,
    rtol: float | None,
    atol: float | None,
    method: str | None,
    inputs: Given,
    step: float | None,
    drift: str | None,
    on_gain: str | None,
    progress: Callable[[float], object] | None,
    keep_interrupted: bool,
    before: Mapping[str, Any] | None = None,
) -> Options:
    """The arguments of :func:`~..simulate.simulate` but start and parameters; ``before`` are the settings of a run that
    this goes on from.

    Raises ``ValueError``, or where only kinds are wrong ``TypeError``, with all that is wrong with them.
    """
    faults = Faults()
    if model.precision == "float" and model.contacts:
        faults.add(
            f"{model.name}: found a model in floats with contacts, expected none: floats are too coarse to find "
            'impacts; generate it with precision="double"'
        )
    with faults.collecting():
        supply, kinks = supply_of(model.inputs, inputs, model.core.Supply)
    with faults.collecting():
        asked = settings_of(
            model, until, rtol, atol, step, method, drift, on_gain, controlled=callable(inputs), before=before
        )
    with faults.collecting():
        check_calls(progress, keep_interrupted)
    faults.stop_if_any()
    return Options(asked, supply, kinks)


def simulate_one(
    model: Model,
    q0: ArrayLike | None,
    u0: ArrayLike | None,
    *,
    until: float | None,
    rtol: float | None,
    atol: float | None,
    method: str | None,
    inputs: Given,
    step: float | None,
    drift: str | None,
    on_gain: str | None,
    progress: Callable[[float], object] | None,
    keep_interrupted: bool,
    params: Mapping[str, float] | None = None,
    state: HybridState | None = None,
    begin: float = 0.0,
    latched: FloatArray | None = None,
    way: Way | None = None,
    watch: Watch | None = None,
) -> Run:
    """The run from one start at t = ``begin`` (s), with the arguments of :func:`~..simulate.simulate`.

    ``latched`` (latches,) is what effects hold at first, not a number where they hold nothing. ``way`` is that
    of the drives up to here, where this is a stretch of a run that began before. ``watch`` is told of the events of the
    scene.
    """
    faults = Faults()
    with faults.collecting():
        model = with_params(model, params)
    valued = not faults
    with faults.collecting():
        options = options_of(
            model,
            until=until,
            rtol=rtol,
            atol=atol,
            method=method,
            inputs=inputs,
            step=step,
            drift=drift,
            on_gain=on_gain,
            progress=progress,
            keep_interrupted=keep_interrupted,
            before=state.settings if isinstance(state, HybridState) else None,
        )
    with faults.collecting():
        if state is not None:
            check_state(model if valued else None, state, q0, u0)
            q, u = state.q, state.u
        else:  # where a start is depends on the values
            q, u = checked_start(model, q0, u0, begin) if valued else read_start(model, q0, u0)
    faults.stop_if_any()
    asked, supply, kinks = options
    if state is not None:
        check_end(state, asked.until)

    found = model.kernels.simulate(
        q,
        u,
        asked.method,
        asked.until,
        asked.rtol,
        asked.atol,
        asked.step,
        STEP_BUDGET,
        RATE_BUDGET,
        checking(progress),
        supply,
        stops_of(model, kinks, asked.until, asked.step),
        asked.drift,
        None if state is None else state.memory,
        asked.on_gain,
        begin,
        latched,
        None if state is None else partial(check_left, state),
        None if watch is None else watch.armed_before,
        None if watch is None else watch.halts,
    )
    if found["outcome"] == "interrupted" and not keep_interrupted:
        raise KeyboardInterrupt
    if watch is not None:
        watch.take(found)
    return _run_of(model, options, inputs, way, found)


def _run_of(model: Model, options: Options, inputs: Given, way: Way | None, found: dict[str, Any]) -> Run:
    """The run from what the core has found."""
    asked, supply, _ = options
    if model.data["drives"] and found["outcome"] not in GOES_ON:
        own, holding = (asked.own_rtol, asked.own_rtol), Latched(found["t"], found["latched"])
        held = (found["hold_t"], found["held"])
        exact = Advance(model, asked.method, asked.drift, *held, own, found["scales"], inputs, supply, holding)
        rows = (found["t"], found["q"], found["u"])
        since = int(np.searchsorted(found["t"], found["hold_t"][-1])) if len(found["hold_t"]) else 0
        contacts = found["held"][-1] if found["held"] else ()
        way = way or Way(float(found["t"][0]), {})
        if met := dead_point(model, *rows, asked.step, exact, way, since, contacts):
            found = cut(found, met.rows) | {"met": met.text}
    tolerances = (0.0, 0.0) if asked.step else (asked.rtol, asked.atol)
    stepped = tuple(
        (found["t"][first : last + 1], found["q"][first : last + 1], found["u"][first : last + 1])
        for *_, first, last in found["stepping"]
    )
    held, scales, holding = (found["hold_t"], found["held"]), found["scales"], Latched(found["t"], found["latched"])
    advance = Advance(model, asked.method, asked.drift, *held, tolerances, scales, inputs, supply, holding, stepped)
    left = None if "met" in found else (found["state"], asked)  # not where rows are cut off
    return run_of(model, advance, asked.until, found, asked.step > 0.0, left)
