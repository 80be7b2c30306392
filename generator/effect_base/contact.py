"""What the contacts of several effects share: the law of impact, radii, and how deep a start may be inside."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

Law = Literal["newton", "poisson", "stronge"]
"""What restitution means: a ratio of speeds, of impulses, or, squared, of work."""

OnGain = Literal["reduce", "stop"]
"""What becomes of an impact that would gain energy: it has less restitution, or the run stops."""

Radius = Annotated[float, Field(ge=0.0)]

DEPTH = 1e-9
"""A start deeper than this (m) is inside the ground; less is rounding."""
