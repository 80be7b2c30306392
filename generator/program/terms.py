"""Expressions of the program: small typed trees whose order of evaluation is settled.

SymPy's sums and products have no order. A :class:`Term` has one, chosen once by names alone, so that links are written
alike and the same equations give the same bytes. Passes over the program (loops, lanes) read and change these trees;
languages print them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction

import sympy as sp

from ..equations.step import step

FUNCTIONS = {
    sp.sin: "sin",
    sp.cos: "cos",
    sp.tan: "tan",
    sp.atan: "atan",
    sp.exp: "exp",
    sp.log: "log",
    sp.tanh: "tanh",
    sp.Abs: "abs",
    step: "step",
}
"""Functions of an expression by name; square roots are ``Call("sqrt", …)`` too."""


@dataclass(frozen=True, slots=True)
class Number:
    """A number that is not negative: a double, or exact."""

    value: Fraction | float


@dataclass(frozen=True, slots=True)
class Name:
    """A quantity by its name."""

    name: str


@dataclass(frozen=True, slots=True)
class Element:
    """Entry ``start + stride * i`` of an array, ``i`` the counter of the loop around it; one lane of a vector there."""

    array: str
    start: int
    stride: int = 0
    lane: int | None = None


@dataclass(frozen=True, slots=True)
class Negative:
    """Minus a term."""

    term: Term


@dataclass(frozen=True, slots=True)
class Sum:
    """Terms, added from the left."""

    terms: tuple[Term, ...]


@dataclass(frozen=True, slots=True)
class Product:
    """Factors, multiplied from the left, over the product of ``under``."""

    factors: tuple[Term, ...]
    under: tuple[Term, ...] = ()


@dataclass(frozen=True, slots=True)
class Power:
    """A whole power, at least the second."""

    base: Term
    exponent: int


@dataclass(frozen=True, slots=True)
class Call:
    """A function of one argument."""

    function: str
    argument: Term


@dataclass(frozen=True, slots=True)
class Gathered:
    """One quantity for each lane of a vector, in their order."""

    lanes: tuple[Term, ...]


Term = Number | Name | Element | Negative | Sum | Product | Power | Call | Gathered
Leaf = Name | Element
ZERO, ONE = Number(Fraction(0)), Number(Fraction(1))

Ordering = Callable[[sp.Expr], Term]
"""Makes terms of expressions, summands in an order."""


@dataclass(frozen=True)
class Assign:
    """``target = value``. A target that is a name is declared there; an element is of an array that exists."""

    target: Leaf
    value: Term


@dataclass(frozen=True)
class Guard:
    """Holds while ``pivot > least``; where the pivot is a vector and there is no least, while all of it is positive."""

    pivot: Term
    least: Term | None


def leaves(term: Term) -> Iterator[Leaf]:
    """Quantities that a term reads, in the order in which it is written."""
    match term:
        case Name() | Element():
            yield term
        case Negative(inner) | Power(inner) | Call(_, inner):
            yield from leaves(inner)
        case Sum(parts) | Gathered(parts):
            for part in parts:
                yield from leaves(part)
        case Product(factors, under):
            for part in (*factors, *under):
                yield from leaves(part)


def exchanged(term: Term, new: Callable[[Leaf], Term]) -> Term:
    """The term with ``new(leaf)`` in the place of each leaf, taken in the order of :func:`leaves`."""
    match term:
        case Number():
            return term
        case Name() | Element():
            return new(term)
        case Negative(inner):
            return Negative(exchanged(inner, new))
        case Sum(parts):
            return Sum(tuple(exchanged(part, new) for part in parts))
        case Gathered(parts):
            return Gathered(tuple(exchanged(part, new) for part in parts))
        case Product(factors, under):
            above = tuple(exchanged(part, new) for part in factors)
            return Product(above, tuple(exchanged(part, new) for part in under))
        case Power(base, exponent):
            return Power(exchanged(base, new), exponent)
        case Call(function, argument):
            return Call(function, exchanged(argument, new))


# -- from SymPy ----------------------------------------------------------------------------------------------------


def term(e: sp.Expr, spell: Callable[[Term], str]) -> Term:
    """The expression as a term. Summands are ordered by how ``spell`` writes them.

    Positive ones come first, short ones before long ones; numbers in names decide last. Raises ``TypeError`` for a kind
    of expression that the program does not have.
    """
    if e.is_Symbol:
        return Name(str(e.name))
    if e.is_Number:
        size = abs(e)
        value = Number(Fraction(int(size.p), int(size.q)) if size.is_Rational else float(size))
        return Negative(value) if e < 0 else value
    if e.is_Add:
        return Sum(tuple(sorted((term(a, spell) for a in e.args), key=lambda t: _reading_order(spell(t)))))
    if e.is_Mul:
        return _product(e, spell)
    if e.is_Pow:
        return _power(e, spell)
    if e.func in FUNCTIONS and len(e.args) == 1:
        return Call(FUNCTIONS[e.func], term(e.args[0], spell))
    raise TypeError(f"no way to write {type(e).__name__}: {e}")


def _product(e: sp.Mul, spell: Callable[[Term], str]) -> Term:
    coefficient, factors = e.as_coeff_mul(rational=False)
    over = sorted((a for a in factors if not _is_divisor(a)), key=lambda a: (not a.is_Symbol, blurred(str(a))))
    under = sorted((1 / a for a in factors if _is_divisor(a)), key=lambda a: blurred(str(a)))
    above = [term(a, spell) for a in over]
    size = abs(coefficient)
    if size != 1 or not above:
        above.insert(0, term(size, spell))
    product = Product(tuple(above), tuple(term(a, spell) for a in under)) if under or len(above) > 1 else above[0]
    return Negative(product) if coefficient < 0 else product


def _is_divisor(a: sp.Expr) -> bool:
    return bool(a.is_Pow and a.exp.is_negative)


def _power(e: sp.Pow, spell: Callable[[Term], str]) -> Term:
    if e.exp.is_negative:
        return Product((ONE,), (term(1 / e, spell),))
    if e.exp.is_Integer:
        return Power(term(e.base, spell), int(e.exp))
    if e.exp.is_Rational and e.exp.q == 2:
        root = Call("sqrt", term(e.base, spell))
        return root if e.exp.p == 1 else Power(root, int(e.exp.p))
    raise TypeError(f"no way to write the power {e}")


_DIGITS = re.compile(r"\d+")


def _reading_order(text: str) -> tuple[bool, bool, int, str, list[int]]:
    bare = text.removeprefix("-")
    return (text.startswith("-"), "*" in bare or "/" in bare, bare.count("*"), *blurred(bare))


def blurred(text: str) -> tuple[str, list[int]]:
    """A text without the numbers in it, and those numbers."""
    return _DIGITS.sub("#", text), [int(number) for number in _DIGITS.findall(text)]
