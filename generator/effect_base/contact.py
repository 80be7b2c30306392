"""What the contacts of several effects share: the law of impact, radii, and how deep a start may be inside."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Literal, get_args

from pydantic import Field

Law = Literal["newton", "poisson", "stronge"]
"""What restitution means: a ratio of speeds, of impulses, or, squared, of work. This is the generator's only list of
laws: where the contacts of a scene have different ones, all its impacts follow the one that is named last here."""

LAWS: tuple[Law, ...] = get_args(Law)

LAW_MEANS = f"the law of impact: {', '.join(LAWS[:-1])} or {LAWS[-1]}"
"""What a key ``law`` is, for fault sentences."""

OnGain = Literal["reduce", "stop"]
"""What becomes of an impact that would gain energy: it has less restitution, or the run stops."""

Radius = Annotated[float, Field(ge=0.0)]

DEPTH = 1e-9
"""A start deeper than this (m) is inside the ground; less is rounding."""


def law_of_all(laws: Iterable[str]) -> str:
    """The law that all impacts of a scene follow whose contacts have these; the first of the list where it has none.

    Raises ``ValueError`` for a law that is not in the list: no other may stand in for it.
    """
    found = set(laws)
    if unknown := sorted(found - set(LAWS)):
        raise ValueError(
            f"law: found {', '.join(map(repr, unknown))}, expected one of {', '.join(LAWS)}; add a new law to Law in "
            "generator/effect_base/contact.py"
        )
    return next((law for law in reversed(LAWS) if law in found), LAWS[0])
