"""The map of the derivation: mechanism and effects in, :class:`Equations` out.

stage          input                        output
kinematics     mechanism, spanning tree     arms, first moments, positions, velocities
gibbs          kinematics, field, loads     accelerations and multipliers; velocity jumps and impulses
closure        kinematics                   residual, rate and Jacobian of the cut joints
contacts       kinematics, gaps             gaps, their rates, generalized impulses
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from ..equations.equations import OTHERWISE, Argument, ContactName, Equations, Kernel, Output, OutputName
from ..equations.ledger import Ledger
from ..equations.names import A_X, A_Y, ALPHA, AXES, SLIDE, State, multiplier, slide_name, sliding_name
from ..mechanism.joints import PointRef
from ..mechanism.links import GROUND
from ..mechanism.mechanism import Mechanism
from ..mechanism.topology import Topology
from ..planning.plan import Plan
from .closure import Closure
from .contact_kinematics import Contacts
from .form import FLIGHT, IMPACT
from .gated import whiles_of
from .gibbs import Recursion
from .indicators import LENGTH, PACE, Indicates, Sets
from .inverse import Inverse
from .kinematics import Kinematics
from .motion import TIME, Couple, Force, Motion, sum_per_link
from .terms_of_effects import Terms, laws_of
from .vectors import ZERO, Vector, Wrench, add, dot, symbol

MARK = "_v"
"""Behind the names of that plan's quantities that the first has named otherwise."""


def derive(
    mechanism: Mechanism,
    topology: Topology,
    plan: Plan,
    effects: Sequence[Terms] = (),
    indicators: Sequence[Indicates] = (),
    values: Sequence[Sets] = (),
) -> Equations:
    """All equations of a mechanism under the given effects, the unknowns eliminated in the order of ``plan``, and
    the event ``indicators`` of its scene, and the ``values`` that its events set.

    The order of the assignments is that of the derivation.
    """
    return _Derivation(mechanism, topology, plan, tuple(effects), tuple(indicators), tuple(values)).equations()


class _Derivation:
    def __init__(
        self,
        mechanism: Mechanism,
        topology: Topology,
        plan: Plan,
        effects: tuple[Terms, ...],
        indicators: tuple[Indicates, ...],
        values: tuple[Sets, ...],
    ) -> None:
        self.mechanism, self.topology, self.plan, self.effects = mechanism, topology, plan, effects
        self.indicators, self.values = indicators, values
        self.ledger = Ledger()
        self.state = State.of(mechanism, topology)
        self.kinematics = Kinematics(mechanism, topology, self.state, self.ledger)
        self.field: Vector = add(ZERO, *(effect.field() for effect in effects))
        self.q = Argument("q", self.state.q, "coordinates")
        self.u = Argument("u", self.state.u, "quasi-velocities, u = dq/dt")
        names = tuple(sp.Symbol(f"in_{name}") for effect in effects for name in effect.inputs())
        sides = tuple(sp.Symbol(f"side_{name}") for effect in effects for name in effect.sides())
        latched = tuple(sp.Symbol(f"latched_{name}") for effect in effects for name, _ in effect.latches())
        meaning = "inputs of the scene" + (", and the sides of their kinks on which effects are" if sides else "")
        meaning += ", and what they hold" if latched else ""
        self.acted = (Argument("t", (TIME,), "time, s"), Argument("inputs", names + sides + latched, meaning))

    def equations(self) -> Equations:
        """Derive everything, kernel by kernel."""
        self.place, self.velocity = self.kinematics.write_positions(), self.kinematics.write_velocities()
        self.closure = Closure(self.kinematics)
        self.motion = Motion(self.kinematics, self.closure, self.place, self.velocity, laws_of(self.effects))
        self.loads = self._loads()
        self.drives = self._drives()
        kernels = [
            *self._dynamics(),
            *self._closure(),
            *self._motion(),
            *self._contact(),
            *self._switching(),
            *self._told(),
            *self._reaches(),
            *self._indicated(),
            *self._set(),
        ]
        parameters = [*self.mechanism.parameters(), *(p for effect in self.effects for p in effect.parameters())]
        blocks, modules = tuple(self.ledger.blocks), tuple(map(self._state_of, self.plan.modules))
        names = tuple(
            ContactName(gap.name, gap.ground, gap.angular, gap.slides, whiles_of(gap)) for gap in self.contacts
        )
        return Equations(
            tuple(parameters),
            self.state,
            blocks,
            tuple(kernels),
            names,
            modules=modules,
            outputs=tuple(self.outputs),
            rated=self.rated,
        )

    def _state_of(self, module: tuple[int, ...]) -> tuple[sp.Symbol, ...]:
        """Coordinates and rates of a module's links."""
        state, slides = self.state, self.kinematics.slides
        found = [s for k in module for s in (state.angle(k), state.rate(k)) if s in (*state.q, *state.u)]
        joints = [branch.joint for branch in self.topology.branches if branch.link in module and branch.link in slides]
        found += [sp.Symbol(name(joint)) for joint in joints for name in (slide_name, sliding_name)]
        return tuple(dict.fromkeys(found))

    def _loads(self) -> dict[int, Wrench]:
        """What the effects do to each link, named effect by effect."""
        loads: list[Force | Couple] = []
        for effect in self.effects:
            loads += effect.loads(self.motion)
            self.ledger.close(f"loads: {effect.title}")
        summed = sum_per_link(loads, self.kinematics)
        self.ledger.close("loads of the links, about their inboard points")
        return summed

    def _drives(self) -> dict[int, sp.Expr]:
        """Prescribed accelerations by joint."""
        found = {joint: value for effect in self.effects for joint, value in effect.drives(self.motion)}
        self.ledger.close("prescribed motion")
        return found

    def _prescribed(self) -> list[Kernel]:
        """The prescribed accelerations alone, for the solution of dependent closure rows."""
        if not self.drives:
            return []
        order = [self.drives[branch.joint] for branch in self.topology.branches if branch.joint in self.drives]
        signs = [1 if b.slides or b.outwards else -1 for b in self.topology.branches if b.joint in self.drives]
        entries = tuple(sign * value for sign, value in zip(signs, order, strict=True))
        output = Output("relative", entries, "prescribed accelerations of driven joints, outwards, rad/s^2 or m/s^2")
        return [Kernel("prescribed", self.acted, (output,), "prescribed accelerations")]

    def _power(self, inverse: Inverse) -> list[Kernel]:
        """The power of loads without a potential, if the scene names any: the energy balance needs its integral."""
        power = sp.Add(*(effect.power(self.motion) for effect in self.effects), inverse.drive_power())
        self.ledger.close("power")
        if power == 0:
            return []
        output = Output("power", (power,), "power of the effects that have no potential, W")
        solved = (inverse.u_dot, inverse.multipliers) if self.drives else ()
        return [Kernel("power", (self.q, self.u, *self.acted, *solved), (output,), "power of the effects")]

    def _switching(self) -> list[Kernel]:
        """The switching functions, if any effect has kinks: where one changes its sign a step of a run ends."""
        values = tuple(value for effect in self.effects for value in effect.switching(self.motion))
        self.ledger.close("switching functions")
        if not values:
            return []
        output = Output("value", values, "switching functions of the effects")
        found = [Kernel("switching", (self.q, self.u, *self.acted), (output,), "switching functions")]
        held = tuple(value for effect in self.effects for value in effect.latching(self.motion))
        self.ledger.close("what effects hold")
        if held:
            output = Output("value", held, "what effects hold from when it is set")
            found.append(Kernel("latching", (self.q, self.u, *self.acted), (output,), "what effects hold"))
        return found

    def _told(self) -> list[Kernel]:
        """What runs tell of the effects by name, if there is any."""
        told = [(effect.title, one) for effect in self.effects for one in effect.outputs(self.motion)]
        self.ledger.close("what runs tell of effects")
        links = [self.mechanism.link_name(one[3]) if len(one) > 3 else "" for _, one in told]
        self.outputs = [
            OutputName(f"{title}.{one[0]}" if one[0] else title, one[1], link)
            for (title, one), link in zip(told, links, strict=True)
        ]
        if not told:
            return []
        output = Output("value", tuple(one[2] for _, one in told), "what runs tell of the effects")
        return [Kernel("outputs", (self.q, self.u, *self.acted), (output,), "what runs tell of the effects")]

    def _reaches(self) -> list[Kernel]:
        """The vectors that loads have the direction of: where one vanishes they jump, and steps become short."""
        reaches = [reach for effect in self.effects for reach in effect.reaches(self.motion)]
        self.ledger.close("lines that loads have the direction of")
        if not reaches:
            return []
        entries = tuple(entry for reach in reaches for entry in reach)
        output = Output("reach", entries, "per line: from its first end to its second, m")
        return [Kernel("reaches", (self.q,), (output,), "lines that loads have the direction of")]

    def _indicated(self) -> list[Kernel]:
        """The event indicators of the scene, if it has any."""
        found = [one.indication(self.motion, f"when_{number}") for number, one in enumerate(self.indicators)]
        self.ledger.close("event indicators")
        self.rated = tuple(int(one.rate is not None) for one in found)
        if not found:
            return []
        time, scales = (
            Argument("t", (TIME,), "time, s"),
            Argument("scales", (LENGTH, PACE), "of lengths, m, and times, s"),
        )
        outputs = (
            Output("value", tuple(one.value for one in found), "event indicators"),
            Output(
                "rate",
                tuple(sp.S.Zero if one.rate is None else one.rate for one in found),
                "their rates per second, 0 of those that have accelerations in theirs",
            ),
            Output("size", tuple(one.size for one in found), "what rounding of the values is a multiple of"),
        )
        return [Kernel("indicators", (self.q, self.u, time, scales), outputs, "event indicators")]

    def _set(self) -> list[Kernel]:
        """What events of the scene set, if they do."""
        found = tuple(one.at(self.motion, f"set_{number}") for number, one in enumerate(self.values))
        self.ledger.close("what events set")
        if not found:
            return []
        output = Output("value", found, "what events set parameters to")
        time = Argument("t", (TIME,), "time, s")
        return [Kernel("event_values", (self.q, self.u, time), (output,), "what events set")]

    def _dynamics(self) -> list[Kernel]:
        """Accelerations and velocity jumps, by the plan and by the one to go to where its guards fail."""
        kernels = self._solved(self.plan, "")
        if self.plan.otherwise:
            self.ledger.mark = MARK
            kernels = [*self._solved(self.plan.otherwise, OTHERWISE), *kernels]
            self.ledger.mark = ""
        return kernels

    def _solved(self, plan: Plan, behind: str) -> list[Kernel]:
        impulses = tuple(sp.Symbol(f"F_{u}") for u in self.state.u)
        rows = [multiplier(*row) for row in self.topology.rows]
        jumps = {row: sp.Symbol(f"y_{row.joint}_{row.axis}") for row in rows}
        recursion = Recursion(
            plan, self.kinematics, self.closure, self.ledger, self.field, self.loads, impulses, jumps, self.drives
        )
        recursion.run()
        results = {}
        for impact in (FLIGHT, IMPACT):
            base = self._base(recursion, impact)
            results[impact] = (
                tuple(base + self._rates(recursion, impact)),
                tuple(recursion.value(impact, GROUND, row) for row in rows),
            )
        guards = tuple(recursion.guards)
        f = Argument("f", impulses, "generalized impulses")
        y = Argument("y", tuple(jumps.values()), "closure rates to be produced")
        solvers = ("acceleration", "impulse")
        otherwise = {name: f"{name}{OTHERWISE}" if plan.otherwise else None for name in solvers}
        where = ", where a guard of the first plan fails" if behind else ""
        return [
            Kernel(
                f"acceleration{behind}",
                (self.q, self.u, *self.acted),
                (
                    Output("u_dot", results[FLIGHT][0], "quasi-accelerations"),
                    Output(
                        "lambda", results[FLIGHT][1], "closure multipliers: force on the second side of each cut, N"
                    ),
                ),
                f"M u_dot + h = A^T lambda, A u_dot + dA/dt u = 0{where}",
                guards,
                otherwise["acceleration"],
                asked="lambda",
            ),
            Kernel(
                f"impulse{behind}",
                (self.q, f, y),
                (
                    Output("du", results[IMPACT][0], "jumps of the quasi-velocities"),
                    Output("Lambda", results[IMPACT][1], "impulses of the cut joints, N s"),
                ),
                f"M du = A^T Lambda + f, A du = y{where}",
                guards,
                otherwise["impulse"],
                asked="Lambda",
            ),
        ]

    def _rates(self, recursion: Recursion, impact: bool) -> list[sp.Expr]:
        """Angular accelerations (their jumps) of the links that have an angle, and those along the sliding joints."""
        state, links = self.state, range(len(self.mechanism.links))
        found = {state.rate(k): recursion.value(impact, k, ALPHA) for k in links}
        slides = self.kinematics.slides
        found |= {slide.speed: recursion.value(impact, link, SLIDE) for link, slide in slides.items()}
        return [found[u] for u in state.u[state.base :]]

    def _base(self, recursion: Recursion, impact: bool) -> list[sp.Expr]:
        """Acceleration (velocity jump) of a floating root; adds the field that the recursion left out (eq. 4.12)."""
        if not self.topology.floating:
            return []
        a = [recursion.value(impact, self.topology.root, v) for v in (A_X, A_Y)]
        return [x + (0 if impact else field) for x, field in zip(a, self.field, strict=True)]

    def _closure(self) -> list[Kernel]:
        closure = self.closure
        return [
            Kernel(
                "closure", (self.q,), (Output("residual", closure.residual(), "gap of each cut joint, m"),), "closure"
            ),
            Kernel(
                "closure_rate", (self.q, self.u), (Output("rate", closure.rate(), "A u, m/s"),), "rate of the closure"
            ),
            Kernel(
                "closure_bias",
                (self.q, self.u),
                (Output("bias", closure.bias(), "dA/dt u, m/s^2"),),
                "bias of the closure",
            ),
            Kernel(
                "closure_jacobian",
                (self.q,),
                (Output("A", closure.jacobian(), "derivatives of the closure rates by u, row by row"),),
                "Jacobian of the closure",
            ),
        ]

    def _motion(self) -> list[Kernel]:
        self.inverse = inverse = Inverse(self.kinematics, self.closure, self.field, self.loads, self.acted, self.drives)
        return [
            *inverse.kernels(self.velocity),
            *self._power(inverse),
            *self._prescribed(),
            Kernel(
                "poses", (self.q,), (Output("pose", self._poses(), "per link: x, y (m), angle of its frame"),), "poses"
            ),
            Kernel(
                "velocities",
                (self.q, self.u),
                (Output("velocity", self._velocities(), "per link: velocity of its frame's origin, angular velocity"),),
                "velocities",
            ),
            Kernel(
                "points",
                (self.q,),
                (Output("position", self._points(), "per joint, then per named point: x, y"),),
                "points",
            ),
            Kernel(
                "energy",
                (self.q, self.u),
                (Output("energy", self._energy(), "kinetic and potential energy, J"),),
                "energy",
            ),
        ]

    def _origins(self) -> list[Vector]:
        """Arms from the inboard points to the frames' origins."""
        arms = []
        for k in range(len(self.mechanism.links)):
            rho = tuple(
                self.ledger.let(f"rho_{k}_o_{a}", -x) for a, x in zip(AXES, self.kinematics.inboard[k], strict=True)
            )
            arms.append(self.ledger.let_vector(f"r_{k}_o", self.kinematics.turn(k, (rho[0], rho[1]))))
        self.ledger.close("arms to the frames' origins")
        return arms

    def _poses(self) -> tuple[sp.Expr, ...]:
        self.origins = self._origins()
        return tuple(
            entry for k, arm in enumerate(self.origins) for entry in (*add(self.place[k], arm), self.state.angle(k))
        )

    def _velocities(self) -> tuple[sp.Expr, ...]:
        return tuple(
            entry
            for k, arm in enumerate(self.origins)
            for entry in (*add(self.velocity[k], self.kinematics.swing(k, arm)), self.state.rate(k))
        )

    def _points(self) -> tuple[sp.Expr, ...]:
        """Each joint where its tree side (a cut: its first side; a line: what slides) has it, then each named point."""
        refs = [self._joint_side(index) for index in range(len(self.mechanism.joints))]
        refs += [PointRef(k, name) for k, link in enumerate(self.mechanism.links) for name in link.points]
        result: list[sp.Expr] = []
        known: dict[PointRef, Vector] = {}
        for ref in refs:
            if ref not in known:
                base = ZERO if ref.link == GROUND else self.place[ref.link]
                known[ref] = add(base, self.kinematics.arm_to(ref))
            result += known[ref]
        self.ledger.close("arms to named points")
        return tuple(result)

    def _joint_side(self, index: int) -> PointRef:
        joint = self.mechanism.joints[index]
        if joint.slides:
            return self.mechanism.as_named(index).second
        for branch in self.topology.branches:
            if branch.joint == index:
                return PointRef(branch.link, branch.inboard)
        return joint.first

    def _energy(self) -> tuple[sp.Expr, sp.Expr]:
        kinetic, potential = sp.S.Zero, sp.S.Zero
        for k, link in enumerate(self.mechanism.links):
            mass = self.kinematics.mass[k]
            arm = self.ledger.let_vector(f"rc_{k}", self.kinematics.turn(k, self.kinematics.centre[k]))
            v = self.ledger.let_vector(f"vc_{k}", add(self.velocity[k], self.kinematics.swing(k, arm)))
            spin = symbol(link.inertia) * self.state.rate(k) ** 2
            kinetic += self.ledger.let(f"T_{k}", (mass * dot(v, v) + spin) / 2)
            potential -= self.ledger.let(f"W_{k}", mass * dot(self.field, add(self.place[k], arm)))
        potential += sp.Add(*(effect.potential(self.motion) for effect in self.effects))
        self.ledger.close("energy")
        return kinetic, potential

    def _contact(self) -> list[Kernel]:
        self.contacts = tuple(c for effect in self.effects for c in effect.gaps(self.ledger.let))
        self.ledger.close("grounds")
        if not self.contacts:
            return [self.inverse.impulses(self.velocity)] if self.mechanism.gates else []
        gaps = Contacts(self.kinematics, self.contacts, self.place, self.velocity)
        pushes = tuple(sp.Symbol(f"N_{index}") for index in range(len(self.contacts)))
        impulses = Argument("P", pushes, "normal impulses of the contacts, N s")
        restitution = tuple(c.restitution for c in self.contacts)
        return [
            Kernel(
                "gaps", (self.q,), (Output("gap", gaps.values(), "gap of each contact, m; of a stop, rad"),), "gaps"
            ),
            Kernel("gap_rates", (self.q, self.u), (Output("rate", gaps.rates(), "N u, m/s"),), "rates of the gaps"),
            Kernel("gap_bias", (self.q, self.u), (Output("bias", gaps.bias(), "dN/dt u, m/s^2"),), "bias of the gaps"),
            Kernel(
                "contact_impulse",
                (self.q, impulses),
                (Output("f", gaps.generalized_impulses(pushes), "generalized impulses N^T P"),),
                "generalized impulses of the contacts",
            ),
            Kernel(
                "restitution",
                (),
                (Output("e", restitution, "coefficient of restitution of each contact"),),
                "restitution",
            ),
            *self._friction(gaps),
            *self._joints_in_contact(gaps, pushes),
        ]

    def _joints_in_contact(self, gaps: Contacts, normal: tuple[sp.Symbol, ...]) -> list[Kernel]:
        """What contacts change in the forces of the joints, and the impulses of the joints in an impact."""
        rough = any(c.friction for c in self.contacts)
        tangential = tuple(sp.Symbol(f"S_{index}_t") for index in range(len(self.contacts))) if rough else ()
        meaning = "normal forces (impulses) of the contacts" + (", then the tangential ones" if rough else "")
        pushes = Argument("P", (*normal, *tangential), f"{meaning}, N, N m (N s, N m s)")
        of_contacts = self.inverse.of_contacts(gaps.wrenches(normal, tangential), pushes)
        return [of_contacts, self.inverse.impulses(self.velocity)]

    def _friction(self, gaps: Contacts) -> list[Kernel]:
        """What sliding needs, if any ground is rough."""
        friction = tuple(c.friction for c in self.contacts)
        if not any(friction):
            return []
        pulls = tuple(sp.Symbol(f"S_{index}_t") for index in range(len(self.contacts)))
        impulses = Argument("P", pulls, "tangential impulses of the contacts, N s")
        return [
            Kernel("slips", (self.q, self.u), (Output("rate", gaps.slips(), "T u, m/s"),), "sliding of the contacts"),
            Kernel(
                "slip_bias",
                (self.q, self.u),
                (Output("bias", gaps.slip_bias(), "dT/dt u, m/s^2"),),
                "bias of the sliding",
            ),
            Kernel(
                "slip_impulse",
                (self.q, impulses),
                (Output("f", gaps.generalized_impulses(pulls, tangential=True), "generalized impulses T^T P"),),
                "generalized impulses of friction",
            ),
            Kernel("friction", (), (Output("mu", friction, "coefficient of friction of each contact"),), "friction"),
        ]
