"""How a run ended, in a sentence."""

from __future__ import annotations

from typing import Any

from ..model.drives import driven_against
from ..model.failed_impact import LIGHT_LINKS, failed_impact
from ..model.model import Model
from ..model.tolerances import largest_angle
from ..model.ways_on import ways_on
from .arguments import RATE_BUDGET, STEP_BUDGET
from .without_value import without_value


def message_of(model: Model, until: float, found: dict[str, Any], fixed: bool) -> str:
    """One sentence on how the run, with steps of ``fixed`` length or not, ended; what to try when it ended early."""
    t, outcome = found["t_end"], found["outcome"]
    if outcome == "done":
        return f"reached t = {until:g} s"
    if "met" in found:
        return f"stopped at t = {t:.12g} s: {found['met']}"
    contact, driven = "a contact", [drive["joint"] for drive in model.data["drives"]]
    if found["contact"] >= 0:
        contact = "{} on {}".format(*model.contacts[found["contact"]])
    reasons = {
        "accumulation": f"events of {contact} and others follow each other without time between them; change the "
        "start or the coefficients of restitution a little",
        "not_finite": "an acceleration is not a finite number; check the parameters and the start",
        "step_too_small": "no step is small enough for the tolerance; "
        "ask for a larger rtol, or, where a loop lies in a line, for another",
        "no_branch": ways_on(model, found["q"][-1], found["u"][-1]) if outcome == "no_branch" else "",
        "two_lines": "one loop comes into a line exactly, and another misses it by very little there, so that the "
        "motion beyond cannot be told; make both lie in it exactly, or the miss larger",
        "not_closed": "the loops cannot be kept closed; ask for a smaller rtol",
        **{key: failed_impact(key, contact, model.data["law"], driven) for key in ("repeats", "jammed", "gained")},
        "budget": f"{STEP_BUDGET} steps are spent; ask for a larger rtol or an earlier end",
        "endless": f"at the pace of its last steps it would take more than {1000 * STEP_BUDGET:.0e} of them to its "
        "end; ask for an earlier end, or look at what moves so fast there",
        "crowded": f"{RATE_BUDGET} steps and events within a characteristic time are spent; ask for a larger "
        "rtol, or change the start a little if the mechanism is jammed there",
        "escaped": f"a step of fixed length takes {contact.replace(' on ', ' behind the surface of ')}; take a smaller "
        "step, or leave its length to rtol"
        if fixed
        else f"{contact} gets behind its surface however short the step, as at a change point where the motion "
        "jumps; change the start or the lengths a little",
        "interrupted": "interrupted",
        "no_convergence": "the stages of a step do not converge; ask for a smaller step or for another method",
        "not_kept": "the next step would gain or lose more than a tenth of the energy in motion; take a smaller "
        "step, or leave its length to rtol"
        if fixed
        else "neither from event to event nor by time stepping does the run get further without gaining energy; change "
        "the start a little",
        "inexact": failed_impact("inexact", contact, model.data["law"])
        if found["contact"] >= 0
        else f"masses differ so much that no digit of the accelerations is sure; {LIGHT_LINKS}",
        "turned_far": _turned_far(model, found) if outcome == "turned_far" else "",
        "no_memory": "memory ran out; record less by ending earlier",
    }
    reason = reasons[outcome]
    if outcome in ("not_finite", "step_too_small"):
        reason = without_value(model, found) or reason
    if outcome in ("repeats", "jammed", "gained") and (hit := driven_against(model, found["q"][-1], found["u"][-1])):
        reason = (
            f"{hit[0]} is driven into {hit[1]} by {', '.join(driven)}, whose prescribed motion no impact can change; "
            "keep it clear of there, or move the joint by a [[motor]], which can give way"
        )
    return f"stopped at t = {t:.12g} s: {reason}"


def _turned_far(model: Model, found: dict[str, Any]) -> str:
    """Which angle has become too large, and what to do."""
    angles, rates = found["q"][-1], found["u"][-1]
    farthest = max(model.angular, key=lambda k: abs(angles[k]), default=0)
    return (
        f"{model.q_of[farthest]} comes to {largest_angle(model.core):.2g} rad, beyond which no digits are left of "
        f"where links point; it turns at {rates[farthest]:.3g} rad/s: check what drives it, or end earlier"
    )
