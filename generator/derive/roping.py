"""A rope between points of links, over eyelets: its gap is its length less that of its way (theory, section 5.14)."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ..mechanism.joints import PointRef
from .gaps import Accelerations, Positions, Velocities
from .vectors import Vector, Wrench, dot, perp, scale

Piece = tuple[PointRef, PointRef]
"""A straight piece of a rope between points of two links."""


@dataclass(frozen=True)
class RopeGap:
    """A rope of ``length`` (m) along ``pieces`` whose lengths change, and others with the sum ``fixed`` that do not.

    A rope without eyelets has one piece and is written with its square, so that its ends may meet. ``label`` tells the
    names of its quantities from those of others.
    """

    name: str
    ground: str
    label: str
    pieces: tuple[Piece, ...]
    fixed: sp.Expr
    length: sp.Expr
    restitution: sp.Expr
    friction: sp.Expr = sp.S.Zero
    angular = False
    slides = False

    def points(self) -> tuple[PointRef, ...]:
        return tuple(dict.fromkeys(point for piece in self.pieces for point in piece))

    def value(self, at: Positions) -> sp.Expr:
        """Eq. 5.22, or eq. 5.23 of a rope without eyelets."""
        if self._plain:
            reach = self._reach(at, 0)
            return (self.length - dot(reach, reach) / self.length) / 2
        return self.length - self.fixed - sp.Add(*(self._span(at, k) for k in range(len(self.pieces))))

    def closing(self, at: Velocities) -> sp.Expr:
        """Eq. 5.24: −Σ e·v, with e the directions of the pieces."""
        return -sp.Add(*(dot(self._direction(at, k), self._drift(at, k)) for k in range(len(self.pieces))))

    def bias(self, at: Accelerations) -> sp.Expr:
        """Eq. 5.25."""
        return -sp.Add(*(self._curved(at, k) for k in range(len(self.pieces))))

    def slip(self, at: Accelerations) -> sp.Expr:
        """Zero: eyelets have no friction."""
        return sp.S.Zero

    def slip_bias(self, at: Accelerations) -> sp.Expr:
        return sp.S.Zero

    def push(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        """Every piece pulls its ends together with the same tension."""
        found: dict[int, Wrench] = {}
        for k, piece in enumerate(self.pieces):
            pull = scale(impulse, self._direction(at, k))
            for point, force in zip(piece, (pull, scale(sp.S.NegativeOne, pull)), strict=True):
                old, moment = found.get(point.link, ((sp.S.Zero, sp.S.Zero), sp.S.Zero))
                total = (old[0] + force[0], old[1] + force[1])
                found[point.link] = (total, moment + dot(perp(at.arm(point)), force))
        return found

    def drag(self, at: Accelerations, impulse: sp.Expr) -> dict[int, Wrench]:
        return {}

    # -- geometry --------------------------------------------------------------------------------------------------

    @property
    def _plain(self) -> bool:
        """Whether it has no eyelets."""
        return len(self.pieces) == 1 and self.fixed == 0

    def _title(self, k: int) -> str:
        return self.label if len(self.pieces) == 1 else f"{self.label}_{k}"

    def _reach(self, at: Positions, k: int) -> Vector:
        """From the start of a piece to its end (m)."""
        return at.let_vector(f"reach_{self._title(k)}", at.distance(*self.pieces[k]))

    def _span(self, at: Positions, k: int) -> sp.Expr:
        """The length of a piece; of a rope without eyelets that of the rope, as which it pulls (m)."""
        if self._plain:
            return self.length
        reach = self._reach(at, k)
        return at.let(f"span_{self._title(k)}", sp.sqrt(dot(reach, reach)))

    def _direction(self, at: Positions, k: int) -> Vector:
        """e: of length 1 where the rope is taut."""
        return at.let_vector(f"pull_{self._title(k)}", scale(1 / self._span(at, k), self._reach(at, k)))

    def _drift(self, at: Velocities, k: int) -> Vector:
        """v: how fast its end moves against its start (m/s)."""
        return at.let_vector(f"drift_{self._title(k)}", at.approach(*self.pieces[k]))

    def _curved(self, at: Accelerations, k: int) -> sp.Expr:
        """The second rate of a piece's length with u̇ = 0, or of that which stands for it (m/s²)."""
        direction, drift = self._direction(at, k), self._drift(at, k)
        square = dot(drift, drift) if self._plain else dot(perp(direction), drift) ** 2
        return dot(direction, at.bend(*self.pieces[k])) + square / self._span(at, k)
