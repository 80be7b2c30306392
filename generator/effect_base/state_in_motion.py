"""Expressions of the state as equations: their values alone, or what events need of them beside these.

The size of a value times the numbers' precision bounds its rounding, first order in it: a running error analysis.
"""

from __future__ import annotations

import ast
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Generic, Protocol, TypeVar, cast

import sympy as sp

from ..derive.indicators import LENGTH, PACE, Indication
from ..derive.motion import Motion
from ..derive.vectors import Vector, dot
from ..equations.step import step
from ..mechanism.mechanism import Mechanism
from .arithmetic import KINKED, value_of
from .grammar_of_state import LAW, RATE
from .piecewise_in_time import Piecewise
from .points import find_point

T = TypeVar("T")
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


class Meaning(Protocol):
    """What a law's name stands for: an expression, the symbols of its ``own`` parameters and its ``curves``, by their
    names."""

    @property
    def own(self) -> Collection[tuple[str, str]]: ...
    @property
    def curves(self) -> Collection[tuple[str, Piecewise]]: ...
    def tree(self) -> ast.expr: ...


class Reading(ABC, Generic[T]):
    """Reads an expression in normal form; the checks were made where it was written. ``name`` begins the names of what
    it consists of; what ``stands`` for a law, or in a table, says what it has of its own."""

    def __init__(self, mechanism: Mechanism, motion: Motion, name: str, stands: Meaning | None = None) -> None:
        self.mechanism, self.motion, self.name, self.named = mechanism, motion, name, 0
        self.own: Mapping[str, str] = dict(stands.own) if stands else {}
        self.curves: Mapping[str, Piecewise] = dict(stands.curves) if stands else {}

    def read(self, node: ast.expr) -> T:
        match node:
            case ast.Constant(value=int() | float() as number):
                return self.constant(sp.Float(number) if isinstance(number, float) else sp.Integer(number))
            case ast.Name(id="pi"):
                return self.constant(PI)
            case ast.Name(id=name) if name in self.own:
                return self.constant(sp.Symbol(self.own[name]))
            case ast.Name():
                return self.time()
            case ast.UnaryOp(op=op, operand=operand):
                inner = self.read(operand)
                return self.negative(inner) if isinstance(op, ast.USub) else inner
            case ast.BinOp(left=left, op=ast.Pow(), right=right):
                return self.power(self.read(left), int(value_of(right, 0.0)))
            case ast.BinOp(left=left, op=op, right=right):
                a, b = self.read(left), self.read(right)
                if isinstance(op, ast.Add | ast.Sub):
                    return self.sum(a, b if isinstance(op, ast.Add) else self.negative(b))
                return self.quotient(a, b) if isinstance(op, ast.Div) else self.product(a, b)
            case ast.Call(func=ast.Name(id=name), args=args):
                return self._called(node, name, args)
        raise ValueError(f"not checked: {ast.dump(node)}")

    def _called(self, node: ast.Call, name: str, args: list[ast.expr]) -> T:
        match args:
            case [ast.Call() as inner] if name == RATE:
                return self.rate_of(inner)
            case [ast.Constant(value=str() as law)] if name == LAW:
                return self.law(law)
            case [first, second] if name == "atan2":
                return self.direction(self.read(first), self.read(second))
            case [first, second] if name in KINKED:
                return self.extreme(node, name, self.read(first), self.read(second))
            case [argument] if name in self.curves:
                return self.curve(node, self.curves[name], self.read(argument))
            case [argument] if name in _FUNCTIONS:
                return self.function(node, name, self.read(argument))
        return self.quantity(name, _names(args))

    @abstractmethod
    def constant(self, value: sp.Expr) -> T: ...
    @abstractmethod
    def time(self) -> T: ...
    @abstractmethod
    def negative(self, a: T) -> T: ...
    @abstractmethod
    def sum(self, a: T, b: T) -> T: ...
    @abstractmethod
    def product(self, a: T, b: T) -> T: ...
    @abstractmethod
    def quotient(self, a: T, b: T) -> T: ...
    @abstractmethod
    def power(self, a: T, exponent: int) -> T: ...
    @abstractmethod
    def function(self, node: ast.Call, name: str, a: T) -> T:
        """A function of one argument."""

    @abstractmethod
    def extreme(self, node: ast.Call, name: str, a: T, b: T) -> T:
        """The least or the greatest of two."""

    @abstractmethod
    def curve(self, node: ast.Call, curve: Piecewise, a: T) -> T:
        """A function that is given by rows."""

    @abstractmethod
    def direction(self, y: T, x: T) -> T:
        """The angle of (x, y)."""

    @abstractmethod
    def quantity(self, kind: str, names: list[str]) -> T:
        """What is asked of the state."""

    @abstractmethod
    def rate_of(self, quantity: ast.Call) -> T:
        """How fast that changes."""

    @abstractmethod
    def law(self, name: str) -> T: ...

    def turning(self, kind: str, names: list[str]) -> tuple[sp.Expr, sp.Expr]:
        """The angle at a joint or of a link, and its rate."""
        motion = self.motion
        first, second = self._sides(names[0]) if kind == "angle" else (-1, self._link(names[0]))
        return motion.angle(second) - motion.angle(first), motion.rate(second) - motion.rate(first)

    def reaching(self, kind: str, names: list[str]) -> tuple[sp.Expr, sp.Expr]:
        """The length along a line or the coordinate of a point, and its rate."""
        motion = self.motion
        if kind == "slide":
            joint = [one.name for one in self.mechanism.joints].index(names[0])
            return motion.joint_position(joint), motion.joint_speed(joint)
        point = find_point(names[0], self.mechanism)[0]
        assert point is not None
        axis = "xy".index(kind)
        return motion.position(point)[axis], motion.velocity(point)[axis]

    def way(self, names: list[str], name: str, rated: bool = True) -> tuple[sp.Expr, sp.Expr]:
        """The distance of two points and, where that is wanted, its rate, both zero where a joint holds them together;
        what it consists of is named by what begins with ``name``."""
        motion = self.motion
        (one, other) = (find_point(name, self.mechanism)[0] for name in names)
        assert one is not None and other is not None
        way = motion.let_vector(f"{name}_way", motion.distance(one, other))
        speed: Vector | None = motion.let_vector(f"{name}_speed", motion.approach(one, other)) if rated else None
        if dot(way, way) == 0:
            return sp.S.Zero, sp.S.Zero
        length = motion.let(f"{name}_length", sp.sqrt(dot(way, way)))
        return length, dot(way, speed) / length if speed else sp.S.Zero

    def _sides(self, joint: str) -> tuple[int, int]:
        """The two links of a joint."""
        found = next(one for one in (*self.mechanism.joints, *self.mechanism.open) if one.name == joint)
        return found.first.link, found.second.link

    def _link(self, name: str) -> int:
        return [link.name for link in self.mechanism.links].index(name)


def _names(args: list[ast.expr]) -> list[str]:
    return [str(one.value) for one in args if isinstance(one, ast.Constant)]


class IndicationReader(Reading[Indication]):
    """What events need of an expression: its value, its rate where that has no accelerations, and its size. Its kinks
    are those of the state itself."""

    def __init__(self, mechanism: Mechanism, motion: Motion, name: str) -> None:
        super().__init__(mechanism, motion, name)
        self.laws: dict[str, Indication] = {}

    def constant(self, value: sp.Expr) -> Indication:
        return Indication(value, sp.S.Zero, sp.Abs(value))

    def time(self) -> Indication:
        return Indication(self.motion.time, sp.S.One, sp.Abs(self.motion.time))

    def negative(self, a: Indication) -> Indication:
        return Indication(-a.value, None if a.rate is None else -a.rate, a.size)

    def sum(self, a: Indication, b: Indication) -> Indication:
        rate = None if a.rate is None or b.rate is None else a.rate + b.rate
        return self._let(a.value + b.value, rate, a.size + b.size)

    def product(self, a: Indication, b: Indication) -> Indication:
        rate = None if a.rate is None or b.rate is None else a.rate * b.value + a.value * b.rate
        return self._let(a.value * b.value, rate, sp.Abs(a.value) * b.size + sp.Abs(b.value) * a.size)

    def quotient(self, a: Indication, b: Indication) -> Indication:
        return self.product(a, self._through(b, lambda x: 1 / x, lambda x: -1 / x**2))

    def power(self, a: Indication, exponent: int) -> Indication:
        if exponent == 0:
            return self.constant(sp.S.One)
        return self._through(a, lambda x: x**exponent, lambda x: exponent * x ** (exponent - 1))

    def function(self, node: ast.Call, name: str, a: Indication) -> Indication:
        return self._through(a, *_FUNCTIONS[name])

    def extreme(self, node: ast.Call, name: str, a: Indication, b: Indication) -> Indication:
        other = self.motion.let(f"{self.name}_{self.named + 1}_side", step(a.value - b.value))
        first = other if name == "max" else 1 - other
        rate = None if a.rate is None or b.rate is None else first * a.rate + (1 - first) * b.rate
        return self._let(first * a.value + (1 - first) * b.value, rate, a.size + b.size)

    def curve(self, node: ast.Call, curve: Piecewise, a: Indication) -> Indication:
        name, let = f"{self.name}_{self.named + 1}", self.motion.let
        x = let(f"{name}_of", a.value)
        begun = {row: step(x - sp.Float(at)) for row, at in curve.jumps(1).items()}
        steep = let(f"{name}_slope", curve.along(x, let, f"{name}_slope", 1, begun))
        value = curve.along(x, let, name, 0, {})
        found = self._let(value, None if a.rate is None else steep * a.rate, sp.Abs(steep) * a.size)
        return Indication(found.value, found.rate, found.size + sp.Abs(found.value))

    def direction(self, y: Indication, x: Indication) -> Indication:
        square = x.value**2 + y.value**2
        behind = PI * step(-x.value) * (1 - 2 * step(-y.value))
        value = sp.atan(y.value / x.value) + behind
        rate = None if x.rate is None or y.rate is None else (x.value * y.rate - y.value * x.rate) / square
        size = (sp.Abs(x.value) * y.size + sp.Abs(y.value) * x.size) / square
        found = self._let(value, rate, size)
        return Indication(found.value, found.rate, found.size + sp.Abs(found.value))

    def quantity(self, kind: str, names: list[str]) -> Indication:
        if kind in ("angle", "direction"):
            value, rate = self.turning(kind, names)
            return self._let(value, rate, sp.Abs(value) + 1)
        if kind == "distance":
            return self._length(*self.way(names, f"{self.name}_{self.named + 1}"))
        return self._length(*self.reaching(kind, names))

    def rate_of(self, quantity: ast.Call) -> Indication:
        found = self.read(quantity)
        assert found.rate is not None
        return self._let(found.rate, None, sp.Abs(found.rate) + found.size / PACE)

    def law(self, name: str) -> Indication:
        """What a law is, as if it stood here."""
        if name in self.laws:
            return self.laws[name]
        stands = cast("Meaning", self.motion.laws[name])
        around = self.own, self.curves
        self.own, self.curves = dict(stands.own), dict(stands.curves)
        found = self.read(stands.tree())
        self.own, self.curves = around
        self.laws[name] = found
        return found

    def _let(self, value: sp.Expr, rate: sp.Expr | None, size: sp.Expr) -> Indication:
        """The same with names for what is long."""
        self.named += 1
        let, name = self.motion.let, f"{self.name}_{self.named}"
        found = let(name, value)
        return Indication(found, rate if rate is None else let(f"{name}_rate", rate), let(f"{name}_size", size))

    def _through(self, a: Indication, function: _Unary, slope: _Unary) -> Indication:
        """A function of one value, with its derivative."""
        steep = self.motion.let(f"{self.name}_{self.named + 1}_slope", slope(a.value))
        found = self._let(function(a.value), None if a.rate is None else steep * a.rate, sp.Abs(steep) * a.size)
        return Indication(found.value, found.rate, found.size + sp.Abs(found.value))

    def _length(self, value: sp.Expr, rate: sp.Expr) -> Indication:
        found = self._let(value, rate, LENGTH)
        return Indication(found.value, found.rate, sp.Abs(found.value) + LENGTH)


class ValueReader(Reading[sp.Expr]):
    """The value of an expression, with names for its functions and lengths.

    Its ``kinks`` have the ``sides`` that the run holds, by their names in the same order; where that is ``None``, as in
    functions that tell these sides, the expression has the kinks of the state itself."""

    def __init__(
        self,
        mechanism: Mechanism,
        motion: Motion,
        name: str,
        stands: Meaning,
        kinks: Sequence[tuple[ast.Call, tuple[float, ...]]],
        sides: tuple[str, ...] | None,
    ) -> None:
        super().__init__(mechanism, motion, name, stands)
        self.known: dict[object, sp.Expr] = {}
        self.held = sides is not None
        left = iter(sides or ())
        self.sides = {ast.dump(call): [next(left) for _ in at] for call, at in kinks if self.held}

    def constant(self, value: sp.Expr) -> sp.Expr:
        return value

    def time(self) -> sp.Expr:
        return self.motion.time

    def negative(self, a: sp.Expr) -> sp.Expr:
        return -a

    def sum(self, a: sp.Expr, b: sp.Expr) -> sp.Expr:
        return a + b

    def product(self, a: sp.Expr, b: sp.Expr) -> sp.Expr:
        return a * b

    def quotient(self, a: sp.Expr, b: sp.Expr) -> sp.Expr:
        return a / b

    def power(self, a: sp.Expr, exponent: int) -> sp.Expr:
        return a**exponent

    def function(self, node: ast.Call, name: str, a: sp.Expr) -> sp.Expr:
        if name == "abs":
            a = self._named(a)
            return self._named((2 * self._positive(node, a) - 1) * a)
        return self._named(_FUNCTIONS[name][0](self._named(a)))

    def extreme(self, node: ast.Call, name: str, a: sp.Expr, b: sp.Expr) -> sp.Expr:
        a, b = self._named(a), self._named(b)
        first = self._positive(node, a - b)
        if name == "min":
            first = 1 - first
        return self._named(first * a + (1 - first) * b)

    def curve(self, node: ast.Call, curve: Piecewise, a: sp.Expr) -> sp.Expr:
        x = self._named(a)
        sides = self.sides.get(ast.dump(node))

        def away(row: int, since: sp.Expr) -> sp.Expr:
            return sp.Abs(since) if sides is None else (2 * self.motion.side(sides[row]) - 1) * since

        name = f"{self.name}_{self.named + 1}"
        return self._once(ast.dump(node), lambda: curve.along(x, self.motion.let, name, 0, {}, away))

    def direction(self, y: sp.Expr, x: sp.Expr) -> sp.Expr:
        x, y = self._named(x), self._named(y)
        return self._named(2 * sp.atan(y / (sp.sqrt(x**2 + y**2) + x)))

    def quantity(self, kind: str, names: list[str]) -> sp.Expr:
        return self._once(f"{kind}({names})", lambda: self._asked(kind, names, rated=False)[0])

    def rate_of(self, quantity: ast.Call) -> sp.Expr:
        kind, names = cast("ast.Name", quantity.func).id, _names(quantity.args)
        return self._once(f"{RATE}({kind}({names}))", lambda: self._asked(kind, names, rated=True)[1])

    def law(self, name: str) -> sp.Expr:
        return self.motion.law(name, self.held)

    def _asked(self, kind: str, names: list[str], rated: bool) -> tuple[sp.Expr, sp.Expr]:
        if kind in ("angle", "direction"):
            return self.turning(kind, names)
        if kind == "distance":
            return self.way(names, f"{self.name}_{self.named + 1}", rated)
        return self.reaching(kind, names)

    def _positive(self, node: ast.Call, value: sp.Expr) -> sp.Expr:
        """1 where what a kink is about is positive, else 0."""
        sides = self.sides.get(ast.dump(node))
        return step(self._named(value)) if sides is None else self.motion.side(sides[0])

    def _named(self, value: sp.Expr) -> sp.Expr:
        """The same by a name, where it is more than one."""
        return self._once(value, lambda: value)

    def _once(self, key: object, make: Callable[[], sp.Expr]) -> sp.Expr:
        if key not in self.known:
            value = make()
            self.named += 1
            self.known[key] = self.motion.let(f"{self.name}_{self.named}", value)
        return self.known[key]
