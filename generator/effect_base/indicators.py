"""Event indicators: the expressions whose zeros are a scene's events, over the moving mechanism, as equations.

The size of a value times the numbers' precision bounds its rounding, first order in it: a running error analysis.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

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


class Changes(Protocol):
    """When a joint lets go or takes hold, as :class:`..scene.changes.Change` says it."""

    @property
    def joint(self) -> str: ...
    @property
    def at(self) -> float | None: ...
    @property
    def watch(self) -> Watches | None: ...
    @property
    def force(self) -> float | None: ...
    @property
    def meets(self) -> bool: ...


class Watches(Protocol):
    """What is watched: the quantity of a ``kind``, of what has the ``names``, and its ``limit``."""

    @property
    def kind(self) -> str: ...
    @property
    def names(self) -> tuple[str, ...]: ...
    @property
    def sign(self) -> int: ...
    @property
    def limit(self) -> float: ...


@dataclass(frozen=True)
class ChangeIndicator:
    """What rises through zero where a joint lets go or takes hold: the time less that of the change; what is watched
    less its limit; where the points of an open joint are nearest, what they miss times its rate. A force and an
    impulse in the joint are compared at run time: of these it is always below zero, and of the rate of a force nothing
    is known."""

    change: Changes
    mechanism: Mechanism

    def indication(self, motion: Motion, name: str) -> Indication:
        """Its value, rate and size; what it consists of is named by what begins with ``name``."""
        change = self.change
        if change.at is not None:
            at = sp.Float(change.at)
            return Indication(motion.time - at, sp.S.One, sp.Abs(motion.time) + at)
        if (watch := change.watch) is not None:
            kind = {"height": "y"}.get(watch.kind, watch.kind)
            quantity = f"{kind}({', '.join(map(repr, watch.names))})"
            less = f"{quantity} - ({watch.limit!r})" if watch.sign > 0 else f"({watch.limit!r}) - {quantity}"
            return Indicator(less, self.mechanism).indication(motion, name)
        if change.force is not None:
            return Indication(sp.S.NegativeOne, None, sp.Float(change.force))
        if not change.meets:
            return Indication(sp.S.NegativeOne, sp.S.Zero, sp.S.Zero)
        path = f"{change.joint}.held"
        number = next(k for k, gate in self.mechanism.gates.items() if gate.path == path)
        rows = motion.closure.missing(number)
        value = sp.Add(*(miss * rate for miss, rate in rows))
        size = sp.Add(*(LENGTH * (sp.Abs(rate) + sp.Abs(miss) / PACE) for miss, rate in rows))
        return Indication(motion.let(name, value), None, motion.let(f"{name}_size", size))


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
            if dot(way, way) == 0:  # a joint holds them together
                return self._length(sp.S.Zero, sp.S.Zero)
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
