"""Small motions: closed forms, an energy method, differences along the loops, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import linearise, static_equilibrium

from ..oracles.maximal import Array
from ..support.folders import ROOT
from ..support.workshop import Workshop

FOUR_BAR = (ROOT / "scenes" / "four-bar.toml").read_text()

PENDULUM = """
name = "swinging"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "arm"
mass = 2.0
inertia = 0.3
com = [0.4, 0]
points = { A = [0, 0], tip = [1, 0] }
[[joint]]
name = "hinge"
between = ["ground.O", "arm.A"]
[gravity]
g = 9.81
[[input]]
name = "push"
joint = "hinge"
[start]
angles = { arm = "-90 deg" }
"""

CART = """
name = "cart"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "cart"
mass = 2.0
inertia = 0.1
com = [0, 0]
points = { A = [0, 0] }
[[joint]]
name = "rail"
type = "prismatic"
axis = [1, 0]
between = ["ground.O", "cart.A"]
[[motor]]
joint = "rail"
position = 0.5
stiffness = 40.0
damping = 12.0
"""


def test_a_compound_pendulum_has_its_frequency(workshop: Workshop) -> None:
    """ω² = m g d / (I + m d²); a torque gives 1 / (I + m d²); the tip moves as the angle does."""
    model = workshop.model(PENDULUM, derivatives=True)
    found = linearise(model, model.start()[0], outputs=["arm.angle", "arm.tip.x", "arm.tip.y", "hinge.fy"])
    about = 0.3 + 2.0 * 0.4**2
    assert found.states == ("arm.angle", "arm.angular_velocity")
    assert pytest.approx(np.array([[0.0, 1.0], [-2.0 * 9.81 * 0.4 / about, 0.0]]), rel=1e-12, abs=1e-12) == found.A
    assert found.B[:, 0] == pytest.approx([0.0, 1.0 / about], rel=1e-12)
    assert pytest.approx(np.array([[1.0, 0.0], [1.0, 0.0], [0.0, 0.0], [0.0, 0.0]]), abs=1e-12) == found.C
    modes = found.modes()
    assert modes.frequencies == pytest.approx([math.sqrt(2.0 * 9.81 * 0.4 / about) / (2 * math.pi)], rel=1e-12)
    assert modes.damping == pytest.approx([0.0], abs=1e-12)
    upside_down = linearise(model, np.array([math.pi / 2]), np.zeros(1))
    assert np.max(upside_down.modes().values.real) == pytest.approx(math.sqrt(2.0 * 9.81 * 0.4 / about), rel=1e-12)


def test_a_damped_cart_has_its_eigenvalues(workshop: Workshop) -> None:
    """s² + (d / m) s + k / m = 0, for its motor is a spring and a damper."""
    model = workshop.model(CART, derivatives=True)
    found = linearise(model, np.array([0.5]))
    assert found.states == ("rail.slide", "rail.slide_rate")
    s = complex(-3.0, math.sqrt(20.0 - 9.0))
    modes = found.modes()
    assert modes.values == pytest.approx([s], rel=1e-12)
    assert modes.damping == pytest.approx([3.0 / math.sqrt(20.0)], rel=1e-12)


def closed_near(model: Any, q: Array, chosen: list[int]) -> Array:
    """The configuration with the ``chosen`` coordinates of q whose loops are shut."""
    others = [i for i in range(len(q)) if i not in chosen]
    for _ in range(30):
        q = q.copy()
        q[others] -= np.linalg.lstsq(model.jacobian(q)[:, others], model.closure(q), rcond=None)[0]
    return q


def rates_with(model: Any, q: Array, chosen: list[int], own: Array) -> Array:
    A, others = model.jacobian(q), [i for i in range(len(q)) if i not in chosen]
    u = np.zeros(len(q))
    u[chosen] = own
    u[others] = -np.linalg.lstsq(A[:, others], A[:, chosen] @ own, rcond=None)[0]
    return u


def test_a_four_bar_swings_as_its_energy_says(workshop: Workshop) -> None:
    """ω² = V'' / M along the one motion that it has, V'' by differences of closed configurations (Rayleigh)."""
    model = workshop.model(FOUR_BAR, derivatives=True)
    q = static_equilibrium(model).q
    found = linearise(model, q)
    assert len(found.states) == 2
    chosen = [model.q_of.index(found.states[0])]
    assert np.max(np.abs(model.jacobian(q) @ found.shapes)) <= 1e-12

    def potential(h: float) -> float:
        moved = q.copy()
        moved[chosen] += h
        return float(model.energy(closed_near(model, moved, chosen), np.zeros(len(q)))[1])

    h = 2e-3
    sharp, wide = ((potential(s) - 2 * potential(0.0) + potential(-s)) / s**2 for s in (h, 2 * h))
    mass = float((found.shapes.T @ model.mass_matrix(q) @ found.shapes)[0, 0])
    assert -found.A[1, 0] == pytest.approx((4 * sharp - wide) / 3 / mass, rel=1e-7)
    assert found.modes().frequencies[0] == pytest.approx(math.sqrt(-found.A[1, 0]) / (2 * math.pi), rel=1e-12)


def test_about_a_motion_it_is_the_difference_of_neighbours(workshop: Workshop) -> None:
    """The crank turns: how the acceleration of the state depends on it, loops shut at every neighbour."""
    model = workshop.model(FOUR_BAR, derivatives=True)
    q, u = model.start()
    u = rates_with(model, q, [0], np.array([5.0]))
    found = linearise(model, q, u, outputs=["crank.angle", "rocker.angular_velocity", "knee.fx", "kinetic_energy"])
    chosen = [model.q_of.index(found.states[0])]

    def seen(dq: float, du: float) -> Array:
        moved = q.copy()
        moved[chosen] += dq
        moved = closed_near(model, moved, chosen)
        rates = rates_with(model, moved, chosen, u[chosen] + du)
        outputs = [moved[0], rates[2], model.reactions(moved, rates)[1, 0], model.energy(moved, rates)[0]]
        return np.array([model.acceleration(moved, rates)[chosen[0]], *outputs])

    h = 1e-4
    columns = [(seen(h, 0.0) - seen(-h, 0.0)) / (2 * h), (seen(0.0, h) - seen(0.0, -h)) / (2 * h)]
    wanted = np.array(columns).T
    assert found.A[1] == pytest.approx(wanted[0], rel=1e-6, abs=1e-6)
    assert np.max(np.abs(found.C - wanted[1:])) <= 1e-6 * np.max(np.abs(wanted))


def test_it_goes_to_python_control(workshop: Workshop) -> None:
    control = pytest.importorskip("control")
    model = workshop.model(PENDULUM, derivatives=True)
    found = linearise(model, model.start()[0])
    system = found.to_control()
    assert system.state_labels == ["arm_angle", "arm_angular_velocity"]
    assert sorted(control.poles(system).imag) == pytest.approx(
        [-2 * math.pi * found.modes().frequencies[0], 2 * math.pi * found.modes().frequencies[0]]
    )


def test_what_cannot_be_linearised_is_said(workshop: Workshop) -> None:
    plain = workshop.model(PENDULUM)
    with pytest.raises(ValueError, match="derivatives=True"):
        linearise(plain, plain.start()[0])
    model = workshop.model(PENDULUM, derivatives=True)
    q = model.start()[0]
    with pytest.raises(ValueError, match="inputs: found pull, expected some of push"):
        linearise(model, q, inputs=["pull"])
    with pytest.raises(ValueError, match=r"outputs: found arm\.tip\.vx, expected some of arm\.angle"):
        linearise(model, q, outputs=["arm.tip.vx"])
    with pytest.raises(ValueError, match="expected one state"):
        linearise(model, np.zeros((2, 1)))
    integral = workshop.model(CART + "integral = 3.0\n", derivatives=True)
    with pytest.raises(ValueError, match="without integrals over time"):
        linearise(integral, integral.start()[0])
    four_bar = workshop.model(FOUR_BAR, derivatives=True)
    with pytest.raises(ValueError, match="open by"):
        linearise(four_bar, four_bar.start()[0] + [0.1, 0.0, 0.0])
