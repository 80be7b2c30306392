"""Motors: closed forms, a table against SciPy, and wrong tables."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ccgen.runtime import simulate

from ..oracles.maximal import Array
from ..support.active import LEFT, ROD, SWING, WHEEL, Wrong, check_refusal
from ..support.workshop import Workshop


def test_torque_is_on_the_second_link(workshop: Workshop) -> None:
    """The wheel is the first link of its joint, so a positive torque turns it backwards."""
    model = workshop.model(WHEEL + LEFT + '[[motor]]\njoint = "hub"\ntorque = 2.0\n')
    assert model.acceleration([0.0], [0.0]) == pytest.approx([-0.5], rel=1e-15)
    model.parameters["motor_0.torque"] = -6.0
    assert model.acceleration([0.0], [0.0]) == pytest.approx([1.5], rel=1e-15)


def test_servo_is_a_damped_torsional_oscillator(workshop: Workshop) -> None:
    model = workshop.model(ROD + '[[motor]]\njoint = "joint_0"\nangle = 0.8\nstiffness = 36\ndamping = 2\n')
    run = simulate(model, [0.1], [0.5], until=4.0, rtol=1e-12)
    decay, omega = 2 / (2 * SWING), math.sqrt(36 / SWING - (2 / (2 * SWING)) ** 2)
    a, b = 0.1 - 0.8, (0.5 + decay * (0.1 - 0.8)) / omega
    wanted = 0.8 + np.exp(-decay * run.t) * (a * np.cos(omega * run.t) + b * np.sin(omega * run.t))
    assert np.max(np.abs(run.q[:, 0] - wanted)) <= 1e-10
    assert run.energy_drift <= 1e-9


def test_servo_follows_a_motion_that_needs_no_torque(workshop: Workshop) -> None:
    """On the wanted motion the law gives nothing, so a uniform turn goes on; it damps the difference of the rates."""
    model = workshop.model(ROD + '[[motor]]\njoint = "joint_0"\nangle = "0.2 + 3*t"\nstiffness = 50\ndamping = 9\n')
    run = simulate(model, [0.2], [3.0], until=2.0, rtol=1e-12)
    assert np.max(np.abs(run.u[:, 0] - 3.0)) <= 1e-11


def test_table_is_piecewise_linear(workshop: Workshop) -> None:
    """SciPy's integration of the pendulum from kink to kink; a pulse far shorter than a step is not missed."""
    table = [(0.5, 0.0), (0.9, 30.0), (1.0, -40.0), (1.7, -5.0), (4.0, -5.0), (4.001, 4e3), (4.002, 0.0)]
    text = f'[gravity]\n[[motor]]\njoint = "joint_0"\ntable = {[list(row) for row in table]}\n'
    model = workshop.model(ROD + text)
    times, torques = zip(*table, strict=True)

    def rates(t: float, y: Array) -> list[float]:
        return [y[1], (np.interp(t, times, torques) - 3.0 * 9.81 * math.cos(y[0])) / SWING]

    y, now = np.array([-1.5, 0.0]), 0.0
    run = simulate(model, y[:1], y[1:], until=6.0, rtol=1e-12)
    for kink in (*times, 6.0):
        y = solve_ivp(rates, (now, kink), y, method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
        now = kink
        assert kink in run.t
        assert np.max(np.abs(np.concatenate(run.at(kink)) - y)) <= 1e-9
    assert run.energy_drift <= 1e-8
    fixed = simulate(model, [-1.5], [0.0], until=6.0, step=0.01)
    assert set(times) <= set(fixed.t)
    assert np.max(np.abs(fixed.q[-1] - y[0])) <= 1e-8


def test_values_of_a_table_are_parameters(workshop: Workshop) -> None:
    model = workshop.model(WHEEL + LEFT + '[[motor]]\njoint = "hub"\ntable = [[0, 0], [1, 8], [2, 0]]\n')
    other = model.with_parameters({"motor_0.table.1.t": 0.5, "motor_0.table.1.torque": 4.0})
    for t, (one, two) in {-1.0: (0, 0), 0.25: (2, 2), 0.5: (4, 4), 1.25: (6, 2), 9.0: (0, 0)}.items():
        assert -4.0 * model.acceleration([0.0], [0.0], t) == pytest.approx([one], abs=1e-14)
        assert -4.0 * other.acceleration([0.0], [0.0], t) == pytest.approx([two], abs=1e-14)
    assert 0.5 in simulate(other, until=3.0).t


BAD: dict[str, Wrong] = {
    "motor without joint": ("[[motor]]\ntorque = 1", 1, "motor[0].joint", "missing, expected the name of the joint"),
    "motor at no joint": (
        '[[motor]]\njoint = "knee"\ntorque = 1',
        2,
        "motor[0].joint",
        'found "knee", expected a joint; the joints are joint_0',
    ),
    "motor without law": (
        '[[motor]]\njoint = "joint_0"',
        1,
        "motor[0]",
        "found no torque, table or angle, expected one of them; add one",
    ),
    "motor with two laws": (
        '[[motor]]\njoint = "joint_0"\ntorque = 1\ntable = [[0, 1], [1, 2]]',
        4,
        "motor[0].table",
        "found table beside torque",
    ),
    "motor with three laws": (
        '[[motor]]\njoint = "joint_0"\ntorque = 1\nangle = 1',
        4,
        "motor[0].angle",
        "found angle beside torque",
    ),
    "motor with stiffness alone": (
        '[[motor]]\njoint = "joint_0"\ntorque = 1\nstiffness = 1',
        4,
        "motor[0].stiffness",
        "found stiffness without angle",
    ),
    "servo without gains": (
        '[[motor]]\njoint = "joint_0"\nangle = 1',
        1,
        "motor[0]",
        "found an angle without stiffness and damping",
    ),
    "negative damping": (
        '[[motor]]\njoint = "joint_0"\nangle = 1\ndamping = -1',
        4,
        "motor[0].damping",
        "found -1, expected the damping in N m s/rad, zero or a positive number",
    ),
    "kink in a damped angle": (
        '[[motor]]\njoint = "joint_0"\nangle = "abs(t - 1)"\ndamping = 1',
        3,
        "motor[0].angle",
        "found abs in an angle with damping",
    ),
    "bad expression": (
        '[[motor]]\njoint = "joint_0"\ntorque = "2*foo(t)"',
        3,
        "motor[0].torque",
        'found "2*foo(t)", expected a torque in N m, a number, an expression of t or the state, or rows or pieces over '
        "time; foo(...) is",
    ),
    "torque is true": ('[[motor]]\njoint = "joint_0"\ntorque = true', 3, "motor[0].torque", "found true, expected"),
    "infinite torque": (
        '[[motor]]\njoint = "joint_0"\ntorque = inf',
        3,
        "motor[0].torque",
        "found inf, expected a torque in N m, a number, an expression of t or the state, or rows or pieces over time; "
        "write a finite number",
    ),
    "table of one row": (
        '[[motor]]\njoint = "joint_0"\ntable = [[0, 1]]',
        3,
        "motor[0].table",
        "expected a torque over time, rows [t, torque] in s and N m, at least two; write 2 values",
    ),
    "table of three columns": (
        '[[motor]]\njoint = "joint_0"\ntable = [[0, 1], [1, 2, 3]]',
        3,
        "motor[0].table[1]",
        "expected a torque over time",
    ),
    "table of text": (
        '[[motor]]\njoint = "joint_0"\ntable = [[0, 1], [1, "t"]]',
        3,
        "motor[0].table[1][1]",
        "t is the time, and this is a number that stays",
    ),
    "table that goes back": (
        '[[motor]]\njoint = "joint_0"\ntable = [[0, 1], [2, 1],\n[2, 3]]',
        4,
        "motor[0].table[2]",
        "found t = 2 after t = 2, expected times that grow; correct it",
    ),
    "unknown key": (
        '[[motor]]\njoint = "joint_0"\ntorque = 1\ntorqe = 1',
        4,
        "motor[0].torqe",
        'remove it, "torque" is there already',
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_wrong_table(case: str, workshop: Workshop) -> None:
    check_refusal(BAD[case], workshop)
