"""How joints let go and take hold in a run (docs/theory.md, section 5.15)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from .._core import TOLERANCES
from ..arrays import FloatArray
from ..model.assembly import UNPROJECTED, project
from ..model.model import Model
from ..record.impact import Impact

WORDS = {
    "angle": "the angle of",
    "direction": "the direction of",
    "slide": "the length along",
    "height": "the height of",
}


@dataclass(frozen=True)
class Held:
    """A state ``q``, ``u`` (n,) of a ``model`` in which a joint has taken hold, by an ``impact``; its points were
    ``gap`` (m) apart, and ``energy`` (J) is what the mechanism got as they were drawn together."""

    model: Model
    q: FloatArray
    u: FloatArray
    impact: Impact
    gap: float
    energy: float


def gate_of(model: Model, joint: str) -> str:
    """The parameter that is 1 while a joint holds and 0 while it is open."""
    return str(model.data["switching"]["ends"][joint]["gate"])


def fits(model: Model, said: Mapping[str, Any]) -> bool:
    """Whether a change is one that can come: a joint lets go while it holds, and takes hold while it is open."""
    held = model.parameters[gate_of(model, said["joint"])] == 1.0
    return held is (said["kind"] == "release")


def with_gate(model: Model, joint: str, held: bool) -> Model:
    """The model in which a joint holds, or is open."""
    return model.with_parameters({gate_of(model, joint): float(held)}).as_nobody_changes_it()


def take_hold(model: Model, said: Mapping[str, Any], t: float, q: FloatArray, u: FloatArray) -> Held:
    """The state behind the plastic impact at ``t`` (s) by which a joint takes hold of a mechanism that does not have it
    yet, its loops staying shut and its drives going on (docs/theory.md, eq. 5.26). ``q`` and ``u`` are (n,).

    Raises ``ValueError`` where its points are too far apart, or it cannot hold there.
    """
    joint = said["joint"]
    there = with_gate(model, joint, held=True)
    rows = [k for k, row in enumerate(there.rows) if row.rpartition(".")[0] == joint]
    gap = float(np.linalg.norm(there.closure(q)[rows]))
    within = said["within"] or TOLERANCES["HOLDS_WITHIN"].value * model.length
    if gap > within:
        raise ValueError(
            f"{joint} is to take hold, but its points are {gap:.3g} m from where it holds, expected at most "
            f"{within:.3g} m; let it take hold elsewhere, or set within"
        )
    after, loss, reactions, outcome = there.kernels.take_hold(np.ascontiguousarray(q), np.ascontiguousarray(u))
    if outcome != "done":
        raise ValueError(f"{joint} cannot take hold: {UNPROJECTED[outcome]}")
    size = float(np.hypot(*reactions[model.joints.index(joint), :2]))
    impact = Impact(t, ((joint, "hold"),), u, after, np.array([size]), float(loss), np.zeros(1), reactions)
    try:
        new_q, new_u = project(there, q, after)
    except ValueError as error:
        raise ValueError(f"{joint} cannot take hold: {error}") from error
    energy = float(sum(there.energy(new_q, new_u)) - sum(there.energy(q, after)))
    return Held(there, new_q, new_u, impact, gap, energy)


def broken_by(model: Model, impact: Impact) -> list[Mapping[str, Any]]:
    """Changes that the impulses of a joint that takes hold bring, to others or to itself."""
    return [
        said
        for said in model.data["switching"]["changes"]
        if said["impulse"] is not None
        and fits(model, said)
        and np.hypot(*impact.reactions[model.joints.index(said["joint"]), :2]) >= said["impulse"]
    ]


def why(said: Mapping[str, Any]) -> str:
    """What brings a change, in words."""
    if said["at"] is not None:
        return f"its time has come, {said['at']:g} s"
    if watch := said["watch"]:
        words = WORDS.get(watch["kind"])
        what = f"{words} {watch['names'][0]}" if words else f"the distance of {' and '.join(watch['names'])}"
        unit = "rad" if watch["kind"] in ("angle", "direction") else "m"
        return f"{what} comes {'above' if watch['sign'] > 0 else 'below'} {watch['limit']:.6g} {unit}"
    limits = [f"{said[key]:g} {unit}" for key, unit in (("force", "N"), ("impulse", "N s")) if said[key] is not None]
    return f"it carries its limit, {' or '.join(limits)}" if limits else "its points meet"
