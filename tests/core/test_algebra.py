"""Linear algebra of the core by itself, against LAPACK's answers."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
import pytest

from ..support.core_functions import Functions

Array = Any
SIZES = (1, 2, 3, 5, 8, 13)


@pytest.fixture(scope="module")
def core(tmp_path_factory: pytest.TempPathFactory) -> Functions:
    return Functions(tmp_path_factory.mktemp("algebra"), "base", "algebra")


def semidefinite(rng: np.random.Generator, n: int, rank: int) -> Array:
    factor = rng.normal(size=(n, rank))
    return factor @ factor.T


@pytest.mark.parametrize("n", SIZES)
def test_cholesky_of_a_part(n: int, core: Functions) -> None:
    """The factor over chosen indices solves with that part of the matrix; a dependent index is said."""
    rng = np.random.default_rng(n)
    W = semidefinite(rng, n, n) + 0.1 * np.eye(n)
    chosen = np.sort(rng.permutation(n)[: max(1, n - 2)]).astype(np.int32)
    part, m = W[np.ix_(chosen, chosen)], len(chosen)
    a, x = np.zeros((m, m)), rng.normal(size=m)
    wanted = np.linalg.solve(part, x)
    assert core.call("cholesky", n, W, m, chosen, 1e-12, a) == 0
    lower = np.tril(a, -1) + np.eye(m)
    assert np.abs(lower @ np.diag(np.diag(a)) @ lower.T - part).max() <= 1e-14 * np.abs(part).max()
    wanted_lower = np.linalg.cholesky(part)
    assert np.abs(lower - wanted_lower / np.diag(wanted_lower)).max() <= 1e-12 * np.abs(lower).max()
    twice = np.zeros((m, m))
    assert core.call("cholesky", n, 2.0 * W, m, chosen, 1e-12, twice) == 0
    np.testing.assert_array_equal(np.tril(twice, -1), np.tril(a, -1))
    core.call("cholesky_solve", m, a, x)
    assert np.abs(x - wanted).max() <= 1e-11 * np.abs(wanted).max()
    if n > 2:
        singular = semidefinite(rng, n, n - 1)
        assert core.call("cholesky", n, singular, n, None, 1e-12, np.zeros((n, n))) == 1


@pytest.mark.parametrize("n", SIZES)
def test_elimination(n: int, core: Functions) -> None:
    """The solution, and the determinant's sign; rows that depend are said."""
    rng = np.random.default_rng([n, 1])
    a, x = rng.normal(size=(n, n)), rng.normal(size=n)
    a[:, 0] *= 1e-8  # columns of other sizes are no reason to fail
    wanted, sign = np.linalg.solve(a, x), np.sign(np.linalg.det(a))
    found = x.copy()
    assert core.call("eliminate", n, a.copy(), found, 1e-14) == sign
    assert np.abs(a @ found - x).max() <= 1e-12 * np.abs(a @ np.diag(wanted)).max()
    if n > 1:
        a[-1] = a[0]
        assert core.call("eliminate", n, a, x, 1e-14) == 0


@pytest.mark.parametrize("rank", [1, 2, 4])
def test_elimination_of_dependent_rows(rank: int, core: Functions) -> None:
    """Rows that agree are solved with as many unknowns as the rank; the others are zero."""
    rng = np.random.default_rng([rank, 2])
    rows, n = 6, 5
    a = rng.normal(size=(rows, rank)) @ rng.normal(size=(rank, n))
    x = np.zeros(max(rows, n))
    x[:rows] = a @ rng.normal(size=n)
    order, wanted = np.zeros(max(rows, n), dtype=np.int32), x[:rows].copy()
    found = core.call("eliminate_dependent", rows, n, a.copy(), x, order, 1e-10)
    assert found == rank == np.linalg.matrix_rank(a)
    z = np.zeros(n)
    z[order[:rank]] = x[:rank]
    assert np.abs(a @ z - wanted).max() <= 1e-11 * np.abs(wanted).max()


@pytest.mark.parametrize(("columns", "rank"), [(3, 3), (4, 2), (5, 5), (5, 1), (19, 3), (40, 5)])
def test_orthogonal_factorisation(columns: int, rank: int, core: Functions) -> None:
    """Its rank, the null space of the columns' transposes, and the solution of least norm, as by singular values."""
    rng = np.random.default_rng([columns, rank])
    n = 6
    g = np.ascontiguousarray(rng.normal(size=(columns, rank)) @ rng.normal(size=(rank, n)))  # column by column
    work, diagonal, beta = g.copy(), np.zeros(columns), np.zeros(columns)
    order = np.arange(columns, dtype=np.int32)
    found = core.call("reduce_columns", n, columns, work, 1e-10, diagonal, beta, order)
    assert found == rank
    assert sorted(order) == list(range(columns))
    basis = np.eye(n)
    for k in range(n):
        core.call("reflect", n, rank, work, beta, 0, basis[k])
    assert np.abs(basis @ basis.T - np.eye(n)).max() <= 1e-14  # rows: Q applied to unit vectors
    assert np.abs(g @ basis[rank:].T).max() <= 1e-13 * np.abs(g).max()  # motions that no column sees
    right = g @ rng.normal(size=n)
    x = np.zeros(n)
    x[:rank] = right[order[:rank]]
    core.call("solve_transposed_triangle", n, rank, work, diagonal, x)
    core.call("reflect", n, rank, work, beta, 0, x)
    assert np.abs(x - np.linalg.pinv(g, rcond=1e-10) @ right).max() <= 1e-12 * np.abs(right).max()


@pytest.mark.parametrize(("n", "rank"), [(1, 1), (3, 3), (4, 2), (6, 3), (7, 1)])
def test_semidefinite_systems(n: int, rank: int, core: Functions) -> None:
    """The solution of least norm is the pseudoinverse's; what is well away from losing rank is told from the rest."""
    rng = np.random.default_rng([n, rank, 3])
    W = semidefinite(rng, n, rank)
    r = W @ rng.normal(size=n)
    x, room = np.zeros(n), np.zeros(16, dtype=np.uint64)  # a struct semidefinite, pointers
    core.call("take_semidefinite", core.arena, room, ctypes.c_size_t(n))
    core.call("solve_semidefinite", n, W, r, x, room)
    wanted = np.linalg.pinv(W, rcond=1e-10) @ r
    assert np.abs(x - wanted).max() <= 1e-10 * np.abs(wanted).max()
    y = r.copy()
    failed = core.call("solve_definite_well", n, W, y, np.zeros((n, n)))
    assert bool(failed) == (rank < n)
    assert failed or np.abs(y - wanted).max() <= 1e-10 * np.abs(wanted).max()
