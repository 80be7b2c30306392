"""The classical closed form M(q) u̇ + h(q, u) = Q + Aᵀλ of small mechanisms, A u̇ + Ȧ u = 0, and M Δu = AᵀΛ + NᵀP.

Nothing here is recursive: SymPy differentiates the positions of the mass centres twice, forms the Gibbs function
S = Σ ½ m |a_c|² + ½ I α² of the virtual open chain, and M = ∂²S/∂u̇², h = ∂S/∂u̇ at u̇ = 0 less the generalized forces
of gravity. Q are the generalized forces of all other loads.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import sympy as sp

from ..equations.equations import Assignment
from ..equations.ledger import Ledger
from ..equations.names import AXES, State, multiplier, slide_name, solution_name
from ..mechanism.joints import PointRef
from ..mechanism.links import GROUND
from ..mechanism.mechanism import Mechanism
from ..mechanism.topology import Branch, Topology
from .closure import gate_of
from .expanded_forces import expanded_forces
from .meshing import passed
from .terms_of_effects import Terms
from .vectors import ZERO, Vector, add, dot, inertia_of, less, local, perp, scale, symbol

LIMIT = 4
"""Links up to which the closed form is written: its length grows with the square of their number."""


@dataclass(frozen=True)
class ExpandedForm:
    """M u̇ + h = Q + Aᵀλ and A u̇ + ``A_rate`` = 0; in impact M Δu = AᵀΛ + NᵀP. Checks its shapes and the symmetry of M.

    ``multipliers`` are the λ, one per row of ``A``; ``contacts`` names the point and the ground of each row of ``N``;
    ``definitions`` are the names in ``N`` that stand for expressions in parameters and q. ``Q`` is ``None`` where
    nothing but gravity acts; ``forces`` are the names in it, which effects have given to expressions in q, u, t,
    inputs and the sides of kinks.
    """

    state: State
    multipliers: tuple[sp.Symbol, ...]
    contacts: tuple[tuple[str, str], ...]
    M: sp.ImmutableMatrix
    h: sp.ImmutableMatrix
    A: sp.ImmutableMatrix
    A_rate: sp.ImmutableMatrix
    N: sp.ImmutableMatrix
    definitions: tuple[Assignment, ...] = ()
    Q: sp.ImmutableMatrix | None = None
    forces: tuple[Assignment, ...] = ()

    def __post_init__(self) -> None:
        nu, rows, contacts = len(self.state.u), len(self.multipliers), len(self.contacts)
        expected = {"M": (nu, nu), "h": (nu, 1), "A": (rows, nu), "A_rate": (rows, 1), "N": (contacts, nu)}
        expected |= {"Q": (nu, 1)} if self.Q is not None else {}
        for name, shape in expected.items():
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} has shape {getattr(self, name).shape}; expected {shape}")
        if self.M != self.M.T:
            raise ValueError("M is not symmetric")


def expand(mechanism: Mechanism, topology: Topology, effects: Sequence[Terms] = (), limit: int = LIMIT) -> ExpandedForm:
    """The closed form of a mechanism of at most ``limit`` links (``ValueError`` for more)."""
    if len(mechanism.links) > limit:
        raise ValueError(
            f"found {len(mechanism.links)} links, expected at most {limit} for the expanded form, whose length grows "
            "with their square; leave out --expand to see the recursive equations"
        )
    return _Expansion(mechanism, topology, tuple(effects)).form()


class _Expansion:
    def __init__(self, mechanism: Mechanism, topology: Topology, effects: tuple[Terms, ...]) -> None:
        self.mechanism, self.topology, self.effects = mechanism, topology, effects
        self.state = State.of(mechanism, topology)
        self.u_dot = tuple(sp.Symbol(f"{u}_dot") for u in self.state.u)
        self.arms: dict[sp.Symbol, sp.Expr] = {}
        self.ledger = Ledger()
        self.inboard = {branch.link: PointRef(branch.link, branch.inboard) for branch in topology.branches}
        origin: Vector = (self.state.q[0], self.state.q[1]) if topology.floating else ZERO
        self.place: dict[int, Vector] = {topology.root: origin}
        for branch in topology.branches:
            self.place[branch.link] = self._hung(branch)
        inertial = [symbol(p) for link in mechanism.links for p in (link.mass, link.inertia)]
        self.tidy = _Tidy(frozenset(inertial), frozenset((*self.state.q, *self.state.u)), self.arms)

    def form(self) -> ExpandedForm:
        """Everything, from the Gibbs function, the cuts and the contacts."""
        gibbs, forces = self._gibbs_function(), self._forces()
        slope = [sp.diff(gibbs, a) for a in self.u_dot]
        still = dict.fromkeys(self.u_dot, sp.S.Zero)
        nu, rows = len(self.u_dot), self._closure()
        upper = {(i, j): self.tidy(sp.diff(slope[i], self.u_dot[j])) for i in range(nu) for j in range(i, nu)}
        rates = [self._rate(row) for row in rows]
        contacts, closing, definitions = self._gaps()
        loads, names = expanded_forces(self.mechanism, self.topology, self.state, self.effects, self.position)
        multipliers = [multiplier(*row) for row in self.topology.rows]
        return ExpandedForm(
            self.state,
            tuple(sp.Symbol(solution_name(GROUND, v, False)) for v in multipliers),
            contacts,
            sp.ImmutableMatrix(nu, nu, lambda i, j: upper[min(i, j), max(i, j)]),
            self._matrix([[s.subs(still) - force] for s, force in zip(slope, forces, strict=True)], 1),
            self._matrix([[sp.diff(rate, u) for u in self.state.u] for rate in rates], nu),
            self._matrix([[self._rate(rate)] for rate in rates], 1),
            self._matrix([[sp.diff(rate, u) for u in self.state.u] for rate in closing], nu),
            definitions,
            self._matrix([[load] for load in loads], 1) if any(loads) else None,
            names,
        )

    def position(self, ref: PointRef) -> Vector:
        """Where a named point is, as a function of q (eq. 2.3)."""
        if ref.link == GROUND:
            return local(self.mechanism.ground_points[ref.point])
        return self._offset(ref.link, local(self.mechanism.links[ref.link].points[ref.point]), ref.point)

    def angle(self, link: int) -> sp.Expr:
        """Angle of a link; zero for the ground."""
        return sp.S.Zero if link == GROUND else self.state.angle(link)

    def distance(self, start: PointRef, end: PointRef) -> Vector:
        """The vector from one named point to another."""
        return less(self.position(end), self.position(start))

    def velocity(self, ref: PointRef) -> Vector:
        """How fast a named point moves, as a function of q and u."""
        x, y = self.position(ref)
        return (self._rate(x), self._rate(y))

    def approach(self, start: PointRef, end: PointRef) -> Vector:
        """The rate of :meth:`distance`."""
        return less(self.velocity(end), self.velocity(start))

    def rate(self, link: int) -> sp.Expr:
        """Angular velocity of a link; zero for the ground."""
        return sp.S.Zero if link == GROUND else self.state.rate(link)

    def let(self, name: str, expression: sp.Expr) -> sp.Expr:
        """A name for what a gap makes of coordinates; rates are not named, so that rows can be taken from them."""
        if expression.free_symbols & set(self.state.u):
            return expression
        return self.ledger.let(name, self.tidy(expression))

    def let_vector(self, name: str, vector: Vector) -> Vector:
        return (self.let(f"{name}_x", vector[0]), self.let(f"{name}_y", vector[1]))

    def once(self, name: str, make: Callable[[], sp.Expr]) -> sp.Expr:
        return self.ledger.once(name, lambda: self.tidy(make()))

    def _offset(self, link: int, there: Vector, name: str) -> Vector:
        """The inboard point's position and an arm in link axes, turned by the link's angle (eq. 2.1 and 2.2)."""
        here = local(self.mechanism.point(self.inboard[link])) if link in self.inboard else ZERO
        x, y = (self._arm(f"rho_{link}_{name}_{axis}", t - h) for axis, t, h in zip(AXES, there, here, strict=True))
        c, s = sp.cos(self.state.angle(link)), sp.sin(self.state.angle(link))
        return add(self.place[link], (c * x - s * y, s * x + c * y))

    def _arm(self, name: str, value: sp.Expr) -> sp.Expr:
        """A difference of two parameters stays together under one symbol until everything is tidy."""
        if not value.is_Add:
            return value
        self.arms[sp.Symbol(name)] = value
        return sp.Symbol(name)

    def _rate(self, e: sp.Expr) -> sp.Expr:
        """d/dt of a function of q and u, without its terms in u̇."""
        return sp.Add(*(sp.diff(e, q) * u for q, u in zip(self.state.q, self.state.u, strict=True)))

    def _acceleration(self, position: sp.Expr) -> sp.Expr:
        """Second time derivative of a function of q."""
        velocity = self._rate(position)
        return self._rate(velocity) + sp.Add(
            *(sp.diff(velocity, u) * u_dot for u, u_dot in zip(self.state.u, self.u_dot, strict=True))
        )

    def _centre(self, link: int) -> Vector:
        return self._offset(link, local(self.mechanism.links[link].com), "c")

    def _gibbs_function(self) -> sp.Expr:
        """S = Σ ½ m |a_c|² + ½ I α² (eq. 4.1 of every link)."""
        alpha = {sp.S.Zero: sp.S.Zero} | dict(zip(self.state.u, self.u_dot, strict=True))
        total = sp.S.Zero
        for k, link in enumerate(self.mechanism.links):
            x, y = self._centre(k)
            a_c = (self._acceleration(x), self._acceleration(y))
            total += symbol(link.mass) * dot(a_c, a_c) / 2 + inertia_of(link) * alpha[self.state.rate(k)] ** 2 / 2
        return total

    def _forces(self) -> list[sp.Expr]:
        """Generalized forces of a uniform field: Σ m field·∂x_c/∂q."""
        field = add(ZERO, *(effect.field() for effect in self.effects))
        work = sp.Add(*(symbol(k.mass) * dot(field, self._centre(i)) for i, k in enumerate(self.mechanism.links)))
        return [sp.diff(work, q) for q in self.state.q]

    def _closure(self) -> list[sp.Expr]:
        """Rows of the closure (eq. 3.1)."""
        rows: list[sp.Expr] = []
        for cut in self.topology.cuts:
            ends = zip(self.position(cut.second), self.position(cut.first), strict=True)
            gap = [second - first for second, first in ends]
            own = gap if not cut.slides else [dot(perp(self._line(cut.joint)), (gap[0], gap[1]))]
            own += [cut.arm * (self.angle(cut.second.link) - self.angle(cut.first.link))] if cut.turns_alike else []
            rows += [gate_of(cut) * row for row in own]
        return [*rows, *(passed(row.mesh, self.state) for row in self.topology.meshes)]

    def _line(self, joint: int) -> Vector:
        """Direction of a sliding joint's line (eq. 2.5)."""
        record = self.mechanism.joints[joint]
        angle = self.state.angle(record.first.link) + symbol(record.axis)
        return (sp.cos(angle), sp.sin(angle))

    def joint_position(self, joint: int) -> sp.Expr:
        """Angle of a joint (rad), or how far a sliding one is along its line (m)."""
        record = self.mechanism.joints[joint]
        if not record.slides:
            return self.angle(record.second.link) - self.angle(record.first.link)
        if any(branch.joint == joint for branch in self.topology.branches):
            return sp.Symbol(slide_name(joint))
        return dot(self._line(joint), less(self.position(record.second), self.position(record.first)))

    def joint_speed(self, joint: int) -> sp.Expr:
        """Its rate (rad/s, m/s)."""
        return self._rate(self.joint_position(joint))

    def _hung(self, branch: Branch) -> Vector:
        """Where the inboard point of a branch is: on its parent's point, or along the line on which it slides."""
        attached = self.position(PointRef(branch.parent, branch.attach))
        if not branch.slides:
            return attached
        length = (1 if branch.outwards else -1) * sp.Symbol(slide_name(branch.joint))
        return add(attached, scale(length, self._line(branch.joint)))

    def _gaps(self) -> tuple[tuple[tuple[str, str], ...], list[sp.Expr], tuple[Assignment, ...]]:
        """Names of the contacts, the rates of their gaps (eq. 5.2), and the names that these use."""
        found = [gap for effect in self.effects for gap in effect.gaps(self.ledger.let)]
        rates = [gap.closing(self) for gap in found]
        self.ledger.close("contacts")
        used = set().union(*(rate.free_symbols for rate in rates))
        written = [a for block in self.ledger.blocks for a in block.assignments]
        for a in reversed(written):
            used |= a.expression.free_symbols if a.symbol in used else set()
        return tuple((gap.name, gap.ground) for gap in found), rates, tuple(a for a in written if a.symbol in used)

    def _matrix(self, rows: list[list[sp.Expr]], columns: int) -> sp.ImmutableMatrix:
        return sp.ImmutableMatrix(len(rows), columns, [self.tidy(entry) for row in rows for entry in row])


@dataclass(frozen=True)
class _Tidy:
    """Brings an entry into the form that a textbook has: l_0 (c_1_x m_1 + l_1 m_2) cos(theta_0 − theta_1) w_1²."""

    inertial: frozenset[sp.Symbol]
    moving: frozenset[sp.Symbol]
    arms: dict[sp.Symbol, sp.Expr]

    def __call__(self, e: sp.Expr) -> sp.Expr:
        """Each sine and cosine of a sum of angles once, its factor gathered."""
        summed = sp.expand(sp.Add(*(_sum_of_angles(term) for term in sp.Add.make_args(sp.expand(e)))))
        groups: dict[sp.Expr, dict[sp.Expr, sp.Expr]] = {}
        for term in summed.as_ordered_terms():
            motion, rest = _split(term, lambda f: bool(f.free_symbols & self.moving))
            masses, lengths = _split(rest, lambda f: f.is_Number or bool(f.free_symbols & self.inertial))
            group = groups.setdefault(motion, {})
            group[lengths] = group.get(lengths, sp.S.Zero) + masses
        return sp.Add(*(motion * _gathered(group) for motion, group in groups.items())).xreplace(self.arms)


def _gathered(group: dict[sp.Expr, sp.Expr]) -> sp.Expr:
    """Σ lengths·masses with equal sums of masses written once, and common factors in front."""
    by_masses: dict[sp.Expr, sp.Expr] = {}
    for lengths, masses in group.items():
        by_masses[masses] = by_masses.get(masses, sp.S.Zero) + lengths
    return sp.factor_terms(sp.Add(*(masses * lengths for masses, lengths in by_masses.items())))


def _split(term: sp.Expr, wanted: Callable[[sp.Expr], bool]) -> tuple[sp.Expr, sp.Expr]:
    """The product of the wanted factors of a term, and of the others."""
    factors = sp.Mul.make_args(term)
    return sp.Mul(*(f for f in factors if wanted(f))), sp.Mul(*(f for f in factors if not wanted(f)))


def _sum_of_angles(term: sp.Expr) -> sp.Expr:
    """A product of sines and cosines as a sum of sines and cosines of sums of their angles."""
    waves: list[sp.Expr] = []
    others: list[sp.Expr] = []
    for factor in sp.Mul.make_args(term):
        base, exponent = factor.as_base_exp()
        if base.func in (sp.sin, sp.cos) and exponent.is_Integer and exponent > 0:
            waves += [base] * int(exponent)
        else:
            others.append(factor)
    total: Iterable[sp.Expr] = waves[:1] or [sp.S.One]
    for wave in waves[1:]:
        total = [part for old in total for part in _product(old, wave)]
    return sp.Mul(*others) * sp.Add(*total)


def _product(first: sp.Expr, second: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """sin or cos times sin or cos, the first with any factor."""
    factor, wave = first.as_independent(sp.sin, sp.cos)
    if not wave.args:
        return (factor * second, sp.S.Zero)
    a, b, half = wave.args[0], second.args[0], factor / 2
    match wave.func is sp.sin, second.func is sp.sin:
        case False, False:
            return (half * sp.cos(a - b), half * sp.cos(a + b))
        case True, True:
            return (half * sp.cos(a - b), -half * sp.cos(a + b))
        case True, False:
            return (half * sp.sin(a - b), half * sp.sin(a + b))
    return (half * sp.sin(b - a), half * sp.sin(a + b))
