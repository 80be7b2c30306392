"""What a step of a run carries of small differences of its state: the linear map, by collocation (docs/theory.md, eq.
11.7).

The states along a step are the solution through its first row, found anew at the nodes of Gauss and Legendre; the
variational equations (eq. 11.5), collocated at the same nodes, are linear systems (E. Hairer, C. Lubich, G. Wanner,
Geometric Numerical Integration, 2006, sections II.1.3 and VI.4.1). All steps that are held alike are taken side by
side.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ..arrays import BoolArray, FloatArray
from ..model.forces import Held
from ..model.model import Model
from ..model.thresholds import characteristic_time
from .held import accelerations, jacobians, jacobians_abreast, no_accelerations
from .moving import Moving, moving_of

STAGES = 8
"""Order 16, as of the method ``gauss``."""

SWEEPS, NEWTON = 40, 30
"""Iterations at most: by putting in, and by Newton's method where that does not contract. At a contraction of 0.4, for
which steps are chosen, forty reach rounding."""

SMALL = 1e-13
"""Sweeps are done where what is left of changes of the accelerations is this part of them: of changes that fall by the
same factor, less than a half, from one to the next, all that follow together; of others as much as the last. By
Newton's method a change by this part is the last."""

STAYS = 1e-9
"""Below this part of the accelerations a change that no longer falls is rounding, of light links that carry heavy ones;
whether the step is as exact as the run, the next row tells."""

HALVINGS = 6
"""A step that misses the next row is halved as often as this at most: 64 pieces of order 16."""

TOGETHER = 64
"""Steps whose linear systems are in memory at one time."""

UNKNOWN = 1e-6
"""What a step of fixed length may miss the next row by, relative to the size of the state: nobody has said how exact it
is to be."""

MISSED = 10.0
"""A step may miss the next row by this many tolerances of the run: its error is of the size of one, and the next."""

ROUNDED = 1e-11
"""By this much a step may miss in any case: by the rounding of accelerations whose masses and contacts make it 1e5
times as large as that of a number."""


class Tableau(NamedTuple):
    """Nodes c (s,), weights b (s,), the matrix A (s, s), and those of double integrals, A A and b A."""

    c: FloatArray
    b: FloatArray
    A: FloatArray
    twice: FloatArray
    twice_b: FloatArray


@cache
def gauss() -> Tableau:
    """The collocation of Gauss and Legendre: A_ij is the integral from 0 to c_i of the polynomial that is 1 at c_j and
    0 at the other nodes (Hairer, Lubich, Wanner, section II.1.2)."""
    legendre = np.polynomial.legendre
    x, w = legendre.leggauss(STAGES)
    basis = np.linalg.inv(legendre.legvander(x, STAGES - 1))  # columns: coefficients of those polynomials
    A = np.array([legendre.legval(x, legendre.legint(basis[:, j], lbnd=-1)) for j in range(STAGES)]).T / 2.0
    b = w / 2.0
    return Tableau((x + 1.0) / 2.0, b, np.ascontiguousarray(A), np.ascontiguousarray(A @ A), b @ A)


class Steps(NamedTuple):
    """Steps from states q, u (k, n) at t (k,) over h (k,), whose ends are near to q1, u1 (k, n)."""

    t: FloatArray
    h: FloatArray
    q: FloatArray
    u: FloatArray
    q1: FloatArray
    u1: FloatArray

    def some(self, which: Any) -> Steps:
        return Steps(*(part[which] for part in self))


def maps(model: Model, moving: Moving, held: Held, steps: Steps, tolerance: tuple[float, float]) -> FloatArray:
    """What the state (q, u) at the end of each step moves by, (k, 2 n, D), by that at its start and the arguments.

    Raises ``ValueError`` where the run cannot be followed to ``tolerance``, relative and in rad and lengths of the
    mechanism (0, 0 where it had none).
    """
    parts = [slice(first, first + TOGETHER) for first in range(0, len(steps.t), TOGETHER)]
    found = [_maps(model, moving, held, steps.some(part), tolerance, HALVINGS) for part in parts]
    return found[0] if len(found) == 1 else np.concatenate(found)


def _maps(
    model: Model, moving: Moving, held: Held, steps: Steps, tolerance: tuple[float, float], halvings: int
) -> FloatArray:
    stages, missed = motion_along(model, held, steps, tolerance)
    n = steps.q.shape[1]
    if not missed.any():
        return linear(model, moving, held, steps, stages)
    found = np.zeros((len(steps.t), 2 * n, len(moving.directions.columns)))
    good = np.flatnonzero(~missed)
    if good.size:
        found[good] = linear(model, moving, held, steps.some(good), stages[good])
    if missed.any() and not halvings:
        t = float(steps.t[np.flatnonzero(missed)[0]])
        raise ValueError(
            f"{model.name}: found no solution through the run's row at t = {t:.9g} s that meets the next row, "
            "expected one within the run's tolerance; simulate with a smaller rtol"
        )
    for i in np.flatnonzero(missed):
        found[i] = _halved(model, moving, held, steps.some(np.array([i])), tolerance, halvings - 1)
    return found


def motion_along(
    model: Model, held: Held, steps: Steps, tolerance: tuple[float, float]
) -> tuple[FloatArray, BoolArray]:
    """Accelerations (k, s, n) at the nodes of steps, and which of these (k,) miss the next row."""
    stages = _stages(model, held, steps)
    q_end, u_end = _ends(steps, stages)
    meets = _meets(model, steps, q_end, u_end, tolerance) & np.isfinite(stages).all(axis=(1, 2))
    return stages, np.logical_not(meets)


def _halved(
    model: Model, moving: Moving, held: Held, step: Steps, tolerance: tuple[float, float], halvings: int
) -> FloatArray:
    """One step as two."""
    half = step._replace(h=step.h / 2.0)
    q, u = _carried(model, held, half, halvings)
    first = _maps(model, moving, held, half._replace(q1=q, u1=u), tolerance, halvings)[0]
    then = Steps(step.t + half.h, half.h, q, u, step.q1, step.u1)
    return _composed(first, _maps(model, moving, held, then, tolerance, halvings)[0])


def _carried(model: Model, held: Held, step: Steps, halvings: int) -> tuple[FloatArray, FloatArray]:
    """The end of one step, in as many pieces as it needs."""
    stages = _stages(model, held, step)
    if np.isfinite(stages).all():
        return _ends(step, stages)
    if not halvings:
        raise ValueError(
            f"{model.name}: found no solution through the run's row near t = {float(step.t[0]):.9g} s by collocation; "
            "simulate with a smaller rtol"
        )
    half = step._replace(h=step.h / 2.0)
    q, u = _carried(model, held, half, halvings - 1)
    return _carried(model, held, Steps(step.t + half.h, half.h, q, u, step.q1, step.u1), halvings - 1)


def _composed(first: FloatArray, then: FloatArray) -> FloatArray:
    """Two maps (2 n, D) one after the other."""
    states = len(first)
    found = then[:, :states] @ first
    found[:, states:] += then[:, states:]
    return found


def _stages(model: Model, held: Held, steps: Steps) -> FloatArray:
    """Accelerations (k, s, n) at the nodes; not a number where none are found."""
    g = gauss()
    start = accelerations(model, held, steps.t, steps.q, steps.u)[0]
    ends = start, accelerations(model, held, steps.t + steps.h, steps.q1, steps.u1)[0]
    found, met, without = model.kernels.collocated(steps, ends, held, g.c, g.A, g.twice, SWEEPS, SMALL, STAYS)
    if without:
        raise no_accelerations(model, *without)
    for i in np.flatnonzero(~met):
        found[i] = _by_newton(model, held, steps.some(np.array([i])))
    return found


def _nodes(steps: Steps, W: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times, coordinates and rates at the nodes, one behind the other, of accelerations (k, s, n) there."""
    g, h = gauss(), steps.h[:, None, None]
    q = steps.q[:, None] + h * g.c[:, None] * steps.u[:, None] + h**2 * (g.twice @ W)
    u = steps.u[:, None] + h * (g.A @ W)
    n = q.shape[-1]
    t = (steps.t[:, None] + steps.h[:, None] * g.c).ravel()
    return t, np.ascontiguousarray(q.reshape(-1, n)), np.ascontiguousarray(u.reshape(-1, n))


def _by_newton(model: Model, held: Held, step: Steps) -> FloatArray:
    """The same of one stiff step, by Newton's method with exact derivatives at all nodes; not numbers where it
    fails."""
    g, n = gauss(), step.q.shape[1]
    start = accelerations(model, held, step.t, step.q, step.u)[0]
    end = accelerations(model, held, step.t + step.h, step.q1, step.u1)[0]
    W = (start + g.c[:, None] * (end - start))[None]
    states, before = moving_of(model, "q0"), np.inf  # by q and u alone
    for _ in range(NEWTON):
        t, q, u = _nodes(step, W)
        if not (np.isfinite(q).all() and np.isfinite(u).all()):
            return np.full_like(W[0], np.nan)
        u_dot, J = jacobians(model, states, held, t, q, u)
        K = model.kernels.collocate(step.h, g.c, g.A, g.twice, J.reshape(1, STAGES, n, -1))
        change = np.linalg.solve(K[0].T, (u_dot - W[0]).ravel()).reshape(W.shape)
        W = W + change
        size, moved = float(np.max(np.abs(W))), float(np.max(np.abs(change)))
        if moved <= SMALL * size or (moved <= STAYS * size and moved >= 0.5 * before):
            return np.asarray(W[0])
        before = moved
    return np.full_like(W[0], np.nan)


def _ends(steps: Steps, W: FloatArray) -> tuple[FloatArray, FloatArray]:
    g, h = gauss(), steps.h[:, None]
    q = steps.q + h * steps.u + h**2 * (g.twice_b @ W)
    return q, steps.u + h * (g.b @ W)


def _meets(model: Model, steps: Steps, q: FloatArray, u: FloatArray, tolerance: tuple[float, float]) -> Any:
    """Whether ends (k, n) are the steps' own, to what the run's tolerance allows."""
    rtol, atol = tolerance
    rtol, atol = (max(MISSED * x, ROUNDED) for x in (rtol, atol)) if rtol else (UNKNOWN, UNKNOWN)
    unit = model.coordinate_units
    parts = np.array([q - steps.q1, u - steps.u1, steps.q1, steps.q1 - steps.q, steps.u, steps.u1])
    place, rate, far, span, before, after = (np.abs(parts) / unit).max(axis=2)
    allowed = atol + rtol * (far + span), atol / characteristic_time(model) + rtol * np.maximum(before, after)
    return (place <= allowed[0]) & (rate <= allowed[1])


def linear(model: Model, moving: Moving, held: Held, steps: Steps, W: FloatArray) -> FloatArray:
    """The maps (k, 2 n, D) of steps with accelerations W (k, s, n) at their nodes.

    The collocated equations K dW = R are solved from the left, for what the end of the step makes of dW, E K^-1: that
    is as many columns as the state has, however many directions R has.
    """
    g, (k, n) = gauss(), steps.q.shape
    J = jacobians(model, moving, held, *_nodes(steps, W))[1].reshape(k, STAGES, n, -1)
    K = model.kernels.collocate(steps.h, g.c, g.A, g.twice, J)  # transposed
    left = np.linalg.solve(K, np.broadcast_to(_to_end(n), (k, STAGES * n, 2 * n)))
    found = np.asarray(left.transpose(0, 2, 1) @ J.reshape(k, STAGES * n, -1))
    h, each = steps.h[:, None, None], np.arange(n)
    found[:, :n] *= h**2
    found[:, n:] *= h
    found[:, each, each] += 1.0
    found[:, n + each, n + each] += 1.0
    found[:, each, n + each] += steps.h[:, None]
    return found


def along_nodes(model: Model, moving: Moving, held: Held, steps: Steps, W: FloatArray) -> FloatArray:
    """Derivatives (k, n, D, s) of the accelerations at the nodes of steps by the state there and the arguments."""
    return jacobians_abreast(model, moving, held, *_nodes(steps, W), STAGES)[1]


@cache
def _to_end(n: int) -> FloatArray:
    """The weights (s n, 2 n) of what accelerations at the nodes add to the place and the rates at the end of a step."""
    g = gauss()
    return np.hstack([np.kron(one[:, None], np.eye(n)) for one in (g.twice_b, g.b)])
