"""The recursive Gibbs–Appell equations: a quadratic form passed from tips to root, one sweep outwards (theory, 4).

The same recursion serves flight and impact. In flight the linear terms of V hold centripetal accelerations, forces and
the closure bias; in impact they hold generalized impulses and the closure velocities to be removed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache

import sympy as sp

from ..mechanism.links import GROUND
from ..mechanism.topology import Cut
from .equations import Ledger
from .form import FLIGHT, IMPACT, Eliminator, Form, Solution
from .kinematics import ZERO, Kinematics, Vector, add, dot, perp, scale, symbol
from .names import A_X, A_Y, ALPHA, AXES, Variable, hessian_name, multiplier, place, solution_name

M, INERTIA, W2 = sp.symbols("m I w2")
A, ALPHA_ = sp.symbols("a_x a_y"), sp.Symbol("alpha")
RC, RHO, MU = sp.symbols("rc_x rc_y"), sp.symbols("rho_x rho_y"), sp.symbols("mu_x mu_y")


def gibbs_function() -> sp.Expr:
    """S = ½ m |a_c|² + ½ I α² of one link (eq. 5), from the acceleration a of its inboard point and α."""
    a_c = add(A, scale(ALPHA_, perp(RC)), scale(-W2, RC))
    return M * dot(a_c, a_c) / 2 + INERTIA * ALPHA_**2 / 2


@dataclass(frozen=True)
class GibbsDerivatives:
    """Derivatives of S by (a, α), written with the first moment µ = m·rc and with rc² = ρ² (a length does not turn)."""

    mass: sp.Expr
    coupling: Vector
    inertia: sp.Expr
    centripetal: Vector
    moment: sp.Expr


@cache
def gibbs_derivatives() -> GibbsDerivatives:
    """SymPy differentiates S once, in the symbols of a nameless link; every link then puts in its own names."""
    gibbs = gibbs_function()
    slope = [sp.diff(gibbs, v) for v in (*A, ALPHA_)]
    still = dict.fromkeys((*A, ALPHA_), 0)
    moments = {M * r: mu for r, mu in zip(RC, MU, strict=True)}
    at_rest = [sp.expand(s.subs(still)).subs(moments) for s in slope]
    coupling = [sp.diff(slope[axis], ALPHA_).subs(moments) for axis in (0, 1)]
    inertia = sp.expand(sp.diff(slope[2], ALPHA_)).subs(dict(zip(RC, RHO, strict=True)))
    return GibbsDerivatives(
        sp.diff(slope[0], A[0]), (coupling[0], coupling[1]), inertia, (at_rest[0], at_rest[1]), at_rest[2]
    )


Wrench = tuple[Vector, sp.Expr]
"""A force, and a moment about the inboard point of the link it acts on."""
NO_LOAD: Wrench = (ZERO, sp.S.Zero)


@dataclass
class Recursion:
    """Runs the recursion for a mechanism.

    ``field_`` is a uniform acceleration field (gravity): the root's acceleration alone carries it, so that it costs
    nothing along the chain (eq. 12).
    """

    kinematics: Kinematics
    ledger: Ledger
    field_: Vector
    loads: dict[int, Wrench]
    impulses: tuple[sp.Symbol, ...]
    jumps: dict[Variable, sp.Symbol]
    forms: dict[int, Form] = field(default_factory=dict)
    solutions: dict[int, list[Solution]] = field(default_factory=dict)
    guards: list[tuple[sp.Expr, sp.Expr]] = field(default_factory=list)
    known: dict[tuple[bool, int, Variable], sp.Expr] = field(default_factory=dict)

    # -- inwards ---------------------------------------------------------------------------------------------------

    def run(self) -> None:
        """Tips to root, then outwards in flight and in impact."""
        topology = self.kinematics.topology
        for branch in reversed(topology.branches):
            self._collect(branch.link)
        self._collect(topology.root)
        for impact in (FLIGHT, IMPACT):
            self._sweep(impact)

    def _collect(self, link: int) -> None:
        """V_link over its own and all outboard accelerations, made stationary in what belongs to it (eq. 7 to 10)."""
        form = Form([] if link == GROUND else [A_X, A_Y, ALPHA])
        if link != GROUND:
            self._own_terms(link, form)
        for branch in self.kinematics.topology.outboard(link):
            self._carry(link, branch.joint, self.forms[branch.link], form)
        for cut in self.kinematics.topology.cuts:
            for side, factor in ((cut.first, -1), (cut.second, 1)):
                if side.link == link:
                    self._closure_side(link, cut, factor, form)
        eliminator = Eliminator(link, form, self.ledger)
        blocks: list[tuple[Variable, ...]] = [
            (multiplier(cut.joint, "x"), multiplier(cut.joint, "y")) for cut in self._loops_closed_at(link, form)
        ]
        gathered = self._gathered_diagonal(link, form, blocks)
        if link != GROUND:
            blocks.append((ALPHA,))
            if link == self.kinematics.topology.root:
                blocks.append((A_X, A_Y))
        self.solutions[link] = [eliminator.eliminate(block) for block in blocks]
        self.guards += [
            (s.guard, (gathered[s.variables[0]] + gathered[s.variables[1]]) ** 2 / 4)
            for s in self.solutions[link]
            if s.guard
        ]
        eliminator.name_entries()
        self.forms[link] = form
        self.ledger.close(f"inwards: {self.kinematics.title(link)}")

    def _gathered_diagonal(self, link: int, form: Form, blocks: list[tuple[Variable, ...]]) -> dict[Variable, sp.Expr]:
        """Diagonal of C before loops that share links take from it: the scale of the guards."""
        diagonal = {}
        for v in (v for block in blocks for v in block):
            name = hessian_name(link, v, v)
            diagonal[v] = self.ledger.let(name if len(blocks) == 1 else f"{name}_all", -form.h(v, v))
            form.hessian[v, v] = -diagonal[v]
        return diagonal

    def _own_terms(self, link: int, form: Form) -> None:
        """Second and first derivatives of S_link, and the loads on the link (eq. 6)."""
        kinematics, derivatives = self.kinematics, gibbs_derivatives()
        here = {M: kinematics.mass[link], W2: kinematics.squared_rate[link]}
        here[INERTIA] = symbol(kinematics.mechanism.links[link].inertia)
        here |= dict(zip(RHO + MU, kinematics.centre[link] + kinematics.mu[link], strict=True))
        self._show_gibbs_function(link, here)
        force, moment = self.loads.get(link, NO_LOAD)
        form.add_h(ALPHA, ALPHA, self.ledger.let(f"J_{link}", derivatives.inertia.xreplace(here)))
        for axis, v in enumerate((A_X, A_Y)):
            form.add_h(v, v, derivatives.mass.xreplace(here))
            form.add_h(v, ALPHA, derivatives.coupling[axis].xreplace(here))
            centripetal = self.ledger.let(f"f_{link}_{v.axis}", derivatives.centripetal[axis].xreplace(here))
            form.add_l(FLIGHT, v, centripetal - force[axis])
        form.add_l(FLIGHT, ALPHA, derivatives.moment.xreplace(here) - moment)
        for variable, impulse in self._impulses(link).items():
            form.add_l(IMPACT, variable, -impulse)

    def _show_gibbs_function(self, link: int, here: dict[sp.Symbol, sp.Expr]) -> None:
        names = {s: sp.Symbol(f"{s.name[:-2]}_{link}{s.name[-2:]}") for s in (*A, *RC)}
        names |= here | {ALPHA_: sp.Symbol(f"alpha_{link}")}
        self.ledger.show_gibbs_function(sp.Symbol(f"S_{link}"), gibbs_function().xreplace(names))

    def _impulses(self, link: int) -> dict[Variable, sp.Symbol]:
        """Generalized impulses that work on the link's own variables."""
        state, topology = self.kinematics.state, self.kinematics.topology
        found = {ALPHA: self.impulses[state.u.index(state.rate(link))]}
        if link == topology.root:
            found |= {A_X: self.impulses[0], A_Y: self.impulses[1]}
        return found

    def _carry(self, link: int, joint: int, child: Form, form: Form) -> None:
        """Add V_child(a + α r⊥ − ω² r): the chain rule with the derivatives of the joint's acceleration (eq. 7)."""
        r, cr = self.kinematics.r[link, joint], self.kinematics.cr[link, joint]
        name = f"{place(link)}_{joint}"
        open_ = [v for v in child.variables if v.kind == "lambda"]
        form.variables += [v for v in open_ if v not in form.variables]
        for i, v in enumerate(open_):
            for w in open_[i:]:
                form.add_h(v, w, child.h(v, w))
        bias = self._field_or(scale(sp.S.NegativeOne, cr), link)
        linear = {i: (child.l(i, A_X), child.l(i, A_Y)) for i in (FLIGHT, IMPACT)}
        phi = [[child.h(v, w) for w in (A_X, A_Y)] for v in (A_X, A_Y)]
        felt = add(linear[FLIGHT], (dot((phi[0][0], phi[0][1]), bias), dot((phi[1][0], phi[1][1]), bias)))
        for v in open_:
            column = (child.h(A_X, v), child.h(A_Y, v))
            form.add_l(FLIGHT, v, child.l(FLIGHT, v) + dot(column, bias))
            form.add_l(IMPACT, v, child.l(IMPACT, v))
        if link == GROUND:
            return
        felt = self.ledger.let_vector(f"beta_{name}", felt)
        arm = perp(r)
        x = self.ledger.let_vector(f"X_{name}", (dot((phi[0][0], phi[0][1]), arm), dot((phi[1][0], phi[1][1]), arm)))
        for axis, v in enumerate((A_X, A_Y)):
            for other, w in tuple(enumerate((A_X, A_Y)))[axis:]:
                form.add_h(v, w, phi[axis][other])
            form.add_h(v, ALPHA, x[axis])
            form.add_l(FLIGHT, v, felt[axis])
            form.add_l(IMPACT, v, linear[IMPACT][axis])
        form.add_h(ALPHA, ALPHA, dot(arm, x))
        form.add_l(FLIGHT, ALPHA, dot(arm, felt))
        form.add_l(IMPACT, ALPHA, dot(arm, linear[IMPACT]))
        for v in open_:
            column = (child.h(A_X, v), child.h(A_Y, v))
            form.add_h(A_X, v, column[0])
            form.add_h(A_Y, v, column[1])
            form.add_h(ALPHA, v, dot(arm, column))

    def _closure_side(self, link: int, cut: Cut, factor: int, form: Form) -> None:
        """−λ·(± acceleration of the cut joint's point on this side) (eq. 7), and the impact's right-hand side once."""
        r, cr = self.kinematics.r[link, cut.joint], self.kinematics.cr[link, cut.joint]
        arm, bias = perp(r), self._field_or(scale(sp.S.NegativeOne, cr), link)
        for axis, name in enumerate(AXES):
            v = multiplier(cut.joint, name)
            if v not in form.variables:
                form.variables.append(v)
            form.add_l(FLIGHT, v, -factor * bias[axis])
            if factor > 0:
                form.add_l(IMPACT, v, self.jumps[v])
            if link != GROUND:
                form.add_h((A_X, A_Y)[axis], v, sp.Integer(-factor))
                form.add_h(ALPHA, v, -factor * arm[axis])

    def _field_or(self, bias: Vector, link: int) -> Vector:
        """The ground accelerates against the field; every other link has its own bias."""
        return scale(sp.S.NegativeOne, self.field_) if link == GROUND else bias

    def _loops_closed_at(self, link: int, form: Form) -> list[Cut]:
        """Cuts whose branches meet at the link, in an order of least fill (minimum degree on shared multipliers)."""
        waiting = [cut for cut in self.kinematics.topology.cuts if cut.meeting == link]
        near = {cut.joint: set[int]() for cut in waiting}
        for v, w in form.hessian:
            if v.kind == w.kind == "lambda" and v.joint != w.joint and v.joint in near and w.joint in near:
                near[v.joint].add(w.joint)
                near[w.joint].add(v.joint)
        ordered: list[Cut] = []
        while waiting:
            cut = min(waiting, key=lambda c: (len(near[c.joint]), c.joint))
            waiting.remove(cut)
            ordered.append(cut)
            shared = near.pop(cut.joint)
            for joint in shared:
                near[joint] = (near[joint] | shared) - {joint, cut.joint}
        return ordered

    # -- outwards --------------------------------------------------------------------------------------------------

    def _sweep(self, impact: bool) -> None:
        """Every acceleration and multiplier from the root outwards (eq. 11); in impact, velocity jumps and impulses."""
        topology, kinematics = self.kinematics.topology, self.kinematics
        phase = "impact" if impact else "flight"
        self._solve(topology.root, impact)
        self.ledger.close(f"outwards in {phase}: {kinematics.title(topology.root)}")
        for branch in topology.branches:
            start = self._acceleration(branch.parent, impact)
            if branch.parent == GROUND:
                value = ZERO if impact else scale(sp.S.NegativeOne, self.field_)
            else:
                r, cr = kinematics.r[branch.parent, branch.joint], kinematics.cr[branch.parent, branch.joint]
                swing = scale(self.known[impact, branch.parent, ALPHA], perp(r))
                value = add(start, swing) if impact else add(start, swing, scale(sp.S.NegativeOne, cr))
            for axis, v in enumerate((A_X, A_Y)):
                name = solution_name(branch.link, v, impact)
                self.known[impact, branch.link, v] = self.ledger.let(name, value[axis])
            self._solve(branch.link, impact)
            self.ledger.close(f"outwards in {phase}: {kinematics.title(branch.link)}")

    def _acceleration(self, link: int, impact: bool) -> Vector:
        if link == GROUND:
            return ZERO
        return (self.known[impact, link, A_X], self.known[impact, link, A_Y])

    def _solve(self, link: int, impact: bool) -> None:
        """What was eliminated at the link, last eliminated first (eq. 11)."""
        for solution in reversed(self.solutions[link]):
            for e in solution.variables:
                terms = [gain * self.value(impact, link, v) for (row, v), gain in solution.gains.items() if row == e]
                value = -sp.Add(*terms, solution.constant[impact, e])
                self.known[impact, link if e.kind != "lambda" else GROUND, e] = self.ledger.let(
                    solution_name(link, e, impact), value
                )

    def value(self, impact: bool, link: int, v: Variable) -> sp.Expr:
        """A solved acceleration of ``link``, or a solved multiplier."""
        return self.known[impact, link if v.kind != "lambda" else GROUND, v]
