"""Terms of the program as text: for C, in each type of numbers, and for the listing."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import sympy as sp

from .terms import ONE, Call, Element, Gathered, Name, Negative, Number, Power, Product, Sum, Term, term


@dataclass(frozen=True)
class Dialect:
    """How a language writes numbers, powers and functions.

    ``suffix`` stands behind the names of the C library's functions, ``decimal`` behind decimal numbers, ``whole``
    behind those of which quotients are taken; ``vector`` makes a vector of a list of numbers.
    """

    listing: bool = False
    suffix: str = ""
    decimal: str = ""
    whole: str = ""
    vector: str = ""

    def text(self, t: Term) -> str:
        """The term as one line of text."""
        match t:
            case Name(name):
                return name
            case Element(array, start, stride, lane):
                return f"{array}[{_affine(start, stride)}]" + ("" if lane is None else f"[{lane}]")
            case Number(value):
                return self._number(value)
            case Negative(inner):
                return "-" + self._factor(inner)
            case Sum(terms):
                first, *rest = map(self.text, terms)
                return first + "".join(f" - {x[1:]}" if x.startswith("-") else f" + {x}" for x in rest)
            case Product():
                return self._product(t)
            case Power(base, exponent):
                if self.listing:
                    return f"{self._factor(base, Product)}**{exponent}"
                return "*".join([self._factor(base)] * exponent)
            case Call(function, argument):
                return f"{self._function(function)}({self.text(argument)})"
            case Gathered(lanes):
                return f"({self.vector}){{{', '.join(map(self.text, lanes))}}}"

    def write(self, e: sp.Expr) -> str:
        """The expression as one line of text. Raises ``TypeError`` for one that the program does not have."""
        return self.text(self.term(e))

    def term(self, e: sp.Expr) -> Term:
        """The expression as a term, its summands in the order in which this language reads best."""
        return term(e, self.text)

    def _number(self, value: Fraction | float) -> str:
        if isinstance(value, float):
            return repr(value) + self.decimal
        if self.listing:
            return str(value)
        if value.denominator == 1:
            return f"{value.numerator}.0{self.decimal}"
        suffix = self.decimal or self.whole
        return f"({value.numerator}.0{suffix}/{value.denominator}.0{suffix})"

    def _product(self, product: Product) -> str:
        text = "*".join(map(self._factor, product.factors))
        if not product.under:
            return text
        below = "*".join(map(self._factor, product.under))
        first = product.under[0]
        several = len(product.under) > 1 or isinstance(first, Product)
        power = isinstance(first, Power) and (not self.listing or product.factors == (ONE,))
        return f"{text}/({below})" if several or power else f"{text}/{below}"

    def _factor(self, t: Term, *bracketed: type) -> str:
        text = self.text(t)
        return f"({text})" if isinstance(t, (Sum, Negative, *bracketed)) else text

    def _function(self, name: str) -> str:
        if self.listing:
            return name
        others = {"step": "unit_step", "abs": "fabs" + self.suffix, "total": "ccgen_total"}
        return others.get(name, name + self.suffix)


def _affine(start: int, stride: int) -> str:
    if not stride:
        return str(start)
    moving = "i" if abs(stride) == 1 else f"{abs(stride)}*i"
    if stride < 0:
        return f"{start} - {moving}"
    return f"{moving} + {start}" if start else moving


C = Dialect()
LISTING = Dialect(listing=True)


def write(e: sp.Expr, dialect: Dialect) -> str:
    """The expression as one line of text (:meth:`Dialect.write`)."""
    return dialect.write(e)
