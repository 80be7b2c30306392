"""Expressions of the time and of where a mechanism is, as ``[[event]]`` has them: ``"angle(hip) + 2*angle(ankle)"``."""

from __future__ import annotations

import ast
import copy
import math
import zlib
from collections.abc import Mapping, Sequence
from difflib import get_close_matches

from ..effect_base.arithmetic import (
    DEEPEST,
    FUNCTIONS,
    HIGHEST,
    ExpressionError,
    Names,
    NameWithoutValue,
    parsed,
    value_of,
)
from ..effect_base.points import find_point
from ..mechanism.mechanism import Mechanism

QUANTITIES: Mapping[str, Sequence[str]] = {
    "angle": ("joint",),
    "direction": ("link",),
    "slide": ("joint",),
    "x": ("point",),
    "y": ("point",),
    "distance": ("point", "point"),
}
"""What may be asked of the state, and of what."""
RATE = "rate"
"""How fast such a quantity changes: ``rate(angle(hip))``."""

SAMPLES = (0.31, -0.47, 0.0083, -0.0021, 5.3, -7.9)
"""Times and states, of no meaning, on both sides of zero, at which a divisor is tried that may be zero always."""
_OPERATORS = (ast.Add, ast.Sub, ast.Mult, ast.Div)


def normal_form(text: str, names: Names, mechanism: Mechanism) -> str:
    """The expression, checked, with numbers in place of ``names`` and texts in place of what is asked.

    Raises ``ExpressionError`` with a sentence, ``NameWithoutValue`` where what is wrong is told elsewhere.
    """
    reader = _Reader(names, mechanism)
    tree = reader.read(parsed(text), 0)
    if not reader.moves:
        raise ExpressionError(f"it has neither t nor a quantity that moves; {_help()}")
    _check_divisors(tree)
    return ast.unparse(tree)


def number_or_form(text: str, names: Names, mechanism: Mechanism) -> float | str:
    """The same of a value that may be a number that stays."""
    reader = _Reader(names, mechanism)
    tree = reader.read(parsed(text), 0)
    if reader.moves:
        _check_divisors(tree)
        return ast.unparse(tree)
    try:
        value = value_of(tree, 0.0)
    except (ArithmeticError, ValueError):
        value = math.nan
    if not math.isfinite(value):
        raise ExpressionError("it has no finite value; change it")
    return value


def _help() -> str:
    told = [f"{name}({', '.join(of)})" for name, of in QUANTITIES.items()]
    return f"the quantities are t, {', '.join(told)} and rate(...) of one of them"


class _AtSome(ast.NodeTransformer):
    """An expression with numbers in place of what is asked of the state, other ones for each ``sample``."""

    def __init__(self, sample: float) -> None:
        self.sample = sample

    def visit_Call(self, node: ast.Call) -> ast.expr:
        if isinstance(node.func, ast.Name) and node.func.id in (*QUANTITIES, RATE):
            return ast.Constant(self.sample * (1.0 + zlib.crc32(ast.unparse(node).encode()) / 2**32))
        return ast.Call(node.func, [self.visit(one) for one in node.args], [])


def _check_divisors(tree: ast.expr) -> None:
    """Raise ``ExpressionError`` where something is divided by what is zero whatever the state is."""
    for sample in SAMPLES:
        try:
            value_of(_AtSome(sample).visit(copy.deepcopy(tree)), sample)
        except ZeroDivisionError:
            continue
        except (ArithmeticError, ValueError):
            pass
        return
    raise ExpressionError("it divides by what is always zero; correct it")


class _Reader:
    """Reads one expression; ``moves``: whether something in it does."""

    def __init__(self, names: Names, mechanism: Mechanism) -> None:
        self.names, self.mechanism, self.moves = names, mechanism, False

    def read(self, node: ast.expr, depth: int) -> ast.expr:
        if depth > DEEPEST:
            raise ExpressionError(f"it is nested deeper than {DEEPEST}; write a simpler one")
        match node:
            case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
                return node
            case ast.Name(id=name):
                return self._name(name)
            case ast.UnaryOp(op=ast.USub() | ast.UAdd() as op, operand=operand):
                return ast.UnaryOp(op, self.read(operand, depth + 1))
            case ast.Call(func=ast.Name(id=name), args=args, keywords=[]):
                return self._call(name, args, depth)
            case ast.BinOp(left=base, op=ast.Pow(), right=exponent):
                return ast.BinOp(self.read(base, depth + 1), ast.Pow(), self._exponent(exponent, depth + 1))
            case ast.BinOp(op=ast.BitXor()):
                raise ExpressionError(f"{_excerpt(node)} has a ^, which is no power here; write ** for ^")
            case ast.BinOp(left=left, op=op, right=right) if isinstance(op, _OPERATORS):
                return ast.BinOp(self.read(left, depth + 1), op, self.read(right, depth + 1))
        comparison = "; it comes to zero where both sides are equal: write their difference"
        why = comparison if isinstance(node, ast.Compare) else f"; use + - * / **, numbers and functions, and {_help()}"
        raise ExpressionError(f"{_excerpt(node)} is no arithmetic{why}")

    def _name(self, name: str) -> ast.expr:
        if name == "t":
            self.moves = True
        if name in ("t", "pi"):
            return ast.Name(name, ast.Load())
        if name in (*QUANTITIES, RATE, *FUNCTIONS):
            raise ExpressionError(f"{name} needs an argument in parentheses; {_help()}")
        if name not in self.names:
            near = get_close_matches(name, self.names, 1)
            advice = f'write "{near[0]}"' if near else "give it a value in [let], or ask for a quantity of it"
            raise ExpressionError(f"{name} is not known here; {_help()}; {advice}")
        value = self.names[name]
        if value is None:
            raise NameWithoutValue
        number = ast.Constant(abs(float(value)))
        return ast.UnaryOp(ast.USub(), number) if math.copysign(1.0, value) < 0.0 else number

    def _call(self, name: str, args: Sequence[ast.expr], depth: int) -> ast.expr:
        if name in QUANTITIES:
            return self._quantity(name, args)
        if name == RATE:
            match args:
                case [ast.Call(func=ast.Name(id=inner), args=inside, keywords=[])] if inner in QUANTITIES:
                    return _called(RATE, [self._quantity(inner, inside)])
            raise ExpressionError(f"rate(...) is of one quantity alone, as rate(angle(...)); {_help()}")
        if name not in FUNCTIONS:
            near = get_close_matches(name, (*QUANTITIES, RATE, *FUNCTIONS), 1)
            advice = f"; write {near[0]}(...)" if near else ""
            raise ExpressionError(f"{name}(...) is not known here; {_help()}, functions {', '.join(FUNCTIONS)}{advice}")
        wanted = 2 if name == "atan2" else 1
        if len(args) != wanted:
            raise ExpressionError(f"{name}(...) takes {'two arguments' if wanted == 2 else 'one argument'}; correct it")
        return _called(name, [self.read(argument, depth + 1) for argument in args])

    def _quantity(self, name: str, args: Sequence[ast.expr]) -> ast.expr:
        self.moves = True
        kinds = QUANTITIES[name]
        if len(args) != len(kinds):
            raise ExpressionError(f"{name}(...) is of {' and '.join(f'a {kind}' for kind in kinds)}; {_help()}")
        found = [self._named(name, kind, argument) for kind, argument in zip(kinds, args, strict=True)]
        return _called(name, [ast.Constant(one) for one in found])

    def _named(self, quantity: str, kind: str, node: ast.expr) -> str:
        """What a name stands for: ``hip``, ``foot.tip``, or in quotes where it reads as something else."""
        match node:
            case ast.Name(id=name) | ast.Constant(value=str() as name):
                given = name
            case ast.Attribute(value=ast.Name(id=owner), attr=point):
                given = f"{owner}.{point}"
            case _:
                raise ExpressionError(f"{quantity}(...) is of a {kind}, and has {_excerpt(node)}; name a {kind}")
        mechanism = self.mechanism
        joints = {joint.name: joint for joint in (*mechanism.joints, *mechanism.open)}
        joints = {name: joint for name, joint in joints.items() if name not in mechanism.hidden_joints}
        links = [link.name for link in mechanism.links[: mechanism.own_links]]
        wrong = ""
        if kind == "joint" and given not in joints:
            wrong = f"is no joint; the joints are {', '.join(joints) or 'none'}"
            if given in links and quantity == "angle":
                wrong += f"; write direction({given}) for the angle of that link"
        elif quantity == "angle" and not joints[given].turns:
            wrong = "does not turn; its links keep their angle"
        elif quantity == "slide" and not joints[given].slides:
            wrong = "does not slide; it only turns"
        elif kind == "link" and given not in links:
            wrong = f"is no link that moves; the links are {', '.join(links)}"
            if given in joints and joints[given].turns:
                wrong += f"; write angle({given}) for the angle at that joint"
        elif kind == "point" and find_point(given, mechanism)[0] is None:
            wrong = f"is no point; {find_point(given, mechanism)[1]}"
            if near := _points_like(given, mechanism):
                wrong += f"; write {' or '.join(near)}"
        if wrong:
            raise ExpressionError(f"{given} in {quantity}(...) {wrong}")
        return given

    def _exponent(self, node: ast.expr, depth: int) -> ast.expr:
        own = _Reader(self.names, self.mechanism)
        tree = own.read(node, depth)
        try:
            value = math.nan if own.moves else value_of(tree, 0.0)
        except (ArithmeticError, ValueError):
            value = math.nan
        if not value.is_integer() or abs(value) > HIGHEST:
            raise ExpressionError(f"exponents are whole numbers up to {HIGHEST}; write sqrt(...) or exp(...)")
        return tree


def _points_like(given: str, mechanism: Mechanism) -> list[str]:
    """Points of links that are called so, or that a link called so has, as ``link.point``."""
    links = mechanism.links[: mechanism.own_links]
    return [f"{link.name}.{point}" for link in links for point in link.points if given in (point, link.name)]


def _called(name: str, args: list[ast.expr]) -> ast.Call:
    return ast.Call(ast.Name(name, ast.Load()), args, [])


def _excerpt(node: ast.expr) -> str:
    text = ast.unparse(node)
    return text if len(text) < 40 else f"{text[:36]}..."
