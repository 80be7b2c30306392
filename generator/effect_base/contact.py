"""What the contacts of several effects share: the law of impact, radii, and how deep a start may be inside."""

from __future__ import annotations

from typing import Annotated, Literal, get_args

from pydantic import Field

from .written_numbers import Measured

Law = Literal["newton", "poisson", "stronge"]
"""What restitution means: a ratio of speeds, of impulses, or, squared, of work. This is the generator's only list of
laws. All impacts of a scene follow one of them, the first where it names none."""

LAWS: tuple[Law, ...] = get_args(Law)

LAW_MEANS = f"the law of all impacts: {', '.join(LAWS[:-1])} or {LAWS[-1]}"
"""What a key ``law`` is, for fault sentences."""

OnGain = Literal["reduce", "stop"]
"""What becomes of an impact that would gain energy: it has less restitution, or the run stops."""

Restitution = Annotated[float, Field(ge=0.0, le=1.0), Measured("1")]
Friction = Annotated[float, Field(ge=0.0), Measured("1")]
Radius = Annotated[float, Field(ge=0.0), Measured("m")]

DEPTH = 1e-9
"""A start deeper than this (m) is inside the ground; less is rounding."""
