"""Why contacts have no forces or impulses, and what to try: for a run that stops and for one impact alone."""

from __future__ import annotations

from collections.abc import Sequence


def failed_impact(outcome: str, contact: str, law: str, driven: Sequence[str] = ()) -> str:
    """One sentence for an ``outcome`` of the core ("jammed", "gained" or "repeats") at ``contact`` by the law named;
    ``driven`` are the joints whose motion is prescribed, against which friction may jam."""
    others = 'law = "poisson" or "stronge" in [run]' if law == "newton" else 'law = "stronge" in [run]'
    reasons = {
        "jammed": f"friction jams: the forces at {contact} have no solution, or more than one, as far as could be "
        "found (Painleve shows how that can be); take less friction or another start"
        + (f", or move {', '.join(driven)} by a [[motor]], which can give way, not by a [[drive]]" if driven else "")
        + (f", or if it jams in an impact, {others}" if law == "newton" else ""),
        "gained": f"an impact of {contact} by {law.title()}'s law would add energy; write {others}",
        "repeats": "impacts at one instant do not come to an end; check the coefficients of restitution",
    }
    return reasons.get(outcome, outcome.replace("_", " "))
