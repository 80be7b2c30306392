"""A run through the events that its scene asks for, and through joints that let go and take hold (docs/theory.md,
sections 5.15 and 5.17)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..faults import Faults, UnknownName
from ..model.model import Model, with_params
from ..record.event import Event
from ..record.hybrid_state import HybridState
from ..run import Run
from .changes import DIRECTIONS, Answered, check_settable, values_of, with_values
from .joint_changes import changes_of
from .one_run import record_of
from .stretches import strung

STOP = "stop"
"""What a function of an event answers for the run to end there."""

Answer = Mapping[str, float] | str | None
OnEvent = Mapping[str, Callable[[Event], Answer]]


def simulate_with_events(
    model: Model,
    q0: ArrayLike | None,
    u0: ArrayLike | None,
    *,
    params: Mapping[str, float] | None,
    on_event: OnEvent | None,
    state: HybridState | None = None,
    **options: Any,
) -> Run:
    """The run of a model whose scene has events, or joints that let go or take hold, with the arguments of
    :func:`~..simulate.simulate`."""
    faults = Faults()
    with faults.collecting():
        model = with_params(model, params)
    with faults.collecting():
        check_functions(model, on_event)
    before = state.changed if isinstance(state, HybridState) else frozenset[str]()
    now = model  # the core has the values of a state in that, and the scales of the motion from the model
    if isinstance(state, HybridState) and not faults:
        now = model.with_parameters(_set_before(model, state, params))
    asked = Asked(now, on_event if isinstance(on_event, Mapping) else {})
    record = record_of(model, q0, u0, now=now, faults=faults, state=state, events=asked.events, **options)
    return strung(record, asked.answers, before)


def _set_before(model: Model, state: HybridState, params: Mapping[str, float] | None) -> dict[str, float]:
    """Values that events have set on the way to a state. What is asked for now is none of them, and is told of where
    the state has another value."""
    own = state.changed - set(params or ()) if state.changed <= model.parameters.keys() else ()
    return {path: state.parameters[path] for path in sorted(own) if path in state.parameters}


def check_functions(model: Model, on_event: object) -> None:
    """Raise ``ValueError`` or ``TypeError`` unless these are functions by names of the model's events, or nothing."""
    faults = Faults()
    names = [said["name"] for said in model.data.get("events", ())]
    if on_event is not None and not isinstance(on_event, Mapping):
        faults.note(TypeError(f"on_event: found {on_event!r}, expected functions by names of events, or None"))
    for name, function in on_event.items() if isinstance(on_event, Mapping) else ():
        if name not in names:
            faults.add(f"on_event: found {name!r}, expected the name of an event; {_known(names)}")
        if not callable(function):
            faults.note(TypeError(f"on_event: found {function!r} for {name!r}, expected a function of the event"))
    if model.folded and any(said["set"] for said in model.data.get("events", ())):
        faults.add(
            f"{model.name}: found events that set parameters, which are folded into the code as numbers, expected a "
            "model without --fold; generate it so"
        )
    faults.stop_if_any()


def _known(names: Sequence[str]) -> str:
    return f"those of the scene are {', '.join(names)}" if names else "the scene has no [[event]]"


class Asked:
    """What the functions of a run are asked at its events, and their ``answers`` so far."""

    def __init__(self, model: Model, on_event: OnEvent) -> None:
        self.model, self.on_event = model, on_event
        self.said: Sequence[Mapping[str, Any]] = model.data.get("events", ())
        self.names, self.values = [*model.settable], values_of(model)
        self.answers: list[Answered] = []
        self.counts: dict[str, int] = {}

    @property
    def events(self) -> tuple[Sequence[bool], Callable[..., tuple[str, FloatArray | None]] | None]:
        """At which indicators the core asks, and what."""
        asked = [one["name"] in self.on_event for one in self.said]
        return [*asked, *[False] * len(changes_of(self.model))], self if any(asked) else None

    def __call__(
        self, indicator: int, direction: int, t: float, q: FloatArray, u: FloatArray, values: FloatArray
    ) -> tuple[str, FloatArray | None]:
        """What a function answers to an event, as the core takes it, and what ``values`` (parameters,) are then, if it
        sets some."""
        name = self.said[indicator]["name"]
        number = self.counts[name] = self.counts.get(name, 0) + 1
        answer = self.on_event[name](Event(float(t), name, DIRECTIONS[direction], number, q, u))
        if answer is None or answer == STOP:
            self.answers.append(Answered(name, number, {}, ends=answer == STOP))
            return "end" if answer == STOP else "go_on", None
        if not isinstance(answer, Mapping):
            raise TypeError(
                f"on_event: found {answer!r} from the function of {name!r}, expected None, values of parameters by "
                f'path, or "{STOP}"'
            )
        with suppress(ValueError):  # what the scene sets beside, which the core refuses unless this is another value
            self.model, self.values = with_values(self.model, self.values, values), values
        try:
            check_settable(self.model, answer)
            self.model.with_parameters(answer)
        except (ValueError, UnknownName) as error:
            self.answers.append(Answered(name, number, {}, error=error))
            return "refuse", None
        self.answers.append(Answered(name, number, {path: float(value) for path, value in answer.items()}))
        found = np.array(values)
        for path, value in answer.items():
            found[self.names.index(path)] = value
        return "go_on", found
