"""Expressions as text, for C and for the listing, with an order of terms that depends on nothing but their names."""

from __future__ import annotations

import re
from dataclasses import dataclass

import sympy as sp

from ..derive.step import step


@dataclass(frozen=True)
class Dialect:
    """How a language writes powers, numbers and functions."""

    name: str

    def number(self, value: sp.Number) -> str:
        if self.name == "listing":
            return repr(float(value)) if value.is_Float else str(value)
        if isinstance(value, sp.Integer):
            return f"{int(value)}.0"
        if isinstance(value, sp.Rational):
            return f"({value.p}.0/{value.q}.0)"
        return repr(float(value))

    def power(self, base: str, exponent: int) -> str:
        return f"{base}**{exponent}" if self.name == "listing" else "*".join([base] * exponent)


FUNCTIONS = {
    sp.sin: ("sin", "sin"),
    sp.cos: ("cos", "cos"),
    sp.tan: ("tan", "tan"),
    sp.exp: ("exp", "exp"),
    sp.log: ("log", "log"),
    sp.tanh: ("tanh", "tanh"),
    sp.Abs: ("abs", "fabs"),
    step: ("step", "unit_step"),
}
"""Functions of an expression: their names in the listing and in C."""

C = Dialect("c")
LISTING = Dialect("listing")


def write(e: sp.Expr, dialect: Dialect) -> str:
    """The expression as one line of text.

    Raises ``TypeError`` for a kind of expression that the program form does not have.
    """
    if e.is_Symbol:
        return str(e.name)
    if e.is_Number:
        return ("-" if e < 0 else "") + dialect.number(abs(e))
    if e.is_Add:
        terms = sorted((write(a, dialect) for a in e.args), key=_reading_order)
        text = terms[0]
        for term in terms[1:]:
            text += f" - {term[1:]}" if term.startswith("-") else f" + {term}"
        return text
    if e.is_Mul:
        return _product(e, dialect)
    if e.is_Pow:
        return _power(e, dialect)
    if e.func in FUNCTIONS:
        name = FUNCTIONS[e.func][dialect is C]
        return f"{name}({', '.join(write(a, dialect) for a in e.args)})"
    raise TypeError(f"no way to write {type(e).__name__}: {e}")


_NUMBER = re.compile(r"\d+")


def _reading_order(term: str) -> tuple[bool, bool, int, str, list[int]]:
    """Positive terms first, short before long; numbers in names decide last, so that links are written alike."""
    bare = term.removeprefix("-")
    return (term.startswith("-"), "*" in bare or "/" in bare, bare.count("*"), *_blurred(bare))


def _blurred(text: str) -> tuple[str, list[int]]:
    return _NUMBER.sub("#", text), [int(number) for number in _NUMBER.findall(text)]


def _product(e: sp.Mul, dialect: Dialect) -> str:
    coefficient, factors = e.as_coeff_mul(rational=False)
    over = sorted((a for a in factors if not _is_divisor(a)), key=lambda a: (not a.is_Symbol, _blurred(str(a))))
    under = sorted((1 / a for a in factors if _is_divisor(a)), key=lambda a: _blurred(str(a)))
    sign, coefficient = ("-" if coefficient < 0 else ""), abs(coefficient)
    texts = [_factor(a, dialect) for a in over]
    if coefficient != 1 or not texts:
        texts.insert(0, dialect.number(coefficient))
    text = sign + "*".join(texts)
    if under:
        below = "*".join(_factor(a, dialect) for a in under)
        several = len(under) > 1 or (dialect is C and under[0].is_Pow and under[0].exp.is_Integer)
        text += f"/({below})" if several else f"/{below}"
    return text


def _is_divisor(a: sp.Expr) -> bool:
    return bool(a.is_Pow and a.exp.is_negative)


def _factor(a: sp.Expr, dialect: Dialect) -> str:
    text = write(a, dialect)
    return f"({text})" if a.is_Add or (a.is_Number and a < 0) else text


def _power(e: sp.Pow, dialect: Dialect) -> str:
    base = _factor(e.base, dialect)
    if e.exp.is_Integer:
        exponent = int(e.exp)
        if exponent > 0:
            return dialect.power(base, exponent)
        return (
            f"1/{base}"
            if dialect is LISTING and exponent == -1
            else f"{dialect.number(sp.Integer(1))}/"
            + (base if exponent == -1 else f"({dialect.power(base, -exponent)})")
        )
    if e.exp == sp.Rational(1, 2):
        return f"sqrt({write(e.base, dialect)})"
    if e.exp == -sp.Rational(1, 2):
        return f"{dialect.number(sp.Integer(1))}/sqrt({write(e.base, dialect)})"
    raise TypeError(f"no way to write the power {e}")
