"""External forces and torques: closed forms, and wrong tables."""

from __future__ import annotations

import numpy as np
import pytest

from ccgen.runtime import simulate

from ..support.active import ROD, SINGLE, SWING, Wrong, check_refusal
from ..support.workshop import Workshop


@pytest.mark.parametrize(
    "effect",
    [
        '[[motor]]\njoint = "joint_0"\ntorque = 2.5\n',
        '[[motor]]\njoint = "joint_0"\ntorque = "5/2"\n',
        '[[motor]]\njoint = "joint_0"\ntable = [[1, 2.5], [2, 2.5]]\n',
        '[[torque]]\nlink = "link_0"\ntorque = 2.5\n',
        '[[force]]\npoint = "link_0.B"\nvector = [0, 1.25]\nframe = "link"\n',
    ],
)
def test_constant_torque(effect: str, workshop: Workshop) -> None:
    run = simulate(workshop.model(ROD + effect), until=3.0, rtol=1e-12)
    assert np.max(np.abs(run.q[:, 0] - 2.5 * run.t**2 / (2 * SWING))) <= 1e-11
    assert np.max(np.abs(run.u[:, 0] - 2.5 * run.t / SWING)) <= 1e-11
    assert run.energy_drift <= 1e-11


def test_sinusoidal_force_on_a_free_body(workshop: Workshop) -> None:
    model = workshop.model(SINGLE + '[[force]]\npoint = "body.C"\nvector = ["3*sin(5*t)", "-2*cos(t/2)"]\n')
    run = simulate(model, until=4.0, rtol=1e-12)
    x = 3 / (2 * 25) * (5 * run.t - np.sin(5 * run.t))
    y = -2 / 2 * 4 * (1 - np.cos(run.t / 2))
    assert np.max(np.abs(run.q - np.stack([x, y, 0 * x], axis=1))) <= 1e-11
    assert run.energy_drift <= 1e-10


BAD: dict[str, Wrong] = {
    "force on nothing": (
        '[[force]]\npoint = "link_0.C"\nvector = [0, 1]',
        2,
        "force[0].point",
        'found "link_0.C", expected a joint or link.point that moves; link_0 has the points A, B',
    ),
    "force on the ground": (
        '[[force]]\npoint = "ground.O"\nvector = [0, 1]',
        2,
        "force[0].point",
        "the ground does not move; choose a point of a link",
    ),
    "force in the frame of a joint": (
        '[[force]]\npoint = "joint_0"\nvector = [0, 1]\nframe = "link"',
        2,
        "force[0].point",
        'a joint has two links; write "link.point"',
    ),
    "force of one number": (
        '[[force]]\npoint = "joint_0"\nvector = [1]',
        3,
        "force[0].vector",
        "expected the force [x, y] in N, numbers or expressions of t or of the state; write 2 values",
    ),
    "force with a bad part": (
        '[[force]]\npoint = "joint_0"\nvector = [1, "t t"]',
        3,
        "force[0].vector[1]",
        'found "t t", expected the force [x, y] in N, numbers or expressions of t or of the state; it cannot be read',
    ),
    "force in no frame": (
        '[[force]]\npoint = "joint_0"\nvector = [0, 1]\nframe = "body"',
        4,
        "force[0].frame",
        'found "body", expected "fixed" for fixed axes or "link"',
    ),
    "torque on no link": (
        '[[torque]]\nlink = "ground"\ntorque = 1',
        2,
        "torque[0].link",
        'found "ground", expected a link that moves; the links are link_0',
    ),
    "torque without torque": (
        '[[torque]]\nlink = "link_0"',
        1,
        "torque[0].torque",
        "missing, expected a torque in N m",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_wrong_table(case: str, workshop: Workshop) -> None:
    check_refusal(BAD[case], workshop)
