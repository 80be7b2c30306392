"""The program of a model: for every kernel just the assignments it needs, in the order of the derivation.

What depends on parameters alone is computed once per parameter set, in the program's constants.
"""

from __future__ import annotations

import heapq
import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import astuple, dataclass

import sympy as sp

from ..equations.equations import Assignment, Block, Equations, Kernel
from ..mechanism.links import Parameter
from .response import responses
from .slices import Slicer


@dataclass(frozen=True)
class Section:
    """Assignments under one heading; ``shared`` ones belong to no module."""

    title: str
    assignments: tuple[Assignment, ...]
    shared: bool = False


@dataclass(frozen=True)
class Counts:
    """Operations of a kernel: sums, products, quotients (square roots too), angles (a sine and a cosine each).

    ``functions`` are the others: tan, atan, exp, log, tanh. A difference of two counts may be negative.
    """

    sums: int = 0
    products: int = 0
    quotients: int = 0
    angles: int = 0
    functions: int = 0

    @property
    def total(self) -> int:
        """Operations besides the sines and cosines and other functions."""
        return self.sums + self.products + self.quotients

    def __add__(self, other: Counts) -> Counts:
        return Counts(*(a + b for a, b in zip(astuple(self), astuple(other), strict=True)))

    def __sub__(self, other: Counts) -> Counts:
        return Counts(*(a - b for a, b in zip(astuple(self), astuple(other), strict=True)))

    def __str__(self) -> str:
        kinds = ((self.sums, "sum"), (self.products, "product"), (self.quotients, "quotient"))
        angles = f"{self.angles} sine{'s with their cosines' if self.angles != 1 else ' with its cosine'}"
        others = f" and {_counted(self.functions, 'other function')}" if self.functions else ""
        listed = ", ".join(_counted(*kind) for kind in kinds)
        return f"{_counted(self.total, 'operation')} ({listed}) and {angles}{others}"


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'s' * (number != 1)}"


@dataclass(frozen=True)
class Function:
    """One kernel, ready to be written out. Checks that every name is defined before use and every output assigned."""

    kernel: Kernel
    sections: tuple[Section, ...]
    constants: tuple[sp.Symbol, ...]

    def __post_init__(self) -> None:
        known = set(self.constants)
        for argument in self.kernel.inputs:
            known.update(argument.symbols)
        for assignment in self.assignments():
            missing = assignment.expression.free_symbols - known
            if missing:
                raise ValueError(f"{self.kernel.name}: {assignment.symbol} uses undefined {sorted(map(str, missing))}")
            if assignment.symbol in known:
                raise ValueError(f"{self.kernel.name}: {assignment.symbol} is defined twice")
            known.add(assignment.symbol)
        for output in self.kernel.outputs:
            for entry in output.entries:
                if not entry.free_symbols <= known:
                    raise ValueError(f"{self.kernel.name}: an entry of {output.name} is not defined")
        for guard in self.kernel.guards:
            if not all(entry.free_symbols <= known for entry in guard):
                raise ValueError(f"{self.kernel.name}: a guard is not defined")

    def assignments(self) -> tuple[Assignment, ...]:
        return tuple(a for section in self.sections for a in section.assignments)

    def inputs_used(self) -> tuple[tuple[str, int, sp.Symbol], ...]:
        """Inputs that the kernel reads: argument name, index, symbol."""
        used = self._used()
        return tuple(
            (argument.name, index, s)
            for argument in self.kernel.inputs
            for index, s in enumerate(argument.symbols)
            if s in used
        )

    def _used(self) -> set[sp.Symbol]:
        used = {s for output in self.kernel.outputs for entry in output.entries for s in entry.free_symbols}
        return used.union(*(a.expression.free_symbols for a in self.assignments()))

    def longest_chain(self) -> int:
        """Operations on the longest chain in which each waits for the one before: what is left with units without end.

        Sums and products take what is ready first, two at a time; sines and cosines are there at the start.
        """
        ready: dict[sp.Symbol, int] = {}
        for a in self.assignments():
            ready[a.symbol] = _chain(a.expression, ready)
        return max((_chain(e, ready) for output in self.kernel.outputs for e in output.entries), default=0)

    def counts(self) -> Counts:
        """Operations of one evaluation."""
        expressions = [a.expression for a in self.assignments()]
        expressions += [entry for output in self.kernel.outputs for entry in output.entries]
        return count(expressions)


@dataclass(frozen=True)
class Program:
    """Parameters, constants derived from them, and one function per kernel.

    ``modules`` are sets of coordinates and rates, those of modules of the mechanism that may be equal.
    """

    parameters: tuple[Parameter, ...]
    constants: tuple[Assignment, ...]
    functions: tuple[Function, ...]
    modules: tuple[tuple[sp.Symbol, ...], ...] = ()

    def __post_init__(self) -> None:
        known = {sp.Symbol(p.symbol) for p in self.parameters}
        for assignment in self.constants:
            if not assignment.expression.free_symbols <= known:
                raise ValueError(f"constant {assignment.symbol} is not made from parameters")
            if assignment.symbol in known:
                raise ValueError(f"constant {assignment.symbol} is defined twice")
            known.add(assignment.symbol)

    def function(self, name: str) -> Function:
        """The kernel's function (``KeyError`` when the model has none of that name)."""
        for function in self.functions:
            if function.kernel.name == name:
                return function
        raise KeyError(name)


def lower(equations: Equations) -> Program:
    """Slice the equations into one function per kernel, and join those that answer impulses of contacts."""
    slicer = Slicer(equations)
    wanted = [(kernel, tuple(slicer.blocks(_roots(kernel)))) for kernel in equations.kernels]
    wanted += responses(equations).values()
    ordered = [sp.Symbol(p.symbol) for p in equations.parameters] + [a.symbol for a in slicer.constants]
    functions = tuple(_function(kernel, blocks, ordered) for kernel, blocks in wanted)
    used = {s for function in functions for s in function.constants}
    needed = slicer.needed(used)
    constants = tuple(a for a in slicer.constants if a.symbol in needed)
    return Program(equations.parameters, constants, functions, equations.modules)


def function_of(equations: Equations, kernel: Kernel) -> Function:
    """The function of a kernel that is made of the quantities of the equations, and is none of theirs."""
    slicer = Slicer(equations)
    ordered = [sp.Symbol(p.symbol) for p in equations.parameters] + [a.symbol for a in slicer.constants]
    return _function(kernel, slicer.blocks(_roots(kernel)), ordered)


def _function(kernel: Kernel, blocks: Iterable[Block], ordered: Iterable[sp.Symbol]) -> Function:
    """A kernel with its blocks; ``ordered`` are all that depends on parameters alone."""
    sections = tuple(Section(block.title, block.assignments, block.shared) for block in blocks)
    direct = {s for section in sections for a in section.assignments for s in a.expression.free_symbols}
    direct |= {s for entry in _roots(kernel) for s in entry.free_symbols}
    return Function(kernel, sections, tuple(s for s in ordered if s in direct))


def _roots(kernel: Kernel) -> list[sp.Expr]:
    """What a kernel must compute."""
    return [entry for output in kernel.outputs for entry in output.entries] + [e for g in kernel.guards for e in g]


def count(expressions: Iterable[sp.Expr]) -> Counts:
    """Operations as they are written out: signs, steps and absolute values are free, an integer power is products."""
    tally: Counter[str] = Counter()
    angles: set[sp.Expr] = set()
    for expression in expressions:
        angles |= {function.args[0] for function in expression.atoms(sp.sin, sp.cos)}
        parts = sp.preorder_traversal(expression)
        tally["function"] += sum(e.func in (sp.tan, sp.atan, sp.exp, sp.log, sp.tanh) for e in parts)
        _count(expression, tally)
    return Counts(tally["sum"], tally["product"], tally["quotient"], len(angles), tally["function"])


def _chain(e: sp.Expr, ready: Mapping[sp.Symbol, int]) -> int:
    """Operations before the value of ``e`` is there, those before its symbols included."""
    if e.is_Symbol:
        return ready.get(e, 0)
    if e.is_Add:
        return _two_at_a_time(_chain(a, ready) for a in e.args)
    if e.is_Mul:
        factors = [a for a in e.args if a not in (1, -1)]
        under = [a for a in factors if a.is_Pow and a.exp.is_negative]
        above = _two_at_a_time(_chain(a, ready) for a in factors if a not in under)
        if not under:
            return above
        below = _two_at_a_time(_chain(sp.Pow(a.base, -a.exp), ready) for a in under)
        return max(above, below) + 1
    if e.is_Pow:
        steps = math.ceil(math.log2(abs(e.exp))) if e.exp.is_Integer else 1
        return _chain(e.base, ready) + steps + int(bool(e.exp.is_negative))
    return max((_chain(a, ready) for a in e.args), default=0)


def _two_at_a_time(waits: Iterable[int]) -> int:
    """When a sum or a product is there, whose entries are there after ``waits``."""
    heap = list(waits)
    heapq.heapify(heap)
    while len(heap) > 1:
        heapq.heappop(heap)
        heapq.heapreplace(heap, heap[0] + 1)
    return heap[0] if heap else 0


def _count(e: sp.Expr, tally: Counter[str]) -> None:
    if e.is_Add:
        tally["sum"] += len(e.args) - 1
    elif e.is_Mul:
        factors = [a for a in e.args if a not in (1, -1)]
        divisors = [a for a in factors if a.is_Pow and a.exp.is_negative]
        tally["product"] += len(factors) - 1 - len(divisors)
        tally["quotient"] += len(divisors)
        for a in divisors:
            factors.remove(a)
            _count(sp.Pow(a.base, -a.exp), tally)
        for a in factors:
            _count(a, tally)
        return
    elif e.is_Pow:
        if e.exp.is_Integer:
            tally["product"] += abs(int(e.exp)) - 1
            tally["quotient"] += int(bool(e.exp.is_negative))
        else:
            tally["quotient"] += 1 + int(bool(e.exp.is_negative))
        _count(e.base, tally)
        return
    for a in e.args:
        _count(a, tally)
