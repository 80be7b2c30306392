"""Gaps of all contacts, their rates, and the generalized impulses of contact (theory, section 5)."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import sympy as sp

from ..equations.names import slide_name, sliding_name
from ..mechanism.joints import PointRef
from ..mechanism.links import GROUND
from .displacement import Displacement, between
from .gaps import Gap
from .generalized_forces import gather_inwards
from .kinematics import Kinematics
from .vectors import NO_LOAD, ZERO, Vector, Wrench, add, dot, less, perp, scale


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
        still: dict[int, Vector] = {GROUND: ZERO}
        self._place, self._velocity = still | place, still | velocity
        self.arms = {ref: kinematics.arm_to(ref) for contact in contacts for ref in contact.points()}
        kinematics.ledger.close("arms to the contact points")

    def values(self) -> tuple[sp.Expr, ...]:
        """Gaps (m, rad), positive outside (eq. 5.1)."""
        return self._all("places where links touch", lambda gap: gap.value(self))

    def rates(self) -> tuple[sp.Expr, ...]:
        """N u (m/s, rad/s), eq. 5.2."""
        return self._all("velocities where links touch", lambda gap: gap.closing(self))

    def slips(self) -> tuple[sp.Expr, ...]:
        """T u (m/s): how fast each contact slides along its ground."""
        return self._all("sliding where links touch", lambda gap: gap.slip(self))

    def bias(self) -> tuple[sp.Expr, ...]:
        """Ṅ u (m/s², rad/s²): what the gaps accelerate at with u̇ = 0, eq. 5.2 differentiated."""
        return self._all("turning of the normals where links touch", lambda gap: gap.bias(self))

    def slip_bias(self) -> tuple[sp.Expr, ...]:
        """Ṫ u (m/s²) likewise."""
        return self._all("the same of the tangents", lambda gap: gap.slip_bias(self))

    def _all(self, title: str, value: Callable[[Gap], sp.Expr]) -> tuple[sp.Expr, ...]:
        """A value of every gap; what the gaps name on the way is written under the title."""
        found = tuple(map(value, self.contacts))
        self.kinematics.ledger.close(title)
        return found

    def generalized_impulses(self, impulses: tuple[sp.Symbol, ...], tangential: bool = False) -> tuple[sp.Expr, ...]:
        """Nᵀ P (eq. 5.3), or Tᵀ P: impulses P become generalized impulses, gathered from tips to root."""
        name = "H" if tangential else "G"
        wrenches = self.wrenches(() if tangential else impulses, impulses if tangential else ())
        return gather_inwards(self.kinematics, wrenches, name, "generalized impulses of the contacts, inwards")

    def wrenches(self, normal: tuple[sp.Symbol, ...], tangential: tuple[sp.Symbol, ...]) -> dict[int, Wrench]:
        """What impulses along the normals, and along the tangents, do to each link, about its inboard point."""
        found: dict[int, Wrench] = {}
        done = [contact.push(self, p) for contact, p in zip(self.contacts, normal, strict=False)]
        done += [contact.drag(self, p) for contact, p in zip(self.contacts, tangential, strict=False)]
        for wrenches in done:
            for link, (push, turn) in wrenches.items():
                if link != GROUND:
                    force, moment = found.get(link, NO_LOAD)
                    found[link] = (add(force, push), moment + turn)
        return found

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

    def let(self, name: str, expression: sp.Expr) -> sp.Expr:
        """A named quantity of a gap."""
        return self.kinematics.ledger.let(name, expression)

    def let_vector(self, name: str, vector: Vector) -> Vector:
        return self.kinematics.ledger.let_vector(name, vector)

    def once(self, name: str, make: Callable[[], sp.Expr]) -> sp.Expr:
        return self.kinematics.ledger.once(name, make)

    def distance(self, start: PointRef, end: PointRef) -> Vector:
        """The vector from one contact point to another (m)."""
        displacement = self._displacement(start, end)
        return displacement.vector() if displacement else less(self.position(end), self.position(start))

    def approach(self, start: PointRef, end: PointRef) -> Vector:
        """Its rate (m/s)."""
        displacement = self._displacement(start, end)
        return displacement.rate() if displacement else less(self.velocity(end), self.velocity(start))

    def bend(self, start: PointRef, end: PointRef) -> Vector:
        """Its second rate with u̇ = 0 (m/s²)."""
        displacement = self._displacement(start, end)
        return displacement.bias() if displacement else less(self.centripetal(end), self.centripetal(start))

    def joint_position(self, joint: int) -> sp.Expr:
        """Angle of a joint (rad), second link against first; of one that slides, how far it is along its line (m): its
        coordinate, or where loops carry both links, d · x with the direction d of the line and x from the first point
        to the second."""
        first, second = self._ends(joint)
        if not self._slides(joint):
            return self.angle(second.link) - self.angle(first.link)
        if self._has_coordinate(joint):
            return sp.Symbol(slide_name(joint))
        return dot(self.kinematics.line(joint), self.distance(first, second))

    def joint_speed(self, joint: int) -> sp.Expr:
        """Its rate (rad/s, m/s); of d · x it is d · ẋ + ω d⊥ · x."""
        first, second = self._ends(joint)
        if not self._slides(joint):
            return self.rate(second.link) - self.rate(first.link)
        if self._has_coordinate(joint):
            return sp.Symbol(sliding_name(joint))
        line, x = self.kinematics.line(joint), self.distance(first, second)
        return dot(line, self.approach(first, second)) + self.rate(first.link) * dot(perp(line), x)

    def joint_bias(self, joint: int) -> sp.Expr:
        """The rate of that with u̇ = 0 (m/s²): d · ẍ + 2 ω d⊥ · ẋ − ω² d · x, and zero of what is linear in u with
        constant coefficients."""
        if not self._slides(joint) or self._has_coordinate(joint):
            return sp.S.Zero
        first, second = self._ends(joint)
        line, x = self.kinematics.line(joint), self.distance(first, second)
        turned = 2 * self.rate(first.link) * dot(perp(line), self.approach(first, second))
        inwards = self.kinematics.squared_rate[first.link] * dot(line, x)
        return dot(line, self.bend(first, second)) + turned - inwards

    def along_joint(self, joint: int, impulse: sp.Expr) -> dict[int, Wrench]:
        """The wrenches of an impulse, the transpose of :meth:`joint_speed`: couples, or forces along the line. The
        moment of what the second point is off the line, rounding where loops are closed, is the first link's."""
        first, second = self._ends(joint)
        if not self._slides(joint):
            return {second.link: (ZERO, impulse), first.link: (ZERO, -impulse)}
        line = self.kinematics.line(joint)
        push, back = scale(impulse, line), scale(-impulse, line)
        off = sp.S.Zero
        if not self._has_coordinate(joint):
            off = impulse * dot(perp(line), self.distance(first, second))
        return {
            second.link: (push, dot(perp(self.arms[second]), push)),
            first.link: (back, dot(perp(self.arms[first]), back) + off),
        }

    def _slides(self, joint: int) -> bool:
        return self.kinematics.mechanism.joints[joint].slides

    def _ends(self, joint: int) -> tuple[PointRef, PointRef]:
        record = self.kinematics.mechanism.joints[joint]
        return record.first, record.second

    def _has_coordinate(self, joint: int) -> bool:
        """Whether a length along the joint's line is a coordinate."""
        return any(branch.joint == joint for branch in self.kinematics.topology.branches)

    def _displacement(self, start: PointRef, end: PointRef) -> Displacement | None:
        """Along the tree, so that the position of a floating mechanism does not enter; none to the ground."""
        if self.kinematics.topology.floating and GROUND in (start.link, end.link):
            return None
        return between(self.kinematics, (start.link, self.arms[start]), (end.link, self.arms[end]))

    @cached_property
    def _inward(self) -> dict[int, Vector]:
        """Accelerations of the inboard points with u̇ = 0, outwards from the root (eq. 2.4)."""
        kinematics, topology = self.kinematics, self.kinematics.topology
        inward: dict[int, Vector] = {GROUND: ZERO, topology.root: ZERO}
        for branch in topology.branches:
            total = add(inward[branch.parent], kinematics.bias(branch))
            inward[branch.link] = kinematics.ledger.let_vector(f"ci_{branch.link}", total)
        kinematics.ledger.close("centripetal accelerations of the inboard points")
        return inward
