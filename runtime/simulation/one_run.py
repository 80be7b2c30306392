"""One run: arguments that are checked, the compiled run, and what stopped it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
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

if TYPE_CHECKING:
    from .._core import Supply

Events = tuple[Sequence[bool], Callable[..., tuple[str, FloatArray | None]] | None]

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


class Recorded(NamedTuple):
    """What the core has ``found`` in the run that a ``model`` begins with these ``options`` and ``inputs``."""

    model: Model
    options: Options
    inputs: Given
    found: dict[str, Any]


def record_of(
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
    now: Model,
    faults: Faults,
    state: HybridState | None = None,
    events: Events | None = None,
) -> Recorded:
    """What the core records of the run from one start, with the arguments of :func:`~..simulate.simulate` but
    ``params``, which the ``model`` has.

    ``now`` is the model with what events have set on the way to the ``state``, if there is one. ``faults`` are what has
    been found wrong before; all is said at once. ``events`` is what the core asks at events of
    the scene: at which indicators, and a function; ``None`` for a scene that has none.
    """
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
            check_state(now if valued else None, state, q0, u0)
            q, u = state.q, state.u
        else:  # where a start is depends on the values
            q, u = checked_start(model, q0, u0) if valued else read_start(model, q0, u0)
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
        None if state is None else partial(check_left, state),
        events,
    )
    if found["outcome"] == "interrupted" and not keep_interrupted:
        raise KeyboardInterrupt
    return Recorded(now, options, inputs, found)


def simulate_one(
    model: Model, q0: ArrayLike | None, u0: ArrayLike | None, *, params: Mapping[str, float] | None, **options: Any
) -> Run:
    """The run from one start of a scene without events, with the arguments of :func:`~..simulate.simulate`."""
    faults = Faults()
    with faults.collecting():
        model = with_params(model, params)
    record = record_of(model, q0, u0, now=model, faults=faults, **options)
    return run_of_record(record, model, record.found, Way(float(record.found["t"][0]), {}))


def run_of_record(record: Recorded, model: Model, found: dict[str, Any], way: Way) -> Run:
    """The run of what the core has found, or of a part of that by another ``model`` than at first; ``way`` is that of
    the drives up to there."""
    (asked, supply, _), inputs = record.options, record.inputs
    if model.data["drives"] and found["outcome"] not in GOES_ON:
        own, holding = (asked.own_rtol, asked.own_rtol), Latched(found["t"], found["latched"])
        held = (found["hold_t"], found["held"])
        exact = Advance(model, asked.method, asked.drift, *held, own, found["scales"], inputs, supply, holding)
        rows = (found["t"], found["q"], found["u"])
        since = int(np.searchsorted(found["t"], found["hold_t"][-1])) if len(found["hold_t"]) else 0
        contacts = found["held"][-1] if found["held"] else ()
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
