"""Runs that go on from where another has come to."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..model.model import Model
from ..record.hybrid_state import HybridState


def check_state(model: Model | None, state: HybridState, q0: object, u0: object) -> None:
    """Refuse a state that is not one of ``model`` with its values, where these are known, or has a start beside it."""
    if not isinstance(state, HybridState):
        raise TypeError(f"state: found {type(state).__name__}, expected a HybridState; take run.state")
    if q0 is not None or u0 is not None:
        raise ValueError("q0, u0: found beside a state, which has its own, expected None; give one of the two")
    if model is None:
        return
    if state.model != model.name:
        raise ValueError(f"state: found one of {state.model}, expected one of {model.name}; give a start instead")
    values = dict(model.parameters)
    others = [name for name in {**values, **state.parameters} if values.get(name) != state.parameters.get(name)]
    if others:
        raise ValueError(
            f"state: found one with another {', '.join(others[:3])}{', …' if len(others) > 3 else ''}, expected that "
            "of the model; set the values that it had, or begin anew from its q and u"
        )


def check_end(state: HybridState, until: float) -> None:
    """Refuse a state that is after ``until`` (s); at it the run is one row."""
    if not until >= state.t:
        raise ValueError(f"until: found {until}, expected the state's t = {state.t} or more; ask for a later end")


def check_left(state: HybridState, t: float, q: FloatArray, u: FloatArray) -> None:
    """Refuse a state with another t (s), q or u (n,) than the core has in its memory, by which alone it goes on."""
    for name, expected in {"t": t, "q": q, "u": u}.items():
        given = np.asarray(getattr(state, name))
        if not np.array_equal(given, np.asarray(expected)):
            raise ValueError(
                f"state.{name}: found {np.array2string(given, threshold=4)}, expected "
                f"{np.array2string(np.asarray(expected), threshold=4)}, where the run was left that the state is of; "
                "begin anew from another q and u, as its memory is of these alone"
            )
