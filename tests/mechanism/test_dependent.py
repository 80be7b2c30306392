"""Dependent closure rows: redundant joints and flat loops, against dense least squares in maximal coordinates."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.interpolate import BarycentricInterpolator

from ..oracles.least_squares import least_squares
from ..oracles.maximal import GROUND
from ..oracles.mechanisms import Drawing, draw
from ..support.dense_comparison import close
from ..support.parallel_cranks import parallel_cranks
from ..support.tiers import hard
from ..support.workshop import Workshop

Array = np.ndarray[Any, Any]


def flat_chain(turn: float) -> Drawing:
    """A chain pinned at both ends whose links all lie on one line."""
    along = np.array([[0.0, 0.0], [1.0, 0.0], [0.2, 0.0], [1.2, 0.0]])
    places = along @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    joints = [(0, GROUND, 0), (1, 0, 1), (2, 1, 2), (3, 2, GROUND)]
    return draw("flat_chain", places, [(0, 1), (1, 2), (2, 3)], joints, np.random.default_rng(5))


@pytest.mark.sample(1)
@pytest.mark.parametrize("angle", [0.4, 1.1, 2.0])
@pytest.mark.parametrize("cranks", [3, hard(5)])
def test_redundant_joints_leave_the_motion_unique(angle: float, cranks: int, workshop: Workshop) -> None:
    """One degree of freedom, and accelerations that no decomposition of the same mechanism disputes."""
    drawing = parallel_cranks(angle, cranks)
    model = workshop.model(drawing.toml())
    assert model.dof == 1
    u = np.array([1.3] * cranks + [0.0])
    q, _ = model.state_from_poses(drawing.poses, np.zeros_like(drawing.poses))
    wanted, _ = least_squares(drawing, drawing.poses, model.velocities(q, u))
    assert close(model.acceleration(q, u), wanted, 1e-11)
    balance = model.kernels.inverse_dynamics(q[None], u[None], 0.0, model.acceleration(q, u)[None])[0]
    assert close(model.jacobian(q).T @ model.multipliers(q, u), balance, 1e-10)
    least = np.linalg.lstsq(model.jacobian(q).T, balance, rcond=1e-9)[0]
    assert close(model.multipliers(q, u), least, 1e-9)


def test_redundant_joints_run(workshop: Workshop) -> None:
    """A run of a mechanism with a redundant crank keeps its energy and its closure."""
    from ccgen.runtime import simulate

    drawing = parallel_cranks(1.1)
    model = workshop.model(drawing.toml())
    q, _ = model.state_from_poses(drawing.poses, np.zeros_like(drawing.poses))
    run = simulate(model, q, np.array([1.3, 1.3, 1.3, 0.0]), until=1.0, rtol=1e-11)
    assert run.success, run.message
    assert run.closure_max <= 1e-13
    assert run.energy_drift <= 1e-9 * max(abs(e) for e in model.energy(run.q[0], run.u[0]))


@pytest.mark.parametrize("turn", [0.0, 0.3, *map(hard, (np.pi / 2, 2.2, np.pi))])
def test_a_flat_chain_at_rest_falls(turn: float, workshop: Workshop) -> None:
    """The loop's row along the line vanishes; the others count, and gravity does the rest."""
    drawing = flat_chain(turn)
    model = workshop.model(drawing.toml())
    q, u = model.state_from_poses(drawing.poses, np.zeros_like(drawing.poses))
    wanted, _ = least_squares(drawing, drawing.poses, np.zeros_like(drawing.poses))
    assert close(model.acceleration(q, u), wanted, 1e-10)


@pytest.mark.parametrize("bend", [1e-3, 1e-4, 1e-5, 1e-7, 0.0])
def test_near_a_flat_configuration_accelerations_are_those_of_the_branch(bend: float, workshop: Workshop) -> None:
    """They are analytic in the bend, and so are states: bends up to 0.25, where few digits are lost, tell both.
    At the bend itself the closure would tell velocities to 1e-16 by its square only."""
    drawing = flat_chain(0.3)
    model = workshop.model(drawing.toml())
    flat, _ = model.state_from_poses(drawing.poses, np.zeros_like(drawing.poses))

    def there(x: float) -> tuple[Array, Array]:
        q = model.assemble(flat + x * np.array([1.0, -1.7, 0.6]))
        u = np.linalg.svd(model.jacobian(q))[2][-1]
        return q, np.copysign(1.0, u[1]) * u

    points = 0.25 * np.cos((2 * np.arange(16) + 1) * np.pi / 32)
    states = [there(float(x)) for x in points]
    known = np.array([model.acceleration(*state) for state in states])
    q, u, wanted = (
        BarycentricInterpolator(points, values)(bend) for values in (*map(np.array, zip(*states, strict=True)), known)
    )
    assert np.max(np.abs(model.acceleration(q, u) - wanted)) <= 1e-8 * np.max(np.abs(wanted))
