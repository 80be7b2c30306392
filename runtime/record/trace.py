"""The last of what a run did beside steps that were accepted: how its stages followed each other, which steps it
refused and why, where effects came to another side of a kink."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import OUTCOMES
from ..arrays import FloatArray
from .drawable import Drawable

STAGES = ("start", "smooth motion", "event", "impacts", "choice of contacts", "time stepping", "end")
"""What the automaton does, in the order of ``enum stage`` (runtime/core/hybrid/automaton.h)."""
EVENTS = {-1: "closes", -2: "is carried no more", -3: "jams"}
"""What a contact does, by ``enum`` of runtime/core/steps/event.h; else how it is held changes."""
STAGE, REFUSAL, KINK = range(3)


@dataclass(frozen=True)
class Traced:
    """At ``t`` (s) the run did what ``what`` says; ``refused``: it refused a step."""

    t: float
    what: str
    refused: bool = False

    def __str__(self) -> str:
        return f"t = {self.t:.12g} s: {self.what}"


def trace_of(model: Drawable, numbers: FloatArray, words: NDArray[np.int32]) -> tuple[Traced, ...]:
    """The lines of what the core has kept: (n, 3) times, lengths of steps and errors, (n, 6) whole numbers."""
    return tuple(
        Traced(one[0].item(), _what(model, one, *row), row[0] == REFUSAL)
        for one, row in zip(numbers, words.tolist(), strict=True)
    )


def _what(model: Drawable, one: Any, kind: int, of: int, to: int, contact: int, watch: int, outcome: int) -> str:
    _, h, error = one.tolist()
    why = OUTCOMES[outcome].replace("_", " ")
    where = "{} on {}".format(*model.contacts[contact]) if contact >= 0 else ""
    if kind == KINK:
        return f"an effect comes to the other side of its kink, number {of}"
    if kind == REFUSAL:
        if outcome:
            reason = f"{why}, {where}" if where else why
        elif np.isfinite(error):
            reason = f"its error is {float(error):.3g} times what it may be"
        else:
            reason = "its error is not known"
        return f"a step of {float(h):.3g} s is refused: {reason}"
    way = f"{STAGES[of]} -> {STAGES[to]}" if to != of else f"{STAGES[of]} fails"
    if outcome:
        return f"{way}: {why}"
    if STAGES[to] == "event" and where:
        return f"{way}: {where} {EVENTS.get(watch, 'changes how it is held')}"
    return way
