"""The linear complementarity problem by itself: against its conditions, all bases, and a convex minimum."""

from __future__ import annotations

from itertools import chain, combinations
from typing import Any

import numpy as np
import pytest
from scipy.optimize import nnls

from ..support.core_functions import Functions

Array = Any


@pytest.fixture(scope="module")
def core(tmp_path_factory: pytest.TempPathFactory) -> Functions:
    return Functions(tmp_path_factory.mktemp("complementarity"), "base", "algebra", "complementarity")


def problem(seed: int) -> tuple[Array, Array]:
    """W = G Gᵀ of any rank and b = G v, as approach makes it: a solution exists."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 7))
    rank = int(rng.integers(1, n + 1))
    G = rng.normal(size=(n, rank))
    return np.ascontiguousarray(G @ G.T), G @ rng.normal(size=rank)


@pytest.mark.parametrize("seed", [*range(60), 4568, 4777, 7108, 7429, 9581, 12191, 12750, 15705])
def test_impulses_of_contacts(seed: int, core: Functions) -> None:
    """The last seeds have impulses of hundreds for rates of 1: the z of what they carry is rounding of that size."""
    W, b = problem(seed)
    n, P = len(b), np.zeros(len(b))
    assert core.call("solve_complementarity", core.arena, n, W, b, P) == 0
    z, scale = W @ P + b, np.abs(b).max()
    rounding = 1e-13 * scale * (1.0 + P.max())  # z is a difference of terms as large as impulses
    assert P.min() >= 0.0 and z.min() >= -rounding and np.abs(z[P > 0.0]).max(initial=0.0) <= rounding
    # the rates after it are unique: those of the minimum of P W P / 2 + b P over P >= 0
    values, vectors = np.linalg.eigh(W)
    kept = values > 1e-10 * values[-1]
    root = (vectors[:, kept] * np.sqrt(values[kept])).T
    best = nnls(root, -np.linalg.pinv(root.T) @ b)[0]
    assert np.abs(W @ (best - P)).max() <= 1e-8 * scale
    assert np.linalg.norm(P) <= np.linalg.norm(best) * (1.0 + 1e-8) + 1e-12  # and these have the least norm


@pytest.mark.parametrize("seed", range(60))
def test_pivoting(seed: int, core: Functions) -> None:
    """Of matrices without symmetry, where all leading parts are positive: the one answer among all bases."""
    rng = np.random.default_rng([seed, 1])
    m = int(rng.integers(1, 6))
    M = rng.normal(size=(m, m))
    M = np.ascontiguousarray(M @ M.T + 0.5 * (skew := rng.normal(size=(m, m))) - 0.5 * skew.T + 0.1 * np.eye(m))
    q, z, inside = rng.normal(size=m), np.zeros(m), np.zeros(m, dtype=np.int8)
    assert core.call("lemke", core.arena, m, M, q, None, None, z, inside) == 0
    found = []
    for basis in chain.from_iterable(combinations(range(m), k) for k in range(m + 1)):
        own = list(basis)
        candidate = np.zeros(m)
        candidate[own] = np.linalg.solve(M[np.ix_(own, own)], -q[own]) if own else 0.0
        if candidate.min() >= 0.0 and (M @ candidate + q).min() >= -1e-9:
            found.append(candidate)
    assert len(found) == 1
    assert np.abs(z - found[0]).max() <= 1e-10 * max(1.0, np.abs(found[0]).max())
    assert sorted(np.flatnonzero(inside)) == sorted(np.flatnonzero(found[0] > 0.0))
