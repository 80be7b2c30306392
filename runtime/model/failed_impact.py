"""Why contacts have no forces or impulses, and what to try: for a run that stops and for one impact alone."""

from __future__ import annotations

from collections.abc import Sequence

LIGHT_LINKS = "make light links that carry heavy ones heavier, or leave them out"
"""What to do where masses differ so much that no digit is sure."""


def failed_impact(outcome: str, contact: str, law: str, driven: Sequence[str] = ()) -> str:
    """One sentence for an ``outcome`` of the core ("jammed", "gained", "repeats" or "inexact") at ``contact``, by the
    law named; ``driven`` are the joints whose motion is prescribed, against which friction may jam."""
    others = 'law = "poisson" or "stronge" in [run]' if law == "newton" else 'law = "stronge" in [run]'
    reasons = {
        "jammed": f"friction jams: the forces at {contact} have no solution, or more than one, as far as could be "
        "found (Painleve shows how that can be); take less friction or another start"
        + (f", or move {', '.join(driven)} by a [[motor]], which can give way, not by a [[drive]]" if driven else "")
        + (f", or if it jams in an impact, {others}" if law == "newton" else ""),
        "gained": f"an impact of {contact} by {law.title()}'s law would add energy; write {others}",
        "repeats": "impacts at one instant do not come to an end; check the coefficients of restitution",
        "inexact": f"masses differ so much that no digit of the force or impulse at {contact} is sure; {LIGHT_LINKS}",
    }
    return reasons.get(outcome, outcome.replace("_", " "))
