"""Gaps between points and grounds, their rates, and the generalized impulses of contact (theory, section 5)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from ..mechanism.joints import PointRef
from .gather import NO_LOAD, Wrench, generalized
from .kinematics import ZERO, Kinematics, Vector, add, dot, perp, scale


@dataclass(frozen=True)
class Gap:
    """A point that may touch a half-plane: gap = normal·x − offset (eq. 15), with a unit normal."""

    name: str
    point: PointRef
    ground: str
    normal: Vector
    offset: sp.Expr
    restitution: sp.Expr
    friction: sp.Expr = sp.S.Zero

    @property
    def tangent(self) -> Vector:
        """The direction of sliding: the normal turned by a right angle, clockwise."""
        return (self.normal[1], -self.normal[0])


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
        return tuple(dot(c.normal, self._velocity(c)) for c in self.contacts)

    def slips(self) -> tuple[sp.Expr, ...]:
        """T u (m/s): how fast each point slides along its ground."""
        return tuple(dot(c.tangent, self._velocity(c)) for c in self.contacts)

    def _velocity(self, c: Gap) -> Vector:
        return add(self.velocity[c.point.link], self.kinematics.swing(c.point.link, self.arms[c.point]))

    def bias(self) -> tuple[sp.Expr, ...]:
        """Ṅ u (m/s²): what the gaps accelerate at with u̇ = 0, eq. 16 differentiated."""
        return tuple(dot(c.normal, acceleration) for c, acceleration in self.centripetal)

    def slip_bias(self) -> tuple[sp.Expr, ...]:
        """Ṫ u (m/s²) likewise."""
        return tuple(dot(c.tangent, acceleration) for c, acceleration in self.centripetal)

    @cached_property
    def centripetal(self) -> list[tuple[Gap, Vector]]:
        """Accelerations of the contact points with u̇ = 0, outwards from the root (eq. 4)."""
        kinematics, topology = self.kinematics, self.kinematics.topology
        inward: dict[int, Vector] = {topology.root: ZERO}
        for branch in topology.branches:
            total = add(inward[branch.parent], kinematics.bias(branch))
            inward[branch.link] = kinematics.ledger.let_vector(f"ci_{branch.link}", total)
        kinematics.ledger.close("centripetal accelerations of the inboard points")
        result = []
        for c in self.contacts:
            own = scale(-kinematics.squared_rate[c.point.link], self.arms[c.point])
            result.append((c, add(inward[c.point.link], own)))
        return result

    def generalized(self, impulses: tuple[sp.Symbol, ...], tangential: bool = False) -> tuple[sp.Expr, ...]:
        """Nᵀ P (eq. 17), or Tᵀ P: impulses P become generalized impulses, gathered from tips to root."""
        wrenches: dict[int, Wrench] = {}
        for contact, impulse in zip(self.contacts, impulses, strict=True):
            direction = contact.tangent if tangential else contact.normal
            link, push = contact.point.link, scale(impulse, direction)
            force, moment = wrenches.get(link, NO_LOAD)
            wrenches[link] = (add(force, push), moment + dot(perp(self.arms[contact.point]), push))
        name = "H" if tangential else "G"
        return generalized(self.kinematics, wrenches, name, "generalized impulses of the contacts, inwards")
