"""Event indicators: the expressions whose zeros are a scene's events, over the moving mechanism, as equations.

The size of a value times the numbers' precision bounds its rounding, first order in it: a running error analysis.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from dataclasses import dataclass

import sympy as sp

from ..derive.indicators import LENGTH, PACE, Indication
from ..derive.motion import Motion
from ..derive.vectors import Vector, dot
from ..equations.step import step
from ..mechanism.mechanism import Mechanism
from .arithmetic import value_of
from .points import find_point


@dataclass(frozen=True)
class Indicator:
    """The expression ``when`` of a mechanism's state and time, in normal form (:mod:`..scene.event_expression`)."""

    when: str
    mechanism: Mechanism

    def indication(self, motion: Motion, name: str) -> Indication:
        """Its value, rate and size; what it consists of is named by what begins with ``name``."""
        return _Reader(self.mechanism, motion, name).read(ast.parse(self.when, mode="eval").body)


@dataclass(frozen=True)
class SetTo:
    """What an event sets a parameter to: a number, or an expression as :class:`Indicator` has one."""

    value: float | str
    mechanism: Mechanism

    def at(self, motion: Motion, name: str) -> sp.Expr:
        """Its value in a motion; what it consists of is named by what begins with ``name``."""
        if isinstance(self.value, str):
            return Indicator(self.value, self.mechanism).indication(motion, name).value
        return sp.Float(self.value)


def _constant(value: sp.Expr) -> Indication:
    return Indication(value, sp.S.Zero, sp.Abs(value))


PI = sp.Float(math.pi)
_Unary = Callable[[sp.Expr], sp.Expr]
_FUNCTIONS: dict[str, tuple[_Unary, _Unary]] = {
    "sin": (sp.sin, sp.cos),
    "cos": (sp.cos, lambda x: -sp.sin(x)),
    "tan": (sp.tan, lambda x: 1 + sp.tan(x) ** 2),
    "exp": (sp.exp, sp.exp),
    "log": (sp.log, lambda x: 1 / x),
    "sqrt": (sp.sqrt, lambda x: 1 / (2 * sp.sqrt(x))),
    "tanh": (sp.tanh, lambda x: 1 - sp.tanh(x) ** 2),
    "abs": (sp.Abs, lambda x: step(x) - step(-x)),
    "asin": (lambda x: sp.atan(x / _leg(x)), lambda x: 1 / _leg(x)),
    "acos": (lambda x: PI / 2 - sp.atan(x / _leg(x)), lambda x: -1 / _leg(x)),
    "atan": (sp.atan, lambda x: 1 / (1 + x**2)),
}
"""Functions of one argument, with their derivatives."""


def _leg(x: sp.Expr) -> sp.Expr:
    """Of a right triangle whose other leg is x and whose hypotenuse is 1."""
    return sp.sqrt((1 - x) * (1 + x))


class _Reader:
    """Reads an expression; the checks were made where it was written."""

    def __init__(self, mechanism: Mechanism, motion: Motion, name: str) -> None:
        self.mechanism, self.motion, self.name, self.named = mechanism, motion, name, 0

    def read(self, node: ast.expr) -> Indication:
        match node:
            case ast.Constant(value=int() | float() as number):
                return _constant(sp.Float(number) if isinstance(number, float) else sp.Integer(number))
            case ast.Name(id="pi"):
                return _constant(PI)
            case ast.Name():
                return Indication(self.motion.time, sp.S.One, sp.Abs(self.motion.time))
            case ast.UnaryOp(op=op, operand=operand):
                inner = self.read(operand)
                return self._negative(inner) if isinstance(op, ast.USub) else inner
            case ast.BinOp(left=left, op=ast.Pow(), right=right):
                return self._power(self.read(left), int(value_of(right, 0.0)))
            case ast.BinOp(left=left, op=op, right=right):
                a, b = self.read(left), self.read(right)
                if isinstance(op, ast.Add | ast.Sub):
                    return self._sum(a, b if isinstance(op, ast.Add) else self._negative(b))
                return self._product(
                    a, self._through(b, lambda x: 1 / x, lambda x: -1 / x**2) if isinstance(op, ast.Div) else b
                )
            case ast.Call(func=ast.Name(id="rate"), args=[inner]):
                found = self.read(inner)
                assert found.rate is not None
                return self._let(found.rate, None, sp.Abs(found.rate) + found.size / PACE)
            case ast.Call(func=ast.Name(id="atan2"), args=[first, second]):
                return self._direction(self.read(first), self.read(second))
            case ast.Call(func=ast.Name(id=name), args=[argument]) if name in _FUNCTIONS:
                return self._through(self.read(argument), *_FUNCTIONS[name])
            case ast.Call(func=ast.Name(id=name), args=args):
                return self._quantity(name, [str(one.value) for one in args if isinstance(one, ast.Constant)])
        raise ValueError(f"not checked: {ast.dump(node)}")

    def _let(self, value: sp.Expr, rate: sp.Expr | None, size: sp.Expr) -> Indication:
        """The same with names for what is long."""
        self.named += 1
        let, name = self.motion.let, f"{self.name}_{self.named}"
        found = let(name, value)
        return Indication(found, rate if rate is None else let(f"{name}_rate", rate), let(f"{name}_size", size))

    def _negative(self, a: Indication) -> Indication:
        return Indication(-a.value, None if a.rate is None else -a.rate, a.size)

    def _sum(self, a: Indication, b: Indication) -> Indication:
        rate = None if a.rate is None or b.rate is None else a.rate + b.rate
        return self._let(a.value + b.value, rate, a.size + b.size)

    def _product(self, a: Indication, b: Indication) -> Indication:
        rate = None if a.rate is None or b.rate is None else a.rate * b.value + a.value * b.rate
        return self._let(a.value * b.value, rate, sp.Abs(a.value) * b.size + sp.Abs(b.value) * a.size)

    def _power(self, a: Indication, exponent: int) -> Indication:
        if exponent == 0:
            return _constant(sp.S.One)
        return self._through(a, lambda x: x**exponent, lambda x: exponent * x ** (exponent - 1))

    def _through(self, a: Indication, function: _Unary, slope: _Unary) -> Indication:
        """A function of one value, with its derivative."""
        steep = self.motion.let(f"{self.name}_{self.named + 1}_slope", slope(a.value))
        found = self._let(function(a.value), None if a.rate is None else steep * a.rate, sp.Abs(steep) * a.size)
        return Indication(found.value, found.rate, found.size + sp.Abs(found.value))

    def _direction(self, y: Indication, x: Indication) -> Indication:
        """The angle of (x, y)."""
        square = x.value**2 + y.value**2
        behind = PI * step(-x.value) * (1 - 2 * step(-y.value))
        value = sp.atan(y.value / x.value) + behind
        rate = None if x.rate is None or y.rate is None else (x.value * y.rate - y.value * x.rate) / square
        size = (sp.Abs(x.value) * y.size + sp.Abs(y.value) * x.size) / square
        found = self._let(value, rate, size)
        return Indication(found.value, found.rate, found.size + sp.Abs(found.value))

    def _quantity(self, kind: str, names: list[str]) -> Indication:
        motion = self.motion
        if kind in ("angle", "direction"):
            first, second = self._sides(names[0]) if kind == "angle" else (-1, self._link(names[0]))
            value, rate = motion.angle(second) - motion.angle(first), motion.rate(second) - motion.rate(first)
            return self._let(value, rate, sp.Abs(value) + 1)
        if kind == "slide":
            joint = [one.name for one in self.mechanism.joints].index(names[0])
            return self._length(motion.joint_position(joint), motion.joint_speed(joint))
        if kind == "distance":
            (one, other) = (find_point(name, self.mechanism)[0] for name in names)
            assert one is not None and other is not None
            way, speed = (
                self._named("way", motion.distance(one, other)),
                self._named("speed", motion.approach(one, other)),
            )
            length = motion.let(f"{self.name}_{self.named + 1}_length", sp.sqrt(dot(way, way)))
            return self._length(length, dot(way, speed) / length)
        point = find_point(names[0], self.mechanism)[0]
        assert point is not None
        axis = "xy".index(kind)
        return self._length(motion.position(point)[axis], motion.velocity(point)[axis])

    def _length(self, value: sp.Expr, rate: sp.Expr) -> Indication:
        found = self._let(value, rate, LENGTH)
        return Indication(found.value, found.rate, sp.Abs(found.value) + LENGTH)

    def _named(self, what: str, vector: Vector) -> Vector:
        return self.motion.let_vector(f"{self.name}_{self.named + 1}_{what}", vector)

    def _sides(self, joint: str) -> tuple[int, int]:
        """The two links of a joint."""
        found = next(one for one in (*self.mechanism.joints, *self.mechanism.open) if one.name == joint)
        return found.first.link, found.second.link

    def _link(self, name: str) -> int:
        return [link.name for link in self.mechanism.links].index(name)
