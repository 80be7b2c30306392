"""Accelerations as functions of numbers: beside a formula, and in a problem of optimal control by CasADi."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import acceleration_function

from ..support.bounced import BOUNCED
from ..support.folders import SCENES
from ..support.workshop import Workshop

ARM = """
name = "lifted"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "arm"
mass = 2.0
inertia = 0.3
com = [0.4, 0]
points = { A = [0, 0] }
[[joint]]
name = "hinge"
between = ["ground.O", "arm.A"]
[gravity]
g = 9.81
[[input]]
name = "torque"
joint = "hinge"
[start]
angles = { arm = "-90 deg" }
"""
ABOUT = 0.3 + 2.0 * 0.4**2


@pytest.fixture(scope="module")
def arm(workshop: Workshop) -> Any:
    return acceleration_function(workshop.model(ARM, derivatives=True), inputs=0.5)


def test_an_arm_is_its_formula(arm: Any) -> None:
    """(torque - m g d cos θ) / (I + m d²)."""
    assert arm.columns == ("arm.angle", "arm.angular_velocity", "torque") and arm.count == 1
    assert arm.x0 == pytest.approx([-np.pi / 2, 0.0, 0.5])
    x = np.array([0.4, -3.0, 2.0])
    value, jacobian = arm.value_and_jacobian(x)
    assert value == pytest.approx([(2.0 - 2.0 * 9.81 * 0.4 * np.cos(0.4)) / ABOUT], rel=1e-13)
    assert jacobian == pytest.approx(np.array([[2.0 * 9.81 * 0.4 * np.sin(0.4) / ABOUT, 0.0, 1.0 / ABOUT]]), rel=1e-13)
    found, gradient = arm.value_and_gradient(x)
    assert found == value[0] and np.array_equal(gradient, jacobian[0])


def test_a_loop_off_its_closure_is_that_of_differences(workshop: Workshop) -> None:
    function = acceleration_function(workshop.model(load_scene(SCENES / "four-bar.toml"), derivatives=True))
    x = function.x0 + 0.05 * np.sin(np.arange(len(function.x0)))
    h, jacobian = 1e-4, function.jacobian(x)

    def moved(k: int, step: float) -> Any:
        e = step * np.eye(len(x))[k]
        return (function(x + e) - function(x - e)) / (2.0 * step)

    wanted = np.array([(4.0 * moved(k, h) - moved(k, 2.0 * h)) / 3.0 for k in range(len(x))]).T
    assert np.abs(jacobian - wanted).max() <= 1e-9 * np.abs(wanted).max()


def test_the_least_torque_that_lifts_an_arm(arm: Any) -> None:
    """Collocation by the trapezoidal rule: the same problem with the formula in place of the model has the same
    solution."""
    casadi = pytest.importorskip("casadi", reason="needs the package casadi: pip install 'ccgen[casadi]'")
    nodes, h = 9, 0.125

    def solved(acceleration: Any) -> Any:
        q, u, torque = (casadi.MX.sym(name, nodes) for name in ("q", "u", "torque"))
        a = casadi.vertcat(*(acceleration(casadi.vertcat(q[k], u[k], torque[k])) for k in range(nodes)))
        closed = [
            casadi.diff(q) - h / 2.0 * (u[:-1] + u[1:]),
            casadi.diff(u) - h / 2.0 * (a[:-1] + a[1:]),
            casadi.vertcat(q[0] + np.pi / 2, u[0], q[-1], u[-1]),
        ]
        problem = {"x": casadi.vertcat(q, u, torque), "f": casadi.sumsqr(torque), "g": casadi.vertcat(*closed)}
        options = {"print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.tol": 1e-11}
        solver = casadi.nlpsol("s", "ipopt", problem, options | {"ipopt.hessian_approximation": "limited-memory"})
        start = np.concatenate([np.linspace(-np.pi / 2, 0.0, nodes), np.zeros(nodes), np.zeros(nodes)])
        found = solver(x0=start, lbg=0.0, ubg=0.0)
        assert solver.stats()["success"], solver.stats()["return_status"]
        return np.array(found["x"]).ravel()

    found = solved(arm.to_casadi("arm"))
    wanted = solved(lambda x: (x[2] - 2.0 * 9.81 * 0.4 * casadi.cos(x[0])) / ABOUT)
    assert np.abs(found - wanted).max() <= 1e-6 * np.abs(wanted).max()
    assert np.abs(found[2 * nodes :]).max() > 1.0


def test_wrong_use_is_refused(arm: Any, workshop: Workshop) -> None:
    with pytest.raises(ValueError, match=r"x: found shape \(2,\), expected \(3,\): arm.angle, arm.angular_velocity"):
        arm([0.0, 1.0])
    with pytest.raises(ValueError, match=r"x: found what is no finite number for torque"):
        arm.jacobian([0.0, 1.0, np.nan])
    with pytest.raises(ValueError, match=r"inputs: found 'push', expected one of torque"):
        acceleration_function(arm.model, inputs={"push": 1.0})
    for wrong in (float("nan"), "1", [0.0, 1.0]):
        with pytest.raises(ValueError, match=r"^t: found .*, expected (a time in s|numbers)"):
            acceleration_function(arm.model, t=wrong)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="derivatives"):
        acceleration_function(workshop.model(BOUNCED))
    with pytest.raises(ValueError, match="double"):
        acceleration_function(workshop.model(BOUNCED, "wide"))
    with pytest.raises(TypeError, match="model: found str, expected a Model"):
        acceleration_function("arm")  # type: ignore[arg-type]
