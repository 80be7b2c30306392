"""Many runs side by side: the same as one after the other, in every bit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene, loop
from ccgen.runtime import simulate

from ..support.folders import SCENES
from ..support.workshop import Workshop


@pytest.fixture(scope="module")
def hexagon(workshop: Workshop) -> Any:
    return workshop.model(load_scene(SCENES / "falling-hexagon.toml"))


def starts(model: Any, count: int) -> tuple[Any, Any]:
    rng = np.random.default_rng(8)
    q, u = model.start()
    pairs = [model.project(q + 0.02 * rng.normal(size=q.size), rng.normal(size=u.size)) for _ in range(count)]
    qs, us = np.array([q for q, _ in pairs]), np.array([u for _, u in pairs])
    qs[:, 1] += 0.5  # clear of the ground
    return qs, us


@pytest.mark.parametrize("method", ["gauss", "dop853"])
def test_each_run_is_that_of_its_start_alone(hexagon: Any, method: str) -> None:
    """With impacts, each its own."""
    qs, us = starts(hexagon, 12)
    runs = simulate(hexagon, qs, us, until=0.8, method=method)
    assert len(runs) == 12
    for q, u, run in zip(qs, us, runs, strict=True):
        alone = simulate(hexagon, q, u, until=0.8, method=method)
        assert np.array_equal(run.t, alone.t)
        assert np.array_equal(run.q, alone.q)
        assert np.array_equal(run.u, alone.u)
        assert [i.t for i in run.impacts] == [i.t for i in alone.impacts]
        assert all(np.array_equal(a.impulses, b.impulses) for a, b in zip(run.impacts, alone.impacts, strict=True))
    assert len({len(run.impacts) for run in runs}) > 1


def test_one_velocity_for_all_and_parameters(workshop: Workshop) -> None:
    model = workshop.model(loop(6, gravity=True))
    q, _ = model.start()
    qs = np.array([q, q + np.array([1.0, 2.0, *np.zeros(6)])])
    u = np.array([0.3, 0.0, *np.full(6, 0.1)])
    runs = simulate(model, qs, u, until=0.5, params={"gravity.g": 1.6})
    assert runs[0].model.parameters["gravity.g"] == 1.6
    moved = runs[1].q[-1] - runs[0].q[-1]
    assert moved == pytest.approx([1.0, 2.0, *np.zeros(6)], abs=1e-12)
    still = simulate(model, qs, until=0.1, params={"gravity.g": 0.001})
    assert np.max(np.abs(still[0].u)) < 1e-3


def test_wrong_batches_are_refused(hexagon: Any) -> None:
    q, u = hexagon.start()
    with pytest.raises(ValueError, match=r"found shapes \(2, 8\) and \(3, 8\), expected \(starts, 8\)"):
        simulate(hexagon, [q, q], [u, u, u])
    with pytest.raises(ValueError, match=r"expected \(starts, 8\) for q0"):
        simulate(hexagon, np.zeros((0, 8)))
    with pytest.raises(ValueError, match="the start has joint_0 inside"):
        simulate(hexagon, [q, q - np.array([0.0, 5.0, *np.zeros(6)])], until=0.1)


def test_what_a_controller_raises_stops_the_batch(workshop: Workshop) -> None:
    text = "name = 'batch-driven'\n[chain]\nlinks = 1\nhinged = true\n[[input]]\nname = 'torque'\njoint = 'joint_0'\n"
    model = workshop.model(text)
    q, u = model.start()

    def controller(t: float, q: Any, u: Any) -> float:
        if q[0] > 1.0:
            raise ArithmeticError("too far")
        return 1.0

    with pytest.raises(ArithmeticError, match="too far"):
        simulate(model, [q, q], [u, u], until=5.0, inputs=controller)
