"""Forces of least norm by themselves: against Kuhn's and Tucker's conditions, in problems with corners and ties."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from scipy.optimize import nnls

from ..support.core_functions import Functions

Array = Any


class Shared(ctypes.Structure):
    """``struct shared`` of complementarity/sharing.h"""

    _fields_ = [("n", ctypes.c_int), ("rows", ctypes.c_int)] + [
        (name, ctypes.c_void_p) for name in ("W", "mu", "side", "leaves", "arena")
    ]


@pytest.fixture(scope="module")
def core(tmp_path_factory: pytest.TempPathFactory) -> Functions:
    return Functions(tmp_path_factory.mktemp("sharing"), "base", "algebra", "complementarity")


def problems(seed: int) -> Iterator[tuple[Array, Array, Array, Array, Array]]:
    """N (rows, k) of contacts on few motions, of whole numbers where there are ties; mu, side, leaves; P within the
    limits, of which some are reached"""
    for number in range(40):
        rng = np.random.default_rng([seed, number])
        n, rough = int(rng.integers(2, 9)), bool(rng.integers(0, 2))
        rows, k = (2 * n if rough else n), int(rng.integers(1, 5))
        N = rng.integers(-2, 3, (rows, k)).astype(float) if number % 2 else rng.normal(size=(rows, k))
        mu = rng.choice([0.0, 0.25, 0.5, 1.0, 2.0], n) if rough else np.zeros(n)
        leaves = (rng.random(n) < 0.1).astype(np.int8)
        side = (rng.choice([-1, 0, 0, 0, 1], n) * (mu > 0.0) * (leaves == 0)).astype(np.int8)
        P = rng.integers(0, 4, n).astype(float) * (leaves == 0)
        F = np.where(side, -side * mu * P, mu * P * rng.choice([-1.0, -0.5, 0.0, 0.5, 1.0], n))
        yield N, mu, side, leaves, np.concatenate([P, F]) if rough else P


def conditions(n: int, rows: int, mu: Array, side: Array, leaves: Array) -> tuple[Array, Array]:
    """G P >= 0 and F P = 0"""
    one, limits, given = np.eye(rows), [], []
    for i in range(n):
        if leaves[i]:
            given += [one[i], *([one[n + i]] if rows > n else [])]
        elif rows > n and mu[i] > 0.0 and not side[i]:
            limits += [mu[i] * one[i] + one[n + i], mu[i] * one[i] - one[n + i]]
        else:
            limits.append(one[i])
            given += [one[n + i] + side[i] * mu[i] * one[i]] if rows > n else []
    return np.reshape(limits, (-1, rows)), np.reshape(given, (-1, rows))


@pytest.mark.parametrize("seed", range(12))
def test_forces_of_least_norm(seed: int, core: Functions) -> None:
    """They give the same rates, keep the law, and no other that does is shorter: P is a sum of what may not change and
    of limits that are reached, with parts that are not negative."""
    shared = 0
    for N, mu, side, leaves, given in problems(seed):
        n, rows, W, P = len(mu), len(given), np.ascontiguousarray(N @ N.T), given.copy()
        arrays = [W, mu, side, leaves, core.arena]
        problem = Shared(n, rows, *[array.ctypes.data for array in arrays])
        assert core.call("share_forces", ctypes.byref(problem), P) == 0
        limits, fixed = conditions(n, rows, mu, side, leaves)
        size = max(1.0, np.max(np.abs(given)))
        assert np.max(np.abs(N.T @ (P - given))) < 1e-9 * size
        assert np.max(np.abs(fixed @ P), initial=0.0) < 1e-9 * size and np.min(limits @ P, initial=0.0) > -1e-9 * size
        assert np.linalg.norm(P) < np.linalg.norm(given) * (1.0 + 1e-12) + 1e-12
        left, values, _ = np.linalg.svd(np.concatenate([N.T, fixed]).T)
        free = left[:, int(np.sum(values > 1e-9 * max(values[0], 1.0))) :]
        reached = limits[np.abs(limits @ P) < 1e-8 * size]
        missed = nnls(free.T @ reached.T, free.T @ P, maxiter=1000)[1] if reached.size else np.linalg.norm(free.T @ P)
        assert missed < 1e-8 * size
        shared += bool(np.max(np.abs(P - given), initial=0.0) > 1e-6)
    assert shared > 10
