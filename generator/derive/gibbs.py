"""The recursive Gibbs–Appell equations: a quadratic form passed from tips to root, one sweep outwards (theory, 4).

The same recursion serves flight and impact. In flight the linear terms of V hold centripetal accelerations, forces and
the closure bias; in impact they hold generalized impulses and the closure velocities to be removed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from itertools import permutations

import sympy as sp

from ..equations.equations import GUARD
from ..equations.ledger import Ledger
from ..equations.names import A_X, A_Y, ALPHA, SLIDE, Variable, hessian_name, multiplier, place, solution_name, turn
from ..mechanism.links import GROUND
from ..mechanism.topology import Branch, Cut
from ..planning.dead_centres import SMALLEST_SINE
from ..planning.plan import Pivot, Plan, is_closure, is_dyad
from ..planning.segments import FAINT, FIRM
from .closure import Closure, gate_of
from .form import FLIGHT, IMPACT, Dyad, Eliminator, Form, Solution, Substitution, carried
from .kinematics import Kinematics
from .vectors import NO_LOAD, ZERO, Vector, Wrench, add, dot, inertia_of, perp, scale, symbol

M, INERTIA, W2 = sp.symbols("m I w2")
A, ALPHA_ = sp.symbols("a_x a_y"), sp.Symbol("alpha")
RC, RHO, MU = sp.symbols("rc_x rc_y"), sp.symbols("rho_x rho_y"), sp.symbols("mu_x mu_y")


def gibbs_function() -> sp.Expr:
    """S = ½ m |a_c|² + ½ I α² of one link (eq. 4.1), from the acceleration a of its inboard point and α."""
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


@dataclass
class Recursion:
    """Runs the recursion for a mechanism; ``plan`` says what goes where.

    ``field_`` is a uniform acceleration field (gravity): the root's acceleration alone carries it, so that it costs
    nothing along the chain (eq. 4.12). ``drives`` are the accelerations of joints whose motion is prescribed, by joint:
    the second link's less the first's (rad/s²), or along the line (m/s², theory, 4.12).
    """

    plan: Plan
    kinematics: Kinematics
    closure: Closure
    ledger: Ledger
    field_: Vector
    loads: dict[int, Wrench]
    impulses: tuple[sp.Symbol, ...]
    jumps: dict[Variable, sp.Symbol]
    drives: Mapping[int, sp.Expr]
    forms: dict[int, Form] = field(default_factory=dict)
    solutions: dict[int, list[Solution]] = field(default_factory=dict)
    guards: list[tuple[sp.Expr, sp.Expr]] = field(default_factory=list)
    known: dict[tuple[bool, int, Variable], sp.Expr] = field(default_factory=dict)
    points: dict[int, sp.Expr] = field(default_factory=dict)
    inertias: dict[int, sp.Expr] = field(default_factory=dict)

    # -- inwards ---------------------------------------------------------------------------------------------------

    def run(self) -> None:
        """Tips to root, then outwards in flight and in impact."""
        topology = self.kinematics.topology
        for branch in reversed(topology.branches):
            self._collect(branch.link)
        self._collect(topology.root)
        self._guard_ends()
        for impact in (FLIGHT, IMPACT):
            self._sweep(impact)

    def _collect(self, link: int) -> None:
        """V_link over its own and outboard accelerations, made stationary in what belongs to it (eq. 4.3 to 4.8)."""
        form = Form([] if link == GROUND else [A_X, A_Y, ALPHA])
        if link != GROUND:
            self._own_terms(link, form)
        topology = self.kinematics.topology
        for branch in topology.outboard(link):
            if branch.link not in self.plan.severed:
                self._carry(link, branch, self.forms[branch.link], form)
        if link == topology.root:
            for begin in self.plan.severed:
                form.add(self.forms[begin])
        for cut in (*topology.cuts, *map(topology.severed, self.plan.severed)):
            for side, factor in ((cut.first, -1), (cut.second, 1)):
                if side.link == link:
                    self._closure_side(link, cut, factor, form)
        self._mesh(link, form)
        eliminator = Eliminator(link, form, self.ledger)
        self.solutions[link] = found = self._eliminate(link, form, eliminator)
        if link == self.kinematics.topology.root and link != GROUND:
            found.append(eliminator.eliminate((A_X, A_Y)))
        eliminator.name_entries()
        if link != self.kinematics.topology.root and ALPHA in form.variables and self._is_open(link):
            form.leave_open(link)
        self.forms[link] = form
        if self._is_point(link, form):
            self.points[link] = form.h(A_X, A_X)
        self.ledger.close(f"inwards: {self.kinematics.title(link)}", self._is_shared(link))

    def _is_shared(self, link: int) -> bool:
        """Whether the segments of the plan meet at the link."""
        return bool(self.plan.severed) and link == self.kinematics.topology.root

    def _is_point(self, link: int, form: Form) -> bool:
        """Whether V depends on a as that of a mass at a point that is fixed in the link's parent."""
        topology = self.kinematics.topology
        if link == topology.root or topology.branch(link).parent == GROUND or topology.branch(link).slides:
            return False
        return bool(form.h(A_X, A_Y) == 0 and form.h(A_X, A_X) == form.h(A_Y, A_Y) != 0)

    def _eliminate(self, link: int, form: Form, eliminator: Eliminator) -> list[Solution]:
        """What the plan says for the link, in its order. Loops that go one after another are guarded together."""
        found: list[Solution] = []
        pivots = [tuple(ALPHA if v == turn(link) else v for v in pivot) for pivot in self.plan.at(link)]
        for number, pivot in enumerate(pivots):
            if is_dyad(pivot):
                solution = eliminator.close_dyad(pivot, self._reach(pivot))
                self._guard(solution.guard, solution.scale)
            elif is_closure(pivot):
                self._let_idle(form, pivot)
                if number == 0 or not is_closure(pivots[number - 1]):
                    stop = next((i for i in range(number, len(pivots)) if not is_closure(pivots[i])), len(pivots))
                    gathered = self._gathered_diagonal(link, form, pivots[number:stop])
                solution = eliminator.eliminate(pivot)
                self._guard(solution.guard, _scale([gathered[v] for v in pivot]))
            else:
                if pivot == (SLIDE,):
                    self._put_slide(link, form, eliminator)
                least = self._least_firm(link, form, eliminator) if pivot == (A_X, A_Y) else None
                solution = eliminator.eliminate(pivot)
                self._guard(solution.guard and solution.guard**2, least)
            found.append(solution)
        return found

    def _let_idle(self, form: Form, pivot: Pivot) -> None:
        """Multipliers of a joint with a gate whose rows nothing moves, whatever the parameters are, are 0 while it
        holds too."""
        for v in pivot:
            alone = all(form.h(v, w) == 0 for w in form.variables if w != v)
            if alone and form.h(v, v) == -sp.Symbol(f"open_{v.joint}"):
                form.hessian[v, v] = sp.Integer(-1)

    def _guard(self, pivot: sp.Expr | None, scale_: sp.Expr | None) -> None:
        if pivot is not None and scale_ is not None:
            self.guards.append((pivot, scale_))

    def _put_slide(self, link: int, form: Form, eliminator: Eliminator) -> None:
        """Make the acceleration along the line of the link's joint a variable of its form."""
        slide = self.kinematics.slides[link]
        eliminator.name_entries((A_X, A_Y), "_fixed")
        rows = carried(self.kinematics.lead.get(link, ZERO), {SLIDE: slide.direction})
        moved = form.substitute(Substitution(rows | {ALPHA: {ALPHA: sp.S.One}}, directions=(SLIDE,)))
        form.variables = [*form.variables, SLIDE]
        form.hessian, form.linear = moved.hessian, moved.linear
        force = self.impulses[self.kinematics.state.u.index(slide.speed)]
        form.add_l(IMPACT, SLIDE, -force)
        for row, factor in self.closure.meshing.along(self.kinematics.topology.branch(link).joint):
            form.add_h(SLIDE, multiplier(row.joint, "m"), sp.Integer(-factor))

    def _reach(self, pivot: Pivot) -> sp.Expr:
        """What a dyad's guard compares the square of its determinant with, from the squares of both arms."""
        joint = pivot[2].joint
        squares = [
            self.ledger.let(f"reach_{v.joint}_{joint}", dot(arm, arm))
            for v, arm in ((v, self.kinematics.local_arm(v.joint, joint)) for v in pivot[:2])
        ]
        least = SMALLEST_SINE**2 / GUARD
        return self.ledger.let(f"reach_{joint}", least * squares[0] * squares[1])

    def _least_firm(self, link: int, form: Form, eliminator: Eliminator) -> sp.Expr:
        """What the guard of a segment compares the square of its determinant with, where only its pin's a is left."""
        eliminator.name_entries((A_X, A_Y))
        trace = self.ledger.let(f"trPhi_{link}", form.h(A_X, A_X) + form.h(A_Y, A_Y))
        return self.ledger.let(f"firm_{link}", round(FIRM / GUARD) * self.kinematics.mass[link] * trace**3)

    def _guard_ends(self) -> None:
        """Links at the outer side of what segments cut open resist by themselves, whatever parameters are set to."""
        topology, plan = self.kinematics.topology, self.plan
        last = {segment[-1] for segment in plan.modules} if plan.severed else set()
        sides = [(cut.first.link, cut.second.link, cut.joint) for cut in map(topology.severed, plan.severed)]
        for cut in (cut for cut in topology.cuts if last & {cut.first.link, cut.second.link}):
            sides += [(a, b, cut.joint) for a, b in permutations((cut.first.link, cut.second.link))]
        for link, other, joint in sides:
            if link not in (topology.root, GROUND):
                arm = self.kinematics.local_arm(link, joint)
                across = symbol(self.kinematics.mechanism.links[other].mass) if other != GROUND else sp.S.Zero
                least = self.ledger.let(f"faint_{link}_{joint}", round(FAINT / GUARD) * across * dot(arm, arm))
                self._guard(self.inertias[link], least)
        self.ledger.close("ends of segments")

    def _is_open(self, link: int) -> bool:
        """Whether what is left of the link's α is handed on as a variable: not where it follows its parent's."""
        return self._turns(link) and self._driven_turn(link) is None

    def _turns(self, link: int) -> bool:
        """Whether the link's angle is a coordinate of its own."""
        topology = self.kinematics.topology
        return link == topology.root or not topology.branch(link).follows

    def _driven_turn(self, link: int) -> sp.Expr | None:
        """The prescribed α of the link less its parent's (rad/s²), ``None`` where its joint is not driven so."""
        branch = self._driven_branch(link)
        if branch is None or branch.slides:
            return None
        return self.drives[branch.joint] * (1 if branch.outwards else -1)

    def _driven_slide(self, link: int) -> sp.Expr | None:
        """The prescribed s̈ along the line of the joint that carries the link (m/s²), ``None`` likewise."""
        branch = self._driven_branch(link)
        return self.drives[branch.joint] if branch is not None and branch.slides else None

    def _driven_branch(self, link: int) -> Branch | None:
        """The branch that ends at the link, if its joint is driven; the root ends none."""
        topology = self.kinematics.topology
        branch = None if link == topology.root else topology.branch(link)
        return branch if branch is not None and branch.joint in self.drives else None

    def _gathered_diagonal(self, link: int, form: Form, blocks: list[tuple[Variable, ...]]) -> dict[Variable, sp.Expr]:
        """Diagonal of C before loops that share links take from it: the scale of the guards."""
        diagonal = {}
        for v in (v for block in blocks for v in block):
            name = hessian_name(link, v, v)
            diagonal[v] = self.ledger.let(name if len(blocks) == 1 else f"{name}_all", -form.h(v, v))
            form.hessian[v, v] = -diagonal[v]
        return diagonal

    def _own_terms(self, link: int, form: Form) -> None:
        """Second and first derivatives of S_link, and the loads on the link (eq. 4.2)."""
        kinematics, derivatives = self.kinematics, gibbs_derivatives()
        here = {M: kinematics.mass[link], W2: kinematics.squared_rate[link]}
        here[INERTIA] = inertia_of(kinematics.mechanism.links[link])
        here |= dict(zip(RHO + MU, kinematics.centre[link] + kinematics.mu[link], strict=True))
        inertia = self.ledger.let(f"J_{link}", derivatives.inertia.xreplace(here))
        self.inertias[link] = inertia
        self._show_gibbs_function(link, here)
        force, moment = self.loads.get(link, NO_LOAD)
        inertia = self._load_with_points(link, here, inertia)
        form.add_h(ALPHA, ALPHA, inertia)
        for axis, v in enumerate((A_X, A_Y)):
            form.add_h(v, v, derivatives.mass.xreplace(here))
            form.add_h(v, ALPHA, derivatives.coupling[axis].xreplace(here))
            centripetal = self.ledger.let(f"f_{link}_{v.axis}", derivatives.centripetal[axis].xreplace(here))
            form.add_l(FLIGHT, v, centripetal - force[axis])
        form.add_l(FLIGHT, ALPHA, derivatives.moment.xreplace(here) - moment)
        for variable, impulse in self._impulses(link).items():
            form.add_l(IMPACT, variable, -impulse)

    def _load_with_points(self, link: int, here: dict[sp.Symbol, sp.Expr], inertia: sp.Expr) -> sp.Expr:
        """Put the masses that act as points at the link's joints into its mass and first moment; returns its inertia.

        Where no α further out has gone, V of a child depends on a as that of a point mass does. The link with such
        points is an augmented body (theory, 4.13).
        """
        kinematics, let = self.kinematics, self.ledger.let
        points = [(b.joint, self.points[b.link]) for b in kinematics.topology.outboard(link) if b.link in self.points]
        if not points:
            return inertia
        mass, moment = here[M], scale(here[M], kinematics.centre[link])
        for joint, point in points:
            arm = kinematics.local_arm(link, joint)
            mass, moment, inertia = mass + point, add(moment, scale(point, arm)), inertia + point * dot(arm, arm)
        moment = self.ledger.let_vector(f"augmented_moment_{link}", moment)
        here[M] = let(f"augmented_mass_{link}", mass)
        turned = self.ledger.let_vector(f"augmented_mu_{link}", kinematics.turn(link, moment))
        here |= dict(zip(MU, turned, strict=True))
        return let(f"augmented_J_{link}", inertia)

    def _show_gibbs_function(self, link: int, here: dict[sp.Symbol, sp.Expr]) -> None:
        names = {s: sp.Symbol(f"{s.name[:-2]}_{link}{s.name[-2:]}") for s in (*A, *RC)}
        names |= here | {ALPHA_: sp.Symbol(f"alpha_{link}")}
        self.ledger.show_gibbs_function(sp.Symbol(f"S_{link}"), gibbs_function().xreplace(names))

    def _impulses(self, link: int) -> dict[Variable, sp.Symbol]:
        """Generalized impulses that work on the link's own variables."""
        state, topology = self.kinematics.state, self.kinematics.topology
        found = {ALPHA: self.impulses[state.u.index(state.rate(link))]} if self._turns(link) else {}
        if link == topology.root:
            found |= {A_X: self.impulses[0], A_Y: self.impulses[1]}
        return found

    def _carry(self, link: int, branch: Branch, child: Form, form: Form) -> None:
        """Add V_child(a + α r⊥ − ω² r): the chain rule with the derivatives of the joint's acceleration (eq. 4.3).

        A child that follows the link's angle, or turns faster by what is prescribed, hands on its α too (eq. 4.6).
        """
        r = self.kinematics.r[link, branch.joint]
        name = f"{place(link)}_{branch.joint}"
        driven = self._driven_turn(branch.link)
        bias = self._bias(branch)
        rows: dict[Variable, dict[Variable, sp.Expr]] = carried(r)
        if link == GROUND:
            bias, rows = add(bias, scale(sp.S.NegativeOne, self.field_)), {A_X: {}, A_Y: {}}
        if branch.follows or driven is not None:
            rows[ALPHA] = {} if link == GROUND else {ALPHA: sp.S.One}
        constant = {A_X: bias[0], A_Y: bias[1], ALPHA: sp.S.Zero if driven is None else driven}
        if branch.link in self.points:  # they are in the link's own terms
            child = child.without_mass()

        def let(new: Variable | None, v: Variable, value: sp.Expr) -> sp.Expr:
            if v.kind != "a" or new not in (None, ALPHA):
                return value
            return self.ledger.let(f"{'X' if new else 'beta'}_{name}_{v.axis}", value)

        form.add(child.substitute(Substitution(rows, constant), let))

    def _bias(self, branch: Branch) -> Vector:
        """What the inboard point accelerates at besides its parent's motion; a prescribed s̈ is part of it."""
        bias, driven = self.kinematics.bias(branch), self._driven_slide(branch.link)
        if driven is None:
            return bias
        return add(bias, scale(driven, self.kinematics.slides[branch.link].direction))

    def _closure_side(self, link: int, cut: Cut, factor: int, form: Form) -> None:
        """−λ·(± acceleration of the cut joint's point on this side) (eq. 4.3), and the impact's right side once.

        All of it is times the gate s of a joint that lets go or takes hold, and −½ (1 − s) λ² makes λ 0 while s is 0
        (eq. 4.19).
        """
        on = gate_of(cut)
        for row in self.closure.side(cut, link, factor):
            v = multiplier(cut.joint, row.name, cut.rank)
            side = Form([A_X, A_Y, v])
            for axis, w in enumerate((A_X, A_Y)):
                if row.direction[axis] != 0:
                    side.add_h(w, v, -factor * on * row.direction[axis])
            bias = scale(sp.Integer(-factor), self.field_) if link == GROUND else ZERO
            side.add_l(FLIGHT, v, -on * (row.bias + dot(row.direction, bias)))
            rows: dict[Variable, dict[Variable, sp.Expr]] = carried(row.arm)
            form.add(side.substitute(Substitution({A_X: {}, A_Y: {}} if link == GROUND else rows)))
        if cut.turns_alike:
            v = multiplier(cut.joint, "a")
            side = Form([ALPHA, v])
            side.add_h(ALPHA, v, -on * self.closure.turning(cut, link))
            form.add(side.substitute(Substitution({ALPHA: {}})) if link == GROUND else side)
        if factor < 0 or cut.rank:  # joints between segments are never open
            return
        for v in (multiplier(cut.joint, row) for row in cut.rows):
            once = Form([v])
            once.add_l(IMPACT, v, on * self.jumps[v])
            if cut.gate:
                once.add_h(v, v, self.ledger.once(f"open_{cut.joint}", lambda: 1 - on) * -1)
            form.add(once)

    def _mesh(self, link: int, form: Form) -> None:
        """−λ·(lever · α) of each mesh that the link is in (eq. 3.4), what is prescribed along its joint's line, and the
        impact's right side once."""
        topology, meshing = self.kinematics.topology, self.closure.meshing
        for row, lever in meshing.at(link):
            side = Form([ALPHA, v := multiplier(row.joint, "m")])
            side.add_h(ALPHA, v, -lever)
            form.add(side)
        branch = None if link == topology.root else topology.branch(link)
        for row, factor in meshing.along(branch.joint) if branch and branch.slides else ():
            side = Form([v := multiplier(row.joint, "m")])
            side.add_l(FLIGHT, v, -factor * (self._driven_slide(link) or sp.S.Zero))
            form.add(side)
        for row in topology.meshes:
            if row.meeting == link:
                side = Form([v := multiplier(row.joint, "m")])
                side.add_l(IMPACT, v, self.jumps[v])
                form.add(side)

    # -- outwards --------------------------------------------------------------------------------------------------

    def _sweep(self, impact: bool) -> None:
        """Every acceleration and multiplier from the root outwards (eq. 4.11); in impact, jumps and impulses."""
        topology, kinematics = self.kinematics.topology, self.kinematics
        phase = "impact" if impact else "flight"
        self._solve(topology.root, impact)
        self.ledger.close(f"outwards in {phase}: {kinematics.title(topology.root)}", self._is_shared(topology.root))
        for branch in topology.branches:
            if branch.link in self.plan.severed:
                self._solve(branch.link, impact)
                self.ledger.close(f"outwards in {phase}: {kinematics.title(branch.link)}")
                continue
            turning = sp.S.Zero if branch.parent == GROUND else self.known[impact, branch.parent, ALPHA]
            swing = scale(turning, perp(kinematics.r[branch.parent, branch.joint]))
            value = add(self._acceleration(branch.parent, impact), swing, ZERO if impact else self._bias(branch))
            turned, slid = self._driven_turn(branch.link), self._driven_slide(branch.link)
            if branch.follows:
                self.known[impact, branch.link, ALPHA] = turning
            elif turned is not None:
                name = solution_name(branch.link, ALPHA, impact)
                self.known[impact, branch.link, ALPHA] = self.ledger.let(name, turning + (0 if impact else turned))
            if slid is not None:
                self.known[impact, branch.link, SLIDE] = sp.S.Zero if impact else slid
            slides = "_before" if branch.link in kinematics.slides and slid is None else ""
            for axis, v in enumerate((A_X, A_Y)):
                name = solution_name(branch.link, v, impact).replace(f"_{branch.link}_", f"_{branch.link}{slides}_")
                self.known[impact, branch.link, v] = self.ledger.let(name, value[axis])
            self._solve(branch.link, impact)
            self.ledger.close(f"outwards in {phase}: {kinematics.title(branch.link)}")

    def _acceleration(self, link: int, impact: bool) -> Vector:
        """Of the inboard point; the ground accelerates against the field."""
        if link == GROUND:
            return ZERO if impact else scale(sp.S.NegativeOne, self.field_)
        return (self.known[impact, link, A_X], self.known[impact, link, A_Y])

    def _solve(self, link: int, impact: bool) -> None:
        """What was eliminated at the link, last eliminated first (eq. 4.11)."""
        for solution in reversed(self.solutions[link]):
            self._solve_block(link, solution, impact)
            if solution.variables == (SLIDE,):
                self._slide(link, impact)

    def _slide(self, link: int, impact: bool) -> None:
        """From here on a is the acceleration of the inboard point, sliding included."""
        slide = self.kinematics.slides[link]
        moved = scale(self.known[impact, link, SLIDE], slide.direction)
        if link in self.kinematics.lead:
            moved = add(moved, scale(self.known[impact, link, ALPHA], perp(self.kinematics.lead[link])))
        for axis, v in enumerate((A_X, A_Y)):
            value = self.known[impact, link, v] + moved[axis]
            self.known[impact, link, v] = self.ledger.let(solution_name(link, v, impact), value)

    def _solve_block(self, link: int, solution: Solution, impact: bool) -> None:
        for e in solution.variables[:2]:
            terms = [gain * self.value(impact, link, v) for (row, v), gain in solution.gains.items() if row == e]
            value = self.ledger.let(solution_name(link, e, impact), -sp.Add(*terms, solution.constant[impact, e]))
            self.known[_key(impact, link, e)] = value
        if solution.dyad:
            self._solve_dyad(link, solution.variables, solution.dyad, impact)

    def _solve_dyad(self, link: int, variables: tuple[Variable, ...], dyad: Dyad, impact: bool) -> None:
        """The multipliers of a dyad: ∂V/∂α = 0 for both of its links, solved for them (eq. 4.17)."""
        moments = []
        for e in variables[:2]:
            terms = [entry * self.value(impact, link, v) for (row, v), entry in dyad.slopes.items() if row == e]
            name = f"t{'i' if impact else ''}_{place(link)}_{e.joint}"
            moments.append(self.ledger.let(name, sp.Add(*terms, dyad.constant[impact, e])))
        for number, e in enumerate(variables[2:]):
            value = sp.Add(*(-dyad.inverse[i][number] * moments[i] for i in (0, 1)))
            self.known[_key(impact, link, e)] = self.ledger.let(solution_name(link, e, impact), value)

    def value(self, impact: bool, link: int, v: Variable) -> sp.Expr:
        """A solved acceleration of ``link`` or of one further out, or a solved multiplier."""
        return self.known[_key(impact, link, v)]


def _key(impact: bool, link: int, v: Variable) -> tuple[bool, int, Variable]:
    """Where a solution is kept: by link, but multipliers by themselves."""
    if v.kind == "turn":
        return impact, v.joint, ALPHA
    return impact, GROUND if v.kind == "lambda" else link, v


def _scale(diagonal: list[sp.Expr]) -> sp.Expr:
    """What a guard's pivot is compared with: the entry itself, or the square of the mean of two."""
    return diagonal[0] if len(diagonal) == 1 else (diagonal[0] + diagonal[1]) ** 2 / 4
