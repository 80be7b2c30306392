"""An impact of a run."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..arrays import FloatArray
from .frozen import freeze, restore


@dataclass(frozen=True, eq=False)
class Impact:
    """Contacts that struck together at the instant t.

    `contacts` are (point, ground) names, `impulses` (k,) theirs along the grounds' normals in N s (of a stop,
    whose names are a joint and `stop_0.lowest` or `.highest`, in N m s), `u_minus` and
    `u_plus` (nu,) the velocities before and after, `energy_loss` the energy that went, in J. `restitution_share` is the
    part of their restitution that the contacts had: less than 1 where all of it would have gained energy, or the law
    has no impulses for it. `friction` (k,) are the impulses along the grounds (N s), and `reactions` (joints, 3) those
    of the joints, x, y (N s) and moment (N m s), on their second links. Where a loop comes to lie in a line on the
    ground, or beside a line comes onto its branch again, it strikes itself: the impulses of the contacts that are
    closed are zero then, and so are the joints', which have no bounds.
    """

    t: float
    contacts: tuple[tuple[str, str], ...]
    u_minus: FloatArray
    u_plus: FloatArray
    impulses: FloatArray
    energy_loss: float
    friction: FloatArray = field(default_factory=lambda: np.zeros(0))
    reactions: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    restitution_share: float = 1.0

    def __post_init__(self) -> None:
        freeze(self, "u_minus", "u_plus", "impulses", "friction", "reactions")
        if self.u_minus.ndim != 1 or self.u_plus.shape != self.u_minus.shape:
            shapes = f"{self.u_minus.shape} and {self.u_plus.shape}"
            raise ValueError(f"velocities of an impact have shapes {shapes}, expected (nu,) for both")
        if not self.contacts or self.impulses.shape != (len(self.contacts),):
            raise ValueError(f"impact has {len(self.contacts)} contacts and impulses of shape {self.impulses.shape}")
        if self.friction.shape not in ((0,), self.impulses.shape) or self.reactions.shape[1:] != (3,):
            shapes = f"{self.friction.shape} and {self.reactions.shape}"
            raise ValueError(
                f"impact has friction and reactions of shapes {shapes}, expected (contacts,) or none, and (joints, 3)"
            )
        if not 0.0 <= self.restitution_share <= 1.0:
            raise ValueError(f"impact has restitution_share {self.restitution_share}, expected a number from 0 to 1")
        if not (math.isfinite(self.t) and math.isfinite(self.energy_loss)):
            raise ValueError(f"impact has time {self.t} and energy loss {self.energy_loss}, expected finite numbers")

    def __setstate__(self, state: dict[str, Any]) -> None:
        restore(self, state)
