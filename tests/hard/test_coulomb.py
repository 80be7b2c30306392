"""The solver of friction by itself: random and nearly degenerate contacts, each answer put back into Coulomb's law."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from itertools import product
from typing import Any

import numpy as np
import pytest

from ..oracles import closed_contacts
from ..oracles.coulomb import Rough, broken
from ..support.c_declarations import fields_of
from ..support.core_functions import Functions
from ..support.folders import ROOT
from ..support.tiers import all_hard_but

Solver = Callable[[Rough], tuple[int, Any]]

CORE = ROOT / "runtime" / "core"
TOLERANCE = 2e-10
KINDS = ("regular", "two alike", "two nearly alike", "masses far apart", "one that hardly moves along", "slow normals")
LAWS = ("compression", "expansion", "newton")


class Problem(ctypes.Structure):
    """``struct friction_problem``, as its header has it."""

    _fields_ = fields_of(CORE / "complementarity" / "coulomb.h", "friction_problem")


@pytest.fixture(scope="module")
def core(tmp_path_factory: pytest.TempPathFactory) -> Functions:
    return Functions(tmp_path_factory.mktemp("friction"), "base", "algebra", "complementarity")


def _solver(core: Functions, name: str, *given: int, missed: float = 0.0) -> Solver:
    """The function ``name``: its outcome and the impulses, normals and then tangents."""

    def solved(c: Rough) -> tuple[int, Any]:
        n = len(c.mu)
        arrays = [np.ascontiguousarray(x, dtype=float) for x in (c.W, c.b[:n], c.b[n:], c.mu, c.least)]
        W, bn, bt, mu, least = (x.ctypes.data for x in arrays)
        mode, P = np.zeros(n, dtype=np.int8), np.zeros(2 * n)
        problem = Problem(
            n=n,
            W=W,
            bn=bn,
            bt=bt,
            mu=mu,
            mode=mode.ctypes.data,
            least=least,
            missed=missed,
            arena=core.arena.ctypes.data,
        )
        assert core.call("prepare_friction", ctypes.byref(problem)) == 0
        return core.call(name, ctypes.byref(problem), *given, P[:n], P[n:]), P

    return solved


@pytest.fixture(scope="module")
def solve(core: Functions) -> Solver:
    return _solver(core, "solve_friction")


@pytest.fixture(scope="module")
def least(core: Functions) -> Solver:
    return _solver(core, "least_impulses", 0)


def _rows(kind: str, n: int, rng: np.random.Generator) -> Any:
    """Rows of n contacts, normals and tangents, of a mechanism with some freedoms and unit masses."""
    freedoms = int(rng.integers(1, 2 * n + 3))
    J = rng.normal(size=(2 * n, freedoms))
    if kind == "two alike":
        J[[n - 1, 2 * n - 1]] = J[[0, n]]
    if kind == "two nearly alike":
        J[n - 1] = J[0] + 10.0 ** rng.uniform(-12, -4) * rng.normal(size=freedoms)
        J[2 * n - 1] = J[n]
    if kind == "masses far apart":
        J *= np.tile(10.0 ** rng.uniform(-2, 2, size=(n, 1)), (2, 1))
    if kind == "one that hardly moves along":
        J[n + int(rng.integers(n))] *= 10.0 ** rng.uniform(-18, -6)
    return J


def _struck(kind: str, n: int, rng: np.random.Generator) -> Rough:
    """All contacts approach; where normals are slow, to 1e-9 of the sliding."""
    J = _rows(kind, n, rng)
    u = rng.normal(size=J.shape[1])
    J[:n] *= np.where(J[:n] @ u > 0.0, -1.0, 1.0)[:, None]
    if kind == "slow normals" and J.shape[1] > n:
        less = 10.0 ** rng.uniform(-9, -3) - 1.0
        u = u + np.linalg.lstsq(J[:n], less * (J[:n] @ u), rcond=None)[0]
    mu = rng.uniform(0.0, 2.0, n) * (rng.random(n) < 0.8) if rng.random() < 0.5 else np.full(n, rng.choice([0.3, 3.0]))
    W = J @ J.T
    return Rough(0.5 * (W + W.T), J @ u, mu, np.zeros(n))


def _after(c: Rough, P: Any, e: float) -> Rough:
    """Expansion after compression with P: what has come to rest is at rest."""
    terms = np.abs(c.W) @ np.abs(P) + np.abs(c.b)
    b = c.b + c.W @ P
    b[np.abs(b) < 1e-10 * (terms + 1e-4 * np.max(terms))] = 0.0
    return Rough(c.W, b, c.mu, e * P[: len(c.mu)])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("law", all_hard_but("compression", of=LAWS))
def test_answers_meet_coulombs_law(law: str, kind: str, solve: Solver) -> None:
    """Compression and expansion always have impulses; where Newton's law has none with two contacts, no modes have."""
    rng = np.random.default_rng([KINDS.index(kind), LAWS.index(law)])
    none = 0
    for _ in range(600):
        n, e = int(rng.integers(1, 8)), float(rng.choice([0.0, 0.3, 0.7, 1.0]))
        c = _struck(kind, n, rng)
        if law == "newton":
            c.b[:n] *= 1.0 + e
        outcome, P = solve(c)
        if law == "expansion":
            assert outcome == 0
            c = _after(c, P, e)
            outcome, P = solve(c)
        if outcome == 0:
            assert not broken(c, P, TOLERANCE), (n, e)
            continue
        none += 1
        assert law == "newton"
        if n <= 2 and np.ptp(c.mu) == 0.0:
            assert not closed_contacts.motions(c.W, c.b, float(c.mu[0]), np.zeros(n))
    assert none < 60


def _ways(c: Rough) -> Iterator[Any]:
    """The impulses of every way that has a system far from singular: each contact has its least impulse or comes to
    rest, and its friction is at one limit, at the other, or brings its sliding to rest."""
    n = len(c.mu)
    root = np.sqrt(np.maximum(np.diag(c.W), 1e-300))
    kinds = [
        [(pushes, friction) for pushes in (0, 1) for friction in ((-1, 0, 1) if mu > 0.0 else (-1,))] for mu in c.mu
    ]
    for way in product(*kinds):
        S, shift, known = np.zeros((2 * n, 2 * n)), np.zeros(2 * n), []
        for i, (pushes, friction) in enumerate(way):
            S[i, i], shift[i] = pushes, 0.0 if pushes else c.least[i]
            S[n + i, n + i], S[n + i, i] = friction == 0, friction * c.mu[i] * pushes
            shift[n + i] = 0.0 if friction == 0 else friction * c.mu[i] * shift[i]
            known += [i] * pushes + [n + i] * (friction == 0)
        A, right = (c.W @ S)[np.ix_(known, known)], -(c.b + c.W @ shift)[known]
        A, right = A / root[known][:, None] / root[known], right / root[known]
        if known and np.linalg.cond(A) > 1e6:
            continue
        x = np.zeros(2 * n)
        x[known] = (np.linalg.solve(A, right) if known else right) / root[known]
        yield S @ x + shift


@pytest.mark.sample(6)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("law", LAWS)
def test_no_way_has_less_impulses(law: str, kind: str, least: Solver) -> None:
    """Of up to three contacts all ways are tried here as well, each by LAPACK: none that keeps the law has less."""
    rng = np.random.default_rng([KINDS.index(kind), LAWS.index(law), 1])
    compared = 0
    for _ in range(40):
        n, e = int(rng.integers(1, 4)), float(rng.choice([0.0, 0.3, 0.7, 1.0]))
        c = _struck(kind, n, rng)
        outcome, P = least(c)
        if law == "newton":
            c.b[:n] *= 1.0 + e
        elif law == "expansion" and outcome == 0:
            c = _after(c, P, e)
        outcome, P = least(c)
        load = np.sqrt(np.diag(c.W))[:n]
        assert outcome or not broken(c, P, TOLERANCE)
        for other in _ways(c):
            if not broken(c, other, 1e-11):
                assert outcome == 0 and load @ P[:n] <= load @ other[:n] * (1.0 + 1e-7)
                compared += 1
    assert compared > 20


def test_a_strike_much_slower_than_the_sliding(solve: Solver) -> None:
    """Beside a sliding of 1 m/s, 3e-6 m/s of approach: friction is at its limit to all digits."""
    for angle in np.linspace(-1.3, 1.3, 27):
        x, y = -0.5 * np.cos(angle), -0.5 * np.sin(angle)
        W = np.array([[1 + 12 * x * x, -12 * x * y], [-12 * x * y, 1 + 12 * y * y]])
        for slides in (-1.0, 1.0):
            c = Rough(W, np.array([-3e-6, slides]), np.array([0.1]), np.zeros(1))
            outcome, P = solve(c)
            assert outcome == 0
            assert P[1] == pytest.approx(-slides * 0.1 * P[0], rel=1e-14)
            assert P[0] == pytest.approx(3e-6 / (W[0, 0] - slides * 0.1 * W[0, 1]), rel=1e-13)


def _row_between_walls(rng: np.random.Generator) -> tuple[Any, Any, int]:
    """Rows of contacts and masses of rough discs side by side between two walls, some on the floor, others on top: the
    walls press what hardly moves, the heights of the row differing by 1e-9 to 1e-3 of a radius."""
    count, top = int(rng.integers(3, 6)), int(rng.integers(0, 3))
    floor = rng.random(count) < 0.5
    height = np.where(floor, 1.0, 1.0 + np.abs(10.0 ** rng.uniform(-9, -3) * rng.normal(size=count)))
    x = np.concatenate([[0.0], np.cumsum(np.sqrt(4.0 - np.diff(height) ** 2))])
    centres = [np.array(c) for c in zip(x, height, strict=True)]
    pairs = [(i, i + 1) for i in range(count - 1)]
    for i in (2 * k for k in range(min(top, count // 2))):
        across = centres[i + 1] - centres[i]
        up = np.array([-across[1], across[0]]) * np.sqrt(4.0 / (across @ across) - 0.25)
        pairs += [(i, len(centres)), (i + 1, len(centres))]
        centres.append(0.5 * (centres[i] + centres[i + 1]) + up)
    touches = [(i, j, (centres[j] - centres[i]) / np.linalg.norm(centres[j] - centres[i])) for i, j in pairs]
    touches += [(-1, i, np.array([0.0, 1.0])) for i in range(count) if floor[i]]
    touches += [(-1, 0, np.array([1.0, 0.0])), (-1, count - 1, np.array([-1.0, 0.0]))]
    J = np.zeros((2 * len(touches), 3 * len(centres)))
    for k, (i, j, normal) in enumerate(touches):
        for row, along, turns in ((k, normal, 0.0), (len(touches) + k, np.array([-normal[1], normal[0]]), 1.0)):
            J[row, 3 * j : 3 * j + 2] += along
            J[row, 3 * j + 2] -= turns
            if i >= 0:
                J[row, 3 * i : 3 * i + 2] -= along
                J[row, 3 * i + 2] -= turns
    return J, np.tile([1.0, 1.0, 2.0], len(centres)), len(touches)


def test_rows_of_discs_between_walls(core: Functions) -> None:
    """Any impulse may press such a row. What is found misses the law by little of the approach:
    approach, pull, friction beyond its limit, and sliding that friction is not against."""
    solve = _solver(core, "solve_friction_least", missed=1e-4)
    rng = np.random.default_rng(7)
    worst = []
    for _ in range(60):
        J, inverse_mass, n = _row_between_walls(rng)
        u = 1e-6 * rng.normal(size=J.shape[1])
        u[1::3] -= 1.0
        W, b, mu = (J * inverse_mass) @ J.T, J @ u, np.full(n, rng.uniform(0.1, 1.0))
        outcome, P = solve(Rough(0.5 * (W + W.T), b, mu, np.zeros(n)))
        assert outcome == 0
        unit = np.sqrt(np.diag(W))
        rates, pushes, limits = (W @ P + b) / unit, unit * P, unit[n:] * mu * P[:n]
        approach = np.sum(np.maximum(-b[:n], 0.0) / unit[:n])
        against = limits + np.sign(rates[n:]) * pushes[n:]
        amiss = [-rates[:n], -pushes[:n], np.minimum(rates[:n], pushes[:n]), np.abs(pushes[n:]) - limits]
        amiss.append(np.minimum(np.abs(rates[n:]), against))
        worst.append(np.max(amiss) / approach)
        expansion = _after(Rough(0.5 * (W + W.T), b, mu, np.zeros(n)), P, 0.5)
        outcome, P = solve(expansion)
        assert outcome == 0 and np.all(P[:n] >= expansion.least * (1.0 - 1e-9) - 1e-4 * approach / unit[:n])
        assert np.all((W @ P + expansion.b)[:n] / unit[:n] >= -1e-4 * (approach + unit[:n] @ expansion.least))
    assert max(worst) <= 1e-4
    assert np.median(worst) <= 1e-10
