"""A disc of one link inside a round hole, or a slot, of another: its gap is the clearance (theory, section 5.13).

The centre of the disc stays within ``reach`` of the hole's centre, or of the slot's middle line. The gap is written
with the square of the distance, so that no rate is singular where the disc is in the middle.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from .gaps import Accelerations, Positions, Velocities
from .touching import Pair
from .vectors import Vector, Wrench, dot, perp, scale


@dataclass(frozen=True, kw_only=True)
class ContainedGap(Pair):
    """A disc whose centre is not farther than ``reach`` (m) from a point, or from a segment, of another link.

    ``thickness`` is the radius of the hole, or half of the slot's width, with a minus: −(reach + radius).
    """

    reach: sp.Expr

    def value(self, at: Positions) -> sp.Expr:
        """Eq. 5.19: (c² − ρ²) / 2c."""
        off = self.nearest(at).off
        return (self.reach - dot(off, off) / self.reach) / 2

    def closing(self, at: Velocities) -> sp.Expr:
        """Eq. 5.20: −ρ·v_cf / c."""
        return -dot(self.nearest(at).off, self._drift(at)) / self.reach

    def bias(self, at: Accelerations) -> sp.Expr:
        """Eq. 5.21: −(v_cf² + ρ·a_cf − ξ̇²) / c, the last inside a slot only."""
        nearest, drift = self.nearest(at), self._drift(at)
        curved = dot(drift, drift) + dot(nearest.off, self._bend(at))
        if self.edge:
            curved -= nearest.inside * self._along(at) ** 2
        return -curved / self.reach

    def slip(self, at: Velocities) -> sp.Expr:
        """Of the material points that touch, eq. 5.20."""
        return dot(self._tangent(at), self._drift(at)) + self._rolling(at)

    def slip_bias(self, at: Accelerations) -> sp.Expr:
        """Eq. 5.21: (ρ⊥·a_cf − ξ̇ η̇) / c, the last inside a slot only."""
        turned = dot(self._tangent(at), self._bend(at))
        if self.edge:
            nearest = self.nearest(at)
            across = dot(perp(nearest.along), self._drift(at))
            turned -= nearest.inside * self._along(at) * across / self.reach
        return turned

    def push(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        """Towards the middle, through the disc's centre and the nearest point of the middle."""
        return self._opposite(at, scale(-impulse / self.reach, self.nearest(at).off))

    def drag(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        return self._across(at, impulse, self._tangent(at))

    def _tangent(self, at: Positions) -> Vector:
        """The direction of sliding: the normal −ρ/c turned by a right angle, clockwise; of length 1 in contact."""
        return at.let_vector(f"tangent_{self.label}", scale(1 / self.reach, perp(self.nearest(at).off)))

    def _along(self, at: Velocities) -> sp.Expr:
        """ξ̇: how fast the nearest point goes along the slot (m/s), where it is inside it."""
        nearest = self.nearest(at)
        turning = at.rate(self.other.link) * dot(perp(nearest.along), nearest.off)
        return at.let(f"along_{self.label}", dot(nearest.along, self._drift(at)) + turning)
