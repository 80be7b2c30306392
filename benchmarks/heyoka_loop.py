"""W(n) by heyoka: the equations of motion in its expressions, its Taylor integrator, its function over many states."""

import sys
from importlib import import_module
from typing import Any

import numpy as np
from workload import GRAVITY, INERTIA, LENGTH, MASS, Array


def heyoka() -> Any:
    """The package; ends the program with advice where there is none."""
    try:
        return import_module("heyoka")
    except ModuleNotFoundError:
        sys.exit("heyoka is not installed; run: python -m pip install -e .[peers]")


def equations(n: int) -> list[tuple[Any, Any]]:
    """dy/dt of W(n) in y = (q, u), each (n + 2,): the position of joint 0 and the angles of all links; their rates."""
    hy = heyoka()
    q = hy.make_vars("x", "y", *(f"angle_{k}" for k in range(n)))
    u = hy.make_vars("v_x", "v_y", *(f"rate_{k}" for k in range(n)))
    return [*zip(q, u, strict=True), *zip(u, _accelerations(hy, n, q[2:], u[2:]), strict=True)]


def integrator(y: Array, tolerance: float, events: list[Any] | None = None) -> Any:
    """heyoka's adaptive Taylor integrator of W(n) from y (2 n + 4,); fully unrolled, which is its fastest form."""
    more = {"t_events": events} if events else {}
    return heyoka().taylor_adaptive(equations(len(y) // 2 - 2), np.array(y), tol=tolerance, **more)


def exact_end(y: Array, until: float) -> Array:
    """The state of W(n) at `until` from y at 0, flown in 80 bits to 1e-20."""
    wide = np.longdouble
    start = np.array(y, dtype=wide)
    pairs = equations(len(y) // 2 - 2)
    exact = heyoka().taylor_adaptive(pairs, start, tol=wide(1e-20), fp_type=wide, compact_mode=True)
    exact.propagate_until(wide(until))
    return exact.state.astype(np.float64)


def function(n: int) -> Any:
    """heyoka's compiled accelerations, called with y (2 n + 4, states) and `outputs=` (n + 2, states)."""
    pairs = equations(n)
    return heyoka().cfunc([right for _, right in pairs[n + 2 :]], vars=[left for left, _ in pairs])


def _accelerations(hy: Any, n: int, angles: Any, rates: Any) -> list[Any]:
    """du/dt with constant data: joint forces by elimination in A M^-1 A^T, joint after joint, then Newton-Euler."""
    arms = [(LENGTH / 2 * hy.cos(angle), LENGTH / 2 * hy.sin(angle)) for angle in angles]
    turned = [(-y, x) for x, y in arms]
    squares = [rate * rate for rate in rates]
    matrix: dict[tuple[int, int], Any] = {}
    right = []
    for k in range(n):
        for a in range(2):
            right.append(squares[k - 1] * arms[k - 1][a] + squares[k] * arms[k][a])
            for b in range(2):
                own = (turned[k - 1][a] * turned[k - 1][b] + turned[k][a] * turned[k][b]) / INERTIA
                between = turned[k][a] * turned[k][b] / INERTIA
                matrix[2 * k + a, 2 * k + b] = own + 2.0 / MASS if a == b else own
                row, column = 2 * k + a, 2 * ((k + 1) % n) + b
                matrix[row, column] = matrix[column, row] = between - 1.0 / MASS if a == b else between
    forces = _solve(matrix, right)
    at = [(forces[2 * k], forces[2 * k + 1]) for k in range(n)]
    after = [*at[1:], at[0]]
    spins = [
        (turned[k][0] * (at[k][0] + after[k][0]) + turned[k][1] * (at[k][1] + after[k][1])) / INERTIA for k in range(n)
    ]
    x = (after[0][0] - at[0][0]) / MASS + spins[0] * arms[0][1] + squares[0] * arms[0][0]
    y = (after[0][1] - at[0][1]) / MASS - GRAVITY - spins[0] * arms[0][0] + squares[0] * arms[0][1]
    return [x, y, *spins]


def _solve(matrix: dict[tuple[int, int], Any], right: list[Any]) -> list[Any]:
    """Solution of a symmetric sparse system of expressions, eliminated in the order of its rows."""
    size = len(right)
    x = list(right)
    pivots, below = [], []
    for p in range(size):
        pivots.append(1.0 / matrix[p, p])
        below.append([j for j in range(p + 1, size) if (p, j) in matrix])
        for j in below[p]:
            factor = matrix[p, j] * pivots[p]
            x[j] = x[j] - factor * x[p]
            for i in below[p]:
                if i <= j:
                    less = factor * matrix[p, i]
                    matrix[i, j] = matrix[j, i] = matrix[i, j] - less if (i, j) in matrix else -less
    for p in reversed(range(size)):
        total = x[p]
        for j in below[p]:
            total = total - matrix[p, j] * x[j]
        x[p] = total * pivots[p]
    return x
