"""Kernels of contact: the bias of the gaps, and sliding, against the motion of the points themselves."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.generator import loop
from ccgen.runtime import simulate

from ..support.workshop import Workshop


@pytest.fixture(scope="module")
def model(workshop: Workshop) -> Any:
    ground = [{"normal": [0.3, 1.0], "restitution": 0.5, "friction": 0.4}]
    return workshop.model(loop(5, gravity=True, start={"height": 1.0}, ground=ground))


TELESCOPE = """
name = "telescope"
[ground_link]
points = { O = [0, 3.0] }
[[link]]
name = "arm"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { O = [0, 0], A = [0.4, 0.1] }
[[link]]
name = "boom"
mass = 0.7
inertia = 0.2
com = [0.3, 0]
points = { A = [0.1, 0.0], B = [0.9, 0.2] }
[[link]]
name = "rider"
mass = 0.5
inertia = 0.1
com = [0.2, 0.1]
points = { P = [0.1, 0.05], Q = [0.5, 0] }
[[joint]]
name = "axle"
between = ["ground.O", "arm.O"]
[[joint]]
name = "telescope"
type = "prismatic"
between = ["arm.A", "boom.A"]
axis = [1, 0.3]
[[joint]]
name = "slot"
type = "pin-in-slot"
between = [SLOT]
axis = [0.8, -0.2]
[start]
angles = { arm = 0.3, boom = 0.5, rider = -0.4 }
[[ground]]
normal = [0.3, 1.0]
restitution = 0.5
friction = 0.4
contacts = ["boom.B", "rider.Q", "rider.P"]
"""
"""Points that slide along lines that turn: the slot is the boom's, or the rider's own."""

DRAG = """
name = "drag"
[ground_link]
points = { O = [0, 0.5] }
[[link]]
name = "crank"
mass = 1.0
inertia = 0.1
com = [0.15, 0]
points = { O = [0, 0], A = [0.3, 0] }
[[link]]
name = "rod"
mass = 1.0
inertia = 0.1
com = [0.5, 0]
points = { A = [0, 0], B = [1.0, 0] }
[[joint]]
name = "axle"
between = ["ground.O", "crank.O"]
[[joint]]
name = "pin"
between = ["crank.A", "rod.A"]
[start]
angles = { crank = 0.3, rod = -0.5 }
[gravity]
g = 9.81
[[drive]]
joint = "axle"
speed = 2.0
[[ground]]
restitution = 0.3
friction = 0.4
contacts = ["rod.B"]
"""
"""A driven crank drags a rod over rough ground."""


@pytest.fixture(scope="module", params=["loop", "slot of the boom", "slot of the rider"])
def moving(request: pytest.FixtureRequest, model: Any, workshop: Workshop) -> Any:
    if request.param == "loop":
        return model
    slot = '"boom.B", "rider.P"' if request.param == "slot of the boom" else '"rider.P", "boom.B"'
    return workshop.model(TELESCOPE.replace("SLOT", slot))


@pytest.mark.sample(1)
@pytest.mark.parametrize(("rate", "bias"), [("gap_rates", "gap_bias"), ("slips", "slip_bias")])
def test_bias_is_the_rate_of_the_rates(rate: str, bias: str, moving: Any) -> None:
    """d/dt (N u) and d/dt (T u) with u constant, by central differences in long steps of a smooth function."""
    rng = np.random.default_rng(4)
    q, _ = moving.start()
    u = rng.normal(size=q.size)
    step = 1e-4
    ahead, behind = (moving.kernels.of_state(rate, (q + s * u)[None], u[None])[0] for s in (step, -step))
    found = moving.kernels.of_state(bias, q[None].copy(), u[None].copy())[0]
    assert (ahead - behind) / (2 * step) == pytest.approx(found, abs=1e-6)


@pytest.mark.parametrize("method", ["gauss", "dop853", "radau"])
def test_work_of_a_drive_that_drags_over_rough_ground(method: str, workshop: Workshop) -> None:
    """Energy balances through impacts and sliding while the drive and friction do work: the kernel of power
    knows nothing of the forces of contact."""
    run = simulate(workshop.model(DRAG), until=3.0, rtol=1e-11, method=method)
    assert run.success, run.message
    slid = [phase for phase in run.phases if phase.kind == "contact" and phase.end - phase.start > 0.3]
    assert slid and run.impacts
    assert np.ptp(np.sum(run.model.energy(run.q, run.u), axis=0)) > 1.0
    assert run.energy_drift <= 1e-9
    assert -float(run.model.gaps(run.q).min()) <= 1e-12


@pytest.mark.parametrize("drift", ["left", "damped"])
def test_held_contacts_are_projected_however_loops_are_kept(drift: str, model: Any) -> None:
    run = simulate(model, until=3.0, drift=drift, method="dop853")
    assert run.success, run.message
    assert any(phase.kind == "contact" for phase in run.phases)
    assert -float(model.gaps(run.q).min()) <= 1e-11


def test_sliding_is_along_the_ground(model: Any) -> None:
    rng = np.random.default_rng(5)
    q, u = model.start()
    q, u = model.project(q, rng.normal(size=u.size))
    slips = model.kernels.of_state("slips", q[None].copy(), u[None].copy())[0]
    rates = model.gap_rates(q, u)
    velocities = model.velocities(q, u)[:, :2]  # frames sit on the joints
    assert slips**2 + rates**2 == pytest.approx(np.sum(velocities**2, axis=1), rel=1e-12)
    normal = np.array([0.3, 1.0]) / np.hypot(0.3, 1.0)
    assert slips == pytest.approx(velocities @ (normal[1], -normal[0]), rel=1e-12)


def test_states_between_rows_keep_what_is_held(model: Any) -> None:
    """`run.at` inside a contact phase is on the ground to rounding."""
    run = simulate(model, until=3.0)
    held = [phase for phase in run.phases if phase.kind == "contact" and phase.end - phase.start > 0.01]
    assert held
    for phase in held:
        q, u = run.at(np.linspace(phase.start, phase.end, 7)[1:-1])
        chosen = [model.contacts.index(contact) for contact in phase.contacts]
        assert np.max(np.abs(model.gaps(q)[:, chosen])) <= 1e-11
        assert np.max(np.abs(model.gap_rates(q, u)[:, chosen])) <= 1e-10
