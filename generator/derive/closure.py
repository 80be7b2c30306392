"""Finite closure of the cut joints, its rate and its Jacobian with respect to u (theory, section 3)."""

from __future__ import annotations

from collections.abc import Callable

import sympy as sp

from ..mechanism.joints import PointRef
from ..mechanism.links import GROUND
from ..mechanism.topology import Cut
from .kinematics import ZERO, Kinematics, Vector, add, perp, scale


class Closure:
    """Rows of every cut joint, x then y: (point on the second side) − (point on the first side) = 0 (eq. 13).

    Both sides are measured from the link where their branches meet, so the position of a floating mechanism does not
    enter and costs no digits.
    """

    def __init__(self, kinematics: Kinematics) -> None:
        self.kinematics = kinematics

    def residual(self) -> tuple[sp.Expr, ...]:
        """The rows themselves (m)."""
        return self._rows(lambda link, arm: arm)

    def rate(self) -> tuple[sp.Expr, ...]:
        """A u (m/s), eq. 14."""
        return self._rows(lambda link, arm: ZERO if link == GROUND else self.kinematics.swing(link, arm))

    def bias(self) -> tuple[sp.Expr, ...]:
        """Ȧ u (m/s²): what the rows accelerate at with u̇ = 0, eq. 14 differentiated."""
        return self._rows(lambda link, arm: ZERO if link == GROUND else scale(-self.kinematics.squared_rate[link], arm))

    def jacobian(self) -> tuple[sp.Expr, ...]:
        """A, row by row (eq. 14)."""
        state = self.kinematics.state
        entries: list[sp.Expr] = []
        for cut in self.kinematics.topology.cuts:
            columns: dict[sp.Symbol, Vector] = {}
            for factor, link, arm in self._arms(cut):
                if link != GROUND:
                    rate = state.rate(link)
                    columns[rate] = add(columns.get(rate, ZERO), scale(sp.Integer(factor), perp(arm)))
            entries += [columns.get(u, ZERO)[axis] for axis in (0, 1) for u in state.u]
        return tuple(entries)

    def _arms(self, cut: Cut) -> list[tuple[int, int, Vector]]:
        """Signed arms around the loop: sign, link, arm."""
        return [
            (factor, link, arm)
            for side, factor in ((cut.first, -1), (cut.second, 1))
            for link, arm in self._way(side, cut)
        ]

    def _way(self, side: PointRef, cut: Cut) -> list[tuple[int, Vector]]:
        """Links from the side of the cut inwards to the meeting link, each with its arm towards the cut."""
        topology = self.kinematics.topology
        found, joint = [], cut.joint
        for link in topology.path(side.link):
            found.append((link, self.kinematics.r[link, joint]))
            if link == cut.meeting:
                return found
            joint = topology.branch(link).joint
        raise AssertionError("the meeting link lies on the way to the root")

    def _rows(self, contribution: Callable[[int, Vector], Vector]) -> tuple[sp.Expr, ...]:
        rows: list[sp.Expr] = []
        for cut in self.kinematics.topology.cuts:
            terms = [scale(sp.Integer(factor), contribution(link, arm)) for factor, link, arm in self._arms(cut)]
            rows += add(*terms)
        return tuple(rows)
