"""Derivatives of a routine, line by line: forward mode (A. Griewank, A. Walther, Evaluating Derivatives, 2008, ch. 3).

Every line v = φ(v₁, v₂, …) gets one behind it, δv = Σ ∂φ/∂vᵢ δvᵢ, where any vᵢ moves at all (theory, eq. 11.1). The
partial derivatives are numbers at the state, the tangents δ are vectors of as many directions as there are lanes. So
the lines of the values stand in front, once, and those of the tangents in a loop over blocks of directions.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from .rolling import Lines, Loop
from .routine import Routine
from .terms import (
    ONE,
    ZERO,
    Assign,
    Call,
    Element,
    Guard,
    Leaf,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Sum,
    Term,
    leaves,
)

PREFIX = "delta_"
"""Before the name of a quantity: its tangents."""

RESULT = "tangent"
"""The array that takes the tangents of all outputs, one output behind the other."""

SHORT = 6
"""Fewer angles than this are written one by one."""

TWO = Number(Fraction(2))


@dataclass(frozen=True)
class Tangent:
    """The tangents of a routine's outputs, as the ``given`` arguments move: those in ``moving`` are read.

    ``values`` and ``loads`` are the statements of the routine that the tangents need, ``statements`` those of the
    tangents, which declare ``arrays`` (name, size) of them; ``results`` is the number of outputs.
    """

    routine: Routine
    name: str
    given: tuple[str, ...]
    moving: tuple[str, ...]
    values: tuple[Lines | Loop, ...]
    value_arrays: tuple[tuple[str, int], ...]
    loads: tuple[Assign, ...]
    statements: tuple[Lines | Loop, ...]
    arrays: tuple[tuple[str, int], ...]
    outputs: tuple[Assign, ...]
    results: int
    read: frozenset[str]

    @property
    def vanishes(self) -> bool:
        """Whether no output moves."""
        return all(line.value == ZERO for line in self.outputs)


def tangent(routine: Routine, name: str, given: Sequence[str]) -> Tangent:
    """The derivative of a ``routine``, whose loops go over links alone, along directions in its arguments ``given``."""
    return _Differentiation(routine, name, tuple(given)).tangent()


def tangent_of_line(line: Assign, moving: Iterable[str]) -> Assign:
    """The line of the tangents behind a line, where the names and arrays ``moving`` have any."""
    rules = _Rules(set(moving), {})
    return Assign(_delta(line.target), rules.derivative(line.value) or ZERO)


def _delta(leaf: Leaf) -> Leaf:
    """The tangents of a quantity."""
    return Name(PREFIX + leaf.name) if isinstance(leaf, Name) else replace(leaf, array=PREFIX + leaf.array)


def _label(leaf: Leaf) -> str:
    """The name of a quantity, or of the array that it lies in."""
    return leaf.name if isinstance(leaf, Name) else leaf.array


class _Rules:
    """The derivative of every kind of term. ``active`` are names and arrays that move, ``loaded`` where names lie."""

    def __init__(self, active: set[str], loaded: dict[str, Leaf]) -> None:
        self.active, self.loaded = active, loaded

    def derivative(self, term: Term) -> Term | None:
        """The tangents of a term, ``None`` where it does not move."""
        match term:
            case Name() | Element():
                leaf = self.loaded.get(_label(term), term) if isinstance(term, Name) else term
                return _delta(leaf) if _label(leaf) in self.active else None
            case Negative(inner):
                moved = self.derivative(inner)
                return None if moved is None else Negative(moved)
            case Sum(parts):
                return _sum([d for d in map(self.derivative, parts) if d is not None])
            case Product():
                return self._product(term)
            case Power(base, exponent):
                moved = self.derivative(base)
                lower = Power(base, exponent - 1) if exponent > 2 else base
                return None if moved is None else Product((Number(Fraction(exponent)), lower, moved))
            case Call(function, argument):
                moved = None if function == "step" else self.derivative(argument)
                return None if moved is None else _called(function, argument, term, moved)
        return None

    def _product(self, product: Product) -> Term | None:
        """Σ over the factors, and over the divisors, of the others times what each moves by."""
        found: list[Term] = []
        for i, factor in enumerate(product.factors):
            moved = self.derivative(factor)
            if moved is not None:
                others = product.factors[:i] + product.factors[i + 1 :]
                found.append(_scaled(others, product.under, moved))
        for divisor in product.under:
            moved = self.derivative(divisor)
            if moved is not None:
                found.append(Negative(_scaled(product.factors, (*product.under, divisor), moved)))
        return _sum(found)


def _scaled(factors: tuple[Term, ...], under: tuple[Term, ...], moved: Term) -> Term:
    """Tangents times a number: the number is made first."""
    while factors and factors[0] == ONE and len(factors) > 1:
        factors = factors[1:]
    if under:
        return Product((Product(factors or (ONE,), under), moved))
    kept = tuple(factor for factor in factors if factor != ONE)
    return Product((*kept, moved)) if kept else moved


def _sum(parts: list[Term]) -> Term | None:
    if len(parts) < 2:
        return parts[0] if parts else None
    return Sum(tuple(parts))


def _called(function: str, x: Term, value: Term, moved: Term) -> Term:
    """The derivative of a function times what its argument moves by.

    At the kink of the absolute value it is that of the side below zero, as a step is zero there.
    """
    match function:
        case "sin":
            return Product((Call("cos", x), moved))
        case "cos":
            return Negative(Product((Call("sin", x), moved)))
        case "tan":
            return Product((Sum((ONE, Power(value, 2))), moved))
        case "atan":
            return Product((Product((ONE,), (Sum((ONE, Power(x, 2))),)), moved))
        case "exp":
            return Product((value, moved))
        case "log":
            return Product((Product((ONE,), (x,)), moved))
        case "tanh":
            return Product((Sum((ONE, Negative(Power(value, 2)))), moved))
        case "abs":
            return Product((Sum((Product((TWO, Call("step", x))), Negative(ONE))), moved))
        case "sqrt":
            return Product((Product((ONE,), (TWO, value)), moved))
    raise TypeError(f"no derivative of the function {function}")


class _Differentiation:
    def __init__(self, routine: Routine, name: str, given: tuple[str, ...]) -> None:
        self.routine, self.name, self.given = routine, name, given
        loaded = {_label(load.target): load.value for load in routine.loads if isinstance(load.value, (Name, Element))}
        loaded["t"] = Element("t", 0)
        self.rules = _Rules(set(given) | ({"c", "s"} if "q" in given else set()), loaded)
        self.blocks = [block for part in routine.statements for block in _blocks_of(part)]

    def tangent(self) -> Tangent:
        routine = self.routine
        while not self._spread():
            pass
        sizes = {o.name: len(o.entries) for o in routine.function.kernel.outputs}
        starts, total = dict[str, int](), 0
        for output, size in sizes.items():
            starts[output], total = total, total + size
        outputs = self._outputs(starts, total)
        needed = {_label(leaf) for line in outputs for leaf in leaves(line.value)}
        behind = _needed([*self._angles(), *map(self._differentiated, routine.statements)], needed)
        needed |= {_label(leaf) for guard in routine.guards for leaf in _read(guard)}
        values = _needed(routine.statements, needed)
        loads = tuple(load for load in routine.loads if _label(load.target) in needed)
        needed |= {_label(leaf) for load in loads for leaf in leaves(load.value)}
        arrays = dict(routine.arrays)
        angles = len(routine.angles.order)
        arrays_behind = {PREFIX + x: size for x, size in (*arrays.items(), ("c", angles), ("s", angles))}
        return Tangent(
            routine,
            self.name,
            self.given,
            tuple(x for x in self.given if PREFIX + x in needed),
            tuple(values),
            tuple((x, size) for x, size in routine.arrays if x in needed),
            loads,
            tuple(behind),
            tuple((x, size) for x, size in arrays_behind.items() if x in needed and size),
            outputs,
            total,
            frozenset(needed),
        )

    def _spread(self) -> bool:
        """Note what moves because what it is made of does; whether all of it was known."""
        before = len(self.rules.active)
        for block in self.blocks:
            for line in block.lines:
                if self.rules.derivative(line.value) is not None:
                    self.rules.active.add(_label(line.target))
        return len(self.rules.active) == before

    def _outputs(self, starts: dict[str, int], total: int) -> tuple[Assign, ...]:
        found: list[Term] = [ZERO] * total
        for line in self.routine.outputs:
            assert isinstance(line.target, Element)
            found[starts[line.target.array] + line.target.start] = self.rules.derivative(line.value) or ZERO
        return tuple(Assign(Element(RESULT, i), value) for i, value in enumerate(found))

    def _angles(self) -> list[Lines | Loop]:
        """The tangents of the sines and cosines of coordinates."""
        order, first = self.routine.angles.order, self.routine.angles.first
        if not order or "q" not in self.given:
            return []
        title = "sines and cosines"
        if first is not None and len(order) >= SHORT:
            return [Loop(len(order), (Lines(title, _turned(0, first, 1)),), title)]
        return [Lines(title, tuple(line for i, index in enumerate(order) for line in _turned(i, index, 0)))]

    def _differentiated(self, part: Lines | Loop) -> Lines | Loop:
        """The statements of the tangents; in loops with the values that only live there."""
        if isinstance(part, Lines):
            return replace(part, lines=tuple(self._behind(part.lines)), late=False)
        body = []
        for block in part.body:
            own = [line for line in block.lines if isinstance(line.target, Name)]
            body.append(replace(block, lines=(*own, *self._behind(block.lines)), late=False))
        return replace(part, body=tuple(body))

    def _behind(self, lines: Iterable[Assign]) -> Iterable[Assign]:
        for line in lines:
            if _label(line.target) in self.rules.active:
                yield Assign(_delta(line.target), self.rules.derivative(line.value) or ZERO)


def _turned(i: int, index: int, stride: int) -> tuple[Assign, Assign]:
    """The tangents of the cosine and the sine of an angle."""
    c, s, q = Element("c", i, stride), Element("s", i, stride), Element(PREFIX + "q", index, stride)
    return Assign(_delta(c), Negative(Product((s, q)))), Assign(_delta(s), Product((c, q)))


def _read(guard: Guard) -> list[Leaf]:
    return [leaf for entry in (guard.pivot, guard.least) if entry is not None for leaf in leaves(entry)]


def _blocks_of(part: Lines | Loop) -> tuple[Lines, ...]:
    return part.body if isinstance(part, Loop) else (part,)


def _needed(statements: Sequence[Lines | Loop], needed: set[str]) -> list[Lines | Loop]:
    """The statements whose targets are ``needed``, to which what they read is added; from the last to the first."""
    kept: list[Lines | Loop] = []
    for part in reversed(statements):
        if isinstance(part, Lines):
            lines = _needed_lines(part.lines, needed)
            if lines:
                kept.append(replace(part, lines=lines))
            continue
        body: list[Lines] = []
        for _ in range(2):  # a round may read what the one before has written
            body = [replace(block, lines=_needed_here(block.lines, needed)) for block in reversed(part.body)]
        body = [block for block in reversed(body) if block.lines]
        if body:
            kept.append(replace(part, body=tuple(body)))
    return kept[::-1]


def _needed_here(lines: Sequence[Assign], needed: set[str]) -> tuple[Assign, ...]:
    """Those of a block in a loop, whose names are its own."""
    own = {line.target.name for line in lines if isinstance(line.target, Name)}
    outside = needed & own
    needed -= own
    kept = _needed_lines(lines, needed)
    needed -= own
    needed |= outside
    return kept


def _needed_lines(lines: Sequence[Assign], needed: set[str]) -> tuple[Assign, ...]:
    kept = []
    for line in reversed(lines):
        if _label(line.target) in needed:
            kept.append(line)
            needed |= {_label(leaf) for leaf in leaves(line.value)}
    return tuple(reversed(kept))
