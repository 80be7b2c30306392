"""The run from what the core found: its impacts and phases, and its audits."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..model.model import Model
from ..record.impact import Impact
from ..record.phase import Phase
from ..record.unexplained import largest
from ..run import Run
from .advance import Advance
from .ending import message_of
from .forces_along import along, impulses_of_joints

AUDITED = 4
"""Rows of a run, at most, at which the rounding of its accelerations is measured."""


def run_of(
    model: Model,
    advance: Advance,
    until: float,
    found: dict[str, Any],
    fixed: bool,
    left: tuple[bytes, object] | None,
) -> Run:
    """The run from what the core recorded, with its audits, and what it has ``left`` to go on from."""
    impacts = _impacts(model, found)
    t, q, u = found["t"], found["q"], found["u"]
    spent = found["work"] - found["work"][0]
    for impact, row in zip(impacts, found["after"], strict=True):
        spent[row:] -= impact.energy_loss
    _account_for_steps(found, spent)
    closure_max, closure_rate_max, *rounding, unexplained = model.kernels.audit(q, u, spent, t.size // AUDITED + 1)

    return Run(
        model=model,
        t=t,
        q=q,
        u=u,
        impacts=impacts,
        phases=_phases(model, found, impacts),
        success=found["outcome"] == "done",
        message=message_of(model, until, found, fixed),
        nfev=int(found["evaluations"]),
        closure_max=closure_max,
        energy_drift=largest(unexplained),
        advance=advance,
        motion=along(advance, found),
        method=advance.method,
        drift=advance.drift,
        rest_speed=found["rest_speed"],
        choices=found["choices"],
        chosen_at=found["chosen_at"],
        closure_rate_max=closure_rate_max,
        acceleration_error=_acceleration_error(model, found, *rounding),
        unexplained=unexplained,
        traced=found["trace"],
        left=left,
    )


def _account_for_steps(found: dict[str, Any], spent: FloatArray) -> None:
    """Put what contacts took in time stepping into ``spent`` (rows,), the energy that each row has more than the first:
    J. It is recorded apart from the work of effects, whatever does some."""
    for (*_, first, last), jumps in zip(found["stepping"], found["jumps"], strict=True):
        taken = np.cumsum(jumps[: last - first])
        spent[first + 1 : last + 1] += taken
        spent[last + 1 :] += taken[-1]


def _acceleration_error(model: Model, found: dict[str, Any], lost: float, whole: float) -> float:
    """What refinement has left; without it what is ``lost`` by rounding at a few rows, of accelerations so large."""
    if model.kernels.refined:
        return float(found["inexact"])
    return lost / max(whole, model.usual) if lost else 0.0


def _impacts(model: Model, found: dict[str, Any]) -> tuple[Impact, ...]:
    if not found["impact_t"].size:
        return ()  # most runs: they need not pay for the arrays
    records = []
    reactions = impulses_of_joints(model, found)
    for i, t in enumerate(found["impact_t"]):
        part = slice(found["first"][i], found["first"][i + 1])
        records.append(
            Impact(
                t=t.item(),
                contacts=tuple(model.contacts[c] for c in found["contacts"][part]),
                u_minus=found["u_minus"][i],
                u_plus=found["u_plus"][i],
                impulses=found["impulses"][part],
                energy_loss=found["energy_loss"][i].item(),
                restitution_share=found["share"][i].item(),
                friction=found["friction"][part],
                reactions=reactions[i],
            )
        )
    return tuple(records)


def _phases(model: Model, found: dict[str, Any], impacts: tuple[Impact, ...]) -> tuple[Phase, ...]:
    """Flights and contacts, and the impacts that end them."""
    start, end = found["t"][0].item(), found["t"][-1].item()
    if not impacts and not found["held"] and not found["stepping"]:
        return (Phase("flight", start, end),) if end > start else ()
    steps = {
        t0: (step, miss, -float(np.sum(jumps[: last - first])))
        for (t0, _, step, miss, first, last), jumps in zip(found["stepping"], found["jumps"], strict=True)
    }
    changes = zip(found["hold_t"], found["held"], [[], *found["held"]], strict=False)
    marks: list[tuple[float, int, list[tuple[int, str]]]] = [
        (t.item(), 1, held) for t, held, before in changes if held != before
    ]
    marks += [(impact.t, 0, []) for impact in impacts]
    marks += [(t, 2, []) for t0, t1, *_ in found["stepping"] for t in (t0, t1)]
    phases: list[Phase] = []
    now, held = start, list[tuple[int, str]]()
    for t, change, new in [*sorted(marks, key=lambda mark: mark[:2]), (end, 0, [])]:
        if t > now and now in steps:
            phases.append(Phase("steps", now, t, (), (), *steps[now]))
            now = t
        elif t > now:
            contacts = tuple(model.contacts[contact] for contact, _ in held)
            phases.append(Phase("contact" if held else "flight", now, t, contacts, tuple(how for _, how in held)))
            now = t
        if change == 1:
            held = new
        elif change == 2:
            continue
        elif t < end or any(impact.t == t for impact in impacts):
            phases.append(Phase("impact", t, t))
    return tuple(phases)
