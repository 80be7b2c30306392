"""Expanded Gibbs-Appell equations of a planar mechanism, straight from the definition, and exact arithmetic for them.

The Gibbs function of the virtual open chain is written as one expression in explicit kinematics, S(q, u, u'), from
positions that SymPy differentiates twice in time. Then

    M = d2S/du'2,   h = dS/du' at u' = 0 - Q,   A = d(closure)/dq,   bias = closure'' at u' = 0
    M u' + h = A^T lambda,   A u' + bias = 0.

:class:`Exact` evaluates expressions in the field of rational functions in the tangents of the half angles, where
cosines and sines are rational and cos^2 + sin^2 = 1 needs no rule: an expression vanishes if and only if its value is
0.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import sympy as sp
from sympy.polys.fields import FracField

GROUND = -1
Pair = tuple[sp.Expr, sp.Expr]


@dataclass(frozen=True)
class Body:
    """Mass, inertia about the centre of mass, and centre of mass in the link's frame."""

    mass: sp.Expr
    inertia: sp.Expr
    com: Pair


@dataclass(frozen=True)
class Branch:
    """The point ``inboard`` of ``link`` lies on the point ``attach`` of ``parent``."""

    link: int
    inboard: Pair
    parent: int
    attach: Pair


@dataclass(frozen=True)
class Cut:
    """Closure is (point of ``second``) - (point of ``first``); each side is a link and a point of it."""

    first: tuple[int, Pair]
    second: tuple[int, Pair]


@dataclass(frozen=True)
class Expanded:
    """The equations over symbols c_k, s_k (cosine and sine of the link angles) and w_k; rows in the order of ``u``."""

    mass: sp.Matrix
    bias: sp.Matrix
    rows: sp.Matrix
    row_bias: sp.Matrix


def expand(
    bodies: Sequence[Body], root: int, branches: Sequence[Branch], cuts: Sequence[Cut], gravity: sp.Expr
) -> Expanded:
    """Equations for u: velocity of the root's frame origin where the root floats, angular velocities of all links."""
    t = sp.Symbol("t")
    links = range(len(bodies))
    angles = [sp.Function(f"angle_{k}")(t) for k in links]
    base = [sp.Function(f"base_{axis}")(t) for axis in "xy"] if root != GROUND else []
    coordinates = [*base, *angles]
    origin: dict[int, sp.Matrix] = {root: sp.Matrix(base) if base else sp.zeros(2, 1)}

    def place(link: int, point: Pair) -> sp.Matrix:
        if link == GROUND:
            return sp.Matrix(point)
        return origin[link] + _turned(angles[link], point)

    for branch in branches:
        hinge = place(branch.parent, branch.attach)
        origin[branch.link] = hinge - _turned(angles[branch.link], branch.inboard)

    gibbs, potential = sp.S.Zero, sp.S.Zero
    for k, body in enumerate(bodies):
        centre = place(k, body.com)
        pull = centre.diff(t, 2)
        gibbs += body.mass * pull.dot(pull) / 2 + body.inertia * angles[k].diff(t, 2) ** 2 / 2
        potential += body.mass * gravity * centre[1]
    closure = [entry for cut in cuts for entry in place(*cut.second) - place(*cut.first)]

    names = _Names(t, coordinates, len(base))
    accelerations = names.accelerations
    gibbs = names(gibbs)
    rest = dict.fromkeys(accelerations, 0)
    slope = [sp.diff(gibbs, a) for a in accelerations]
    force = [-names(potential.diff(q)) for q in coordinates]
    rows = [[names(entry.diff(q)) for q in coordinates] for entry in closure]
    return Expanded(
        sp.Matrix([[sp.diff(row, a) for a in accelerations] for row in slope]),
        sp.Matrix([row.subs(rest) - f for row, f in zip(slope, force, strict=True)]),
        sp.Matrix(len(closure), len(coordinates), [entry for row in rows for entry in row]),
        sp.Matrix(len(closure), 1, [names(entry.diff(t, 2)).subs(rest) for entry in closure]),
    )


def _turned(angle: sp.Expr, point: Pair) -> sp.Matrix:
    c, s = sp.cos(angle), sp.sin(angle)
    return sp.Matrix([c * point[0] - s * point[1], s * point[0] + c * point[1]])


class _Names:
    """Replaces functions of time by the symbols of the state and of its accelerations."""

    def __init__(self, t: sp.Symbol, coordinates: Sequence[sp.Expr], base: int) -> None:
        count = len(coordinates)
        self.accelerations = [sp.Symbol(f"acceleration_{k}") for k in range(count)]
        second = {q.diff(t, 2): a for q, a in zip(coordinates, self.accelerations, strict=True)}
        first: dict[sp.Expr, sp.Expr] = {}
        shape: dict[sp.Expr, sp.Expr] = {}
        for k, q in enumerate(coordinates):
            first[q.diff(t)] = sp.Symbol(f"rate_{k}") if k < base else sp.Symbol(f"w_{k - base}")
            if k >= base:
                shape[sp.cos(q)], shape[sp.sin(q)] = sp.Symbol(f"c_{k - base}"), sp.Symbol(f"s_{k - base}")
        self._rules = (second, first, shape)

    def __call__(self, expression: sp.Expr) -> sp.Expr:
        for rule in self._rules:
            expression = expression.xreplace(rule)
        return expression


class Exact:
    """Exact values of expressions: ``values`` fixes symbols to rational numbers, the others are indeterminates.

    Angle k enters through the tangent of its half, an indeterminate too or the given one of ``tangents``; ``c_k`` and
    ``s_k`` and cos(theta_k), sin(theta_k) are known.
    """

    def __init__(
        self,
        links: int,
        indeterminates: Iterable[sp.Symbol],
        values: Mapping[sp.Symbol, sp.Rational],
        tangents: Sequence[Fraction] = (),
    ) -> None:
        halves = [] if tangents else [sp.Symbol(f"tan_{k}") for k in range(links)]
        names = [*halves, *indeterminates]
        self.field = FracField(names, sp.ZZ, sp.lex)
        generators = dict(zip(names, self.field.gens, strict=True))
        self.known: dict[sp.Expr, Any] = {s: generators[s] for s in names[len(halves) :]}
        self.known |= {s: self._number(v) for s, v in values.items()}
        given = [generators[half] for half in halves] or [self._ratio(x.numerator, x.denominator) for x in tangents]
        for k, tangent in enumerate(given):
            cosine, sine = (1 - tangent**2) / (1 + tangent**2), 2 * tangent / (1 + tangent**2)
            angle = sp.Symbol(f"theta_{k}")
            self.known |= {sp.Symbol(f"c_{k}"): cosine, sp.cos(angle): cosine}
            self.known |= {sp.Symbol(f"s_{k}"): sine, sp.sin(angle): sine}

    def _ratio(self, above: int, below: int) -> Any:
        return self.field(above) / below

    def _number(self, value: sp.Rational) -> Any:
        return self._ratio(int(value.p), int(value.q))

    def __call__(self, expression: sp.Expr) -> Any:
        """Value of an expression in known symbols."""
        if expression in self.known:
            return self.known[expression]
        if expression.is_Rational:
            return self._number(expression)
        if expression.is_Add:
            return sum((self(part) for part in expression.args[1:]), self(expression.args[0]))
        if expression.is_Mul:
            result = self(expression.args[0])
            for part in expression.args[1:]:
                result = result * self(part)
            return result
        if expression.is_Pow and expression.exp.is_Integer:
            return self(expression.base) ** int(expression.exp)
        raise ValueError(f"no exact value for {expression}")

    def assign(self, assignments: Iterable[tuple[sp.Symbol, sp.Expr]]) -> None:
        """Evaluate named assignments in their order; later ones may use earlier names."""
        for symbol, expression in assignments:
            self.known[symbol] = self(expression)


def residuals(exact: Exact, equations: Expanded, rates: Sequence[Any], multipliers: Sequence[Any]) -> list[Any]:
    """``M u' + h - A^T lambda`` and ``A u' + bias`` for given exact accelerations and multipliers."""
    mass, rows = equations.mass, equations.rows
    found = []
    for i in range(mass.rows):
        value = exact(equations.bias[i])
        for j, rate in enumerate(rates):
            value = value + exact(mass[i, j]) * rate
        for j, multiplier in enumerate(multipliers):
            value = value - exact(rows[j, i]) * multiplier
        found.append(value)
    for i in range(rows.rows):
        value = exact(equations.row_bias[i])
        for j, rate in enumerate(rates):
            value = value + exact(rows[i, j]) * rate
        found.append(value)
    return found
