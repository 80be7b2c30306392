"""From given motions to forces: momentum, inverse dynamics, and the forces in the joints (theory, section 7).

Nothing is solved here. Motion is carried outwards from the root, forces are gathered inwards from the tips.
"""

from __future__ import annotations

from collections.abc import Collection

import sympy as sp

from ..equations.equations import Argument, Kernel, Output
from ..equations.names import place
from .closure import Closure
from .generalized_forces import gather_inwards
from .kinematics import Kinematics
from .shares import Shares
from .vectors import NO_LOAD, ZERO, Vector, Wrench, add, dot, inertia_of, perp, scale


class Inverse:
    """Kernels that turn motions into forces, less those that effects supply: ``field`` and ``loads``."""

    def __init__(
        self,
        kinematics: Kinematics,
        closure: Closure,
        field: Vector,
        loads: dict[int, Wrench],
        acted: tuple[Argument, ...],
        driven: Collection[int],
    ) -> None:
        self.kinematics, self.topology, self.ledger = kinematics, kinematics.topology, kinematics.ledger
        self.closure, self.driven = closure, driven
        self.held: dict[int, sp.Expr] = {}
        self.pushed: dict[int, Vector] = {}
        self.state, self.field, self.loads, self.acted = kinematics.state, field, loads, acted
        self.q = Argument("q", self.state.q, "coordinates")
        self.u = Argument("u", self.state.u, "quasi-velocities, u = dq/dt")
        self.u_dot = Argument("u_dot", tuple(sp.Symbol(f"{u}_dot") for u in self.state.u), "quasi-accelerations")

    def kernels(self, velocity: dict[int, Vector]) -> list[Kernel]:
        """``momentum``, ``inverse_dynamics`` and ``reactions``; ``velocity`` of every inboard point."""
        inertia = self._inertia(self._accelerations())
        return [self._momentum(velocity), self._inverse_dynamics(inertia), self._reactions(inertia)]

    def _accelerations(self) -> dict[int, Vector]:
        """Accelerations of the inboard points less the field, from given quasi-accelerations, outwards (eq. 2.4)."""
        kinematics, topology = self.kinematics, self.topology
        base = (self.u_dot.symbols[0], self.u_dot.symbols[1]) if topology.floating else ZERO
        root = add(base, scale(sp.S.NegativeOne, self.field))
        a = {topology.root: self.ledger.let_vector(f"aR_{place(topology.root)}", root)}
        for branch in topology.branches:
            terms = [
                a[branch.parent],
                scale(self._spin(branch.parent), perp(kinematics.r[branch.parent, branch.joint])),
            ]
            if branch.link in kinematics.lead:
                terms.append(scale(self._spin(branch.link), perp(kinematics.lead[branch.link])))
            if branch.link in kinematics.slides:
                slide = kinematics.slides[branch.link]
                terms.append(scale(self._dot(slide.speed), slide.direction))
            a[branch.link] = self.ledger.let_vector(f"aR_{branch.link}", add(*terms, kinematics.bias(branch)))
        self.ledger.close("accelerations less the field, outwards")
        return a

    def _spin(self, link: int) -> sp.Expr:
        rate = self.state.rate(link)
        return sp.S.Zero if rate == 0 else self._dot(rate)

    def _dot(self, velocity: sp.Expr) -> sp.Symbol:
        return self.u_dot.symbols[self.state.u.index(velocity)]

    def _inertia(self, a: dict[int, Vector]) -> dict[int, Wrench]:
        """The wrench that gives each link its acceleration, less its loads: derivatives of S by a and α (eq. 4.2)."""
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
        return self.ledger.let(f"J_{link}", inertia_of(body) + sp.expand(self.kinematics.mass[link] * dot(rho, rho)))

    def _momenta(self, velocity: dict[int, Vector]) -> dict[int, Wrench]:
        """Linear momentum of each link, and angular momentum about its inboard point."""
        wrenches = {}
        for k in range(len(self.kinematics.mechanism.links)):
            mass, mu, rate = self.kinematics.mass[k], self.kinematics.mu[k], self.state.rate(k)
            linear = add(scale(mass, velocity[k]), scale(rate, perp(mu)))
            wrenches[k] = (linear, dot(perp(mu), velocity[k]) + self._moment_of_inertia(k) * rate)
        return wrenches

    def _momentum(self, velocity: dict[int, Vector]) -> Kernel:
        """L = M u, gathered inwards (eq. 7.2)."""
        momenta = gather_inwards(self.kinematics, self._momenta(velocity), "L", "momenta, inwards")
        return Kernel(
            "momentum",
            (self.q, self.u),
            (Output("p", momenta, "generalized momenta M u"),),
            "momenta of the open chain",
        )

    def _inverse_dynamics(self, inertia: dict[int, Wrench]) -> Kernel:
        """M u̇ + h̄, gathered inwards (eq. 7.1)."""
        forces = gather_inwards(self.kinematics, inertia, "Q", "forces for a given motion, inwards")
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
        given = self._given()
        self.pushed, self.held = self._carried(inertia, given, "R", "reactions, inwards")
        self.multipliers = multipliers = Argument("lambda", tuple(given.values()), "closure multipliers, N")
        entries = self._per_joint(self.pushed, self.held, "R")
        output = Output("reaction", entries, "per joint: force x, y (N) and moment (N m) on the outboard link")
        return Kernel(
            "reactions", (self.q, self.u, *self.acted, self.u_dot, multipliers), (output,), "forces in the joints"
        )

    def of_contacts(self, pushed: dict[int, Wrench], pushes: Argument) -> Kernel:
        """What ``pushed``, the wrenches of contacts on links, adds to the reactions."""
        against = {k: (scale(sp.S.NegativeOne, force), -moment) for k, (force, moment) in pushed.items()}
        forces, moments = self._carried(against, {}, "RC", "reactions to what contacts do, inwards")
        output = Output(
            "reaction", self._per_joint(forces, moments, "RC"), "per joint: force x, y and moment, to be added"
        )
        return Kernel("contact_reactions", (self.q, pushes), (output,), "forces in the joints by the contacts")

    def impulses(self, velocity: dict[int, Vector]) -> Kernel:
        """The impulses of the joints for jumps of the velocities, less those of contacts: eq. 4.13 with momenta,
        as eq. 5.27 has them."""
        given = self._given()
        forces, moments = self._carried(self._momenta(velocity), given, "RI", "impulses of the joints, inwards")
        output = Output(
            "reaction",
            self._per_joint(forces, moments, "RI"),
            "per joint: impulse x, y (N s), moment (N m s) on the outboard link",
        )
        jumps = Argument("u", self.state.u, "jumps of the quasi-velocities")
        impulses = Argument("lambda", tuple(given.values()), "impulses of the cut joints, N s")
        return Kernel("impulse_reactions", (self.q, jumps, impulses), (output,), "impulses of the joints")

    def _given(self) -> dict[tuple[int, str], sp.Symbol]:
        """Multipliers as arguments."""
        return {row: sp.Symbol(f"given_lambda_{row[0]}_{row[1]}") for row in self.topology.rows}

    def _per_joint(self, forces: dict[int, Vector], moments: dict[int, sp.Expr], name: str) -> tuple[sp.Expr, ...]:
        """Those of all joints, of which some bear a share of others'; moments of prismatic joints are about their later
        ends."""
        moved = dict(moments)
        for branch in self.topology.branches:
            ends = self.kinematics.mechanism.as_named(branch.joint)
            link = (ends.second if branch.outwards else ends.first).link  # a shaft stands for what is welded to it
            if branch.follows and branch.joint in moments and link < branch.parent:
                slide = self.kinematics.slides[branch.link]
                arm = scale(slide.length, slide.direction)
                moved[branch.joint] += dot(perp(arm), forces[branch.joint])
        for cut in self.topology.cuts:
            if cut.kind == "prismatic" and cut.joint in forces and cut.second.link < cut.first.link:
                arm = self.closure.lines[cut.joint].distance
                moved[cut.joint] = moved.get(cut.joint, sp.S.Zero) + dot(perp(arm), forces[cut.joint])
        return Shares(self.kinematics, forces, moved, name).reactions()

    def _carried(
        self, wrenches: dict[int, Wrench], given: dict[tuple[int, str], sp.Symbol], name: str, title: str
    ) -> tuple[dict[int, Vector], dict[int, sp.Expr]]:
        """Force and moment of each joint on its outboard link, from the tips inwards (eq. 4.13), that give the links
        the ``wrenches``; a cut joint's force is its multipliers', where those are ``given``. A pin has no moment,
        and a link's moments are written only where its joint holds its angle."""
        result: dict[int, Vector] = {}
        moment = {k: wrench[1] for k, wrench in wrenches.items()}
        felt: dict[int, Vector] = {}
        holding = [cut for cut in self.topology.cuts if cut.turns_alike]
        for cut in self.topology.cuts if given else ():
            for side, factor in ((cut.first, 1), (cut.second, -1)):
                sides = self.closure.side(cut, side.link, -factor)
                force = add(*(scale(given[cut.joint, row.name], row.direction) for row in sides))
                result[cut.joint] = force
                felt[side.link] = add(felt.get(side.link, ZERO), scale(sp.Integer(factor), force))
                moment[side.link] = moment.get(side.link, sp.S.Zero) + factor * dot(perp(sides[0].arm), force)
                if cut.turns_alike:
                    moment[side.link] -= self.closure.turning(cut, side.link) * given[cut.joint, "a"]
        if given:
            self._meshed(given, felt, moment)
        moments = {cut.joint: sp.Float(cut.arm) * given[cut.joint, "a"] for cut in holding} if given else {}
        for branch in reversed(self.topology.branches):
            link, parent = branch.link, branch.parent
            if link not in wrenches and link not in felt and link not in moment:
                continue
            force = add(wrenches.get(link, NO_LOAD)[0], felt.get(link, ZERO))
            result[branch.joint] = self.ledger.let_vector(f"{name}_{branch.joint}", force)
            felt[parent] = add(felt.get(parent, ZERO), result[branch.joint])
            turned = dot(perp(self.kinematics.r[parent, branch.joint]), result[branch.joint])
            moment[parent] = moment.get(parent, sp.S.Zero) + turned
            if branch.follows or (branch.joint in self.driven and not branch.slides):
                moments[branch.joint] = self.ledger.let(f"M{name}_{branch.joint}", moment.get(link, sp.S.Zero))
                moment[parent] += moments[branch.joint]
        self.ledger.close(title)
        return result, moments

    def _meshed(
        self, given: dict[tuple[int, str], sp.Symbol], felt: dict[int, Vector], moment: dict[int, sp.Expr]
    ) -> None:
        """Takes from what links need what meshes give them: moments, and forces along lines (eq. 3.4)."""
        meshing = self.closure.meshing
        for row in self.topology.meshes:
            force = given[row.joint, "m"]
            for link, lever in meshing.levers[row.joint].items():
                moment[link] = moment.get(link, sp.S.Zero) - lever * force
            for joint, sign in meshing.lengths[row.joint].items():
                branch = next(one for one in self.topology.branches if one.joint == joint)
                push = scale(sign * force, self.kinematics.slides[branch.link].direction)
                felt[branch.link] = add(felt.get(branch.link, ZERO), scale(sp.S.NegativeOne, push))
                felt[branch.parent] = add(felt.get(branch.parent, ZERO), push)
                turned = dot(perp(self.kinematics.r[branch.parent, joint]), push)
                moment[branch.parent] = moment.get(branch.parent, sp.S.Zero) + turned

    def drive_power(self) -> sp.Expr:
        """What joints with prescribed motion put in (W): moment times relative rate, or force times sliding speed."""
        total = sp.S.Zero
        for branch in self.topology.branches:
            if branch.joint not in self.driven:
                continue
            if branch.slides:
                slide = self.kinematics.slides[branch.link]
                total += dot(slide.direction, self.pushed[branch.joint]) * slide.speed
            else:
                rates = self.state.rate(branch.link) - self.state.rate(branch.parent)
                total += self.held[branch.joint] * rates
        return total
