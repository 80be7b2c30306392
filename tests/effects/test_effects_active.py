"""Motors, external forces and torques, inputs, all at once: against the dense reference, and their work."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ccgen.generator.pipeline import listing
from ccgen.generator.program.reading import read_listing
from ccgen.generator.scene import SceneError
from ccgen.runtime import simulate

from ..oracles import loads, maximal, mechanisms
from ..oracles.loads import Acting
from ..oracles.maximal import Array
from ..support.active import ROD
from ..support.dense_comparison import allowed, close, quasi_accelerations, states
from ..support.tiers import all_hard_but
from ..support.workshop import Workshop

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


@pytest.fixture(scope="module", params=all_hard_but(*FAMILIES[:2], of=FAMILIES), ids=str)
def driven(request: pytest.FixtureRequest, workshop: Workshop) -> tuple[Any, Driven]:
    case = Driven(*request.param)
    return workshop.model(case.text), case


@pytest.mark.sample(1)
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
    for state in states(model, case.drawing, 3):
        forces = case.solve(case.acting(state.poses, state.velocities, T, INPUTS)).forces
        reactions = model.reactions(state.q, state.u, T, INPUTS)
        assert close(reactions[:, :2], forces, allowed(case.drawing.system))
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


def test_all_faults_at_once(workshop: Workshop) -> None:
    wrong = (
        '[[motor]]\njoint = "a"\ntorque = 1\nangle = 2\n[[force]]\npoint = "b"\nvector = [0]\n'
        '[[input]]\nname = "t"\npoint = "c"\nlink = "d"\n'
    )
    with pytest.raises(SceneError) as caught:
        workshop.scene(ROD + wrong)
    keys = [fault.key for fault in caught.value.faults]
    assert {"motor[0].joint", "motor[0].angle", "force[0].point", "force[0].vector", "input[0].name"} <= set(keys)
