"""The displacement from one point of the mechanism to another, arm by arm along the tree, and its rates.

Both ends are measured from the link where their ways meet, so the position of a floating mechanism does not enter and
costs no digits.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from .kinematics import Kinematics
from .vectors import ZERO, Vector, add, perp, scale

End = tuple[int, Vector]
"""A point: the link that carries it, and the arm to it from the link's inboard point."""


@dataclass(frozen=True)
class Displacement:
    """Signed arms (sign, link, arm) and signed sliding joints (sign, link that the joint carries) from the start to
    the end."""

    kinematics: Kinematics
    arms: tuple[tuple[int, int, Vector], ...]
    slides: tuple[tuple[int, int], ...]

    def vector(self) -> Vector:
        """From the start to the end (m)."""
        return add(ZERO, *(scale(sp.Integer(sign), arm) for sign, _, arm in self.arms))

    def rate(self) -> Vector:
        """Its rate (m/s): ω r⊥ of every arm, and ṡ d of every sliding joint."""
        terms = [scale(sp.Integer(sign), self.kinematics.swing(link, arm)) for sign, link, arm in self.arms]
        for sign, link in self.slides:
            slide = self.kinematics.slides[link]
            terms.append(scale(sign * slide.speed, slide.direction))
        return add(ZERO, *terms)

    def bias(self) -> Vector:
        """Its second rate at u̇ = 0 (m/s²): −ω² r of every arm, and 2 ω ṡ d⊥ of every sliding joint."""
        squared = self.kinematics.squared_rate
        terms = [scale(-sign * squared[link], arm) for sign, link, arm in self.arms]
        terms += [scale(sp.Integer(sign), self.kinematics.coriolis(link)) for sign, link in self.slides]
        return add(ZERO, *terms)

    def columns(self) -> dict[sp.Expr, Vector]:
        """Derivatives of the rate by those quasi-velocities that it depends on."""
        found: dict[sp.Expr, Vector] = {}
        for sign, link, arm in self.arms:
            rate = self.kinematics.state.rate(link)
            found[rate] = add(found.get(rate, ZERO), scale(sp.Integer(sign), perp(arm)))
        for sign, link in self.slides:
            slide = self.kinematics.slides[link]
            found[slide.speed] = add(found.get(slide.speed, ZERO), scale(sp.Integer(sign), slide.direction))
        found.pop(sp.S.Zero, None)
        return found


def between(kinematics: Kinematics, start: End, end: End) -> Displacement:
    """The displacement from ``start`` to ``end``."""
    topology = kinematics.topology
    inwards = {link: topology.path(link) for link in (start[0], end[0])}
    others = set(inwards[start[0]])
    meeting = next(link for link in inwards[end[0]] if link in others)
    arms, slides = [], []
    for (first, arm), sign in ((start, -1), (end, 1)):
        arms.append((sign, first, arm))
        for link in inwards[first][: inwards[first].index(meeting)]:
            branch = topology.branch(link)
            if link in kinematics.lead:
                arms.append((sign, link, kinematics.lead[link]))
            if link in kinematics.slides:
                slides.append((sign, link))
            arms.append((sign, branch.parent, kinematics.r[branch.parent, branch.joint]))
    return Displacement(kinematics, tuple(arms), tuple(slides))
