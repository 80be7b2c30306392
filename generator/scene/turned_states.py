"""Expressions of the state in a part that is placed: what they ask for is called otherwise there, and is turned.

A part is written as it stands about its own origin, and so are its expressions: where the part is mirrored and turned,
as :mod:`.turning` says, with σ, β and the angle α of the place, what was φ, θ or (x, y) is found from what it is there.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping

from ..effect_base.arithmetic import ExpressionError, parsed
from ..effect_base.grammar_of_state import QUANTITIES, RATE, VELOCITIES
from ..effect_base.table import NameKind
from .turning import Sides, Turning, cos_sin

Outside = Callable[[NameKind, str], str]
"""What something of a kind that a part names is called outside of it."""


def turned_state(
    text: str, turning: Turning, named: Mapping[str, str], joints: Mapping[str, Sides], outside: Outside
) -> str:
    """The expression as it is in a place; the same text where it cannot be read.

    ``named`` are numbers and laws of the part, each with what it is called in the place, ``joints`` those of the part,
    each with which of its sides are the part's.
    """
    try:
        tree = parsed(text)
    except ExpressionError:
        return text  # told when it is read
    return ast.unparse(_Turned(turning, named, joints, outside).visit(tree))


class _Turned(ast.NodeTransformer):
    def __init__(
        self, turning: Turning, named: Mapping[str, str], joints: Mapping[str, Sides], outside: Outside
    ) -> None:
        self.turning, self.named, self.joints, self.outside = turning, named, joints, outside

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return ast.Name(self.named.get(node.id, node.id), ast.Load())

    def visit_Call(self, node: ast.Call) -> ast.expr:
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if name == RATE and len(node.args) == 1:
            inner = node.args[0]
            if isinstance(inner, ast.Call) and isinstance(inner.func, ast.Name) and inner.func.id in QUANTITIES:
                return self._quantity(inner.func.id, inner.args, rate=True)
            joint = _name(inner)
            sides = self.joints.get(joint or "")
            if joint is None or sides is None:
                return node
            return self._quantity("angle" if sides.has_angle else "slide", [inner], rate=True)
        if name in VELOCITIES:
            return self._quantity(VELOCITIES[name], node.args, rate=True)
        if name in QUANTITIES:
            return self._quantity(name, node.args, rate=False)
        return ast.Call(node.func, [self.visit(one) for one in node.args], node.keywords)

    def _quantity(self, kind: str, args: list[ast.expr], rate: bool) -> ast.expr:
        names = [_name(one) for one in args]
        kinds = QUANTITIES[kind]
        if len(names) != len(kinds) or None in names:
            return _asked(kind, [ast.unparse(one) for one in args], rate, quoted=False)  # told when it is read
        found = [self.outside(of, str(name)) for of, name in zip(kinds, names, strict=True)]
        sign, shift = self.turning.sign, 0.0
        if kind == "direction":
            return _less(_asked(kind, found, rate), self.turning.shift, sign, rate)
        if kind == "angle" and (sides := self.joints.get(str(names[0]))):
            if sides.first != sides.second:
                shift = -self.turning.shift if sides.first else self.turning.shift
            return _less(_asked(kind, found, rate), shift, sign, rate)
        if kind in ("x", "y"):
            return self._coordinate(kind, found, rate)
        return _asked(kind, found, rate)

    def _coordinate(self, kind: str, names: list[str], rate: bool) -> ast.expr:
        """A coordinate in the plane of the part."""
        turning = self.turning
        cos, sin = cos_sin(turning.angle)
        x, y = (_less(_asked(one, names, rate), at, 1.0, rate) for one, at in zip("xy", turning.at, strict=True))
        factors = (cos * turning.sign, sin * turning.sign) if kind == "x" else (-sin, cos)
        terms = [_times(one, factor) for one, factor in zip((x, y), factors, strict=True) if factor]
        return terms[0] if len(terms) == 1 else ast.BinOp(terms[0], ast.Add(), terms[1])


def _name(node: ast.expr) -> str | None:
    """What an argument names: ``hip``, ``foot.sole``, ``"lambda"``."""
    match node:
        case ast.Name(id=name) | ast.Constant(value=str() as name):
            return name
        case ast.Attribute(value=ast.Name(id=owner), attr=point):
            return f"{owner}.{point}"
    return None


def _asked(kind: str, names: list[str], rate: bool, quoted: bool = True) -> ast.expr:
    """A quantity of things by their names, or its rate."""
    args = [ast.Constant(name) if quoted else ast.parse(name, mode="eval").body for name in names]
    asked = ast.Call(ast.Name(kind, ast.Load()), args, [])
    return ast.Call(ast.Name(RATE, ast.Load()), [asked], []) if rate else asked


def _less(value: ast.expr, shift: float, sign: float, rate: bool) -> ast.expr:
    """sign (value - shift), of a rate without the shift."""
    if shift and not rate:
        value = ast.BinOp(value, ast.Sub(), _number(shift))
    return _times(value, sign)


def _times(value: ast.expr, factor: float) -> ast.expr:
    if factor == 1.0:
        return value
    if factor == -1.0:
        return ast.UnaryOp(ast.USub(), value)
    return ast.BinOp(_number(factor), ast.Mult(), value)


def _number(value: float) -> ast.expr:
    number = ast.Constant(abs(value))
    return ast.UnaryOp(ast.USub(), number) if value < 0.0 else number
