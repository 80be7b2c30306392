"""Expressions of time as scenes write them (``"2*sin(3*t) + 0.5"``), parsed without evaluating anything of Python's."""

from __future__ import annotations

import ast
import math
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import PlainValidator
from pydantic_core import PydanticCustomError

from ..mechanism.links import Parameter
from .angle import read_angle

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Motion
    from ..derive.terms_of_effects import Let

FUNCTIONS: dict[str, Callable[[float], float]] = {
    "sin": math.sin,
    "cos": math.cos,
    "tan": math.tan,
    "exp": math.exp,
    "log": math.log,
    "sqrt": math.sqrt,
    "tanh": math.tanh,
    "abs": abs,
}
LONGEST, DEEPEST, HIGHEST = 2000, 100, 64
"""Limits of an expression: characters, nesting, and the power of t (or of a function of t) that it amounts to."""

_HELP = f"the names are t and pi, the functions {', '.join(FUNCTIONS)}"
_OPERATORS = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Pow)


class ExpressionError(ValueError):
    """What is wrong with an expression, and what to do."""


@dataclass(frozen=True)
class Expression:
    """An expression of t (s), checked; ``text`` is its normal form. Its numbers are not parameters."""

    text: str

    def at(self, t: float) -> float:
        """The value at a time; ``ArithmeticError`` or ``ValueError`` where there is none."""
        return _value(self._tree(), t)

    def has_rate(self) -> bool:
        """Whether its derivative by time exists everywhere as far as its functions go: ``abs`` has a kink."""
        return not any(isinstance(node, ast.Name) and node.id == "abs" for node in ast.walk(self._tree()))

    def realise(self, motion: Motion, name: str) -> Expr:
        """The expression in the equations; its functions are named ``name_1``, ``name_2``, … there."""
        return _Realised(motion.time, motion.let, name, self._tree()).value(self._tree())

    def rate(self, motion: Motion, name: str) -> Expr:
        """The derivative by time in the equations, with names as for :meth:`realise`."""
        return _Realised(motion.time, motion.let, name, self._tree()).rate(self._tree())

    def plain(self) -> Expr:
        """The expression as a function of the symbol t alone, with nothing named."""
        from ..derive.motion import TIME

        return _Realised(TIME, lambda _, expression: expression, "", self._tree()).value(self._tree())

    def slope_at(self, t: float, order: int = 1) -> float:
        """The derivative by time of the given order at a time, ``nan`` where there is none."""
        import sympy as sp

        time = sp.Symbol("t")
        value = sp.diff(self.plain(), time, order).subs(time, sp.Float(t, 30)).evalf(17)
        return float(value) if value.is_real and value.is_finite else math.nan

    def _tree(self) -> ast.expr:
        return ast.parse(self.text, mode="eval").body


def parse(text: str) -> Expression | float:
    """The expression, or its value if it does not depend on t. Raises ``ExpressionError`` with a sentence."""
    if len(text) > LONGEST:
        raise ExpressionError(f"it has {len(text)} characters; write one of at most {LONGEST}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = ast.parse(" ".join(text.split()), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise ExpressionError("it cannot be read; write it like 2*sin(3*t) + 0.5, with * for products") from error
    if _check(tree, 0) > HIGHEST:
        raise ExpressionError(f"it amounts to a power higher than {HIGHEST}; write a lower one")
    try:
        start = _value(tree, 0.0)
    except (ArithmeticError, ValueError):
        start = math.nan
    if not math.isfinite(start):
        raise ExpressionError("it has no finite value at t = 0, where runs begin; change it")
    return Expression(ast.unparse(tree)) if _moves(tree) else start


def _check(node: ast.expr, depth: int) -> int:
    """Refuse everything but arithmetic on known names; the power of t that the node amounts to."""
    if depth > DEEPEST:
        raise ExpressionError(f"it is nested deeper than {DEEPEST}; write a simpler one")
    match node:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            return 0
        case ast.Name(id="t"):
            return 1
        case ast.Name(id="pi"):
            return 0
        case ast.Name(id=name):
            wrong = "needs an argument in parentheses" if name in FUNCTIONS else "is not known here"
            raise ExpressionError(f"{name} {wrong}; {_HELP}")
        case ast.UnaryOp(op=ast.USub() | ast.UAdd(), operand=operand):
            return _check(operand, depth + 1)
        case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in FUNCTIONS:
            return min(_check(argument, depth + 1), 1)
        case ast.Call(func=ast.Name(id=name)):
            wrong = "takes one argument" if name in FUNCTIONS else "is not known here"
            raise ExpressionError(f"{name}(...) {wrong}; {_HELP}")
        case ast.BinOp(left=base, op=ast.Pow(), right=exponent):
            return _check(base, depth + 1) * _check_exponent(base, exponent, depth + 1)
        case ast.BinOp(op=ast.BitXor()):
            raise ExpressionError(f"{_excerpt(node)} has a ^, which is no power here; write ** for ^")
        case ast.BinOp(left=left, op=op, right=right) if isinstance(op, _OPERATORS):
            powers = _check(left, depth + 1), _check(right, depth + 1)
            return max(powers) if isinstance(op, ast.Add | ast.Sub) else sum(powers)
    raise ExpressionError(f"{_excerpt(node)} is not arithmetic; use + - * / **, numbers, and no more: {_HELP}")


def _check_exponent(base: ast.expr, exponent: ast.expr, depth: int) -> int:
    """The size of an exponent: any number where the base is one too, else a whole number."""
    _check(exponent, depth)
    if _moves(exponent):
        raise ExpressionError("it has t in an exponent; write exp(...) for that")
    if not _moves(base):
        return 0
    try:
        value = _value(exponent, 0.0)
    except (ArithmeticError, ValueError):
        value = math.nan
    if not value.is_integer() or abs(value) > HIGHEST:
        raise ExpressionError(f"exponents are whole numbers up to {HIGHEST}; write sqrt(...) for a root")
    return abs(int(value))


def _excerpt(node: ast.expr) -> str:
    text = ast.unparse(node)
    return text if len(text) < 40 else f"{text[:36]}..."


def _moves(node: ast.expr) -> bool:
    """Whether it depends on t."""
    return any(isinstance(part, ast.Name) and part.id == "t" for part in ast.walk(node))


def _value(node: ast.expr, t: float) -> float:
    match node:
        case ast.Constant(value=int() | float() as number):
            return float(number)
        case ast.Name(id=name):
            return t if name == "t" else math.pi
        case ast.UnaryOp(op=op, operand=operand):
            return -_value(operand, t) if isinstance(op, ast.USub) else _value(operand, t)
        case ast.Call(func=ast.Name(id=name), args=[argument]):
            return FUNCTIONS[name](_value(argument, t))
        case ast.BinOp(left=left, op=op, right=right):
            a, b = _value(left, t), _value(right, t)
            if isinstance(op, ast.Pow):
                return math.pow(a, b)
            if isinstance(op, ast.Div):
                return a / b
            return a + b if isinstance(op, ast.Add) else a - b if isinstance(op, ast.Sub) else a * b
    raise TypeError(f"not checked: {ast.dump(node)}")


class _Realised:
    """The parts of one expression of ``time``: each function of t gets a name of its own, which ``let`` gives."""

    def __init__(self, time: Expr, let: Let, name: str, tree: ast.expr) -> None:
        self.time, self.let, self.name = time, let, name
        calls = [ast.dump(node) for node in ast.walk(tree) if isinstance(node, ast.Call) and _moves(node)]
        self.number = {call: index for index, call in enumerate(dict.fromkeys(calls), start=1)}

    def value(self, node: ast.expr) -> Expr:
        import sympy as sp

        if not _moves(node):
            return _number(_value(node, 0.0))
        match node:
            case ast.UnaryOp(op=op, operand=operand):
                return -self.value(operand) if isinstance(op, ast.USub) else self.value(operand)
            case ast.Call(func=ast.Name(id=name), args=[argument]):
                function = {"abs": sp.Abs, "sqrt": sp.sqrt}.get(name) or getattr(sp, name)
                return self._named(node, function(self._argument(node, argument)))
            case ast.BinOp(left=base, op=ast.Pow(), right=exponent):
                return self.value(base) ** int(_value(exponent, 0.0))
            case ast.BinOp(left=left, op=op, right=right):
                a, b = self.value(left), self.value(right)
                if isinstance(op, ast.Div):
                    return a / b
                return a + b if isinstance(op, ast.Add) else a - b if isinstance(op, ast.Sub) else a * b
        return self.time

    def rate(self, node: ast.expr) -> Expr:
        import sympy as sp

        if not _moves(node):
            return sp.S.Zero
        match node:
            case ast.UnaryOp(op=op, operand=operand):
                return -self.rate(operand) if isinstance(op, ast.USub) else self.rate(operand)
            case ast.Call(func=ast.Name(id=name), args=[argument]):
                return self._slope(node, name, argument) * self.rate(argument)
            case ast.BinOp(left=base, op=ast.Pow(), right=exponent):
                power = int(_value(exponent, 0.0))
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
        raise ValueError(f"{name} has no derivative everywhere")

    def _argument(self, node: ast.expr, argument: ast.expr) -> Expr:
        return self._named(node, self.value(argument), "_of")

    def _named(self, node: ast.expr, expression: Expr, what: str = "") -> Expr:
        return self.let(f"{self.name}_{self.number[ast.dump(node)]}{what}", expression)


def _number(value: float) -> Expr:
    import sympy as sp

    return sp.Integer(int(value)) if value.is_integer() and abs(value) < 2.0**53 else sp.Float(value)


def read_angle_law(value: object) -> float | Expression:
    """As :func:`read_law`; an angle may also be written ``"30 deg"``."""
    try:
        angle = read_angle(value)
    except PydanticCustomError:
        return read_law(value)
    return read_law(angle)


def read_law(value: object) -> float | Expression:
    """A number, or an expression in quotes; for pydantic, whose fault then carries the advice."""
    if isinstance(value, str):
        try:
            return parse(value)
        except ExpressionError as error:
            raise PydanticCustomError("expression", "{advice}", {"advice": str(error)}) from error
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= sys.float_info.max:
        advice = 'write a finite number or a text such as "2*sin(3*t)"'
        if isinstance(value, list):
            advice += "; rows over time are for torques and forces only, table = [[t, value], ...]"
        raise PydanticCustomError("expression", "{advice}", {"advice": advice})
    return float(value)


Law = Annotated[float | Expression, PlainValidator(read_law)]
"""A value in a scene: a number, which becomes a parameter, or an expression of t."""

AngleLaw = Annotated[float | Expression, PlainValidator(read_angle_law)]
"""A :data:`Law` of an angle (rad)."""

Quantity = Parameter | Expression | None
"""A :data:`Law` in an effect's record; ``None`` where it is exactly zero."""


def quantity(law: float | Expression, path: str, symbol: str) -> Quantity:
    """What a law becomes in a record."""
    if isinstance(law, Expression):
        return law
    return Parameter(path, symbol, law) if law else None


def own_parameters(*quantities: Quantity) -> tuple[Parameter, ...]:
    """The parameters among them."""
    return tuple(q for q in quantities if isinstance(q, Parameter))


def term(of: Quantity, motion: Motion, name: str) -> Expr:
    """A quantity in the equations; ``name`` is that of an expression."""
    if isinstance(of, Expression):
        return motion.let(name, of.realise(motion, f"{name}_part"))
    return motion.value(of)
