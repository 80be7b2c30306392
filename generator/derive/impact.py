"""Gaps of all contacts, their rates, and the generalized impulses of contact (theory, section 5)."""

from __future__ import annotations

from functools import cached_property

import sympy as sp

from ..mechanism.joints import PointRef
from ..mechanism.links import GROUND
from .gaps import Gap
from .gather import NO_LOAD, Wrench, gather_inwards
from .kinematics import ZERO, Kinematics, Vector, add, scale


class Contacts:
    """Gap functions of all contacts of a scene; what the gaps see of the mechanism."""

    def __init__(
        self,
        kinematics: Kinematics,
        contacts: tuple[Gap, ...],
        place: dict[int, Vector],
        velocity: dict[int, Vector],
    ) -> None:
        self.kinematics, self.contacts = kinematics, contacts
        self._place, self._velocity = place, velocity
        self.arms = {ref: kinematics.arm_to(ref) for contact in contacts for ref in contact.points()}
        kinematics.ledger.close("arms to the contact points")

    def values(self) -> tuple[sp.Expr, ...]:
        """Gaps (m, rad), positive outside (eq. 15)."""
        return tuple(c.value(self) for c in self.contacts)

    def rates(self) -> tuple[sp.Expr, ...]:
        """N u (m/s, rad/s), eq. 16."""
        return tuple(c.closing(self) for c in self.contacts)

    def slips(self) -> tuple[sp.Expr, ...]:
        """T u (m/s): how fast each contact slides along its ground."""
        return tuple(c.slip(self) for c in self.contacts)

    def bias(self) -> tuple[sp.Expr, ...]:
        """Ṅ u (m/s², rad/s²): what the gaps accelerate at with u̇ = 0, eq. 16 differentiated."""
        return tuple(c.bias(self) for c in self.contacts)

    def slip_bias(self) -> tuple[sp.Expr, ...]:
        """Ṫ u (m/s²) likewise."""
        return tuple(c.slip_bias(self) for c in self.contacts)

    def generalized_impulses(self, impulses: tuple[sp.Symbol, ...], tangential: bool = False) -> tuple[sp.Expr, ...]:
        """Nᵀ P (eq. 17), or Tᵀ P: impulses P become generalized impulses, gathered from tips to root."""
        wrenches: dict[int, Wrench] = {}
        for contact, impulse in zip(self.contacts, impulses, strict=True):
            done = contact.drag(self, impulse) if tangential else contact.push(self, impulse)
            for link, (push, turn) in done.items():
                if link != GROUND:
                    force, moment = wrenches.get(link, NO_LOAD)
                    wrenches[link] = (add(force, push), moment + turn)
        name = "H" if tangential else "G"
        return gather_inwards(self.kinematics, wrenches, name, "generalized impulses of the contacts, inwards")

    # -- what gaps see ---------------------------------------------------------------------------------------------

    def position(self, ref: PointRef) -> Vector:
        """Position of a contact point (m)."""
        return add(self._place[ref.link], self.arms[ref])

    def angle(self, link: int) -> sp.Expr:
        """Angle of a link (rad); zero for the ground."""
        return sp.S.Zero if link == GROUND else self.kinematics.state.angle(link)

    def arm(self, ref: PointRef) -> Vector:
        """From the inboard point to a contact point (m)."""
        return self.arms[ref]

    def velocity(self, ref: PointRef) -> Vector:
        """Velocity of a contact point (m/s)."""
        return add(self._velocity[ref.link], self.kinematics.swing(ref.link, self.arms[ref]))

    def centripetal(self, ref: PointRef) -> Vector:
        """Acceleration of a contact point with u̇ = 0 (m/s²)."""
        own = scale(-self.kinematics.squared_rate[ref.link], self.arms[ref])
        return add(self._inward[ref.link], own)

    def rate(self, link: int) -> sp.Expr:
        """Angular velocity of a link (rad/s); zero for the ground."""
        return sp.S.Zero if link == GROUND else self.kinematics.state.rate(link)

    @cached_property
    def _inward(self) -> dict[int, Vector]:
        """Accelerations of the inboard points with u̇ = 0, outwards from the root (eq. 4)."""
        kinematics, topology = self.kinematics, self.kinematics.topology
        inward: dict[int, Vector] = {topology.root: ZERO}
        for branch in topology.branches:
            total = add(inward[branch.parent], kinematics.bias(branch))
            inward[branch.link] = kinematics.ledger.let_vector(f"ci_{branch.link}", total)
        kinematics.ledger.close("centripetal accelerations of the inboard points")
        return inward
