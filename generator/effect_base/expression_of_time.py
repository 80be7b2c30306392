"""Expressions of time as scenes write them (``"2*sin(3*t) + 0.5"``), parsed without evaluating anything of Python's."""

from __future__ import annotations

import ast
import math
import sys
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationInfo
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from ..mechanism.links import Parameter
from .arithmetic import (
    NO_NAMES,
    ExpressionError,
    Names,
    Written,
    calculate,
    laws_among,
    moves,
    read_tree,
    value_of,
)
from .changing import Changing
from .grammar_of_state import FORCES, QUANTITIES, RATE, VELOCITIES, asks_state
from .written_numbers import check_dimension, faults_as_advice, read_quantity

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Motion
    from ..derive.terms_of_effects import Let


class OfTime(Changing):
    """A value over time that a scene gives in place of a number."""

    @abstractmethod
    def at(self, t: float) -> float:
        """The value at a time (s); ``ArithmeticError`` or ``ValueError`` where there is none."""

    @abstractmethod
    def slope_at(self, t: float, order: int = 1) -> float:
        """The derivative by time of the given order at a time, ``nan`` where there is none."""

    @abstractmethod
    def has_rate(self) -> bool:
        """Whether its derivative by time exists everywhere, as far as can be told without its values."""

    @abstractmethod
    def rate(self, motion: Motion, name: str) -> Expr:
        """The derivative by time in the equations, with names as for :meth:`realise`."""

    @abstractmethod
    def derivative(self, motion: Motion, name: str, order: int, begun: Mapping[int, Expr]) -> Expr:
        """A derivative in the equations; ``begun`` is 1 after the time at which it :meth:`jumps`, else 0, by number."""

    def jumps(self, order: int) -> Mapping[int, float]:
        """Times (s) at which a derivative jumps, by their numbers."""
        return {}


@dataclass(frozen=True)
class Expression(OfTime):
    """An expression of t (s), checked; ``text`` is its normal form."""

    text: str

    @property
    def shown(self) -> str:
        return self.text

    def at(self, t: float) -> float:
        return value_of(self._tree(), t)

    def has_rate(self) -> bool:  # abs has a kink
        return not any(isinstance(node, ast.Name) and node.id == "abs" for node in ast.walk(self._tree()))

    def realise(self, motion: Motion, name: str) -> Expr:
        return _Realised(motion.time, motion.let, name, self._tree()).value(self._tree())

    def rate(self, motion: Motion, name: str) -> Expr:
        return _Realised(motion.time, motion.let, name, self._tree()).rate(self._tree())

    def derivative(self, motion: Motion, name: str, order: int, begun: Mapping[int, Expr]) -> Expr:
        import sympy as sp

        return sp.diff(self.plain(), motion.time, order)

    def plain(self) -> Expr:
        """The expression as a function of the symbol t alone, with nothing named."""
        from ..derive.motion import TIME

        return _Realised(TIME, lambda _, expression: expression, "", self._tree()).value(self._tree())

    def slope_at(self, t: float, order: int = 1) -> float:
        import sympy as sp

        time = sp.Symbol("t")
        value = _derived(self.text, order).subs(time, sp.Float(t, 30)).evalf(17)
        return float(value) if value.is_real and value.is_finite else math.nan

    def _tree(self) -> ast.expr:
        return ast.parse(self.text, mode="eval").body


@lru_cache(maxsize=64)
def _derived(text: str, order: int) -> Expr:
    """The derivative of an expression, by one order after the other: SymPy would simplify between several at once."""
    import sympy as sp

    return sp.diff(_derived(text, order - 1), sp.Symbol("t")) if order else Expression(text).plain()


def parse(text: str, names: Names = NO_NAMES) -> Expression | float:
    """The expression, or its value if it does not depend on t; ``names`` stand for numbers in it.

    Raises ``ExpressionError`` with a sentence.
    """
    tree = read_tree(text, names)
    if not moves(tree) and math.isfinite(value := calculate(text, names)):
        return value
    try:
        start = value_of(tree, 0.0)
    except (ArithmeticError, ValueError):
        start = math.nan
    if not math.isfinite(start):
        raise ExpressionError("it has no finite value at t = 0, where runs begin; change it")
    return Expression(ast.unparse(tree))


class _Realised:
    """The parts of one expression of ``time``: each function of t gets a name of its own, which ``let`` gives."""

    def __init__(self, time: Expr, let: Let, name: str, tree: ast.expr) -> None:
        self.time, self.let, self.name = time, let, name
        calls = [ast.dump(node) for node in ast.walk(tree) if isinstance(node, ast.Call) and moves(node)]
        self.number = {call: index for index, call in enumerate(dict.fromkeys(calls), start=1)}

    def value(self, node: ast.expr) -> Expr:
        if not moves(node):
            return _number(value_of(node, 0.0))
        match node:
            case ast.UnaryOp(op=op, operand=operand):
                return -self.value(operand) if isinstance(op, ast.USub) else self.value(operand)
            case ast.Call(args=[y, x]):
                return self._named(node, self._direction(self._argument(node, x), self._argument(node, y, "_height")))
            case ast.Call(func=ast.Name(id=name), args=[argument]):
                return self._named(node, self._function(name, self._argument(node, argument)))
            case ast.BinOp(left=base, op=ast.Pow(), right=exponent):
                return self.value(base) ** int(value_of(exponent, 0.0))
            case ast.BinOp(left=left, op=op, right=right):
                a, b = self.value(left), self.value(right)
                if isinstance(op, ast.Div):
                    return a / b
                return a + b if isinstance(op, ast.Add) else a - b if isinstance(op, ast.Sub) else a * b
        return self.time

    def rate(self, node: ast.expr) -> Expr:
        import sympy as sp

        if not moves(node):
            return sp.S.Zero
        match node:
            case ast.UnaryOp(op=op, operand=operand):
                return -self.rate(operand) if isinstance(op, ast.USub) else self.rate(operand)
            case ast.Call(args=[ordinate, abscissa]):
                y, x = self._argument(node, ordinate, "_height"), self._argument(node, abscissa)
                return (x * self.rate(ordinate) - y * self.rate(abscissa)) / (x**2 + y**2)
            case ast.Call(func=ast.Name(id=name), args=[argument]):
                return self._slope(node, name, argument) * self.rate(argument)
            case ast.BinOp(left=base, op=ast.Pow(), right=exponent):
                power = int(value_of(exponent, 0.0))
                return power * self.value(base) ** (power - 1) * self.rate(base)
            case ast.BinOp(left=left, op=op, right=right):
                da, db = self.rate(left), self.rate(right)
                if isinstance(op, ast.Mult):
                    return da * self.value(right) + self.value(left) * db
                if isinstance(op, ast.Div):
                    return (da - self.value(node) * db) / self.value(right)
                return da + db if isinstance(op, ast.Add) else da - db
        return sp.S.One

    def _slope(self, node: ast.expr, name: str, argument: ast.expr) -> Expr:
        """The derivative of a function by its argument."""
        import sympy as sp

        own, inner = self.value(node), self._argument(node, argument)
        match name:
            case "sin":
                return self._named(node, sp.cos(inner), "_rate")
            case "cos":
                return -self._named(node, sp.sin(inner), "_rate")
            case "tan":
                return 1 + own**2
            case "tanh":
                return 1 - own**2
            case "exp":
                return own
            case "log":
                return 1 / inner
            case "sqrt":
                return 1 / (2 * own)
            case "asin":
                return 1 / sp.sqrt(1 - inner**2)
            case "acos":
                return -1 / sp.sqrt(1 - inner**2)
            case "atan":
                return 1 / (1 + inner**2)
        raise ValueError(f"{name} has no derivative everywhere")

    def _function(self, name: str, x: Expr) -> Expr:
        """A function of one argument. Programs have the arctangent alone of those that give angles."""
        import sympy as sp

        if name == "asin":
            return 2 * sp.atan(x / (1 + sp.sqrt(1 - x**2)))
        if name == "acos":
            return sp.Float(math.pi / 2) - self._function("asin", x)
        plain: Expr = ({"abs": sp.Abs, "sqrt": sp.sqrt}.get(name) or getattr(sp, name))(x)
        return plain

    def _direction(self, x: Expr, y: Expr) -> Expr:
        """The angle of (x, y): in programs twice that from the circle's far end; where it is plain, what has the right
        derivative there too."""
        import sympy as sp

        return 2 * sp.atan(y / (sp.sqrt(x**2 + y**2) + x)) if self.name else sp.atan2(y, x)

    def _argument(self, node: ast.expr, argument: ast.expr, what: str = "_of") -> Expr:
        return self._named(node, self.value(argument), what)

    def _named(self, node: ast.expr, expression: Expr, what: str = "") -> Expr:
        return self.let(f"{self.name}_{self.number[ast.dump(node)]}{what}", expression)


def _number(value: float) -> Expr:
    import sympy as sp

    return sp.Integer(int(value)) if value.is_integer() and abs(value) < 2.0**53 else sp.Float(value)


class InTime:
    """Marks a value that is a number or an expression of t; ``units`` are those of :class:`Measured`.

    Other marks that derive from it may read expressions of the state too (:meth:`read_state`)."""

    def __init__(self, *units: str) -> None:
        self.units = units

    def __repr__(self) -> str:
        return f"InTime({', '.join(self.units)})"

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.with_info_plain_validator_function(self._read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return {"type": ["number", "string"]}

    def read_state(self, text: str, info: ValidationInfo) -> Changing | None:
        """The text as an expression of the state; ``None`` where it is none. Raises ``ExpressionError``."""
        laws = laws_among(info.context or NO_NAMES)
        asked = [word for word in asks_state(text, laws) if word in (*_OF_STATE, *laws)]
        if not asked:
            return None
        told = asked[0] if asked[0] in laws else f"{asked[0]}(...)"
        raise ExpressionError(
            f"it has {told}, which is of the state, and what is prescribed or wanted is a function of the time alone; "
            "write a [[motor]] with a torque or a force of the state"
        )

    def _read(self, value: object, info: ValidationInfo) -> float | Changing:
        if isinstance(value, str):
            names = info.context or NO_NAMES
            with faults_as_advice():
                if (changing := self.read_state(value, info)) is not None:
                    return changing
                if (quantity := read_quantity(value, self.units)) is not None:
                    return quantity
                law = parse(value, names)
                if isinstance(law, Written):
                    check_dimension(law, self.units)
                return law
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= sys.float_info.max:
            advice = 'write a finite number or a text such as "2*sin(3*t)"'
            if isinstance(value, dict):
                advice += "; rows over time are for what joints do, and for [[torque]]"
            if isinstance(value, list):
                advice += "; write rows over time as { rows = [[t, value], ...], order = 3 }, where they may stand"
            raise PydanticCustomError("expression", "{advice}", {"advice": advice})
        return float(value)


_OF_STATE = (*QUANTITIES, RATE, *VELOCITIES, *FORCES)
"""Words that show that an expression is meant to be of the state."""

Law = float | Changing
"""A value in a scene: a number, which becomes a parameter, or one that changes."""

Quantity = Parameter | Changing | None
"""A :data:`Law` in an effect's record; ``None`` where it is exactly zero."""


def quantity(law: Law, path: str, symbol: str) -> Quantity:
    """What a law becomes in a record."""
    if isinstance(law, Changing):
        return law
    return Parameter(path, symbol, law) if law else None


def load_quantity(law: Law, path: str, symbol: str) -> Parameter | Changing:
    """What the law of a load becomes in a record: a number that is zero too is a parameter, which can be raised."""
    return law if isinstance(law, Changing) else Parameter(path, symbol, law or 0.0)


def kinks_of(*quantities: Quantity) -> tuple[tuple[float, float], ...]:
    """The times (s) at which those over time have kinks, as :meth:`Changing.kinks` tells them."""
    return tuple(kink for q in quantities if isinstance(q, Changing) for kink in q.kinks())


def own_parameters(*quantities: Quantity) -> tuple[Parameter, ...]:
    """The parameters among them."""
    return tuple(q for q in quantities if isinstance(q, Parameter))


def those_over_time(quantities: Mapping[str, Quantity]) -> dict[str, Changing]:
    """Those of them, by their paths, that are no numbers."""
    return {path: q for path, q in quantities.items() if isinstance(q, Changing)}


def term(of: Quantity, motion: Motion, name: str) -> Expr:
    """A quantity in the equations; ``name`` is that of a value that changes."""
    if isinstance(of, Changing):
        return motion.let(name, of.realise(motion, f"{name}_part"))
    return motion.value(of)
