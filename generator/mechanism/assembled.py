"""A mechanism as it stands at its start: what is there, asked point by point, link by link, joint by joint."""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from dataclasses import dataclass

from .branch import Triple, place
from .joints import PointRef
from .links import GROUND
from .mechanism import Mechanism


@dataclass(frozen=True)
class Assembled:
    """``mechanism`` with its links at ``poses`` (x and y in m, angle in rad), of which there may be more."""

    mechanism: Mechanism
    poses: Sequence[Triple]

    def place(self, ref: PointRef) -> tuple[float, float]:
        """Where a point is (m)."""
        there = place(self.mechanism, self.poses, ref)
        return there.real, there.imag

    def angle(self, link: int) -> float:
        """The angle of a link (rad); of the ground, zero."""
        return 0.0 if link == GROUND else self.poses[link][2]

    def length(self, joint: int) -> float:
        """How far a joint that slides is along its line (m)."""
        slides = self.mechanism.joints[joint]
        axis = slides.axis.value if slides.axis else 0.0
        first, second = (place(self.mechanism, self.poses, end) for end in (slides.first, slides.second))
        line = cmath.exp(1j * (self.angle(slides.first.link) + axis))
        return ((second - first) * line.conjugate()).real
