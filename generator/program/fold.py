"""Folding: parameter values become numbers in the equations, and what then simplifies is simplified.

Assignments are taken in the order of the derivation. One that has become a number, or another name with or without a
sign, disappears into those that use it, and so does one whose expression an earlier name already has: that is how equal
links and lengths of 1 pay off. No expression is multiplied out, so nothing that was shared is computed twice.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import replace

import sympy as sp
from sympy.core.parameters import distribute

from ..equations.equations import Assignment, Block, Equations, Kernel
from ..equations.step import step
from ..mechanism.links import Parameter
from .errors import FoldError

EXACT = 2.0**53
"""Whole numbers below this are integers in the equations, so that factors and summands of 1 and 0 vanish."""

FOREIGN = (sp.oo, -sp.oo, sp.zoo, sp.nan, sp.I)
"""What no number of the machine is made of."""

FUNCTIONS: dict[type[sp.Basic], Callable[[float], float]] = {
    sp.sin: math.sin,
    sp.cos: math.cos,
    sp.tan: math.tan,
    sp.atan: math.atan,
    sp.exp: math.exp,
    sp.log: math.log,
    sp.tanh: math.tanh,
    sp.Abs: abs,
    step: lambda x: float(x > 0.0),
}


def fold(equations: Equations, kept: Collection[Parameter] = ()) -> Equations:
    """The same equations with the values of all parameters but those ``kept`` in them; those alone are parameters then,
    and all are ``folded`` ones.

    Numbers are those of double arithmetic: results agree with the unfolded equations to rounding. Raises
    :class:`FoldError` when values leave an equation without a finite number.
    """
    with distribute(False):
        return _Folding(equations, tuple(kept)).equations()


class _Folding:
    def __init__(self, given: Equations, kept: tuple[Parameter, ...]) -> None:
        self.given, self.kept = given, kept
        folded = (p for p in given.parameters if p not in kept)
        self.meaning: dict[sp.Symbol, sp.Expr] = {sp.Symbol(p.symbol): number(p.value) for p in folded}
        self.names: dict[sp.Expr, sp.Expr] = {}

    def equations(self) -> Equations:
        given = self.given
        blocks = tuple(block for block in map(self._block, given.blocks) if block.assignments)
        kernels = tuple(map(self._kernel, given.kernels))
        return replace(given, parameters=self.kept, blocks=blocks, kernels=kernels, folded=given.parameters)

    def _block(self, block: Block) -> Block:
        kept = [a for a in map(self._assignment, block.assignments) if a is not None]
        gibbs = replace(block.gibbs, expression=self._value(block.gibbs.expression, "S")) if block.gibbs else None
        stationary = tuple(replace(a, expression=self._value(a.expression, a.symbol)) for a in block.stationary)
        return replace(block, assignments=tuple(kept), gibbs=gibbs, stationary=stationary)

    def _assignment(self, assignment: Assignment) -> Assignment | None:
        """The assignment that remains, or ``None`` when its symbol has become something that is known already."""
        value = self._value(assignment.expression, assignment.symbol)
        known = value if _is_plain(value) else self.names.get(value)
        if known is not None:
            self.meaning[assignment.symbol] = known
            return None
        self.names[value] = assignment.symbol
        self.names[_negated(value)] = -assignment.symbol
        return Assignment(assignment.symbol, value)

    def _kernel(self, kernel: Kernel) -> Kernel:
        outputs = tuple(replace(o, entries=tuple(self._value(e, o.name) for e in o.entries)) for o in kernel.outputs)
        guards = tuple(
            (self._value(pivot, kernel.name), self._value(scale, kernel.name)) for pivot, scale in kernel.guards
        )
        return replace(kernel, outputs=outputs, guards=guards)

    def _value(self, expression: sp.Expr, name: object) -> sp.Expr:
        """The expression called ``name`` with everything that is known put in, until nothing changes any more."""
        value = expression.xreplace(self.meaning)
        while (simpler := _tidy(value)) != value:
            value = simpler
        if value.has(*FOREIGN):
            raise FoldError(
                f"found no finite number for {name} with the values of the scene, expected one; change the values, or "
                "leave out --fold"
            )
        return value


def number(value: float) -> sp.Expr:
    """A value as it stands in equations: whole numbers as integers, others as doubles, the infinite as ``nan``."""
    if not math.isfinite(value):
        return sp.nan
    return sp.Integer(int(value)) if value.is_integer() and abs(value) < EXACT else sp.Float(value)


def _is_plain(e: sp.Expr) -> bool:
    return bool(e.is_Number or e.is_Symbol or (-e).is_Symbol)


def _negated(e: sp.Expr) -> sp.Expr:
    return sp.Add(*(-term for term in e.args)) if e.is_Add else -e


def _tidy(e: sp.Expr) -> sp.Expr:
    """Numbers as :func:`number` writes them, functions of numbers evaluated; exponents stay exact."""
    if e.is_Number:
        return number(float(e))
    if e.is_Pow:
        base = _tidy(e.base)
        return number(_power(base, e.exp)) if base.is_Number else sp.Pow(base, e.exp)
    if not e.args:
        return e
    args = [_tidy(a) for a in e.args]
    if e.func in FUNCTIONS and args[0].is_Number:
        return number(_applied(FUNCTIONS[e.func], float(args[0])))
    return e if tuple(args) == e.args else e.func(*args)


def _applied(function: Callable[[float], float], value: float) -> float:
    try:
        return function(value)
    except (ValueError, OverflowError):
        return math.nan


def _power(base: sp.Expr, exponent: sp.Expr) -> float:
    """A whole power of a number, or its square root or one over that, as the machine takes it."""
    value = _applied(math.sqrt, float(base)) if not exponent.is_Integer else float(base)
    power = int(exponent) if exponent.is_Integer else int(2 * exponent)
    if value == 0.0 and power < 0:
        return math.nan
    return _applied(lambda x: math.pow(x, power), value)
