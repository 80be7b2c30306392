"""What the equations of motion miss by, in one function: the start of their derivatives (theory, eq. 11.2).

Accelerations and multipliers solve M u̇ + h̄ = Aᵀ λ, A u̇ + Ȧ u = 0, whatever way they are found on, and the jumps of an
impact M Δu = Aᵀ Λ + f, A Δu = y. So derivatives of the solutions solve the same systems, with the derivatives of what
these miss by where the solution is held fixed.
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from ..equations.equations import Equations, Kernel, Output
from .program import Function, function_of

RESIDUAL, JUMP = "residual", "jump"


def residuals(equations: Equations) -> tuple[Function, ...]:
    """The functions ``residual`` (of flight) and ``jump`` (of an impact).

    Each has two outputs: ``f`` (nu), what is left of the generalized forces, and ``y`` (rows), what is left of the
    closure's accelerations or rates, both as the right-hand sides on which a correction follows.
    """
    kernels = {kernel.name: kernel for kernel in equations.kernels}
    inverse, momentum = kernels["inverse_dynamics"], kernels["momentum"]
    pushed = next(a for a in kernels["reactions"].inputs if a.name == "lambda")
    u_dot, jumps = inverse.inputs[-1], momentum.inputs[1]
    jacobian = kernels["closure_jacobian"].outputs[0].entries
    bias = kernels["closure_bias"].outputs[0].entries
    forces = _forces(inverse.outputs[0].entries, jacobian, pushed.symbols)
    rows = [-(row + more) for row, more in zip(_rates(jacobian, u_dot.symbols), bias, strict=True)]
    impulses = _forces(momentum.outputs[0].entries, jacobian, pushed.symbols)
    flight = Kernel(
        RESIDUAL, (*inverse.inputs, pushed), _outputs(forces, rows), "A^T lambda - M u_dot - h, -A u_dot - dA/dt u"
    )
    rates = [-row for row in _rates(jacobian, jumps.symbols)]
    jump = Kernel(JUMP, (*momentum.inputs, pushed), _outputs(impulses, rates), "A^T Lambda - M du, -A du")
    return function_of(equations, flight), function_of(equations, jump)


def _outputs(forces: Sequence[sp.Expr], rows: Sequence[sp.Expr]) -> tuple[Output, ...]:
    return (
        Output("f", tuple(forces), "what is left of the generalized forces"),
        Output("y", tuple(rows), "what is left of the closure's accelerations, or rates"),
    )


def _forces(own: Sequence[sp.Expr], A: Sequence[sp.Expr], multipliers: Sequence[sp.Symbol]) -> list[sp.Expr]:
    """What the multipliers leave of the forces that the motion needs."""
    n = len(own)
    return [sp.Add(*(A[r * n + i] * x for r, x in enumerate(multipliers)), -own[i]) for i in range(n)]


def _rates(A: Sequence[sp.Expr], x: Sequence[sp.Symbol]) -> list[sp.Expr]:
    """A x, row by row."""
    n = len(x)
    return [sp.Add(*(A[start + i] * x[i] for i in range(n))) for start in range(0, len(A), n)]
