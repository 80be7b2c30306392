"""A joint that let go or took hold along a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class JointChange:
    """At ``t`` (s) the ``joint`` let go or took hold (``kind`` "release" or "hold"); ``why`` says what brought it.

    ``gap`` (m) is how far its points were from where it took hold. A hold is an impact too: ``run.impacts`` has it,
    with the joint and "hold" for its contact.
    """

    t: float
    joint: str
    kind: Literal["release", "hold"]
    why: str
    gap: float = 0.0
