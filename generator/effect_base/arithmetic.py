"""Arithmetic as scenes write it in quotes (``"2*rho*l"``), parsed without evaluating anything of Python's."""

from __future__ import annotations

import ast
import math
import re
import warnings
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from difflib import get_close_matches

from .units import UNITS, Dimension, kind_of

Names = Mapping[str, float | None]
"""Numbers that a scene has given names to; ``None`` where what a name stands for is wrong, which is told there."""
NO_NAMES: Names = {}

FUNCTIONS: dict[str, Callable[..., float]] = {
    "sin": math.sin,
    "cos": math.cos,
    "tan": math.tan,
    "exp": math.exp,
    "log": math.log,
    "sqrt": math.sqrt,
    "tanh": math.tanh,
    "abs": abs,
    "asin": math.asin,
    "acos": math.acos,
    "atan": math.atan,
    "atan2": math.atan2,
}
"""Functions of one argument, but for atan2(y, x)."""
KINKED: dict[str, Callable[..., float]] = {"min": min, "max": max}
"""Functions that expressions of the state have beside these."""
EVERY = {**FUNCTIONS, **KINKED}
"""All functions that have values of their own."""
LONGEST, DEEPEST, HIGHEST = 2000, 100, 64
"""Limits of an expression: characters, nesting, and the power of t (or of a function of t) that it amounts to."""

MOST_NAMED = 50
"""Names that a sentence lists: of more it says how many there are."""

_OPERATORS = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Pow)
RESERVED = ("t", "pi", *FUNCTIONS)
"""Names that mean something already."""


class NamesAndLaws(dict[str, float | None]):
    """Names of numbers, and beside them those of ``laws``, which stand for expressions of the state, each with the
    names of its own parameters."""

    def __init__(self, names: Names, laws: Mapping[str, Collection[str]]) -> None:
        super().__init__(names)
        self.laws = dict(laws)

    def __bool__(self) -> bool:
        return True  # laws alone are something too


def laws_among(names: Names) -> Mapping[str, Collection[str]]:
    """The laws that stand beside the names of numbers, with the names of their parameters."""
    return names.laws if isinstance(names, NamesAndLaws) else {}


class ExpressionError(ValueError):
    """What is wrong with an expression, and what to do."""


class NameWithoutValue(ExpressionError):
    """The expression has a name whose own value is wrong; that is told where the name is given."""


class Written(float):
    """A number (SI) that a scene gives as the text ``text``; ``dimension`` is what it measures, as far as it says."""

    text: str
    dimension: Dimension | None

    def __new__(cls, value: float, text: str, dimension: Dimension | None = None) -> Written:
        number = super().__new__(cls, value)
        number.text, number.dimension = text, dimension
        return number

    def __reduce__(self) -> tuple[type[Written], tuple[float, str, Dimension | None]]:
        return Written, (float(self), self.text, self.dimension)


def read_tree(text: str, names: Names, of_time: bool = True) -> ast.expr:
    """The expression, checked, with numbers in place of ``names``; ``of_time``: whether it may have t in it.

    Raises ``ExpressionError`` with a sentence, ``NameWithoutValue`` where what is wrong is told elsewhere.
    """
    tree = parsed(text)
    free = dict.fromkeys(free_names(tree))
    _check_names(tree, free, names, of_time)
    if _check(tree, 0, names) > HIGHEST:
        raise ExpressionError(f"it amounts to a power higher than {HIGHEST}; write a lower one")
    if any(names.get(name, 0.0) is None for name in free):
        raise NameWithoutValue
    put: ast.expr = _Numbers(names).visit(tree)
    return put


def parsed(text: str) -> ast.expr:
    """The text as Python reads it. Raises ``ExpressionError`` where it does not."""
    if len(text) > LONGEST:
        raise ExpressionError(f"it has {len(text)} characters; write one of at most {LONGEST}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return ast.parse(" ".join(text.split()), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise ExpressionError(f"{_unreadable(text)}; write it like 2*sin(pi/6) + 0.5, with * for products") from error


def _unreadable(text: str) -> str:
    """Why a text is no expression, as far as that can be told."""
    opened, closed = text.count("("), text.count(")")
    if opened != closed:
        return f"it cannot be read, with {opened} ( and {closed} )"
    if re.search("(?<![<>=!])=(?!=)", text):
        return (
            "it cannot be read: an expression has no = in it; write its right side alone, or, for an event, the "
            "difference of both sides"
        )
    units = [unit for unit in re.findall(r"[\w.)]\s+([A-Za-zµ%°]+)", text) if unit in UNITS and unit not in RESERVED]
    if units:
        return f"it cannot be read: units stand behind a single number, not in arithmetic as {units[0]} does here"
    return "it cannot be read"


def free_names(tree: ast.expr) -> Iterator[str]:
    """Names in an expression that are no functions' and no constants', each as often as it stands there."""
    nodes = list(ast.walk(tree))
    called = {id(node.func) for node in nodes if isinstance(node, ast.Call)}
    found = [node for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)]
    for node in sorted(found, key=lambda node: node.col_offset):
        if node.id not in RESERVED and id(node) not in called:
            yield node.id


def moves(node: ast.expr) -> bool:
    """Whether it depends on t."""
    return any(isinstance(part, ast.Name) and part.id == "t" for part in ast.walk(node))


def value_of(node: ast.expr, t: float) -> float:
    """The value of a checked expression at time ``t`` (s). ``ArithmeticError`` or ``ValueError`` where it has none."""
    match node:
        case ast.Constant(value=int() | float() as number):
            return float(number)
        case ast.Name(id=name):
            return t if name == "t" else math.pi
        case ast.UnaryOp(op=op, operand=operand):
            return -value_of(operand, t) if isinstance(op, ast.USub) else value_of(operand, t)
        case ast.Call(func=ast.Name(id=name), args=arguments):
            return EVERY[name](*(value_of(argument, t) for argument in arguments))
        case ast.BinOp(left=left, op=op, right=right):
            a, b = value_of(left, t), value_of(right, t)
            if isinstance(op, ast.Pow):
                if a == 0.0 and b < 0.0:
                    raise ZeroDivisionError("a power of zero")
                return math.pow(a, b)
            if isinstance(op, ast.Div):
                return a / b
            return a + b if isinstance(op, ast.Add) else a - b if isinstance(op, ast.Sub) else a * b
    raise TypeError(f"not checked: {ast.dump(node)}")


def calculate(text: str, names: Names) -> Written:
    """The number that arithmetic without t amounts to, with what it measures as far as its names say.

    Raises ``ExpressionError`` with a sentence: unknown names, no finite value, a length added to a mass.
    """
    tree = read_tree(text, names, of_time=False)
    try:
        value = value_of(tree, 0.0)
    except ZeroDivisionError as error:
        raise ExpressionError("it divides by zero, so that it has no finite value; change it") from error
    except ValueError as error:
        raise ExpressionError("it has no finite value, as a root of a negative number has none; change it") from error
    except OverflowError:
        value = math.inf
    if not math.isfinite(value):
        raise ExpressionError("it has no finite value, because it is too large; change it")
    return Written(value, text, _measures(parsed(text), names))


def _check_names(tree: ast.expr, free: Iterable[str], names: Names, of_time: bool) -> None:
    """Every name is known; all that are not are told together."""
    unknown = [name for name in free if name not in names and name not in RESERVED]
    allowed = (*(("t",) if of_time else ()), "pi", *names)
    laws = laws_among(names)
    if law := next((name for name in unknown if name in laws), None):
        raise ExpressionError(
            f"{law} is a law, which changes with the state, and this is a number that stays; laws stand in loads, "
            "events and other laws: write a number, or the load as a [[motor]], [[torque]] or [[force]]"
            if not of_time
            else f"{law} is a law, which may not stand here; write a number or an expression of t"
        )
    if unknown:
        close = get_close_matches(unknown[0], allowed, 1)
        advice = f'write "{close[0]}"' if close else "write a number without quotes, or give a name its value in [let]"
        told = f"{' and '.join(unknown)} {'is' if len(unknown) == 1 else 'are'} not known here"
        raise ExpressionError(f"{told}; {_told(allowed)}; {advice}")
    if moves(tree) and not of_time:
        raise ExpressionError(f"t is the time, and this is a number that stays; {_told(allowed)}")


def _told(allowed: Sequence[str]) -> str:
    if len(allowed) == 1:
        return f"the only name is {allowed[0]}"
    if len(allowed) > MOST_NAMED:
        return f"the names are {', '.join(allowed[:MOST_NAMED])} and {len(allowed) - MOST_NAMED} more"
    return f"the names are {', '.join(allowed[:-1])} and {allowed[-1]}"


def _help(names: Names) -> str:
    return f"{_told(('t', 'pi', *names))}, and the functions {', '.join(FUNCTIONS)}"


def _check(node: ast.expr, depth: int, names: Names) -> int:
    """Refuse everything but arithmetic on known names; the power of t that the node amounts to."""
    if depth > DEEPEST:
        raise ExpressionError(f"it is nested deeper than {DEEPEST}; write a simpler one")
    match node:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            return 0
        case ast.Name(id="t"):
            return 1
        case ast.Name(id=name) if name in FUNCTIONS:
            raise ExpressionError(f"{name} needs an argument in parentheses; {_help(names)}")
        case ast.Name():
            return 0
        case ast.UnaryOp(op=ast.USub() | ast.UAdd(), operand=operand):
            return _check(operand, depth + 1, names)
        case ast.Call(func=ast.Name(id=name), keywords=keywords, args=arguments):
            return _check_call(node, name, arguments, keywords, depth, names)
        case ast.BinOp(left=base, op=ast.Pow(), right=exponent):
            return _check(base, depth + 1, names) * _check_exponent(base, exponent, depth + 1, names)
        case ast.BinOp(op=ast.BitXor()):
            raise ExpressionError(f"{_excerpt(node)} has a ^, which is no power here; write ** for ^")
        case ast.BinOp(left=left, op=op, right=right) if isinstance(op, _OPERATORS):
            powers = _check(left, depth + 1, names), _check(right, depth + 1, names)
            return max(powers) if isinstance(op, ast.Add | ast.Sub) else sum(powers)
    raise ExpressionError(_not_arithmetic(node, names))


def _check_call(
    node: ast.Call, name: str, arguments: list[ast.expr], keywords: list[ast.keyword], depth: int, names: Names
) -> int:
    """A function that is known, with as many arguments as it takes."""
    if name not in FUNCTIONS:
        raise ExpressionError(f"{name}(...) is not known here; {_help(names)}")
    if any(isinstance(argument, ast.Starred) for argument in arguments):
        raise ExpressionError(_not_arithmetic(node, names))
    wanted = 2 if name == "atan2" else 1
    if len(arguments) != wanted or keywords:
        told = "two arguments" if wanted == 2 else "one argument"
        raise ExpressionError(f"{name}(...) takes {told}; {_help(names)}")
    return min(max(_check(argument, depth + 1, names) for argument in arguments), 1)


def _check_exponent(base: ast.expr, exponent: ast.expr, depth: int, names: Names) -> int:
    """The size of an exponent: any number where the base is one too, else a whole number."""
    _check(exponent, depth, names)
    if moves(exponent):
        raise ExpressionError("it has t in an exponent; write exp(...) for that")
    if not moves(base):
        return 0
    if any(names.get(name, 0.0) is None for name in free_names(exponent)):
        raise NameWithoutValue
    try:
        value = value_of(_Numbers(names).visit(ast.parse(ast.unparse(exponent), mode="eval").body), 0.0)
    except (ArithmeticError, ValueError):
        value = math.nan
    if not value.is_integer() or abs(value) > HIGHEST:
        raise ExpressionError(wrong_exponent(base, exponent, value))
    return abs(int(value))


def wrong_exponent(base: ast.expr, exponent: ast.expr, value: float) -> str:
    """What to write for a power of what changes whose exponent, of this ``value`` if it has one, is no whole number."""
    told, of = f"exponents are whole numbers up to {HIGHEST}", ast.unparse(base)
    if value == 0.5:
        return f"{told}; write sqrt(...) for a root, sqrt({of}) here"
    power = ast.unparse(ast.BinOp(exponent, ast.Mult(), _called_log(base)))
    return f"{told}; write exp({power}) for this power of what is positive"


def _called_log(of: ast.expr) -> ast.Call:
    return ast.Call(ast.Name("log", ast.Load()), [of], [])


def _not_arithmetic(node: ast.expr, names: Names) -> str:
    return f"{_excerpt(node)} is not arithmetic; use + - * / **, numbers, and no more: {_help(names)}"


def _excerpt(node: ast.expr) -> str:
    text = ast.unparse(node)
    return text if len(text) < 40 else f"{text[:36]}..."


class _Numbers(ast.NodeTransformer):
    """Puts numbers into the places of names; a negative one as a sign and a number, as it would be written."""

    def __init__(self, names: Names) -> None:
        self.names = names

    def visit_Call(self, node: ast.Call) -> ast.Call:
        node.args = [self.visit(argument) for argument in node.args]
        return node

    def visit_Name(self, node: ast.Name) -> ast.expr:
        value = self.names.get(node.id)
        if value is None or node.id in RESERVED:
            return node
        plain = value if isinstance(value, int) else float(value)
        number = ast.Constant(abs(plain))
        return ast.UnaryOp(ast.USub(), number) if math.copysign(1.0, plain) < 0.0 else number


def _measures(node: ast.expr, names: Names) -> Dimension | None:
    """What an expression measures, ``None`` where that is not known: numbers may stand for anything."""
    match node:
        case ast.Name(id=name):
            value = names.get(name)
            return value.dimension if isinstance(value, Written) else None
        case ast.UnaryOp(operand=operand):
            return _measures(operand, names)
        case ast.BinOp(left=left, op=ast.Add() | ast.Sub() as op, right=right):
            one, other = _measures(left, names), _measures(right, names)
            if one and other and not one.fits(other):
                told = "adds" if isinstance(op, ast.Add) else "subtracts"
                raise ExpressionError(f"{_excerpt(node)} {told} {kind_of(other)} and {kind_of(one)}; correct it")
            return one or other
        case ast.BinOp(left=left, op=ast.Mult() | ast.Div() as op, right=right):
            one, other = _measures(left, names), _measures(right, names)
            if one is None or other is None:
                return None
            found = one.times(other, 1 if isinstance(op, ast.Mult) else -1)
            return Dimension(found.kg, found.m, found.s, None)
    return None
