"""Problems on cones: conditions of optimality on random and on degenerate data, and the same by SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog, nnls  # type: ignore[import-untyped]

from ccgen.runtime.analysis.cones import farthest, least_distance, nonnegative

RNG = np.random.default_rng(7)
SIZES = [(m, n) for m in (1, 2, 4, 6) for n in (1, 3, 7, 11)]


def columns(m: int, n: int, kind: str) -> np.ndarray:
    """Random ones, or some that are equal, opposite or zero."""
    found = RNG.standard_normal((m, n))
    return found if kind == "general" else np.round(found)


@pytest.mark.parametrize("kind", ["general", "degenerate"])
@pytest.mark.parametrize(("m", "n"), SIZES)
def test_least_squares_have_no_negative_part(m: int, n: int, kind: str) -> None:
    for reachable in (False, True):
        a = columns(m, n, kind)
        b = a @ np.maximum(RNG.standard_normal(n), 0.0) if reachable else RNG.standard_normal(m)
        x = nonnegative(a, b)
        left = b - a @ x
        assert x.min() >= 0.0
        assert np.max(a.T @ left) <= 1e-11 and abs(x @ (a.T @ left)) <= 1e-11
        assert np.linalg.norm(left) == pytest.approx(nnls(a, b)[1], abs=1e-11)
        taken = a[:, x > 0.0]
        assert (np.linalg.matrix_rank(taken) if taken.size else 0) == np.sum(x > 0.0)


@pytest.mark.parametrize("kind", ["general", "degenerate"])
@pytest.mark.parametrize(("m", "n"), SIZES)
def test_the_nearest_point_of_a_polyhedron(m: int, n: int, kind: str) -> None:
    for reachable in (False, True):
        g = columns(n, m, kind)
        h = g @ RNG.standard_normal(m) - RNG.integers(0, 2, n) * RNG.random(n) if reachable else RNG.standard_normal(n)
        x = least_distance(g, h)
        feasible = linprog(np.zeros(m), A_ub=-g, b_ub=-h, bounds=(None, None)).status == 0
        assert (x is not None) == feasible
        if x is not None:
            assert np.min(g @ x - h) >= -1e-9
            active = np.abs(g @ x - h) <= 1e-8
            assert (nnls(g[active].T, x)[1] if np.any(active) else np.linalg.norm(x)) <= 1e-8


@pytest.mark.parametrize("kind", ["general", "degenerate"])
@pytest.mark.parametrize(("m", "n"), SIZES)
def test_linear_functions_go_as_far_as_in_a_linear_programme(m: int, n: int, kind: str) -> None:
    a, c = columns(m, n, kind), RNG.standard_normal(n)
    x = nonnegative(a, a @ np.maximum(RNG.standard_normal(n), 0.0))
    value, y = farthest(a, x, c)
    known = linprog(-c, A_eq=a, b_eq=a @ x, bounds=(0.0, None))
    assert np.max(np.abs(a @ (y - x))) <= 1e-9 * (1.0 + np.max(y)) and y.min() >= 0.0
    assert value == pytest.approx(-known.fun if known.status == 0 else np.inf, rel=1e-8, abs=1e-8)
