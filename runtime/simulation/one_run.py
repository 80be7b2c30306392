"""One run: arguments that are checked, the compiled run, and what stopped it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from numpy.typing import ArrayLike

from ..model.inputs import Given, supply_of
from ..model.model import Model
from ..record.hybrid_state import HybridState
from ..run import Run
from .advance import Advance
from .arguments import RATE_BUDGET, STEP_BUDGET, checked_start, settings_of, stops_of
from .dead_point import cut, dead_point
from .going_on import check_end, check_model, left_at
from .result import run_of

GOES_ON = ("done", "interrupted", "no_memory", "turned_far")
"""Ends of a run that say nothing of the motion after it."""


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
    progress: Callable[[float], object] | None,
    keep_interrupted: bool,
    params: Mapping[str, float] | None = None,
    state: HybridState | None = None,
) -> Run:
    """The run from one start, with the arguments of :func:`~..simulate.simulate`."""
    model = model.with_parameters(params) if params else model.as_it_is()
    if model.precision == "float" and model.contacts:
        raise ValueError(
            f"{model.name}: found a model in floats with contacts, expected none: floats are too coarse to find "
            'impacts; generate it with precision="double"'
        )
    supply, kinks = supply_of(model.inputs, inputs, model.core.Supply)
    if state is not None:
        check_model(model, state)
    before = None if state is None else state.settings
    asked = settings_of(model, until, rtol, atol, step, method, drift, controlled=callable(inputs), before=before)
    if state is None:
        q, u = checked_start(model, q0, u0)
    elif q0 is None and u0 is None:
        check_end(state, asked.until)
        q, u = state.q, state.u
    else:
        raise ValueError("q0, u0: found beside a state, which has its own, expected None; give one of the two")
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
        progress,
        supply,
        stops_of(model, kinks),
        asked.drift,
        None if state is None else state.memory,
    )
    if found["outcome"] == "interrupted" and not keep_interrupted:
        raise KeyboardInterrupt
    if model.data["drives"] and found["outcome"] not in GOES_ON:
        own = (asked.own_rtol, asked.own_rtol)
        exact = Advance(
            model, asked.method, asked.drift, found["hold_t"], found["held"], own, found["scales"], inputs, supply
        )
        if met := dead_point(model, found["t"], found["q"], found["u"], asked.step, exact):
            found = cut(found, met.rows) | {"met": met.text}
    tolerances = (0.0, 0.0) if asked.step else (asked.rtol, asked.atol)
    advance = Advance(
        model, asked.method, asked.drift, found["hold_t"], found["held"], tolerances, found["scales"], inputs, supply
    )
    left = None if "met" in found else left_at(found, asked)  # not where rows are cut off
    return run_of(model, advance, asked.until, found, asked.step > 0.0, left)
