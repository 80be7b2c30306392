"""A phase of a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np


@dataclass(frozen=True)
class Phase:
    """A stretch of the motion of one kind; an impact starts and ends at the same instant.

    In a phase of kind "contact" the `contacts`, (point, ground) names, stay closed, and `how` says how each does:
    "smooth"; "sticks"; "slides forward" or "slides backward", forward being along the ground with its normal to the
    left; "at the limit, forward" or "backward" of its friction while other contacts keep it from sliding; "carried" by
    others; "touches" where there is friction but nothing presses, as between what moves side by side.
    """

    kind: Literal["flight", "impact", "contact"]
    start: float
    end: float
    contacts: tuple[tuple[str, str], ...] = ()
    how: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.kind not in ("flight", "impact", "contact"):
            raise ValueError(f"phase is of kind {self.kind!r}, not 'flight', 'impact' or 'contact'")
        if len(self.how) != len(self.contacts):
            raise ValueError(
                f"phase has {len(self.contacts)} contacts, and says of {len(self.how)} how they stay closed"
            )
        if (self.kind == "contact") != bool(self.contacts):
            raise ValueError(f"phase of kind {self.kind!r} has {len(self.contacts)} contacts that stay closed")
        if not self.start <= self.end < np.inf:
            raise ValueError(f"phase goes from {self.start} to {self.end}")
