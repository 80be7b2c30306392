"""The record that the derivation hands on: every quantity a named assignment, in the order of the derivation."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ..mechanism.links import Parameter
from .names import State

GUARD = 1e-6
"""The fraction of its scale that a guard's pivot must exceed: below, the state is solved on another way."""

OTHERWISE = "_otherwise"
"""Behind the name of a kernel that solves for the same by the plan to go to where the guards of the first fail."""


@dataclass(frozen=True)
class Assignment:
    """``symbol = expression``."""

    symbol: sp.Symbol
    expression: sp.Expr


@dataclass(frozen=True)
class Block:
    """Assignments that belong together, under the heading that a reader sees.

    ``gibbs`` is the Gibbs function of the link the block is about, ``stationary`` the equations ∂V/∂v = 0 that the
    block solves, as (unknown v, ∂V/∂v). Both are for the reader; no kernel evaluates them. ``shared`` assignments
    belong to what modules meet at, even those that read one module alone.
    """

    title: str
    assignments: tuple[Assignment, ...]
    gibbs: Assignment | None = None
    stationary: tuple[Assignment, ...] = ()
    shared: bool = False


@dataclass(frozen=True)
class Argument:
    """A named array argument of a kernel: its symbols in order."""

    name: str
    symbols: tuple[sp.Symbol, ...]
    meaning: str


@dataclass(frozen=True)
class Output:
    """A named array that a kernel fills: one expression per entry, and the text that explains its shape and unit."""

    name: str
    entries: tuple[sp.Expr, ...]
    meaning: str


@dataclass(frozen=True)
class Kernel:
    """A function of the model: what it reads, what it fills, and pivots that must stay away from zero.

    A guard ``(pivot, scale)`` holds while ``pivot > GUARD * scale``; where one fails, the kernel called ``otherwise``
    solves for the same in another order, and where that has failed or there is none, the closure rows lose rank.
    Of the inputs and outputs named in ``columns`` there are as many, one behind the other, as the caller asks for.
    The output named in ``asked`` is computed only where the caller has room for it.
    """

    name: str
    inputs: tuple[Argument, ...]
    outputs: tuple[Output, ...]
    purpose: str
    guards: tuple[tuple[sp.Expr, sp.Expr], ...] = ()
    otherwise: str | None = None
    columns: tuple[str, ...] = ()
    asked: str | None = None


@dataclass(frozen=True)
class ContactName:
    """A contact as a scene calls it: the point (of a stop: the joint), and what it touches; ``angular`` is a stop, and
    ``slides`` one of a joint that slides. It is there while one of ``whiles`` is so: parameters, each with whether it
    is 1 or 0 then."""

    point: str
    ground: str
    angular: bool
    slides: bool
    whiles: tuple[tuple[tuple[str, bool], ...], ...] = ((),)


@dataclass(frozen=True)
class OutputName:
    """A number that runs tell of an effect, as they call it, ``motor_0.torque``, and its ``unit``; the name of the
    ``link`` that a force acts on, where its own does not have it."""

    name: str
    unit: str
    link: str = ""


@dataclass(frozen=True)
class Equations:
    """All equations of a model. Checks that each name is defined once and before use, and each output is defined.

    ``folded`` are parameters whose values stand in the equations as numbers; ``modules`` are the coordinates and rates
    of sets of links that may be equal modules. ``rated`` tells of each event indicator whether it has a rate, 1 or 0.
    """

    parameters: tuple[Parameter, ...]
    state: State
    blocks: tuple[Block, ...]
    kernels: tuple[Kernel, ...]
    contacts: tuple[ContactName, ...] = ()
    folded: tuple[Parameter, ...] = ()
    modules: tuple[tuple[sp.Symbol, ...], ...] = ()
    outputs: tuple[OutputName, ...] = ()
    rated: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        known = {sp.Symbol(p.symbol) for p in self.parameters}
        if len(known) != len(self.parameters):
            raise ValueError("two parameters share a symbol")
        arguments = {s for kernel in self.kernels for argument in kernel.inputs for s in argument.symbols}
        if known & arguments:
            raise ValueError(f"both a parameter and an argument: {', '.join(sorted(map(str, known & arguments)))}")
        known |= arguments
        defined: set[sp.Symbol] = set()
        for assignment in self.assignments():
            if assignment.symbol in defined or assignment.symbol in known:
                raise ValueError(f"{assignment.symbol} is defined twice")
            unknown = assignment.expression.free_symbols - known - defined
            if unknown:
                raise ValueError(f"{assignment.symbol} uses undefined {', '.join(sorted(map(str, unknown)))}")
            defined.add(assignment.symbol)
        for kernel in self.kernels:
            for output in kernel.outputs:
                for entry in output.entries:
                    unknown = entry.free_symbols - known - defined
                    if unknown:
                        raise ValueError(f"{kernel.name}: {output.name} uses undefined {sorted(map(str, unknown))}")
            unknown = {s for guard in kernel.guards for entry in guard for s in entry.free_symbols} - known - defined
            if unknown:
                raise ValueError(f"{kernel.name}: a guard uses undefined {sorted(map(str, unknown))}")

    @property
    def lines(self) -> int:
        """Lines that loads have the direction of."""
        return sum(len(kernel.outputs[0].entries) // 2 for kernel in self.kernels if kernel.name == "reaches")

    def assignments(self) -> tuple[Assignment, ...]:
        return tuple(assignment for block in self.blocks for assignment in block.assignments)
