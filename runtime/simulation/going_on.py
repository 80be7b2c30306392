"""Runs that go on from where another has come to."""

from __future__ import annotations

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
    """Refuse a state that is not before ``until`` (s)."""
    if not until > state.t:
        raise ValueError(f"until: found {until}, expected more than the state's t = {state.t}; ask for a later end")
