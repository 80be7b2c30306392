"""Why what events ask for at an instant cannot be, or a joint cannot take hold there: nothing of that instant is set
then, and the run ends at it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .._core import TOLERANCES
from ..arrays import FloatArray
from ..faults import UnknownName
from ..model.assembly import UNPROJECTED, project
from ..model.model import Model
from ..model.tolerances import joint_miss
from .arguments import checked_start
from .changes import Answered, Change, Told, check_settable, values_of, with_values
from .ending import message_of
from .joint_changes import changes_of


def why_not(model: Model, found: dict[str, Any], told: Told, answers: Sequence[Answered]) -> str:
    """How a run of the ``model`` has ended at an instant at which not all can be that is asked for, in a sentence;
    empty of one that has ended otherwise."""
    done = len(found["origins"])
    tried = [Change(*one) for one in found["changes"][done:]]
    if not tried or found["outcome"] == "interrupted":
        return ""
    stopped, now = f"stopped at t = {found['t'][-1]:.12g} s", told.begins[-1].model
    if found["outcome"] == "set_without_end":
        what = "events set parameters" if model.data.get("events") else "joints let go and take hold"
        return f"{stopped}: {what} without end; change when they come"
    if found["outcome"] == "cannot_set":
        return f"{stopped} by {_not_settable(now, told, found, tried, answers)}"
    last, q, u = tried[-1], found["q"][-1], found["u"][-1]
    try:
        now = with_values(now, values_of(now), found["values"][-1])
        if last.gate >= 0:
            _check_hold(now, found, last, q)
            q, u = project(now, q, u)
        _check_closed(now, q)
        checked_start(now, q, u, float(found["t"][-1]))
    except ValueError as error:
        drawn = last.gate >= 0 and found["outcome"] != "too_far" and last.gap > joint_miss(now.core.REAL, now.length)
        if drawn:
            stopped += (
                f": {_joint(now, last)} took hold and drew links together by {last.gap:.3g} m, to where no run begins"
            )
        return f"{stopped}: {error}"
    return message_of(now, 0.0, found, fixed=False)


def _not_settable(
    model: Model, told: Told, found: Mapping[str, Any], tried: Sequence[Change], answers: Sequence[Answered]
) -> str:
    """Which event asks the ``model`` in force for what cannot be, and what that is."""
    refused = answers[-1] if answers and answers[-1].error is not None else None
    if refused is not None:
        return f"the answer to {refused.name}: {_in_a_line(refused.error)}"
    said = model.data["events"]
    before = np.cumsum([0, *(len(one["set"]) + len({*one["on"], *one["off"]}) for one in said)])
    q, u = np.ascontiguousarray(found["q"][-1]), np.ascontiguousarray(found["u"][-1])
    values = model.kernels.event_values(found["t"][-1], q, u)
    by = tried[-1].indicator
    for change, behind in zip(tried, found["values"][-len(tried) :], strict=True):
        if change.gate >= 0:  # a joint beside it
            gate = [*model.settable][change.gate]
            model = model.with_parameters({gate: float(behind[change.gate])})
            continue
        by, one = change.indicator, said[change.indicator]
        own = values[before[change.indicator] :][: len(one["set"])]
        asked = {path: float(value) for path, value in zip(one["set"], own, strict=True)}
        try:
            check_settable(model, asked)
            model = model.with_parameters(asked)
        except (ValueError, UnknownName) as error:
            return f"{one['name']}: {_in_a_line(error)}"
    return f"{said[by]['name']}: what it sets leaves equations without numbers; set other values"


def _in_a_line(error: Exception | None) -> str:
    return "; ".join(str(error).splitlines())


def _joint(model: Model, change: Change) -> str:
    """The joint of a change."""
    gate = [*model.settable][change.gate]
    return next(joint for joint, path in model.joint_gates.items() if path == gate)


def _check_hold(model: Model, found: Mapping[str, Any], change: Change, q: FloatArray) -> None:
    """Raise ``ValueError`` where a joint cannot take hold of a ``model`` that has it."""
    joint, changes = _joint(model, change), changes_of(model)
    tables = [one for one in changes if one["joint"] == joint and one["kind"] == "hold"]
    number = change.indicator - len(model.data.get("events", ()))
    said = changes[number] if change.indicator >= 0 else tables[0] if tables else {"within": None}
    within = said["within"] or TOLERANCES["HOLDS_WITHIN"].value * model.length
    if change.gap > within:
        raise ValueError(
            f"{joint} is to take hold, but its points are {change.gap:.3g} m from where it holds, expected at most "
            f"{within:.3g} m; let it take hold elsewhere, or set within"
        )
    if outcome := UNPROJECTED.get(found["outcome"]):
        raise ValueError(f"{joint} cannot take hold: {outcome}")


def _check_closed(model: Model, q: FloatArray) -> None:
    """Raise ``ValueError`` unless the loops are shut and wheels mesh with the values that are set."""
    open_by = float(np.max(np.abs(model.closure(q)), initial=0.0))
    if open_by > joint_miss(model.core.REAL, model.length):
        raise ValueError(
            f"{model.name}: what events have set opens the loops by {open_by:.3g} m; set what leaves them shut"
        )
