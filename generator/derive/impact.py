"""Gaps between points and grounds, their rates, and the generalized impulses of contact (theory, section 5)."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ..mechanism.joints import PointRef
from .gather import NO_LOAD, Wrench, generalized
from .kinematics import Kinematics, Vector, add, dot, perp, scale


@dataclass(frozen=True)
class Gap:
    """A point that may touch a half-plane: gap = normal·x − offset (eq. 15), with a unit normal."""

    name: str
    point: PointRef
    ground: str
    normal: Vector
    offset: sp.Expr
    restitution: sp.Expr


class Contacts:
    """Gap functions of all contacts of a scene."""

    def __init__(
        self,
        kinematics: Kinematics,
        contacts: tuple[Gap, ...],
        place: dict[int, Vector],
        velocity: dict[int, Vector],
    ) -> None:
        self.kinematics, self.contacts, self.place, self.velocity = kinematics, contacts, place, velocity
        self.arms = {contact.point: kinematics.arm_to(contact.point) for contact in contacts}
        kinematics.ledger.close("arms to the contact points")

    def values(self) -> tuple[sp.Expr, ...]:
        """Gaps (m), positive outside (eq. 15)."""
        return tuple(dot(c.normal, add(self.place[c.point.link], self.arms[c.point])) - c.offset for c in self.contacts)

    def rates(self) -> tuple[sp.Expr, ...]:
        """N u (m/s), eq. 16."""
        result = []
        for c in self.contacts:
            swing = self.kinematics.swing(c.point.link, self.arms[c.point])
            result.append(dot(c.normal, add(self.velocity[c.point.link], swing)))
        return tuple(result)

    def generalized(self, impulses: tuple[sp.Symbol, ...]) -> tuple[sp.Expr, ...]:
        """Nᵀ P (eq. 17): normal impulses P become generalized impulses, gathered from tips to root."""
        wrenches: dict[int, Wrench] = {}
        for contact, impulse in zip(self.contacts, impulses, strict=True):
            link, push = contact.point.link, scale(impulse, contact.normal)
            force, moment = wrenches.get(link, NO_LOAD)
            wrenches[link] = (add(force, push), moment + dot(perp(self.arms[contact.point]), push))
        return generalized(self.kinematics, wrenches, "G", "generalized impulses of the contacts, inwards")
