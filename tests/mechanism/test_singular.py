"""Flattened loops, whatever their direction, and many turns of a link."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.generator import loop

from ..support.workshop import Workshop

PI = np.pi
FLAT = {
    "doubled": [0.0, 0.0, PI, PI],
    "doubled-upright": [PI / 2, PI / 2, -PI / 2, -PI / 2],
    "folded": [0.0, PI, 0.0, PI],
}
TURNS = [0.0, 0.3, 1.0, -2.1, PI / 4, PI / 3, PI, 17.3, 1e-9]


@pytest.fixture(scope="module")
def square(workshop: Workshop) -> Any:
    return workshop.model(loop(4))


def states(model: Any, angles: list[float], turn: float) -> tuple[np.ndarray, np.ndarray]:
    """The loop at these angles, turned, and some velocities."""
    rng = np.random.default_rng(3)
    q = np.array([0.0, 0.0, *(np.array(angles) + turn)])
    assert np.max(np.abs(model.closure(q))) <= 1e-14
    return q, rng.normal(size=6)


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("name", FLAT)
def test_a_flattened_loop_at_rest_stays(square: Any, name: str, turn: float) -> None:
    """Nothing acts on it, so nothing moves, whatever its direction; the multipliers are those of least norm."""
    q, u = states(square, FLAT[name], turn)
    assert np.max(np.abs(square.acceleration(q, 0 * u))) <= 1e-14
    assert np.max(np.abs(square.multipliers(q, 0 * u))) <= 1e-14


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("name", FLAT)
def test_a_flattened_loop_that_moves(square: Any, name: str, turn: float) -> None:
    """Accelerations have the size of the velocities squared, not of what a vanishing pivot would make of them."""
    q, u = square.project(*states(square, FLAT[name], turn))
    u_dot = square.acceleration(q, u)
    assert np.max(np.abs(u_dot)) <= 100 * np.max(np.abs(u)) ** 2
    momentum = square.kernels.inverse_dynamics(q[None], u[None], 0.0, u_dot[None])[0]
    rows = square.jacobian(q)
    assert np.max(np.abs(rows.T @ square.multipliers(q, u) - momentum)) <= 1e-11


@pytest.mark.parametrize("bend", [1e-2, 1e-3])
def test_a_loop_that_is_nearly_flat_moves(square: Any, bend: float) -> None:
    """A thin rhombus is regular: nothing may be refused there."""
    for turn in TURNS:
        angles = np.array([0.0, bend, PI, PI + bend]) + turn
        q, u = square.project(np.array([0.0, 0.0, *angles]), np.ones(6))
        assert np.all(np.isfinite(square.acceleration(q, u)))


# -- many turns ----------------------------------------------------------------------------------------------------


def turned(model: Any, q: np.ndarray, turns: int) -> np.ndarray:
    """The same configuration with every angle some whole turns on."""
    angles = [k for k, name in enumerate(model.q_names) if name.startswith("theta_")]
    q = q.copy()
    q[angles] += 2 * PI * turns
    return q


def test_a_triangle_that_spins_for_long(workshop: Workshop) -> None:
    """159 turns: the loop stays shut, and the triangle stands where an even rotation puts it."""
    from ccgen.runtime import simulate

    model = workshop.model(loop(3))
    q, u = model.start()
    poses = model.poses(q)
    spin, arms = 10.0, poses[:, :2] - poses[:, :2].mean(axis=0)
    moving = np.column_stack([-spin * arms[:, 1], spin * arms[:, 0], np.full(3, spin)])
    q, u = model.state_from_poses(poses, moving)
    run = simulate(model, q, u, until=100.0)
    assert run.success, run.message
    assert run.closure_max <= 1e-11
    assert run.energy_drift <= 1e-10 * sum(model.energy(q, u))
    end = model.poses(run.q[-1])
    assert end[:, 2] - poses[:, 2] == pytest.approx(spin * 100.0, abs=1e-6)
    c, s = np.cos(1000.0), np.sin(1000.0)
    wanted = poses[:, :2].mean(axis=0) + arms @ np.array([[c, s], [-s, c]])
    assert np.max(np.abs(end[:, :2] - wanted)) <= 1e-6


@pytest.mark.parametrize("turns", [100, -100])
@pytest.mark.parametrize("links", [3, 4, 6])
def test_projection_after_many_turns(links: int, turns: int, workshop: Workshop) -> None:
    model = workshop.model(loop(links))
    q, u = model.start()
    rng = np.random.default_rng(links)
    q, u = model.project(q, rng.normal(size=u.size))
    far, u_far = model.project(turned(model, q, turns), u)
    difference = model.poses(far) - model.poses(q)
    assert np.max(np.abs(difference[:, :2])) <= 1e-10
    assert np.max(np.abs(difference[:, 2] - 2 * PI * turns)) <= 1e-10
    assert np.max(np.abs(u_far - u)) <= 1e-10


@pytest.mark.parametrize("turns", [50, -50])
def test_accelerations_after_many_turns(turns: int, workshop: Workshop) -> None:
    model = workshop.model(loop(6, gravity=True))
    q, u = model.start()
    q, u = model.project(q, np.random.default_rng(6).normal(size=u.size))
    near, far = model.acceleration(q, u), model.acceleration(turned(model, q, turns), u)
    assert np.max(np.abs(far - near)) <= 1e-11 * np.max(np.abs(near))
