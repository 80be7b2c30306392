"""Effects with kinks (ropes, buffers, motors at their limit): steps end at them, and no method loses its order."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from ccgen.generator import loop
from ccgen.generator.pipeline import listing
from ccgen.generator.scene import load_scene
from ccgen.runtime import HybridState, Model, simulate, static_equilibrium

from ..oracles.maximal import Array
from ..support.active import ROD, SWING, Wrong, check_refusal
from ..support.folders import ROOT
from ..support.workshop import Workshop

G, MASS, STIFFNESS, LENGTH, START = 9.81, 1.0, 100.0, 1.0, 0.2
WEIGHT = """
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "weight"
mass = 1.0
inertia = 0.01
com = [0, 0]
points = { c = [0, 0] }
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "weight.c"]
axis = [0, -1]
angle = 0
[start]
slides = { guide = 0.2 }
[gravity]
"""
ROPE = '[[spring]]\nname = "rope"\nbetween = ["ground.O", "weight.c"]\nstiffness = 100\nlength = 1\nacts = "pull"\n'
BRAKED = ROPE + "damping = 4\n"
"""The rope is slack down to 1 m below its end."""


def hanging(t: float) -> float:
    """Way down (m) of the weight at time t: it falls from rest, is caught by the rope, thrown up, and so on."""
    omega, speed = math.sqrt(STIFFNESS / MASS), math.sqrt(2 * G * (LENGTH - START))

    def caught(s: float) -> float:
        return G / omega**2 * (1 - math.cos(omega * s)) + speed / omega * math.sin(omega * s)

    falls = speed / G
    pulls = brentq(caught, 0.5 * math.pi / omega, 1.999 * math.pi / omega, xtol=1e-16, rtol=1e-15)
    t = t % (2 * falls + pulls)
    if falls < t < falls + pulls:
        return LENGTH + caught(t - falls)
    t = min(t, 2 * falls + pulls - t)
    return START + G * t**2 / 2


def by_parts(
    branches: Callable[[int, Array], list[float]],
    edges: Callable[[Array], list[float]],
    y: Array,
    until: float,
    strikes: Callable[[Array], Array] | None = None,
) -> Array:
    """The state at the end by SciPy, from one sign change of ``edges`` to the next, by steps too short to miss one.

    ``branches(sides, y)`` is smooth in y; bit i of ``sides`` is set where edge i is positive. With ``strikes`` the last
    edge is a floor.
    """
    t, count = 0.0, len(edges(y))
    ahead = y + 1e-9 * np.array(branches(_sides(edges(y)), y))
    sides = _sides(edges(ahead))
    while t < until:
        events = [lambda _, y, i=i: edges(y)[i] for i in range(count)]
        for i, event in enumerate(events):
            event.terminal, event.direction = True, -1.0 if sides >> i & 1 else 1.0  # type: ignore[attr-defined]
        found = solve_ivp(
            lambda _, y, s=sides: branches(s, y),
            (t, until),
            y,
            method="DOP853",
            rtol=1e-13,
            atol=1e-14,
            events=events,
            max_step=0.01,
        )
        t, y = found.t[-1], found.y[:, -1]
        for i in range(count):
            if len(found.t_events[i]) and strikes is not None and i == count - 1:
                y = strikes(y)
            elif len(found.t_events[i]):
                sides ^= 1 << i
    return y


def _sides(values: list[float]) -> int:
    return sum((value > 0.0) << i for i, value in enumerate(values))


@pytest.mark.sample(2)
@pytest.mark.parametrize(("method", "most"), [("gauss", 2), ("dop853", 20), ("dopri5", 400), ("radau", 10)])
def test_a_rope_catches_a_weight(method: str, most: float, workshop: Workshop) -> None:
    """Through 36 kinks; errors are those of the smooth parts, and energy is kept."""
    model = workshop.model(WEIGHT + ROPE)
    for rtol in (1e-6, 1e-9, 1e-12) if method != "radau" else (1e-6, 1e-9):
        run = simulate(model, until=20.0, rtol=rtol, method=method)
        assert run.q[-1, 0] == pytest.approx(hanging(20.0), abs=most * rtol + 1e-13)
        assert run.energy_drift <= 2.0 * most * rtol + 1e-13


ORDERS = [("dopri5", 5, 0.02), ("radau", 5, 0.05), ("dop853", 8, 0.04), ("gauss", 14, 0.4)]


@pytest.mark.sample(2)
@pytest.mark.parametrize(("method", "order", "step"), ORDERS)
def test_steps_of_fixed_length_keep_their_order(method: str, order: int, step: float, workshop: Workshop) -> None:
    model = workshop.model(WEIGHT + ROPE)
    runs = [simulate(model, until=2.0, step=part * step, method=method) for part in (1.0, 0.5)]
    coarse, fine = (abs(run.q[-1, 0] - hanging(2.0)) for run in runs)
    assert fine > 1e-15 and math.log2(coarse / fine) >= order - 0.6


def test_a_run_is_known_between_its_rows(workshop: Workshop) -> None:
    run = simulate(workshop.model(WEIGHT + ROPE), until=5.0, rtol=1e-12)
    times = np.linspace(0.0, 5.0, 501)
    assert run.at(times)[0][:, 0] == pytest.approx([hanging(t) for t in times], abs=1e-12)
    assert np.array_equal(run.at(run.t)[0], run.q)


def test_it_goes_on_from_where_it_was_left(workshop: Workshop, tmp_path: Path) -> None:
    """While the rope pulls, and while it is slack."""
    model = workshop.model(WEIGHT + ROPE)
    for left in (0.5, 1.0):
        first = simulate(model, until=left, rtol=1e-9)
        assert first.state is not None
        first.state.save(tmp_path / "left.npz")
        for state in (first.state, HybridState.load(tmp_path / "left.npz")):
            run = simulate(model, until=5.0, rtol=1e-9, state=state)
            assert run.q[-1, 0] == pytest.approx(hanging(5.0), abs=1e-8)


@pytest.mark.parametrize("speed", [3.0, -3.0, 0.0])
def test_a_start_at_the_kink(speed: float, workshop: Workshop) -> None:
    """Thrown down it is caught at once, thrown up it comes back, let go it hangs in the rope and is never slack."""
    run = simulate(workshop.model(WEIGHT + ROPE), [1.0], [speed], until=0.2, rtol=1e-12)
    omega = math.sqrt(STIFFNESS / MASS)
    if speed < 0.0:
        wanted = LENGTH + speed * 0.2 + G * 0.2**2 / 2
    else:
        wanted = LENGTH + G / omega**2 * (1 - math.cos(0.2 * omega)) + speed / omega * math.sin(0.2 * omega)
    assert run.q[-1, 0] == pytest.approx(wanted, abs=1e-12)


def test_a_rope_with_damping_above_a_floor(workshop: Workshop) -> None:
    """It never pushes: where damping would turn it round it is slack. Below it the weight bounces off a floor."""
    ground = '[[ground]]\npoint = [0, -1.25]\nrestitution = 0.8\ncontacts = ["weight.c"]\n'
    model = workshop.model(WEIGHT + BRAKED + ground)

    def tension(y: Array) -> float:
        return float(STIFFNESS * (y[0] - LENGTH) + 4.0 * y[1])

    def branches(sides: int, y: Array) -> list[float]:
        return [y[1], G - (tension(y) if sides & 3 == 3 else 0.0) / MASS]

    def edges(y: Array) -> list[float]:
        return [y[0] - LENGTH, tension(y), 1.25 - y[0]]

    def strikes(y: Array) -> Array:
        return np.array([1.25, -0.8 * y[1]])

    run = simulate(model, until=3.0, rtol=1e-12)
    wanted = by_parts(branches, edges, np.array([START, 0.0]), 3.0, strikes)
    assert len(run.impacts) >= 1
    assert np.concatenate([run.q[-1], run.u[-1]]) == pytest.approx(wanted, abs=1e-9)
    assert run.energy_drift <= 1e-10
    slack = static_equilibrium(model, [1.1])
    assert slack.q == pytest.approx([LENGTH + MASS * G / STIFFNESS], abs=1e-12)


def test_a_motor_gives_no_more_than_its_limit(workshop: Workshop) -> None:
    law = 'angle = "1.2*sin(3*t) - 1.5"\nstiffness = 40\ndamping = 3\nlimit = 9\n'
    model = workshop.model(ROD + '[gravity]\n[[motor]]\njoint = "joint_0"\n' + law)

    def asked(y: Array) -> float:
        return float(40 * (1.2 * math.sin(3 * y[2]) - 1.5 - y[0]) + 3 * (3.6 * math.cos(3 * y[2]) - y[1]))

    def branches(sides: int, y: Array) -> list[float]:
        torque = 9.0 if sides & 1 else -9.0 if sides & 2 else asked(y)
        return [y[1], (torque - 3.0 * G * math.cos(y[0])) / SWING, 1.0]

    def edges(y: Array) -> list[float]:
        return [asked(y) - 9.0, -asked(y) - 9.0]

    run = simulate(model, [-1.4], [0.0], until=4.0, rtol=1e-12)
    wanted = by_parts(branches, edges, np.array([-1.4, 0.0, 0.0]), 4.0)
    assert np.concatenate([run.q[-1], run.u[-1]]) == pytest.approx(wanted[:2], abs=1e-9)
    assert run.energy_drift <= 1e-9
    rows = zip(run.t, run.q, run.u, strict=True)
    torques = [model.acceleration(q, u, t)[0] * SWING + 3.0 * G * math.cos(q[0]) for t, q, u in rows]
    assert max(torques) == pytest.approx(9.0, rel=1e-12) and min(torques) == pytest.approx(-9.0, rel=1e-12)


def _loop(acts: str) -> str:
    four_bar = (ROOT / "scenes" / "four-bar.toml").read_text(encoding="utf-8")
    spring = '[[spring]]\nname = "band"\nbetween = ["ground.O", "coupler.tip"]\nstiffness = 300\nlength = 0.45\n'
    return four_bar + spring + (f'acts = "{acts}"\n' if acts else "")


def test_in_a_loop_it_acts_on_its_side_alone(workshop: Workshop) -> None:
    """Accelerations are those with the spring where it acts, those without it elsewhere, one by one and many."""
    pull, push, both = (workshop.model(_loop(acts)) for acts in ("pull", "push", ""))
    run = simulate(both, until=1.0)
    tips = both.point("coupler.tip", run.q)
    longer = np.hypot(tips[:, 0], tips[:, 1]) > 0.45
    assert 0 < longer.sum() < longer.size
    slack = both.with_parameters({"band.stiffness": 0.0})
    acts, none = both.acceleration(run.q, run.u), slack.acceleration(run.q, run.u)
    assert pull.acceleration(run.q, run.u) == pytest.approx(np.where(longer[:, None], acts, none), rel=1e-12)
    assert push.acceleration(run.q, run.u) == pytest.approx(np.where(longer[:, None], none, acts), rel=1e-12)
    assert push.acceleration(run.q[3], run.u[3]) == pytest.approx(push.acceleration(run.q, run.u)[3], rel=1e-13)


@pytest.mark.parametrize("acts", ["pull", "push"])
def test_a_loop_keeps_its_energy(acts: str, workshop: Workshop) -> None:
    model: Model = workshop.model(_loop(acts))
    run = simulate(model, until=10.0, rtol=1e-12)
    assert run.success and run.energy_drift <= 1e-10
    other = simulate(model, until=10.0, rtol=1e-12, method="dop853")
    assert run.q[-1] == pytest.approx(other.q[-1], abs=1e-8)


FLYING = """
name = "flying"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "box"
mass = 1.0
inertia = 0.05
com = [0, 0]
points = { c = [0, 0] }
[[spring]]
between = ["ground.O", "box.c"]
stiffness = 1e4
length = 0.1
acts = "push"
[start]
poses = { box = [-2.13, 0.04, 0.0] }
"""


@pytest.mark.parametrize("method", ["gauss", "dop853", "dopri5", "radau"])
def test_a_buffer_is_met_however_long_the_step(method: str, workshop: Workshop) -> None:
    """A box flies at it: the distance has a sharp minimum within one step, which errors of that step do not show."""

    def branches(sides: int, y: Array) -> list[float]:
        away = 1e4 * (0.1 / math.hypot(y[0], y[1]) - 1.0) if sides else 0.0
        return [y[2], y[3], away * y[0], away * y[1]]

    wanted = by_parts(branches, lambda y: [0.1 - math.hypot(y[0], y[1])], np.array([-2.13, 0.04, 2.13, 0.0]), 2.0)
    model = workshop.model(FLYING)
    for rtol in (1e-4, 1e-9, 1e-11):
        run = simulate(model, [-2.13, 0.04, 0.0], [2.13, 0.0, 0.0], until=2.0, rtol=rtol, method=method)
        assert run.q[-1, :2] == pytest.approx(wanted[:2], abs=1e3 * rtol + 1e-9)


@pytest.mark.parametrize("step", [None, 0.05])
def test_coming_to_rest_at_a_kink(step: float | None, workshop: Workshop) -> None:
    """A motor brings the weight to where the rope begins to pull: swings become smaller than what steps resolve."""
    motor = '[[motor]]\njoint = "guide"\nposition = 1.0\nstiffness = 100\ndamping = 20\n'
    model = workshop.model(WEIGHT.replace("[gravity]\n", "") + motor + ROPE)
    for method in ("gauss", "dop853"):
        run = simulate(model, until=60.0, step=step, method=method)
        assert run.success and run.q[-1, 0] == pytest.approx(LENGTH, abs=1e-9)


@pytest.mark.parametrize("acts", ["pull", "push"])
def test_a_contact_that_keeps_it_at_its_length(acts: str, workshop: Workshop) -> None:
    """A weight rests on a floor where the spring begins to act: rounding alone has a sign there, and ends no step."""
    floor = '[[ground]]\npoint = [0, -1]\nrestitution = 0.0\ncontacts = ["weight.c"]\n'
    run = simulate(workshop.model(WEIGHT + ROPE.replace("pull", acts) + floor), until=20.0)
    assert run.success and run.q[-1, 0] == pytest.approx(LENGTH, abs=1e-14)
    assert len(run.t) <= 60


@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", [3, 5])
def test_buffers_between_joints_that_come_to_rest(seed: int, workshop: Workshop) -> None:
    """Contacts that stick keep a buffer of a fallen hexagon at its length, which dense output misses by the tolerance:
    steps ended at kinks that were none, 200,000 of them, and runs stopped.

    What friction takes beside lines is accounted for to 3e-5 of what moves (docs/hard-cases.md): the bound is a third.
    """
    buffers = [
        {"between": ["joint_0", "joint_3"], "stiffness": 200.0, "length": 1.2, "acts": "push"},
        {"between": ["joint_1", "joint_4"], "stiffness": 800.0, "length": 1.0, "acts": "push"},
    ]
    ground = [{"restitution": 0.5, "friction": 0.4}]
    model = workshop.model(loop(6, gravity=True, start={"height": 1.0}, ground=ground, spring=buffers))
    rng = np.random.default_rng(seed)
    q, u = model.start()
    q, u = q + np.append([0.0, 0.0], np.full(6, rng.normal())), u + 2.0 * rng.normal(size=u.size)
    q, u = model.project(q, u)
    q[1] += 0.2 + 1.5 * max(0.0, -float(model.gaps(q).min()))
    run = simulate(model, q, u, until=3.0)
    assert run.success and run.energy_drift <= 1e-5


def test_time_stepping_comes_to_it(workshop: Workshop) -> None:
    model = workshop.model(WEIGHT + ROPE)
    errors = [
        abs(simulate(model, until=2.0, step=step, method="moreau").q[-1, 0] - hanging(2.0)) for step in (1e-3, 2.5e-4)
    ]
    assert errors[1] <= 0.5 * errors[0] <= 1e-2


def test_what_has_no_kink_says_nothing_of_any(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(WEIGHT + ROPE.replace('acts = "pull"\n', ""), encoding="utf-8")
    plain = listing(load_scene(tmp_path / "scene.toml"))
    assert "side_" not in plain and "switching" not in plain
    (tmp_path / "scene.toml").write_text(WEIGHT + ROPE, encoding="utf-8")
    scene = load_scene(tmp_path / "scene.toml")
    assert "side_spring_0" in listing(scene)
    assert [effect.describe(scene.mechanism) for effect in scene.effects][1].endswith(", pulls only")


BAND = '[[spring]]\nbetween = ["ground.O", "link_0.B"]\nstiffness = 100\n'
WRONG: list[Wrong] = [
    (BAND + 'acts = "pull"', 4, "spring[0].acts", 'found "pull" without a length, expected a length at rest'),
    (BAND + 'acts = "push"', 4, "spring[0].acts", 'found "push" without a length, expected a length at rest'),
    (BAND + "length = 1\ndamping = 2", 5, "spring[0].damping", "found damping of a spring that acts both ways"),
    (BAND + 'length = 1\nacts = "tension"', 5, "spring[0].acts", "expected"),
    ('[[motor]]\njoint = "joint_0"\ntorque = 2\nlimit = 3', 4, "motor[0].limit", "found limit without angle"),
    ('[[motor]]\njoint = "joint_0"\nangle = 2\nstiffness = 3\nlimit = 0', 5, "motor[0].limit", "positive"),
]


@pytest.mark.parametrize("wrong", WRONG)
def test_wrong_tables(wrong: Wrong, workshop: Workshop) -> None:
    check_refusal(wrong, workshop)
