"""States that a search for periodic motions tries, told: what is wrong with one is not wrong with the guess."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from ..arrays import FloatArray
from ..model.model import Model
from .values import names_of, unit_of

SHOWN = 6
"""As many coordinates and rates of a state a sentence has."""

State = tuple[FloatArray, FloatArray]


def told(model: Model, state: State) -> str:
    """A state (n,), (n,) for a sentence."""
    named = zip(names_of(model), np.concatenate(state).tolist(), strict=True)
    parts = [f"{name} = {value:.6g} {unit_of(name)}" for name, value in named]
    return ", ".join(parts[:SHOWN]) + (", …" if len(parts) > SHOWN else "")


def why(model: Model, error: ValueError) -> str:
    """An error without the advice behind its last semicolon, which is for a start that a user gave."""
    text = str(error).removeprefix(f"{model.name}: ")
    return text.rpartition("; ")[0] or text


@contextmanager
def trying(model: Model, step: int, guess: State, state: State) -> Iterator[None]:
    """Make a ``ValueError`` of a state that Newton's method came to in a step, from 1 on, tell that, and what to try.

    Before the first step the state is the guess, and errors are left as they are.
    """
    try:
        yield
    except ValueError as error:
        if step == 0:
            raise
        raise ValueError(
            f"{model.name}: found no periodic motion: from the guess {told(model, guess)} step {step} of Newton's "
            f"method led to {told(model, state)}, where no run could be made: {why(model, error)}; begin nearer to the "
            "motion (q0 and u0, --guess), or try a smaller rtol or a longer until"
        ) from error
