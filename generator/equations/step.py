"""The unit step: by it a formula has branches, and its derivatives take the branch that holds."""

from __future__ import annotations

import sympy as sp


class step(sp.Function):  # type: ignore[misc]  # noqa: N801 (spelled as in listings)
    """1 where its argument is positive, else 0; its derivative is zero on either side."""

    nargs = 1

    @classmethod
    def eval(cls, x: sp.Expr) -> sp.Expr | None:
        """The value at a number."""
        if x.is_Number:
            return sp.S.One if x > 0 else sp.S.Zero
        return None

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """Zero: what jumps here is never differentiated across the jump."""
        return sp.S.Zero

    def _latex(self, printer: sp.printing.latex.LatexPrinter) -> str:
        return rf"\mathrm{{step}}\left({printer.doprint(self.args[0])}\right)"
