"""From given motions to forces: momentum, inverse dynamics, and the forces in the joints (theory, section 7).

Nothing is solved here. Motion is carried outwards from the root, forces are gathered inwards from the tips.
"""

from __future__ import annotations

import sympy as sp

from ..mechanism.links import GROUND
from .equations import Argument, Kernel, Output
from .gibbs import NO_LOAD, Wrench
from .kinematics import ZERO, Kinematics, Vector, add, dot, perp, scale, symbol
from .names import AXES, place


class Inverse:
    """Kernels that turn motions into forces, less those that effects supply: ``field`` and ``loads``."""

    def __init__(
        self, kinematics: Kinematics, field: Vector, loads: dict[int, Wrench], acted: tuple[Argument, ...]
    ) -> None:
        self.kinematics, self.topology, self.ledger = kinematics, kinematics.topology, kinematics.ledger
        self.state, self.field, self.loads, self.acted = kinematics.state, field, loads, acted
        self.q = Argument("q", self.state.q, "coordinates")
        self.u = Argument("u", self.state.u, "quasi-velocities, u = dq/dt")
        self.u_dot = Argument("u_dot", tuple(sp.Symbol(f"{u}_dot") for u in self.state.u), "quasi-accelerations")

    def kernels(self, velocity: dict[int, Vector]) -> list[Kernel]:
        """``momentum``, ``inverse_dynamics`` and ``reactions``; ``velocity`` of every inboard point."""
        inertia = self._inertia(self._accelerations())
        return [self._momentum(velocity), self._inverse_dynamics(inertia), self._reactions(inertia)]

    def _accelerations(self) -> dict[int, Vector]:
        """Accelerations of the inboard points less the field, from given quasi-accelerations, outwards (eq. 4)."""
        kinematics, topology = self.kinematics, self.topology
        base = (self.u_dot.symbols[0], self.u_dot.symbols[1]) if topology.floating else ZERO
        root = add(base, scale(sp.S.NegativeOne, self.field))
        a = {topology.root: self.ledger.let_vector(f"aR_{place(topology.root)}", root)}
        for branch in topology.branches:
            k, value = branch.parent, a[branch.parent]
            if k != GROUND:
                swing = scale(self._spin(k), perp(kinematics.r[k, branch.joint]))
                value = add(value, swing, scale(sp.S.NegativeOne, kinematics.cr[k, branch.joint]))
            a[branch.link] = self.ledger.let_vector(f"aR_{branch.link}", value)
        self.ledger.close("accelerations less the field, outwards")
        return a

    def _spin(self, link: int) -> sp.Expr:
        return self.u_dot.symbols[self.state.u.index(self.state.rate(link))]

    def _inertia(self, a: dict[int, Vector]) -> dict[int, Wrench]:
        """The wrench that gives each link its acceleration, less its loads: derivatives of S by a and α (eq. 6)."""
        result = {}
        for k in range(len(self.kinematics.mechanism.links)):
            mass, mu, alpha = self.kinematics.mass[k], self.kinematics.mu[k], self._spin(k)
            centripetal = scale(-self.kinematics.squared_rate[k], mu)
            load, moment = self.loads.get(k, NO_LOAD)
            force = add(scale(mass, a[k]), scale(alpha, perp(mu)), centripetal, scale(sp.S.NegativeOne, load))
            result[k] = (force, dot(perp(mu), a[k]) + self._moment_of_inertia(k) * alpha - moment)
        return result

    def _moment_of_inertia(self, link: int) -> sp.Expr:
        """J about the inboard point; the recursion gives it the same name."""
        rho = self.kinematics.centre[link]
        body = self.kinematics.mechanism.links[link]
        return self.ledger.let(
            f"J_{link}", symbol(body.inertia) + sp.expand(self.kinematics.mass[link] * dot(rho, rho))
        )

    def _gather(self, wrenches: dict[int, Wrench], name: str, title: str) -> tuple[sp.Expr, ...]:
        """Generalized forces of wrenches on the links, from the tips inwards: Σ over what hangs outboard (eq. 17)."""
        force = {k: wrench[0] for k, wrench in wrenches.items()}
        moment = {k: wrench[1] for k, wrench in wrenches.items()}
        for branch in reversed(self.topology.branches):
            felt = self.ledger.let_vector(f"{name}_{branch.link}", force[branch.link])
            if branch.parent != GROUND:
                force[branch.parent] = add(force[branch.parent], felt)
                moment[branch.parent] += dot(perp(self.kinematics.r[branch.parent, branch.joint]), felt)
        self.ledger.close(title)
        base = list(force[self.topology.root]) if self.topology.floating else []
        return tuple(base + [moment[k] for k in range(len(moment))])

    def _momentum(self, velocity: dict[int, Vector]) -> Kernel:
        wrenches = {}
        for k in range(len(self.kinematics.mechanism.links)):
            mass, mu, rate = self.kinematics.mass[k], self.kinematics.mu[k], self.state.rate(k)
            linear = add(scale(mass, velocity[k]), scale(rate, perp(mu)))
            wrenches[k] = (linear, dot(perp(mu), velocity[k]) + self._moment_of_inertia(k) * rate)
        momenta = self._gather(wrenches, "L", "momenta, inwards")
        return Kernel(
            "momentum",
            (self.q, self.u),
            (Output("p", momenta, "generalized momenta M u"),),
            "momenta of the open chain",
        )

    def _inverse_dynamics(self, inertia: dict[int, Wrench]) -> Kernel:
        forces = self._gather(inertia, "Q", "forces for a given motion, inwards")
        output = Output(
            "f", forces, "generalized forces M u_dot + h that the motion needs besides those of the effects"
        )
        return Kernel(
            "inverse_dynamics",
            (self.q, self.u, *self.acted, self.u_dot),
            (output,),
            "inverse dynamics of the open chain",
        )

    def _reactions(self, inertia: dict[int, Wrench]) -> Kernel:
        """Force of each joint on its outboard link, from the tips inwards (eq. 18); a cut joint's is its multiplier."""
        cuts = self.topology.cuts
        given = {cut.joint: tuple(sp.Symbol(f"given_lambda_{cut.joint}_{axis}") for axis in AXES) for cut in cuts}
        result: dict[int, Vector] = {joint: (pair[0], pair[1]) for joint, pair in given.items()}
        felt: dict[int, Vector] = {}
        for cut in cuts:
            for side, factor in ((cut.first, 1), (cut.second, -1)):
                felt[side.link] = add(felt.get(side.link, ZERO), scale(sp.Integer(factor), result[cut.joint]))
        for branch in reversed(self.topology.branches):
            force = add(inertia[branch.link][0], felt.get(branch.link, ZERO))
            result[branch.joint] = self.ledger.let_vector(f"R_{branch.joint}", force)
            felt[branch.parent] = add(felt.get(branch.parent, ZERO), result[branch.joint])
        self.ledger.close("reactions, inwards")
        multipliers = Argument("lambda", tuple(s for pair in given.values() for s in pair), "closure multipliers, N")
        joints = range(len(self.kinematics.mechanism.joints))
        entries = tuple(entry for joint in joints for entry in (*result[joint], sp.S.Zero))
        output = Output("reaction", entries, "per joint: force x, y (N) and moment (N m) on the outboard link")
        return Kernel(
            "reactions", (self.q, self.u, *self.acted, self.u_dot, multipliers), (output,), "forces in the joints"
        )
