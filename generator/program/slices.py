"""Slices of the equations: the assignments that expressions need, in the order of the derivation."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import replace

import sympy as sp

from ..equations.equations import Assignment, Block, Equations


class Slicer:
    """Cuts blocks out of equations. What depends on parameters alone is constant, and no part of a slice.

    What divides by something that a gate changes is not: where joints meet at one place that is zero while they hold,
    and is looked at by a guard, whereas constants have to be finite.
    """

    def __init__(self, equations: Equations) -> None:
        self.equations = equations
        self.constant = {sp.Symbol(p.symbol) for p in equations.parameters}
        self.constants: list[Assignment] = []
        self.definitions: dict[sp.Symbol, Assignment] = {}
        gated = {sp.Symbol(p.symbol) for p in equations.parameters if p.domain.whole}
        for assignment in equations.assignments():
            expression = assignment.expression
            changed = not gated.isdisjoint(expression.free_symbols)
            gated |= {assignment.symbol} if changed else set()
            if expression.free_symbols <= self.constant and not (changed and _divides_by(expression, gated)):
                self.constant.add(assignment.symbol)
                self.constants.append(assignment)
            self.definitions[assignment.symbol] = assignment

    def needed(self, roots: Iterable[sp.Expr]) -> set[sp.Symbol]:
        """Every symbol that the roots depend on."""
        found: set[sp.Symbol] = set()
        waiting = [s for entry in roots for s in entry.free_symbols]
        while waiting:
            s = waiting.pop()
            if s not in found:
                found.add(s)
                if s in self.definitions:
                    waiting.extend(self.definitions[s].expression.free_symbols)
        return found

    def blocks(self, roots: Iterable[sp.Expr], done: Collection[sp.Symbol] = ()) -> list[Block]:
        """What the roots need besides constants and what is ``done``."""
        needed = self.needed(roots) - self.constant - set(done)
        found = []
        for block in self.equations.blocks:
            kept = tuple(a for a in block.assignments if a.symbol in needed)
            if kept:
                found.append(replace(block, assignments=kept))
        return found


def _divides_by(expression: sp.Expr, symbols: Collection[sp.Symbol]) -> bool:
    """Whether one of the symbols is in a denominator."""
    powers = (one for one in expression.atoms(sp.Pow) if one.exp.is_negative)
    return any(not one.base.free_symbols.isdisjoint(symbols) for one in powers)
