"""Joints that others imply take their share of the forces: those of least norm that balance (theory, section 8).

The equations give the forces of all other joints as if an implied joint bore nothing. A self-stress is a set of forces
that balance by themselves: one through the implied joint and back on the way that implies it. What of the forces lies
along self-stresses is taken away, and what is left is perpendicular to all of them.
"""

from __future__ import annotations

import sympy as sp

from ..mechanism.implied import Implied, Part
from .displacement import between
from .kinematics import Kinematics
from .vectors import ZERO, Vector, dot, perp, scale

Entry = tuple[int, int]
"""A joint, and which number of its reaction: force x, force y (N), moment (N m)."""
Stress = dict[Entry, sp.Expr]

X, Y, MOMENT = range(3)


class Shares:
    """``forces`` and ``moments`` of the joints that are not implied become those of all, in :meth:`reactions`.

    ``name`` is that of the forces in the equations. Moments are about the joints' later ends.
    """

    def __init__(
        self, kinematics: Kinematics, forces: dict[int, Vector], moments: dict[int, sp.Expr], name: str
    ) -> None:
        self.name = name
        self.kinematics, self.topology, self.ledger = kinematics, kinematics.topology, kinematics.ledger
        self.found: Stress = {}
        for joint in range(len(kinematics.mechanism.joints)):
            force = forces.get(joint, ZERO)
            self.found |= {(joint, X): force[0], (joint, Y): force[1], (joint, MOMENT): moments.get(joint, sp.S.Zero)}

    def reactions(self) -> tuple[sp.Expr, ...]:
        """Force x, y and moment per joint on its outboard link."""
        basis: list[Stress] = []
        for stress in (z for idle in self.topology.implied for z in self._stresses(idle)):
            basis.append(self._perpendicular(stress, basis))
        for number, stress in enumerate(basis):  # in any order, as they are perpendicular to each other
            along = _product(stress, self.found) / _product(stress, stress)
            self.found = _less(self.found, self.ledger.let(f"share_{self.name}_{number}", along), stress)
        if basis:
            self.ledger.close("shares of joints that others imply")
        return tuple(self.found.values())

    def _perpendicular(self, stress: Stress, basis: list[Stress]) -> Stress:
        for other in basis:
            stress = _less(stress, _product(stress, other) / _product(other, other), other)
        return {e: self.ledger.let(f"stress_{len(basis)}_{e[0]}_{e[1]}", value) for e, value in stress.items()}

    def _stresses(self, idle: Implied) -> list[Stress]:
        """The forces and moments that an implied joint can bear, and those that hold them in balance."""
        kind = self.kinematics.mechanism.joints[idle.joint].kind
        ring = (Part(idle.joint, 1), *idle.way)
        if kind == "revolute":
            return [self._along(ring, direction) for direction in ((sp.S.One, sp.S.Zero), (sp.S.Zero, sp.S.One))]
        across = self._along(ring, perp(self.kinematics.line(idle.joint)))
        if kind == "pin-in-slot":
            return [across]
        return [across, {(part.joint, MOMENT): sp.Integer(self._sign(part)) for part in ring}]

    def _along(self, ring: tuple[Part, ...], direction: Vector) -> Stress:
        """A force through all joints of the ring, on one line; those that hold an angle bear its moment as well."""
        mechanism, found = self.kinematics.mechanism, Stress()
        acts = mechanism.joints[ring[0].joint].second
        for part in ring:
            force = scale(sp.Integer(self._sign(part)), direction)
            found |= {(part.joint, X): force[0], (part.joint, Y): force[1]}
            if mechanism.joints[part.joint].kind == "prismatic":
                borne = mechanism.joints[part.joint].later
                ends = [(ref.link, self.kinematics.arm_to(ref)) for ref in (borne, acts)]
                arm = between(self.kinematics, *ends).vector()
                found[part.joint, MOMENT] = dot(perp(arm), force)
        return {entry: value for entry, value in found.items() if value != 0}

    def _sign(self, part: Part) -> int:
        """Of the force on the link that a joint's reaction is given for."""
        inwards = any(branch.joint == part.joint and not branch.outwards for branch in self.topology.branches)
        return -part.sign if inwards else part.sign


def _product(one: Stress, other: Stress) -> sp.Expr:
    return sp.Add(*(value * other[entry] for entry, value in one.items() if entry in other))


def _less(one: Stress, factor: sp.Expr, other: Stress) -> Stress:
    """``one`` less ``factor`` times ``other``."""
    if factor == 0:
        return one
    return {e: one.get(e, sp.S.Zero) - factor * other.get(e, sp.S.Zero) for e in dict.fromkeys((*one, *other))}
