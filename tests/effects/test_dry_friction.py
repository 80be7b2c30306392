"""Stribeck's curve and brakes: slowing down in closed form, stick and slip against a set-valued law, wrong tables."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from ccgen.generator.scene import SceneError
from ccgen.runtime import Model, Run, simulate, static_equilibrium

from ..oracles.maximal import Array
from ..support.workshop import Workshop

INERTIA, VISCOUS, COULOMB, BREAKAWAY, STRIBECK, RATE = 0.02, 0.01, 0.5, 0.8, 0.4, 0.004
ROTOR = (
    'name = "rotor"\n[ground_link]\npoints = { O = [0, 0] }\n[[link]]\nname = "rotor"\nmass = 1\n'
    f'inertia = {INERTIA}\ncom = [0, 0]\npoints = {{ O = [0, 0] }}\n[[joint]]\nname = "shaft"\n'
    'between = ["ground.O", "rotor.O"]\n'
)
CURVE = (
    f'[[joint_friction]]\nname = "bearing"\nviscous = {VISCOUS}\ndry = {COULOMB}\nbreakaway = {BREAKAWAY}\n'
    f"stribeck = {STRIBECK}\nrate = {RATE}\n"
)


def moment(omega: float) -> float:
    """Stribeck's curve, smoothed about standstill."""
    curve = COULOMB + (BREAKAWAY - COULOMB) * math.exp(-((omega / STRIBECK) ** 2))
    return curve * math.tanh(omega / RATE) + VISCOUS * omega


def integral(of: str, begins: float, ends: float) -> float:
    """Time (∫ I dω/T) or angle (∫ I ω dω/T) in which a rotor slows down, by quadrature."""
    power = {"time": 0, "angle": 1}[of]
    edges = [begins, *(x for x in (1.0, 0.2, 0.02) if ends < x < begins), ends]
    parts = zip(edges[1:], edges, strict=False)
    return sum(quad(lambda w: INERTIA * w**power / moment(w), *part, epsabs=1e-14, epsrel=1e-12)[0] for part in parts)


@pytest.mark.parametrize("method", ["gauss", "dop853", "radau"])
def test_slowing_down_on_stribecks_curve(method: str, workshop: Workshop) -> None:
    model = workshop.model(ROTOR + CURVE)
    for last in (2.0, 0.1):
        run = simulate(model, [0.0], [10.0], until=integral("time", 10.0, last), rtol=1e-11, method=method)
        assert run.u[-1, 0] == pytest.approx(last, abs=1e-8)
        assert run.q[-1, 0] == pytest.approx(integral("angle", 10.0, last), abs=1e-9)
        lost = 0.5 * INERTIA * (10.0**2 - last**2)
        assert sum(model.energy(run.q[-1], run.u[-1])) == pytest.approx(0.5 * INERTIA * 100.0 - lost, abs=1e-9)
        assert run.energy_drift <= 1e-9


def test_the_curve_is_what_the_joint_carries(workshop: Workshop) -> None:
    """Inverse dynamics of a steady turn, forward and backward, past breakaway; at rest, nothing."""
    model = workshop.model(ROTOR + CURVE)
    for omega in (0.0, 0.003, 0.02, 0.4, 3.0, -0.02, -3.0):
        found = model.acceleration([0.2], [omega])[0]
        assert found == pytest.approx(-moment(omega) / INERTIA, rel=1e-12, abs=1e-14)
    assert max(map(moment, np.linspace(0.0, 1.0, 2001))) == pytest.approx(BREAKAWAY, rel=0.01)


MASS, STIFFNESS, BELT, HOLDS, SLIDES, FALLS = 1.0, 100.0, 0.1, 4.0, 2.0, 0.1
"""A mass on a belt (m/s), held back by a spring to the ground; friction in N, and the speed over which it falls."""
ON_BELT = (
    'name = "belt"\n[ground_link]\npoints = { O = [0, 0], W = [-5, 0] }\n[[link]]\nname = "belt"\nmass = 1\n'
    'inertia = 1\ncom = [0, 0]\npoints = { B = [0, 0] }\n[[link]]\nname = "body"\n'
    f'mass = {MASS}\ninertia = 0.01\ncom = [0, 0]\npoints = {{ C = [0, 0] }}\n[[joint]]\nname = "runs"\n'
    'type = "prismatic"\nbetween = ["ground.O", "belt.B"]\naxis = [1, 0]\nangle = 0\n[[joint]]\nname = "rubs"\n'
    'type = "prismatic"\nbetween = ["belt.B", "body.C"]\naxis = [1, 0]\nangle = 0\n'
    f'[[drive]]\njoint = "runs"\nspeed = {BELT}\n'
    f'[[spring]]\nbetween = ["ground.W", "body.C"]\nstiffness = {STIFFNESS}\nlength = 5\n'
    f'[[joint_friction]]\nname = "felt"\njoints = ["rubs"]\ndry = {SLIDES}\nbreakaway = {HOLDS}\nstribeck = {FALLS}\n'
)


def felt(slip: float) -> float:
    return SLIDES + (HOLDS - SLIDES) * math.exp(-((slip / FALLS) ** 2))


def cycle() -> tuple[float, float, float]:
    """Period, largest and smallest way of the mass in stick and slip, with a set-valued law: it goes with the belt up
    to where the spring pulls with HOLDS, and slips until it has the belt's speed again."""

    def slipping(_: float, y: Array) -> list[float]:
        return [y[1], (felt(BELT - y[1]) - STIFFNESS * y[0]) / MASS]

    def catches(t: float, y: Array) -> float:
        return BELT - y[1] if t > 1e-3 else 1.0

    catches.terminal = True  # type: ignore[attr-defined]
    start = [HOLDS / STIFFNESS, BELT - 1e-9]
    found = solve_ivp(
        slipping, (0.0, 5.0), start, method="DOP853", rtol=1e-12, atol=1e-13, events=catches, dense_output=True
    )
    slip, back = found.t[-1], found.y[0, -1]
    return slip + (HOLDS / STIFFNESS - back) / BELT, float(found.y[0].max()), float(found.y[0].min())


def test_stick_and_slip_on_a_belt(workshop: Workshop) -> None:
    """The limit cycle of a law with true sticking, integrated with its events by SciPy, is the limit of the smoothed
    one: what is off goes with the speed over which that changes its sign."""
    model = workshop.model(ON_BELT)
    period, _, lowest = cycle()
    off = []
    body, belt = model.q_names.index("slide_1"), model.q_names.index("slide_0")
    for rate in (1e-3, 1e-4):
        params = {"felt.rate": rate}
        run = simulate(model, until=4.0 * period, rtol=1e-8, method="radau", params=params)
        assert run.success
        times = np.linspace(2.0 * period, 4.0 * period, 4001)
        q, _ = run.at(times)
        way = q[:, body] + q[:, belt]
        falling = np.flatnonzero((way[:-1] > 0.02) & (way[1:] <= 0.02))
        assert len(falling) == 2
        crossings = [_crossing(run, _both(body, belt, len(run.q[0])), times[i], times[i + 1]) for i in falling]
        off.append((abs(crossings[1] - crossings[0] - period), abs(way.min() - lowest)))
    assert off[0][0] <= 0.02 * period and off[1][0] <= 0.3 * off[0][0]
    assert off[0][1] <= 1e-3 and off[1][1] <= 0.3 * off[0][1]


def _crossing(run: Run, weights: Array, low: float, high: float) -> float:
    """When the way falls below 0.02 m between two times."""
    return float(brentq(lambda t: float(run.at(t)[0] @ weights) - 0.02, low, high))


def _both(body: int, belt: int, size: int) -> Array:
    """The way of the body is that of the belt and its own on it."""
    weights = np.zeros(size)
    weights[[body, belt]] = 1.0
    return weights


BRAKE = '[[brake]]\nname = "disc"\njoint = "shaft"\n'


@pytest.mark.parametrize("method", ["gauss", "dop853", "dopri5", "radau"])
def test_a_brake_stops_a_rotor(method: str, workshop: Workshop) -> None:
    """From the time at which it begins, at T/I; it comes to rest and stays there."""
    model = workshop.model(ROTOR + BRAKE + "torque = 0.3\nbegins = 0.25\nrate = 1e-3\n")
    slowing = 0.3 / INERTIA
    run = simulate(model, [0.0], [9.0], until=0.6, rtol=1e-10, method=method)
    assert run.u[-1, 0] == pytest.approx(9.0 - slowing * 0.35, abs=1e-9)
    assert run.q[-1, 0] == pytest.approx(9.0 * 0.6 - 0.5 * slowing * 0.35**2, abs=1e-9)
    assert 0.25 in run.t
    if method != "radau":
        return
    run = simulate(model, [0.0], [9.0], until=3.0, rtol=1e-10, method=method)
    assert abs(run.u[-1, 0]) <= 1e-9 and run.energy_drift <= 1e-8
    assert run.q[-1, 0] == pytest.approx(9.0 * 0.25 + 0.5 * 9.0**2 / slowing, abs=1e-3 * 9.0 / slowing)


def test_a_brake_is_released(workshop: Workshop) -> None:
    """Pressed by a sine, half of the time: not where that is negative; after its end never again."""
    model = workshop.model(ROTOR + BRAKE + 'torque = "0.2*sin(10*t)"\nends = 1.0\n')
    run = simulate(model, [0.0], [9.0], until=2.0, rtol=1e-11)
    halves = [(k * math.pi / 5.0, min((2 * k + 1) * math.pi / 10.0, 1.0)) for k in range(2)]
    pressed = sum(0.2 * quad(lambda t: math.sin(10.0 * t), *half)[0] for half in halves if half[0] < 1.0)
    assert run.u[-1, 0] == pytest.approx(9.0 - pressed / INERTIA, abs=1e-9)
    assert run.u[run.t >= 1.0, 0] == pytest.approx(run.u[-1, 0], abs=1e-12)


def test_a_brake_holds_a_pendulum_but_for_its_creep(workshop: Workshop) -> None:
    """Rate · atanh(load/torque): nine tenths of what it can hold creep with 1.47 of the rate. Statics know none."""
    arm = ROTOR.replace("com = [0, 0]", "com = [0.1, 0]")
    model = workshop.model(arm + "[gravity]\n" + BRAKE + f"torque = {9.81 * 0.1 / 0.9}\nrate = 1e-5\n")
    run = simulate(model, [0.0], [0.0], until=0.5, method="radau")
    assert run.u[-1, 0] == pytest.approx(-1e-5 * math.atanh(0.9), rel=1e-4)
    loose = simulate(model, [0.0], [0.0], until=0.1, method="radau", params={"disc.torque": 0.5})
    inertia = INERTIA + 0.1**2
    assert loose.u[-1, 0] == pytest.approx(-(0.981 - 0.5) * 0.1 / inertia, rel=0.02)
    assert static_equilibrium(model, [-1.0]).q == pytest.approx([-math.pi / 2], abs=1e-9)


def test_a_brake_on_a_line(workshop: Workshop) -> None:
    rubs = '[[brake]]\njoint = "rubs"\nforce = "3 N"\nrate = "1 mm/s"\n'
    model: Model = workshop.model(ON_BELT[: ON_BELT.index("[[joint_friction]]")] + rubs)
    q, u = model.start()
    u = u.copy()
    u[model.q_names.index("slide_1")] = 0.5
    found = model.acceleration(q, u)[model.q_names.index("slide_1")]
    assert found == pytest.approx(-3.0 / MASS, rel=1e-12)


WRONG = [
    (CURVE.replace(f"stribeck = {STRIBECK}\n", ""), "joint_friction[0].breakaway", "found without stribeck"),
    (CURVE.replace(f"breakaway = {BREAKAWAY}\n", ""), "joint_friction[0].stribeck", "found without breakaway"),
    (CURVE.replace(f"dry = {COULOMB}\n", "").replace(f"rate = {RATE}\n", ""), "joint_friction[0].breakaway", "dry"),
    (CURVE.replace(f"= {BREAKAWAY}", "= 0.4"), "joint_friction[0].breakaway", "more than dry"),
    (CURVE.replace(f"= {RATE}", "= 0.5"), "joint_friction[0].rate", "less than stribeck"),
    (CURVE.replace(f"= {BREAKAWAY}", '= "1 N"'), "joint_friction[0].breakaway", "a force, expected a moment"),
    (BRAKE, "brake[0]", "found no torque"),
    (BRAKE + "force = 3\n", "brake[0].force", "write torque in its place"),
    (BRAKE + "torque = -3\n", "brake[0].torque", "a positive number or an expression of t"),
    (BRAKE + "torque = 3\nbegins = 2\nends = 1\n", "brake[0].ends", "a time after begins"),
    (BRAKE + 'torque = 3\nrate = "1 m/s"\n', "brake[0].rate", "a speed, expected an angular velocity"),
    (BRAKE.replace("shaft", "axle") + "torque = 3\n", "brake[0].joint", '"axle"'),
    (BRAKE + "dry = 3\n", "brake[0].dry", "it belongs to [[joint_friction]]"),
]


@pytest.mark.parametrize(("table", "key", "words"), WRONG)
def test_wrong_tables(table: str, key: str, words: str, workshop: Workshop) -> None:
    with pytest.raises(SceneError) as caught:
        workshop.scene(ROTOR + table)
    faults = {fault.key: fault.message for fault in caught.value.faults}
    assert words in faults[key]
