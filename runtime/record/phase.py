"""A phase of a run."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Phase:
    """A stretch of the motion of one kind; an impact starts and ends at the same instant.

    In a phase of kind "contact" the `contacts`, (point, ground) names, stay closed, and `how` says how each does:
    "smooth"; "sticks"; "slides forward" or "slides backward", forward being along the ground with its normal to the
    left; "at the limit, forward" or "backward" of its friction while other contacts keep it from sliding; "carried" by
    others, or by driven joints; "touches" where there is friction but nothing presses, as between what moves side by
    side.

    In a phase of kind "steps" the run went on by time stepping, where event by event it did not get further: the
    longest `step` (s), and by how much the steps differ from their halves in all, `missed` (rad, or
    lengths of the mechanism): what they may have cost in accuracy. Impulses of contacts are not recorded there, but
    `taken` (J) is what those took from the energy in all, friction included, in no :class:`Impact`; where joints are
    driven it counts what their drives gave in the same jumps.
    """

    kind: Literal["flight", "impact", "contact", "steps"]
    start: float
    end: float
    contacts: tuple[tuple[str, str], ...] = ()
    how: tuple[str, ...] = ()
    step: float = 0.0
    missed: float = 0.0
    taken: float = 0.0

    def __post_init__(self) -> None:
        if self.kind not in ("flight", "impact", "contact", "steps"):
            raise ValueError(f"phase is of kind {self.kind!r}, not 'flight', 'impact', 'contact' or 'steps'")
        if (self.kind == "steps") != (self.step > 0.0) or not self.missed >= 0.0:
            raise ValueError(f"phase of kind {self.kind!r} has steps of {self.step} s that miss {self.missed}")
        if not math.isfinite(self.taken) or (self.taken and self.kind != "steps"):
            raise ValueError(f"phase of kind {self.kind!r} takes {self.taken} J, expected a number, 0 unless of steps")
        if len(self.how) != len(self.contacts):
            raise ValueError(
                f"phase has {len(self.contacts)} contacts, and says of {len(self.how)} how they stay closed"
            )
        if (self.kind == "contact") != bool(self.contacts):
            raise ValueError(f"phase of kind {self.kind!r} has {len(self.contacts)} contacts that stay closed")
        if not self.start <= self.end < math.inf:
            raise ValueError(f"phase goes from {self.start} to {self.end}")
