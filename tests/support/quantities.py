"""Expressions of the time and the state, as events of scenes have them, along states: values, rates, and sizes, by
what models tell of their points and joints, which is another way than that of their kernels.

A size times the numbers' precision bounds the rounding of a value, first order in it (a running error analysis).
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ccgen.runtime.arrays import FloatArray
from ccgen.runtime.model.joint_sides import between, ends_of
from ccgen.runtime.model.model import Model


@dataclass(frozen=True)
class Values:
    """Of states (b,): the ``value``, its ``rate`` per second, ``None`` where that is not known, and its ``size``."""

    value: FloatArray
    rate: FloatArray | None
    size: FloatArray

    def __neg__(self) -> Values:
        return Values(-self.value, None if self.rate is None else -self.rate, self.size)

    def __add__(self, other: Values) -> Values:
        rate = None if self.rate is None or other.rate is None else self.rate + other.rate
        return Values(self.value + other.value, rate, self.size + other.size)

    def __sub__(self, other: Values) -> Values:
        return self + (-other)

    def __mul__(self, other: Values) -> Values:
        known = self.rate is not None and other.rate is not None
        rate = self.rate * other.value + self.value * other.rate if known else None  # type: ignore[operator]
        return Values(self.value * other.value, rate, np.abs(self.value) * other.size + self.size * np.abs(other.value))

    def __truediv__(self, other: Values) -> Values:
        return self * other.through(lambda x: 1.0 / x, lambda x: -1.0 / x**2)

    def power(self, exponent: int) -> Values:
        """The value to a whole power."""
        return self.through(
            lambda x: x**exponent, lambda x: exponent * x ** (exponent - 1) if exponent else np.zeros_like(x)
        )

    def through(
        self, function: Callable[[FloatArray], FloatArray], slope: Callable[[FloatArray], FloatArray]
    ) -> Values:
        """A function of the value, with its derivative."""
        value, steep = function(self.value), slope(self.value)
        rate = None if self.rate is None else steep * self.rate
        return Values(value, rate, np.abs(steep) * self.size + np.abs(value))


_FUNCTIONS: dict[str, tuple[Callable[[FloatArray], FloatArray], Callable[[FloatArray], FloatArray]]] = {
    "sin": (np.sin, np.cos),
    "cos": (np.cos, lambda x: -np.sin(x)),
    "tan": (np.tan, lambda x: 1.0 + np.tan(x) ** 2),
    "exp": (np.exp, np.exp),
    "log": (np.log, lambda x: 1.0 / x),
    "sqrt": (np.sqrt, lambda x: 0.5 / np.sqrt(x)),
    "tanh": (np.tanh, lambda x: 1.0 - np.tanh(x) ** 2),
    "abs": (np.abs, np.sign),
    "asin": (np.arcsin, lambda x: 1.0 / np.sqrt(1.0 - x**2)),
    "acos": (np.arccos, lambda x: -1.0 / np.sqrt(1.0 - x**2)),
    "atan": (np.arctan, lambda x: 1.0 / (1.0 + x**2)),
}


@dataclass(frozen=True)
class Quantity:
    """The expression ``text`` of a model's states."""

    text: str

    def along(self, model: Model, t: FloatArray, q: FloatArray, u: FloatArray) -> Values:
        """At times t (b,) and states q, u (b, n). Not a number where it has no value."""
        with np.errstate(all="ignore"):
            return _Reader(model, t, q, u).read(ast.parse(self.text, mode="eval").body)

    def at(self, model: Model, t: float, q: FloatArray, u: FloatArray) -> float:
        """The value at one state."""
        return float(self.along(model, np.array([t]), q[None], u[None]).value[0])


class _Reader:
    """Reads an expression at states of a model; the checks were made where it was written."""

    def __init__(self, model: Model, t: FloatArray, q: FloatArray, u: FloatArray) -> None:
        self.model, self.t, self.q, self.u = model, t, q, u
        self.poses, self.velocities = model.poses(q), model.velocities(q, u)

    def read(self, node: ast.expr) -> Values:
        match node:
            case ast.Constant(value=int() | float() as number):
                return self._constant(float(number))
            case ast.Name(id=name):
                return self._constant(math.pi) if name == "pi" else Values(self.t, np.ones_like(self.t), np.abs(self.t))
            case ast.UnaryOp(op=op, operand=operand):
                inner = self.read(operand)
                return -inner if isinstance(op, ast.USub) else inner
            case ast.BinOp(left=left, op=ast.Pow(), right=right):
                return self.read(left).power(int(self.read(right).value[0]))
            case ast.BinOp(left=left, op=op, right=right):
                a, b = self.read(left), self.read(right)
                if isinstance(op, ast.Div):
                    return a / b
                return a + b if isinstance(op, ast.Add) else a - b if isinstance(op, ast.Sub) else a * b
            case ast.Call(func=ast.Name(id="rate"), args=[inner]):
                found = self.read(inner)
                assert found.rate is not None
                pace = self.model.time or self.model.duration
                return Values(found.rate, None, np.abs(found.rate) + found.size / pace)
            case ast.Call(func=ast.Name(id="atan2"), args=[first, second]):
                return _direction(self.read(first), self.read(second))
            case ast.Call(func=ast.Name(id=name), args=[argument]) if name in _FUNCTIONS:
                return self.read(argument).through(*_FUNCTIONS[name])
            case ast.Call(func=ast.Name(id=name), args=args):
                return self._quantity(name, [one.value for one in args if isinstance(one, ast.Constant)])
        raise ValueError(f"not checked: {ast.dump(node)}")

    def _constant(self, number: float) -> Values:
        whole = np.full_like(self.t, number)
        return Values(whole, np.zeros_like(self.t), np.abs(whole))

    def _quantity(self, name: str, of: list[object]) -> Values:
        names = [str(one) for one in of]
        if name in ("angle", "direction"):
            first, second = between(self.model, names[0]) if name == "angle" else (-1, self.model.links.index(names[0]))
            turns, spins = self.poses[..., 2], self.velocities[..., 2]
            angle, spin = (_of_link(one, second) - _of_link(one, first) for one in (turns, spins))
            return Values(angle, spin, np.abs(angle) + 1.0)
        if name == "slide":
            length, rate = ends_of(self.model, names[0]).along(self.poses, self.velocities)
        elif name == "distance":
            (one, its), (other, others) = map(self._point, names)
            way, speed = other - one, others - its
            length = np.linalg.norm(way, axis=-1)
            rate = np.sum(way * speed, axis=-1) / np.where(length > 0.0, length, 1.0)
        else:
            place, speed = self._point(names[0])
            length, rate = (part[..., "xy".index(name)] for part in (place, speed))
        return Values(length, rate, np.abs(length) + self.model.length)

    def _point(self, name: str) -> tuple[FloatArray, FloatArray]:
        if name.startswith("ground."):
            place = np.broadcast_to(self.model.point(name, self.q), (len(self.t), 2))
            return place, np.zeros_like(place)
        return self.model.point(name, self.q), self.model.point_velocity(name, self.q, self.u)


def _of_link(of_links: FloatArray, link: int) -> FloatArray:
    return of_links[..., link] if link >= 0 else np.zeros(of_links.shape[:-1], dtype=of_links.dtype)


def _direction(y: Values, x: Values) -> Values:
    """The angle of (x, y)."""
    square = x.value**2 + y.value**2
    known = x.rate is not None and y.rate is not None
    rate = (x.value * y.rate - y.value * x.rate) / square if known else None  # type: ignore[operator]
    value = np.arctan2(y.value, x.value)
    size = (np.abs(x.value) * y.size + np.abs(y.value) * x.size) / square + np.abs(value)
    return Values(value, rate, size)
