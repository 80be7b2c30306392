"""Rings that lie flat on their ground while a driven joint turns on: what lifts them out keeps them closed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

from ..hard.driven import LAWS, Driven, faults, run
from ..support.tiers import all_hard_but
from ..support.workshop import Workshop

RINGS = {
    "stands but for the drive": Driven("loop", 6, "poisson", 0.0, 0.0, 1.5927500660906324, 329273121),
    "rough": Driven("loop", 6, "poisson", 0.9947700884390305, 0.0405288598947765, -1.846491855656186, 1056825729),
    "bounces": Driven("loop", 6, "stronge", 0.0, 0.406312269891413, 3.1684541759793508, 172781116),
}
"""Found by random runs: each stopped where its links lay in a line."""


def _chi(q: np.ndarray, u: np.ndarray) -> float:
    """The second derivative of the loop's length along its line (m/s2), which velocities alone give."""
    return float(np.sum(np.cos(q[2:] - q[2]) * u[2:] ** 2))


def _mass(model: Any, q: np.ndarray) -> np.ndarray:
    """M by the kinetic energy, which is quadratic."""
    unit = np.eye(q.size)

    def energy(u: np.ndarray) -> float:
        return float(model.energy(q, u)[0])

    return np.array([[energy(a + b) - energy(a) - energy(b) for b in unit] for a in unit])


def _nearest(model: Any, q: np.ndarray, u: np.ndarray, speed: float) -> float:
    """The least distance by the mass matrix from u to velocities that leave the ring closed and drive no joint into its
    ground, by SciPy from many starts."""
    mass, rng, n = _mass(model, q), np.random.default_rng(5), q.size
    rates = np.array([model.gap_rates(q, one) for one in np.eye(n)]).T
    closed = np.zeros((2, n))
    closed[0, 2:], closed[1, 2:] = -np.sin(q[2:]), np.cos(q[2:])
    conditions = [
        {"type": "eq", "fun": lambda v: closed[1] @ v},
        {"type": "eq", "fun": lambda v: v[3] - v[2] - speed},
        {"type": "eq", "fun": lambda v: _chi(q, v)},
        {"type": "ineq", "fun": lambda v: rates @ v},
    ]
    found = []
    for _ in range(60):
        answer = minimize(
            lambda v: 0.5 * (v - u) @ mass @ (v - u),
            u + rng.normal(size=n) * np.max(np.abs(u)),
            jac=lambda v: mass @ (v - u),
            constraints=conditions,
            method="SLSQP",
            options={"ftol": 1e-13, "maxiter": 300},
        )
        if answer.success and abs(_chi(q, answer.x)) < 1e-7 and np.min(rates @ answer.x) > -1e-7:
            found.append(answer.fun)
    return float(min(found))


@pytest.mark.parametrize("name", all_hard_but("bounces", of=RINGS))
def test_a_driven_ring_leaves_its_line(name: str, workshop: Workshop) -> None:
    one = RINGS[name]
    assert one.law in LAWS
    found = run(workshop.model, one)
    assert found.success and not faults(found, one), found.message
    model, left = found.model, 0
    for impact in found.impacts:
        q, before, behind = found.at(impact.t)[0], impact.u_minus, impact.u_plus
        size = np.max(np.abs(before)) ** 2
        in_line = np.max(np.abs(np.sin(q[2:] - q[2]))) < 1e-9
        if np.any(impact.impulses) or not in_line or abs(_chi(q, before)) <= 1e-6 * size:
            continue
        assert abs(_chi(q, behind)) <= 1e-9 * size
        assert behind[3] - behind[2] == pytest.approx(one.speed, rel=1e-12)
        assert np.min(model.gap_rates(q, behind)) >= -1e-7
        jump = behind - before
        assert 0.5 * jump @ _mass(model, q) @ jump <= (1.0 + 1e-5) * _nearest(model, q, before, one.speed)
        left += 1
    assert left
