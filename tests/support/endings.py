"""How a run ended, by its message: a reason that is known, that can be so in this run, and what to try."""

from __future__ import annotations

import re
from typing import Any

REASONS = {
    "accumulation": r"events of (?P<contact>.+) and others follow each other without time between them; change the .+",
    "step_too_small": r"no step is small enough for the tolerance; ask for .+",
    "no_branch": r"a loop lies in a line, and these velocities are those of neither motion .+; give .+",
    "two_lines": r"one loop comes into a line exactly, and another misses it by very little .+; make both .+",
    "not_closed": r"the loops cannot be kept closed; ask for a smaller rtol",
    "repeats": r"impacts at one instant do not come to an end; check .+",
    "jammed": r"friction jams: the forces at (?P<contact>.+) have no solution, or .+; take less friction .+",
    "gained": r"an impact of (?P<contact>.+) by (?P<law>\w+)'s law would add energy; write .+",
    "crowded": r"\d+ steps and events within a characteristic time are spent; ask for .+",
    "escaped": r"(?P<contact>.+) gets behind its surface however short the step, .+; change .+",
    "overstepped": r"a step of fixed length takes (?P<contact>.+); take a smaller step, .+",
    "no_convergence": r"the stages of a step do not converge; ask for .+",
    "turned_far": r"[\w.]+ comes to \S+ rad, beyond which no digits are left of where links point; it turns at .+",
    "not_kept": r"the next step would gain or lose more than a tenth of the energy in motion; take a smaller step, .+",
}
"""What a run that is asked for reasonably may stop for: the reason, then what to try.

Accelerations that are not finite, memory that runs out, masses without a sure digit and all steps of a run spent are
not among them: they have a place in no survey.
"""
DONE = "done"


def ending(run: Any) -> str:
    """``DONE``, or the key in :data:`REASONS` of what the run stopped for; ``ValueError`` where the message is wrong.

    It is wrong where it names no known reason or more than one, another instant than the last of the record, a contact
    that the model has not, another law than the model's, friction that jams on smooth ground, or energy that Stronge's
    law adds.
    """
    if run.success:
        if run.message != f"reached t = {run.t[-1]:g} s":
            raise ValueError(f"the record ends at {run.t[-1]!r} s: {run.message}")
        return DONE
    stopped = re.fullmatch(r"stopped at t = (\S+) s: (.+)", run.message)
    if not stopped or stopped[1] != f"{run.t[-1]:.12g}":
        raise ValueError(f"no instant, or not the last of the record, {run.t[-1]!r} s: {run.message}")
    found = {key: said for key, reason in REASONS.items() if (said := re.fullmatch(reason, stopped[2]))}
    if len(found) != 1:
        raise ValueError(f"{len(found)} known reasons: {run.message}")
    ((key, said),) = found.items()
    contact, law = said.groupdict().get("contact"), said.groupdict().get("law")
    between = " behind the surface of " if key == "overstepped" else " on "
    if contact and contact not in {between.join(pair) for pair in run.model.contacts}:
        raise ValueError(f"no contact of the model: {run.message}")
    if law and (law != run.model.data["law"].title() or law == "Stronge"):
        raise ValueError(f"a law that cannot be so: {run.message}")
    if key == "jammed" and not any(k.endswith(".friction") and v > 0.0 for k, v in run.model.parameters.items()):
        raise ValueError(f"nothing is rough: {run.message}")
    return key
