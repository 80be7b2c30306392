"""The ledger of a derivation: named assignments in the order in which they come about, in titled blocks."""

from __future__ import annotations

from collections.abc import Callable

import sympy as sp

from .equations import Assignment, Block


class Ledger:
    """Collects assignments in order while the derivation runs; :meth:`let` names what is worth a name."""

    def __init__(self) -> None:
        self.blocks: list[Block] = []
        self._open: list[Assignment] = []
        self._gibbs: Assignment | None = None
        self._stationary: list[Assignment] = []
        self._written: dict[str, sp.Expr] = {}
        self.mark = ""

    def let(self, name: str, expression: sp.Expr) -> sp.Expr:
        """A symbol for ``expression``; numbers, symbols and negated symbols stand for themselves.

        While there is a ``mark``, what another plan of elimination has named otherwise gets it behind its name.
        """
        if expression.is_Number or expression.is_Symbol or (-expression).is_Symbol:
            return expression
        if self.mark and self._written.get(name, expression) != expression:
            name += self.mark
        symbol = sp.Symbol(name)
        if name not in self._written:
            self._written[name] = expression
            self._open.append(Assignment(symbol, expression))
        elif self._written[name] != expression:
            raise ValueError(f"{name} is defined twice")
        return symbol

    def once(self, name: str, make: Callable[[], sp.Expr]) -> sp.Expr:
        """The same of what ``make`` says, which is not asked where the name is written down: for long expressions."""
        return sp.Symbol(name) if name in self and not self.mark else self.let(name, make())

    def __contains__(self, name: str) -> bool:
        """Whether a quantity of this name is written down."""
        return name in self._written

    def let_vector(self, name: str, vector: tuple[sp.Expr, sp.Expr]) -> tuple[sp.Expr, sp.Expr]:
        return (self.let(f"{name}_x", vector[0]), self.let(f"{name}_y", vector[1]))

    def show_gibbs_function(self, symbol: sp.Symbol, expression: sp.Expr) -> None:
        """The Gibbs function of the link that the current block is about."""
        self._gibbs = Assignment(symbol, expression)

    def remark(self, unknown: sp.Symbol, equation: sp.Expr) -> None:
        """An equation ``0 = equation`` that the current block solves for ``unknown``."""
        self._stationary.append(Assignment(unknown, equation))

    def close(self, title: str, shared: bool = False) -> None:
        """End the current block under ``title``; an empty one is dropped."""
        if self._open:
            title = f"otherwise, {title}" if self.mark else title
            self.blocks.append(Block(title, tuple(self._open), self._gibbs, tuple(self._stationary), shared))
        self._open, self._gibbs, self._stationary = [], None, []
