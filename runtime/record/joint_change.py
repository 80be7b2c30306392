"""A joint that let go or took hold along a run."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal


@dataclass(frozen=True)
class JointChange:
    """At ``t`` (s) the ``joint`` let go or took hold (``kind`` "release" or "hold"); ``why`` says what brought it.

    ``gap`` (m) is how far its points were from where it took hold, ``energy`` (J) what the mechanism got as they were
    drawn together. A hold is an impact too: ``run.impacts`` has it, with the joint and "hold" for its contact.
    ``number`` is that of the table among those of the scene that have joints let go or take hold; -1: a function asked
    for it.
    """

    t: float
    joint: str
    kind: Literal["release", "hold"]
    why: str
    gap: float = 0.0
    energy: float = 0.0
    number: int = field(default=-1, repr=False, compare=False)
