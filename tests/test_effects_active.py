"""Motors, external forces and torques, inputs: dense references, closed forms, and equal laws by different ways."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ccgen.generator.effects import expressions
from ccgen.generator.effects.expressions import Expression, ExpressionError
from ccgen.generator.pipeline import listing
from ccgen.generator.program.reading import read_listing
from ccgen.generator.scene import SceneError
from ccgen.runtime import simulate

from .conftest import Workshop
from .oracles import loads, maximal, mechanisms
from .oracles.loads import Acting
from .oracles.maximal import Array
from .test_acceleration import allowed, close, quasi_accelerations, states

T = 0.37
"""A time at which accelerations are compared."""

TABLE = [(0.1, 2.0), (0.3, -1.0), (0.45, 4.0), (0.5, 4.0), (2.0, 0.5)]
ACTIVE = f"""
[[motor]]
joint = "joint_0"
torque = "2*sin(3*t) + exp(-t)/(1 + t**2) - 0.25*sqrt(1 + t)*tanh(t)"
[[motor]]
joint = "joint_1"
table = {[list(row) for row in TABLE]}
[[motor]]
joint = "joint_2"
angle = "0.3*sin(2*t)**2 + log(2 + t)"
stiffness = 30
damping = 0.7
[[force]]
name = "wind"
point = "body_1.SPOT1"
vector = [3.0, "cos(pi*t)"]
[[force]]
point = "body_2.SPOT2"
vector = ["abs(t - 1)", -2.0]
frame = "link"
[[torque]]
link = "body_1"
torque = -1.5
[[input]]
name = "push"
point = "body_2.SPOT2"
direction = [3, 4]
[[input]]
name = "tail"
point = "body_2.SPOT2"
direction = [0, -2]
frame = "link"
[[input]]
name = "servo"
joint = "joint_1"
[[input]]
name = "spin"
link = "body_2"
"""
INPUTS = {"push": 2.0, "servo": -3.0, "spin": 0.8, "tail": 1.7}


class Driven:
    """A drawn mechanism with every active effect at once, and what they do as the reference computes it."""

    def __init__(self, family: str, n: int) -> None:
        drawing = mechanisms.FAMILIES[family](n)
        self.drawing = replace(drawing, system=drawing.system.with_gravity(0.0))
        self.spots = [list(drawing.points[k]) for k in range(len(drawing.points))]
        text = ACTIVE.replace("SPOT1", self.spots[1][-1]).replace("SPOT2", self.spots[2][-1])
        self.text = self.drawing.toml(extra=text)

    def acting(self, poses: Array, velocities: Array, t: float, inputs: dict[str, float]) -> Acting:
        acting, pins = Acting(self.drawing.system, poses, velocities), self.drawing.system.pins
        angles, spins = np.array([*acting.poses[:, 2], 0]), np.array([*acting.velocities[:, 2], 0])
        wanted = 0.3 * math.sin(2 * t) ** 2 + math.log(2 + t)
        rate = 1.2 * math.sin(2 * t) * math.cos(2 * t) + 1 / (2 + t)
        one, other = pins[2].a, pins[2].b
        servo = 30 * (wanted - angles[other] + angles[one]) + 0.7 * (rate - spins[other] + spins[one])
        given = 2 * math.sin(3 * t) + math.exp(-t) / (1 + t * t) - 0.25 * math.sqrt(1 + t) * math.tanh(t)
        table = float(np.interp(t, *zip(*TABLE, strict=True)))
        for pin, torque in zip(pins, (given, table + inputs["servo"], servo), strict=False):
            acting.twist(pin.a, pin.b, torque)
            acting.power += torque * (spins[pin.b] - spins[pin.a])
        for link, torque in ((1, -1.5), (2, inputs["spin"])):
            acting.twist(-1, link, torque)
            acting.power += torque * spins[link]
        turn = angles[2]
        self._push(acting, 1, np.array([3.0, math.cos(math.pi * t)]))
        self._push(acting, 2, maximal.turned(turn, [abs(t - 1), -2.0]))
        self._push(acting, 2, inputs["push"] * np.array([0.6, 0.8]))
        self._push(acting, 2, maximal.turned(turn, [0.0, -inputs["tail"]]))
        return acting

    def _push(self, acting: Acting, link: int, force: Array) -> None:
        place = link, self.drawing.points[link][self.spots[link][-1]]
        acting.push(place, force)
        acting.power += force @ acting.at(place)[1]

    def solve(self, acting: Acting) -> maximal.Motion:
        motion: maximal.Motion = loads.accelerate(
            self.drawing.system, acting.poses, acting.velocities, acting.wrenches, (0, -1)
        )
        return motion


FAMILIES = [("hinged", 3), ("floating", 4), ("two_loops", 7), ("pinned", 4), ("open", 12)]


@pytest.fixture(scope="module", params=FAMILIES, ids=str)
def driven(request: pytest.FixtureRequest, workshop: Workshop) -> tuple[Any, Driven]:
    case = Driven(*request.param)
    return workshop.model(case.text), case


# --- against the dense reference --------------------------------------------------------------------------------------


def test_accelerations_are_those_of_the_dense_solve(driven: tuple[Any, Driven]) -> None:
    model, case = driven
    assert model.inputs == ("push", "tail", "servo", "spin")
    for inputs in (INPUTS, None, {"spin": -5.0}, [0.1, 0.2, 0.3, 0.4]):
        values = dict.fromkeys(model.inputs, 0.0)
        values |= inputs if isinstance(inputs, dict) else dict(zip(model.inputs, inputs or [], strict=False))
        for state in states(model, case.drawing, 3):
            for t in (0.0, T, 0.47, 5.0):
                acting = case.acting(state.poses, state.velocities, t, values)
                wanted = quasi_accelerations(model, case.solve(acting))
                assert close(model.acceleration(state.q, state.u, t, inputs), wanted, allowed(case.drawing.system))


def test_reactions_and_multipliers_hold_the_loads(driven: tuple[Any, Driven]) -> None:
    model, case = driven
    pins = case.drawing.system.pins
    for state in states(model, case.drawing, 3):
        forces = case.solve(case.acting(state.poses, state.velocities, T, INPUTS)).forces
        signs = [1.0 if model.outboard[k] == f"body_{pin.b}" else -1.0 for k, pin in enumerate(pins)]
        reactions = model.reactions(state.q, state.u, T, INPUTS)
        assert close(reactions[:, :2], np.array(signs)[:, None] * forces, allowed(case.drawing.system))
        cuts = np.array([row for name in model.cuts for row in forces[model.joints.index(name)]], float)
        miss = np.max(np.abs(model.multipliers(state.q, state.u, T, INPUTS) - cuts), initial=0.0)
        assert miss <= allowed(case.drawing.system) * float(np.max(np.abs(forces)))


def test_power(driven: tuple[Any, Driven], workshop: Workshop) -> None:
    model, case = driven
    listed = read_listing(listing(workshop.scene(case.text)))
    for state in states(model, case.drawing, 3):
        wanted = float(case.acting(state.poses, state.velocities, T, INPUTS).power)
        inputs = np.array([INPUTS[name] for name in model.inputs])
        given = {"q": state.q, "u": state.u, "t": np.array([T]), "inputs": inputs}
        assert listed.evaluate("power", given)["power"][0] == pytest.approx(wanted, rel=1e-12, abs=1e-12)
        found = listed.evaluate("acceleration", given)["u_dot"]
        assert close(found, model.acceleration(state.q, state.u, T, INPUTS), 1e-11)


@pytest.mark.parametrize("inputs", ["none", "constant", "table", "controller"])
def test_work_closes_the_energy_balance(driven: tuple[Any, Driven], inputs: str) -> None:
    model, _ = driven
    q, u = model.start()
    given: Any = {
        "none": None,
        "constant": INPUTS,
        "table": {"t": [0.2, 0.7, 0.9], "push": [0.0, 5.0, 1.0], "servo": [1.0, -1.0, -1.0]},
        "controller": lambda t, q, u: {"spin": math.sin(3 * t) - 0.2 * u[-1]},
    }[inputs]
    run = simulate(model, q, 0 * u, until=1.0, rtol=1e-11, inputs=given)
    assert run.success, run.message
    kinetic, potential = model.energy(run.q, run.u)
    assert np.ptp(kinetic + potential) > 0.1
    assert run.energy_drift <= 1e-8 * np.max(kinetic)


# --- closed forms -----------------------------------------------------------------------------------------------------

ROD = 'name = "rod"\n[chain]\nlinks = 1\nhinged = true\nmass = 3.0\nlength = 2.0\n'
SWING = 3.0 * 2.0**2 / 3
"""Inertia of the rod about its hinge."""
LEFT = '[[joint]]\nname = "hub"\nbetween = ["wheel.C", "ground.O"]\n'
WHEEL = (
    'name = "wheel"\n[ground_link]\npoints = { O = [0, 0] }\n[[link]]\nname = "wheel"\nmass = 1.0\ninertia = 4.0\n'
    "com = [0, 0]\npoints = { C = [0, 0] }\n"
)
SINGLE = (
    'name = "body"\n[[link]]\nname = "body"\nmass = 2.0\ninertia = 0.5\ncom = [0, 0]\n'
    "points = { C = [0, 0], P = [0.3, 0] }\n"
)


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


def test_sinusoidal_force_on_a_free_body(workshop: Workshop) -> None:
    model = workshop.model(SINGLE + '[[force]]\npoint = "body.C"\nvector = ["3*sin(5*t)", "-2*cos(t/2)"]\n')
    run = simulate(model, until=4.0, rtol=1e-12)
    x = 3 / (2 * 25) * (5 * run.t - np.sin(5 * run.t))
    y = -2 / 2 * 4 * (1 - np.cos(run.t / 2))
    assert np.max(np.abs(run.q - np.stack([x, y, 0 * x], axis=1))) <= 1e-11
    assert run.energy_drift <= 1e-10


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


# --- inputs -----------------------------------------------------------------------------------------------------------

ARM = 'name = "arm"\n[chain]\nlinks = 3\nhinged = true\n[start]\nangles = [-0.5, 0.4, 1.0]\n[gravity]\n'


def test_constant_input_is_the_effect(workshop: Workshop) -> None:
    effects = (
        '[[force]]\npoint = "link_2.B"\nvector = [1.5, 0]\n[[torque]]\nlink = "link_1"\ntorque = -0.7\n'
        '[[motor]]\njoint = "joint_2"\ntorque = 0.3\n'
    )
    inputs = (
        '[[input]]\nname = "push"\npoint = "link_2.B"\ndirection = [7, 0]\n[[input]]\nname = "turn"\nlink = "link_1"\n'
        '[[input]]\nname = "knee"\njoint = "joint_2"\n'
    )
    values = {"push": 1.5, "turn": -0.7, "knee": 0.3}
    one, other = workshop.model(ARM + effects), workshop.model(ARM + inputs)
    q, u = one.start()
    u = u + 1.0
    assert np.max(np.abs(other.acceleration(q, u, 0.0, values) - one.acceleration(q, u))) <= 1e-14
    wanted, found = simulate(one, q, u, until=2.0), simulate(other, q, u, until=2.0, inputs=values)
    assert wanted.t.shape == found.t.shape
    assert np.max(np.abs(found.q - wanted.q)) <= 1e-11
    assert found.energy_drift == pytest.approx(wanted.energy_drift, abs=1e-11)
    assert np.max(np.abs(found.at(1.3)[0] - wanted.at(1.3)[0])) <= 1e-11
    for same in ([1.5, -0.7, 0.3], np.array([1.5, -0.7, 0.3]), {"t": [0.0], **{k: [v] for k, v in values.items()}}):
        assert np.array_equal(simulate(other, q, u, until=2.0, inputs=same).q, found.q)
    constant = simulate(other, q, u, until=2.0, inputs=lambda t, q, u: values)
    assert np.array_equal(constant.q, found.q)


def test_inputs_are_zero_unless_given(workshop: Workshop) -> None:
    model = workshop.model(ARM + '[[input]]\nname = "knee"\njoint = "joint_2"\n')
    plain = workshop.model(ARM)
    q, u = plain.start()
    assert not np.array_equal(model.acceleration(q, u, 0.0, 2.0), plain.acceleration(q, u))
    for none in (None, {}, [0.0], 0.0):
        assert np.max(np.abs(model.acceleration(q, u, 0.0, none) - plain.acceleration(q, u))) <= 1e-14
    run = simulate(model, until=1.0)
    end = run.q[-1]
    run.model.acceleration(q, u, 0.0, 2.0)
    assert np.max(np.abs(run.at(1.0 - 1e-13)[0] - end)) <= 1e-11
    assert np.max(np.abs(end - simulate(plain, until=1.0).q[-1])) <= 1e-8


def test_controller_is_the_law(workshop: Workshop) -> None:
    """A proportional-derivative law in Python against the same law as an effect."""
    law = '[[motor]]\njoint = "joint_1"\nangle = "0.5*sin(2*t)"\nstiffness = 20\ndamping = 1.5\n'
    effect = workshop.model(ARM + law)
    model = workshop.model(ARM + '[[input]]\nname = "knee"\njoint = "joint_1"\n')
    asked = []

    def control(t: float, q: Array, u: Array) -> float:
        asked.append((t, q, u))
        wanted, rate = 0.5 * math.sin(2 * t), math.cos(2 * t)
        return float(20 * (wanted - (q[1] - q[0])) + 1.5 * (rate - (u[1] - u[0])))

    wanted, found = simulate(effect, until=3.0, rtol=1e-11), simulate(model, until=3.0, rtol=1e-11, inputs=control)
    assert len(asked) >= found.nfev
    assert len({id(q) for _, q, _ in asked}) == len(asked), "states are the controller's to keep"
    for t in (1.0, 2.0, 3.0):
        assert np.max(np.abs(np.concatenate(found.at(t)) - np.concatenate(wanted.at(t)))) <= 1e-9
    assert found.energy_drift <= 1e-9


def test_table_of_inputs_is_the_table_of_a_motor(workshop: Workshop) -> None:
    rows = [(0.2, 1.0), (0.6, -3.0), (0.9, 2.0)]
    effect = workshop.model(ARM + f'[[motor]]\njoint = "joint_1"\ntable = {[list(row) for row in rows]}\n')
    model = workshop.model(ARM + '[[input]]\nname = "knee"\njoint = "joint_1"\n')
    t, values = zip(*rows, strict=True)
    wanted = simulate(effect, until=2.0, rtol=1e-11)
    found = simulate(model, until=2.0, rtol=1e-11, inputs={"t": t, "knee": values})
    assert {0.2, 0.6, 0.9} <= set(wanted.t) & set(found.t)
    for instant in (0.2, 0.4, 0.6, 0.77, 0.9, 1.5, 2.0):
        assert np.max(np.abs(found.at(instant)[0] - wanted.at(instant)[0])) <= 1e-9


def test_what_a_controller_raises_ends_the_run(workshop: Workshop) -> None:
    model = workshop.model(ARM + '[[input]]\nname = "knee"\njoint = "joint_2"\n')
    times = []

    def control(t: float, q: Array, u: Array) -> list[float]:
        times.append(t)
        if t > 0.5:
            raise LookupError("no more set points")
        return [0.0]

    with pytest.raises(LookupError, match="no more set points"):
        simulate(model, until=2.0, inputs=control)
    assert times[-1] > 0.5
    assert sum(t > 0.5 for t in times) == 1
    assert simulate(model, until=2.0).success


def test_ctrl_c_in_a_controller_is_ctrl_c(workshop: Workshop) -> None:
    model = workshop.model(ARM + '[[input]]\nname = "knee"\njoint = "joint_2"\n')

    def control(t: float, q: Array, u: Array) -> float:
        if t > 0.5:
            raise KeyboardInterrupt
        return 0.0

    with pytest.raises(KeyboardInterrupt):
        simulate(model, until=2.0, inputs=control)
    run = simulate(model, until=2.0, inputs=control, keep_interrupted=True)
    assert not run.success
    assert "interrupted" in run.message


BAD_INPUTS: dict[str, tuple[Any, str]] = {
    "unknown name": ({"knie": 1.0}, "inputs: found 'knie', expected one of knee, push"),
    "too few": ([1.0], r"inputs: found shape (1,), expected (2,): knee, push"),
    "too many": ([1.0, 2.0, 3.0], "inputs: found shape (3,)"),
    "a number for two": (1.0, "inputs: found shape ()"),
    "text": ("full", "inputs: found 'full', expected numbers"),
    "text by name": ({"push": "full"}, "inputs: push: found 'full', expected numbers"),
    "a list by name": ({"push": [1.0, 2.0]}, "inputs: push: found shape (2,), expected a number"),
    "not finite": ({"push": math.nan}, "inputs: push: found nan, expected finite numbers"),
}
BAD_RUNS: dict[str, tuple[Any, str]] = {
    "table without growth": ({"t": [0, 0], "push": [1, 2]}, "inputs: t: found no row of times that grow"),
    "table without rows": ({"t": [], "push": []}, "inputs: t: found no row of times that grow"),
    "short row": ({"t": [0, 1], "push": [1]}, "inputs: push: found shape (1,), expected (2,)"),
    "unknown row": ({"t": [0, 1], "pull": [1, 2]}, "inputs: found 'pull', expected one of t, knee, push"),
    "controller gives nothing": (lambda t, q, u: None, "inputs at t = 0: found None, expected values of knee, push"),
    "controller gives one": (lambda t, q, u: [1.0], "inputs at t = 0: found shape (1,)"),
    "controller gives nan": (lambda t, q, u: [1.0, math.nan], "inputs at t = 0: found nan"),
}


@pytest.fixture(scope="module")
def two_inputs(workshop: Workshop) -> Any:
    text = (
        '[[input]]\nname = "knee"\njoint = "joint_2"\n[[input]]\nname = "push"\npoint = "joint_1"\ndirection = [1, 1]\n'
    )
    return workshop.model(ARM + text)


@pytest.mark.parametrize("case", [*BAD_INPUTS, *BAD_RUNS])
def test_wrong_inputs_are_sentences(case: str, two_inputs: Any) -> None:
    given, words = {**BAD_INPUTS, **BAD_RUNS}[case]
    with pytest.raises(ValueError, match=re.escape(words)):
        simulate(two_inputs, inputs=given)
    if case in BAD_INPUTS:
        for function in (two_inputs.acceleration, two_inputs.multipliers, two_inputs.reactions):
            with pytest.raises(ValueError, match=re.escape(words)):
                function(*two_inputs.start(), 0.0, given)


def test_a_model_without_inputs_takes_none(workshop: Workshop) -> None:
    model = workshop.model(ARM)
    assert model.inputs == ()
    calls: list[Callable[[], object]] = [
        lambda: model.acceleration(*model.start(), 0.0, [1.0]),
        lambda: simulate(model, inputs=lambda t, q, u: []),
        lambda: simulate(model, inputs={"t": [0, 1]}),
    ]
    for call in calls:
        with pytest.raises(ValueError, match="the model has no inputs"):
            call()


def test_direction_is_a_unit_vector(workshop: Workshop) -> None:
    """Also when its parameters are changed; along an axis there are none."""
    model = workshop.model(SINGLE + '[[input]]\nname = "jet"\npoint = "body.C"\ndirection = [30, 40]\n')
    q = u = np.zeros(3)
    assert model.acceleration(q, u, 0.0, 10.0) == pytest.approx([3.0, 4.0, 0.0], rel=1e-15)
    model.parameters["jet.direction.x"] = 0.8
    assert model.acceleration(q, u, 0.0, 2.0) == pytest.approx([0.5**0.5, 0.5**0.5, 0.0], rel=1e-15)
    axis = workshop.model(SINGLE + '[[input]]\nname = "jet"\npoint = "body.C"\ndirection = [0, -3]\nframe = "link"\n')
    assert not [path for path in axis.parameters if path.startswith("jet")]
    assert axis.acceleration([0, 0, math.pi / 2], u, 0.0, 2.0) == pytest.approx([1.0, 0.0, 0.0], abs=1e-15)


# --- expressions ------------------------------------------------------------------------------------------------------

EXPRESSIONS: dict[str, Callable[[float], float]] = {
    "2*sin(3*t) + 0.5": lambda t: 2 * math.sin(3 * t) + 0.5,
    " t ": lambda t: t,
    "-t**2/(1 + t)": lambda t: -(t**2) / (1 + t),
    "(1 + t)**-3": lambda t: (1 + t) ** -3,
    "+pi*cos(2*pi*t - 1e-3)": lambda t: math.pi * math.cos(2 * math.pi * t - 1e-3),
    "exp(-t)*log(1 + t)*sqrt(2 + t)*sqrt(2 + t)**3": lambda t: math.exp(-t) * math.log(1 + t) * (2 + t) ** 2,
    "tanh(10*(t - 0.5))*abs(sin(7*t) - 0.2)": lambda t: math.tanh(10 * (t - 0.5)) * abs(math.sin(7 * t) - 0.2),
    "tan(t/2)**2 + 2**0.5": lambda t: math.tan(t / 2) ** 2 + 2**0.5,
    "exp(0.5*log(1 + t))": lambda t: math.sqrt(1 + t),
    "abs(exp(-t) - 1)\n + 1": lambda t: abs(math.exp(-t) - 1) + 1,
    "sqrt(exp(t))*sqrt(t**2 + 1e-4)**-1": lambda t: math.exp(t / 2) / math.sqrt(t * t + 1e-4),
    "sin(t)*sin(t) + 0.1*sin(t + pi) - t*0": lambda t: math.sin(t) ** 2 - 0.1 * math.sin(t),
    "cos(sin(tan(t/3)))": lambda t: math.cos(math.sin(math.tan(t / 3))),
}


@pytest.fixture(scope="module")
def clockwork(workshop: Workshop) -> Any:
    """Two wheels of inertia 1 for each expression: one under it as a torque, one under its rate if it has one."""
    text = 'name = "clockwork"\n[ground_link]\npoints = { O = [0, 0] }\n'
    for k, law in enumerate(EXPRESSIONS):
        laws = [f'torque = """{law}"""', f'angle = """{law}"""\ndamping = 1' if "abs" not in law else "torque = 1"]
        for wheel, line in zip((f"a{k}", f"b{k}"), laws, strict=True):
            text += f'[[link]]\nname = "{wheel}"\nmass = 1\ninertia = 1\ncom = [0, 0]\npoints = {{ C = [0, 0] }}\n'
            text += f'[[joint]]\nname = "hub_{wheel}"\nbetween = ["ground.O", "{wheel}.C"]\n'
            text += f'[[motor]]\njoint = "hub_{wheel}"\n{line}\n'
    return workshop.model(text)


@pytest.mark.parametrize("text", EXPRESSIONS)
def test_expression_in_a_model(text: str, clockwork: Any) -> None:
    """Its value at reading, and as torque of a motor; its rate in a servo with damping alone."""
    value, index = EXPRESSIONS[text], list(EXPRESSIONS).index(text)
    parsed = expressions.parse(text)
    assert isinstance(parsed, Expression)
    rest = np.zeros(2 * len(EXPRESSIONS))
    for t in (0.0, 0.1, 0.63, 2.2):
        found = clockwork.acceleration(rest, rest, t)[2 * index : 2 * index + 2]
        assert parsed.at(t) == pytest.approx(value(t), rel=1e-14, abs=1e-14)
        assert found[0] == pytest.approx(value(t), rel=1e-13, abs=1e-13)
        if t and parsed.has_rate():
            h = 1e-4
            rate = (8 * (value(t + h) - value(t - h)) - (value(t + 2 * h) - value(t - 2 * h))) / (12 * h)
            assert found[1] == pytest.approx(rate, rel=1e-8, abs=1e-8)


@pytest.mark.parametrize(
    ("text", "value"), [("2*pi", 2 * math.pi), ("-3", -3.0), ("sqrt(2)/exp(1)", 2**0.5 / math.e), ("9**0.5", 3.0)]
)
def test_expression_without_time_is_a_number(text: str, value: float) -> None:
    assert expressions.parse(text) == pytest.approx(value, rel=1e-15)


REFUSED = {
    "": "cannot be read",
    "2 t": "cannot be read",
    "t +": "cannot be read",
    "(" * 300 + "t" + ")" * 300: "cannot be read",
    "__import__('os').system('true')": "is not arithmetic",
    "__import__": "__import__ is not known here; the names are t and pi",
    "eval('t')": "eval(...) is not known here",
    "t.real": "t.real is not arithmetic",
    "().__class__": "is not arithmetic",
    "sin.__call__(t)": "is not arithmetic",
    "x + t": "x is not known here",
    "sin": "sin needs an argument in parentheses",
    "sin(t, 2)": "sin(...) takes one argument",
    "sin(x=t)": "sin(...) takes one argument",
    "sin(*t)": "is not arithmetic",
    "asin(t)": "asin(...) is not known here",
    "'t'": "is not arithmetic",
    "True": "is not arithmetic",
    "1j*t": "is not arithmetic",
    "[t]": "is not arithmetic",
    "t if t else 1": "is not arithmetic",
    "lambda: t": "is not arithmetic",
    "t // 2": "is not arithmetic",
    "t % 2": "is not arithmetic",
    "t < 1": "is not arithmetic",
    "(x := t)": "is not arithmetic",
    "t**t": "t in an exponent",
    "2**t": "t in an exponent",
    "t**0.5": "write sqrt(...)",
    "t**65": "whole numbers up to 64",
    "t**(10**10)": "whole numbers up to 64",
    "((t**8)**8)**8": "a power higher than 64",
    "(t + 1)**40*(t + 1)**40": "a power higher than 64",
    "9**9**9**9": "no finite value",
    "10**400": "no finite value",
    "1e999": "no finite value",
    "1/t": "no finite value at t = 0",
    "log(t)": "no finite value at t = 0",
    "sqrt(-1)*t": "no finite value",
    "(0-8)**0.5": "no finite value",
    "t/0": "no finite value",
    "-" * 150 + "t": "nested deeper than 100",
    "t" + " + t" * 400: "nested deeper than 100",
    "t" + " + t" * 4000: "characters",
    "t\0": "cannot be read",
}


@pytest.mark.parametrize("text", REFUSED, ids=lambda text: repr(text[:30]))
def test_refused_expression(text: str) -> None:
    with pytest.raises(ExpressionError) as caught:
        expressions.parse(text)
    assert REFUSED[text] in str(caught.value)
    assert "\n" not in str(caught.value)


def test_reading_an_expression_needs_no_algebra() -> None:
    import subprocess
    import sys

    code = (
        "import sys; from ccgen.generator.effects import expressions;"
        "expressions.parse('sin(t)**2'); assert 'sympy' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_spelling_does_not_change_the_scene(workshop: Workshop) -> None:
    """Spaces and digits that mean the same are the same scene; numbers in quotes are parameters."""
    one, two = (
        workshop.scene(ROD + f'[[motor]]\njoint = "joint_0"\ntorque = "{text}"\n').canonical()
        for text in ("2*sin( 3*t )+0.50", "2 * sin(3*t) + .5")
    )
    assert one == two
    three, four = (
        workshop.scene(ROD + f'[[motor]]\njoint = "joint_0"\ntorque = {text}\n').canonical()
        for text in ('"5/2"', "2.5")
    )
    assert three == four


# --- wrong tables -----------------------------------------------------------------------------------------------------

BAD: dict[str, tuple[str, int, str, str]] = {
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
        'found "2*foo(t)", expected a torque in N m, a number or an expression of t; foo(...) is not known here',
    ),
    "torque is true": ('[[motor]]\njoint = "joint_0"\ntorque = true', 3, "motor[0].torque", "found true, expected"),
    "infinite torque": (
        '[[motor]]\njoint = "joint_0"\ntorque = inf',
        3,
        "motor[0].torque",
        "found inf, expected a torque in N m, a number or an expression of t; write a finite number",
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
        "write a number without quotes",
    ),
    "table that goes back": (
        '[[motor]]\njoint = "joint_0"\ntable = [[0, 1], [2, 1],\n[2, 3]]',
        4,
        "motor[0].table[2]",
        "found t = 2 after t = 2, expected times that grow; correct it",
    ),
    "unknown key": ('[[motor]]\njoint = "joint_0"\ntorque = 1\ntorqe = 1', 4, "motor[0].torqe", 'write "torque"'),
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
        "expected the force [x, y] in N, numbers or expressions of t; write 2 values",
    ),
    "force with a bad part": (
        '[[force]]\npoint = "joint_0"\nvector = [1, "t t"]',
        3,
        "force[0].vector[1]",
        'found "t t", expected the force [x, y] in N, numbers or expressions of t; it cannot be read',
    ),
    "no force": ('[[force]]\npoint = "joint_0"\nvector = [0, 0.0]', 3, "force[0].vector", "found [0, 0]"),
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
    "input without name": ('[[input]]\nlink = "link_0"', 1, "input[0].name", "missing, expected a name"),
    "input on nothing": (
        '[[input]]\nname = "a"',
        1,
        "input[0]",
        "found no point, joint or link, expected one of them; add one",
    ),
    "input on two things": (
        '[[input]]\nname = "a"\nlink = "link_0"\njoint = "joint_0"',
        3,
        "input[0].link",
        "found link beside joint, expected one of point, joint and link; remove one",
    ),
    "input without direction": (
        '[[input]]\nname = "a"\npoint = "link_0.B"',
        1,
        "input[0].direction",
        "missing, expected the direction of the force",
    ),
    "input without a direction's length": (
        '[[input]]\nname = "a"\npoint = "link_0.B"\ndirection = [0, 0]',
        4,
        "input[0].direction",
        "expected a direction, not both zero",
    ),
    "torque with a direction": (
        '[[input]]\nname = "a"\njoint = "joint_0"\ndirection = [0, 1]',
        4,
        "input[0].direction",
        "found direction without point",
    ),
    "input called t": (
        '[[input]]\nname = "t"\njoint = "joint_0"',
        2,
        "input[0].name",
        'found "t", the name of the time',
    ),
    "input at no joint": ('[[input]]\nname = "a"\njoint = "b"', 3, "input[0].joint", "the joints are joint_0"),
    "input on no link": ('[[input]]\nname = "a"\nlink = "b"', 3, "input[0].link", "the links are link_0"),
    "input on no point": (
        '[[input]]\nname = "a"\npoint = "b"\ndirection = [1, 0]',
        3,
        "input[0].point",
        'found "b", expected a joint or link.point that moves',
    ),
    "same name twice": (
        '[[input]]\nname = "a"\nlink = "link_0"\n[[input]]\nname = "a"\nlink = "link_0"',
        5,
        "input[1].name",
        'found "a" a second time',
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_wrong_table(case: str, workshop: Workshop) -> None:
    text, line, key, words = BAD[case]
    with pytest.raises(SceneError) as caught:
        workshop.scene(ROD + text + "\n")
    assert len(caught.value.faults) == 1, str(caught.value)
    fault = caught.value.faults[0]
    assert (fault.line, fault.key) == (line + ROD.count("\n"), key)
    assert words in fault.message


def test_all_faults_at_once(workshop: Workshop) -> None:
    wrong = (
        '[[motor]]\njoint = "a"\ntorque = 1\nangle = 2\n[[force]]\npoint = "b"\nvector = [0, 0]\n'
        '[[input]]\nname = "t"\npoint = "c"\nlink = "d"\n'
    )
    with pytest.raises(SceneError) as caught:
        workshop.scene(ROD + wrong)
    keys = [fault.key for fault in caught.value.faults]
    assert {"motor[0].joint", "motor[0].angle", "force[0].point", "force[0].vector", "input[0].name"} <= set(keys)
