"""Forces of least norm by themselves: against Kuhn's and Tucker's conditions, in problems with corners and ties."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from scipy.optimize import linprog, nnls

from ccgen.runtime import _core

from ..support.core_functions import Functions

Array = Any


class Shared(ctypes.Structure):
    """``struct shared`` of complementarity/sharing.h"""

    _fields_ = (
        [("n", ctypes.c_int), ("rows", ctypes.c_int)]
        + [(name, ctypes.c_void_p) for name in ("W", "mu", "side", "leaves")]
        + [("beyond", ctypes.c_double), ("arena", ctypes.c_void_p)]
    )


@pytest.fixture(scope="module")
def core(tmp_path_factory: pytest.TempPathFactory) -> Functions:
    return Functions(tmp_path_factory.mktemp("sharing"), "base", "algebra", "complementarity")


AS_GIVEN = -1.0  # sharing.h
PASSES_LAW = _core.TOLERANCES["PASSES_LAW"].value
REPEATS = _core.OUTCOMES.index("repeats")


def share(core: Functions, W: Array, mu: Array, side: Array, leaves: Array, beyond: float, P: Array) -> int:
    problem = Shared(
        len(mu), len(P), *[array.ctypes.data for array in (W, mu, side, leaves)], beyond, core.arena.ctypes.data
    )
    return core.call("share_forces", ctypes.byref(problem), P)


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
        assert share(core, W, mu, side, leaves, AS_GIVEN, P) == 0
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


@pytest.mark.parametrize("seed", range(6))
def test_forces_against_the_law_are_shared_within_it_where_that_can_be(seed: int, core: Functions) -> None:
    """Those of least norm without a law, as a motion takes them, pull here and there. Others that give the same rates
    keep the law wherever a linear program finds any; else they stay and that is said."""
    found = missed = 0
    for number, (N, mu, side, leaves, kept) in enumerate(problems(100 + seed)):
        rows, W = len(kept), np.ascontiguousarray(N @ N.T)
        limits, fixed = conditions(len(mu), rows, mu, side, leaves)
        wanted = N.T @ (kept if number % 3 else np.random.default_rng([seed, number]).normal(size=rows))
        asked = np.concatenate([N.T, fixed])
        P = np.linalg.lstsq(asked, np.concatenate([wanted, np.zeros(len(fixed))]), rcond=None)[0]
        size = max(1.0, np.max(np.abs(P)))
        if np.max(np.abs(asked @ P - np.concatenate([wanted, np.zeros(len(fixed))]))) > 1e-9 * size:
            continue  # not from forces at all
        against = np.min(limits @ P, initial=0.0) < -1e-6 * size
        within = linprog(
            np.zeros(rows), -limits, np.zeros(len(limits)), asked, asked @ P, bounds=(None, None), method="highs"
        ).success
        before = P.copy()
        outcome = share(core, W, mu, side, leaves, 0.0, P)
        if against and within:
            assert outcome == 0
            assert np.max(np.abs(asked @ (P - before))) < 1e-9 * size
            assert np.min(limits @ P) > -1e-9 * size
            found += 1
        elif against:
            assert outcome == REPEATS and np.array_equal(P, before)
            missed += 1
    assert found > 4 and missed > 2


@pytest.mark.parametrize("beyond", [0.0, PASSES_LAW])
def test_limits_are_passed_by_no_more_than_is_allowed(beyond: float, core: Functions) -> None:
    """Two contacts of one motion, of which only the sum counts: it pulls by a ten-billionth of the forces."""
    none = np.zeros(2, dtype=np.int8)
    P = np.array([1.0, -1.0 - 1e-10])
    assert share(core, np.ones((2, 2)), np.zeros(2), none, none, beyond, P) == (0 if beyond else REPEATS)
    assert np.allclose(P, [-5e-11, -5e-11] if beyond else [1.0, -1.0 - 1e-10], rtol=0.0, atol=1e-15)


@pytest.mark.parametrize(("least", "outcome"), [(1.0, 0), (-1e-8, REPEATS)])
def test_forces_that_are_the_only_ones_are_within_the_law_or_not(least: float, outcome: int, core: Functions) -> None:
    none, given = np.zeros(2, dtype=np.int8), np.array([least, 1.0])
    P = given.copy()
    assert share(core, np.eye(2), np.zeros(2), none, none, PASSES_LAW, P) == outcome and np.array_equal(P, given)
    assert share(core, np.eye(2), np.zeros(2), none, none, AS_GIVEN, P) == 0 and np.array_equal(P, given)
