"""Runs past change points with whatever else is there, by all methods: on their branch, and with the right energy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.runtime import simulate

from ..support.tiers import hard
from ..support.workshop import Workshop

METHODS = ["gauss", "dop853", "dopri5", "radau"]


def angle_of(model: Any, q: Any, link: str) -> Any:
    """The angle of a link (rad) in rows of coordinates."""
    return q[..., model.q_names.index(f"theta_{list(model.links).index(link)}")]


COUPLING_ROD = """
name = "coupling-rod"
[ground_link]
points = { O = [0, 0], Q = [1.5, 0] }
[[link]]
name = "crank"
rod = { mass = 10 }
points = { A = [0, 0], B = [0.3, 0] }
[[link]]
name = "side_rod"
rod = { mass = 40 }
points = { A = [0, 0], B = [1.5, 0] }
[[link]]
name = "wheel"
rod = { mass = 10 }
points = { A = [0, 0], B = [0.3, 0] }
[[joint]]
name = "axle"
between = ["ground.O", "crank.A"]
[[joint]]
between = ["crank.B", "side_rod.A"]
[[joint]]
between = ["side_rod.B", "wheel.B"]
[[joint]]
name = "hub"
between = ["ground.Q", "wheel.A"]
[gravity]
[run]
until = 1
"""
DRIVEN = """
[start]
angles = { crank = "90 deg", side_rod = 0, wheel = "90 deg" }
[[drive]]
joint = "axle"
angle = "pi/2 + 2*pi*t"
"""
LOADS: dict[str, tuple[str, Any]] = {
    "none": ("", lambda t: 0.0 * t),
    "table": (
        '[[motor]]\njoint = "hub"\ntable = [[0, 0], [0.25, 10], [1, 0]]\n',
        lambda t: np.interp(t, [0.0, 0.25, 1.0], [0.0, 10.0, 0.0]),
    ),
    "torque": ('[[torque]]\nlink = "wheel"\ntorque = "10*sin(3*t)"\n', lambda t: 10.0 * np.sin(3.0 * t)),
    "brake": (
        '[[brake]]\njoint = "hub"\ntorque = 5\nrate = 0.01\nends = 0.25\n',
        lambda t: np.where(t < 0.25, -5.0 * np.tanh(2.0 * np.pi / 0.01), 0.0),
    ),
}
"""What acts on the wheel, and its moment (N m): the table bends and the brake ends at a change point."""


@pytest.mark.parametrize("load", [*LOADS])
@pytest.mark.parametrize("method", METHODS)
def test_a_driven_parallelogram_stays_one(method: str, load: str, workshop: Workshop) -> None:
    """Its drive gives what weights of 15 kg m take, less the load, and the energy is that of a turning crank."""
    text, moment = LOADS[load]
    model = workshop.model(COUPLING_ROD + DRIVEN + text)
    run = simulate(model, method=method)
    assert run.success, run.message
    t = np.array([0.0, 0.1, 0.249, 0.25, 0.251, 0.3, 0.5, 0.6, 0.749, 0.75, 0.751, 1.0])
    q, _ = run.at(t)
    angle = np.pi / 2 + 2.0 * np.pi * t
    for name, wanted in (("crank", angle), ("wheel", angle), ("side_rod", 0.0 * t)):
        assert np.max(np.abs(angle_of(model, q, name) - wanted)) <= 1e-8, name
    off = t != 0.25  # where the load may jump
    found = run.reactions(t[off])[:, model.joints.index("axle"), 2]
    assert np.max(np.abs(found - (15.0 * 9.81 * np.cos(angle) - moment(t))[off])) <= 1e-5
    assert run.energy_drift <= 1e-6 * 377.0
    assert len(run.t) <= (20 if method in ("gauss", "dop853") else 130)


@pytest.mark.parametrize("speed", [2.5, *map(hard, (4.1, 6.0, 7.7, 11.0, 13.0))])
@pytest.mark.parametrize("method", METHODS)
def test_an_antiparallelogram_stays_one(method: str, speed: float, workshop: Workshop) -> None:
    """The tangents of half the angles of its cranks have a quotient that stays: (a + b) / (a - b), of links a and b."""
    model = workshop.model("""
name = "antiparallelogram"
[ground_link]
points = { O = [0, 0], Q = [0.5, 0] }
[[link]]
name = "crank"
rod = { mass = 1 }
points = { A = [0, 0], B = [0.2, 0] }
[[link]]
name = "coupler"
rod = { mass = 1 }
points = { A = [0, 0], B = [0.5, 0] }
[[link]]
name = "rocker"
rod = { mass = 1 }
points = { A = [0, 0], B = [0.2, 0] }
[[joint]]
name = "motor"
between = ["ground.O", "crank.A"]
[[joint]]
name = "p1"
between = ["crank.B", "coupler.A"]
[[joint]]
name = "p2"
between = ["coupler.B", "rocker.B"]
[[joint]]
between = ["ground.Q", "rocker.A"]
[start]
joints = { p1 = [0, 0.2], p2 = [0.362, -0.145] }
[[drive]]
joint = "motor"
speed = 6
[run]
until = 4
""")
    model = model.with_parameters({model.data["drives"][0]["speed"]: speed})
    run = simulate(model, method=method, until=8.0 * np.pi / speed)
    assert run.success, run.message
    crank, rocker = (angle_of(model, run.q, link) for link in ("crank", "rocker"))
    wanted = 2.0 * np.arctan2(-0.7 * np.sin(0.5 * crank), 0.3 * np.cos(0.5 * crank))
    assert np.max(np.abs(np.sin(0.5 * (rocker - wanted)))) <= 1e-8
    assert np.max(np.abs(crank - crank[0] - speed * run.t)) <= 1e-8
    assert run.energy_drift <= 1e-6 * np.ptp(np.sum(model.energy(run.q, run.u), axis=0))


CARRIES = """
name = "parallelogram-with-flap"
[ground_link]
points = { G0 = [0, 0], G1 = [0.3, 0], F = [1.6, 0.3] }
[[link]]
name = "c0"
rod = { mass = 1 }
points = { A = [0, 0], B = [0.4, 0] }
[[link]]
name = "c1"
rod = { mass = 1 }
points = { A = [0, 0], B = [0.4, 0] }
[[link]]
name = "bar"
rod = { mass = 1, between = ["H0", "H1"] }
points = { H0 = [0, 0], H1 = [0.3, 0], T = [0.4, 0] }
[[link]]
name = "flap"
rod = { mass = 0.3 }
points = { A = [0, 0], B = [1.2, 0] }
[[joint]]
between = ["ground.G0", "c0.A"]
[[joint]]
between = ["ground.G1", "c1.A"]
[[joint]]
between = ["c0.B", "bar.H0"]
[[joint]]
between = ["c1.B", "bar.H1"]
[[joint]]
between = ["ground.F", "flap.A"]
[[touch]]
between = ["bar.T", "flap"]
radius = [0.05, 0]
restitution = 0
friction = 0.3
[gravity]
[start]
angles = { c0 = "-40 deg", c1 = "-40 deg", bar = 0, flap = 3.6514905325704334 }
angular_velocities = { c0 = 8.74 }
[run]
until = 0.4
"""


@pytest.mark.parametrize("rtol", [1e-9, hard(1e-12)])
@pytest.mark.parametrize("speed", [8.74, *map(hard, np.linspace(8.0, 9.5, 7).tolist())])
@pytest.mark.parametrize("method", METHODS)
def test_a_parallelogram_that_carries_a_contact_stays_one(
    method: str, speed: float, rtol: float, workshop: Workshop
) -> None:
    """The energy has what friction takes, and the bar stays level; where the cranks come to is what runs of neighbours
    that miss the change point close in on."""
    model = workshop.model(CARRIES)
    q, u = model.start()
    run = simulate(model, q, u * speed / 8.74, method=method, rtol=rtol)
    assert run.success, run.message
    c0, c1, bar = (angle_of(model, run.q, link) for link in ("c0", "c1", "bar"))
    assert np.max(np.abs(c0 - c1)) <= 1e-9
    assert np.max(np.abs(bar)) <= 1e-9
    assert run.energy_drift <= max(1e-8, 10.0 * rtol) * 10.2
    if speed == 8.74:
        assert c0[-1] == pytest.approx(0.3746, abs=1e-4)


def flat(*, tell: str) -> str:
    return (
        COUPLING_ROD
        + f"""
[start]
angles = {{ crank = 0, side_rod = 0, wheel = 0 }}
{tell}
[[drive]]
joint = "axle"
speed = "60 rpm"
"""
    )


@pytest.mark.parametrize("method", METHODS)
def test_a_start_in_line_goes_on_as_its_speeds_say(method: str, workshop: Workshop) -> None:
    model = workshop.model(flat(tell='angular_velocities = { wheel = "60 rpm" }'))
    run = simulate(model, method=method)
    assert run.success, run.message
    assert np.max(np.abs(angle_of(model, run.q, "wheel") - 2.0 * np.pi * run.t)) <= 1e-8
    assert run.energy_drift <= 1e-6 * 377.0


def test_a_start_in_line_asks_which_way(workshop: Workshop) -> None:
    """The wheel goes with the crank, or, as that of an antiparallelogram, (b + a) / (b - a) times as fast and back."""
    run = simulate(workshop.model(flat(tell="")))
    assert not run.success and len(run.t) == 1
    assert run.message == (
        "stopped at t = 0 s: a loop lies in a line, and these velocities are those of neither motion that leads on "
        "from there, with angular velocities side_rod -3.14159, wheel -9.42478 or side_rod 0, wheel 6.28319 rad/s; "
        "give that of side_rod or wheel as well"
    )


def test_a_free_start_in_line_keeps_the_speed_that_is_given(workshop: Workshop) -> None:
    """What is asked for is told for the crank's own speed, and each answer runs with it."""
    drive = '[[drive]]\njoint = "axle"\nspeed = "60 rpm"\n'
    run = simulate(workshop.model(flat(tell="angular_velocities = { crank = 6 }").replace(drive, "")))
    assert not run.success
    assert run.message.endswith(
        "with angular velocities side_rod -3, wheel -9 or side_rod 0, wheel 6 rad/s; "
        "give that of side_rod or wheel as well"
    )
    for answer in ("side_rod = -3", "side_rod = 0", "wheel = -9", "wheel = 6"):
        tell = f"angular_velocities = {{ crank = 6, {answer} }}"
        model = workshop.model(flat(tell=tell).replace(drive, ""))
        goes = simulate(model, until=0.01)
        assert goes.success, goes.message
        assert model.velocities(goes.q[0], goes.u[0])[0, 2] == pytest.approx(6.0, abs=1e-12)


SPINS = """
name = "spin"
[[link]]
name = "s0"
rod = { mass = 1 }
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "s1"
rod = { mass = 1 }
points = { A = [0, 0], B = [0.6, 0] }
[[link]]
name = "s2"
rod = { mass = 1 }
points = { A = [0, 0], B = [1, 0] }
[[link]]
name = "s3"
rod = { mass = 1 }
points = { A = [0, 0], B = [0.6, 0] }
[[joint]]
between = ["s0.B", "s1.A"]
[[joint]]
between = ["s1.B", "s2.A"]
[[joint]]
between = ["s2.B", "s3.A"]
[[joint]]
between = ["s3.B", "s0.A"]
[start]
angles = { s0 = 0.3, s1 = 0.3, s2 = 3.4415926535897931, s3 = 3.4415926535897931 }
angular_velocities = { s0 = 2, s1 = 2.001, s2 = 2, s3 = 2.001 }
[run]
until = 5
"""


@pytest.mark.parametrize("method", METHODS)
def test_a_parallelogram_that_spins_stretched_out_goes_on(method: str, workshop: Workshop) -> None:
    """It stays within 0.005 rad of its line for all of the run. Both pairs of its links turn evenly: their angles are
    orthogonal coordinates of a free parallelogram, whose masses do not depend on them."""
    model = workshop.model(SPINS)
    run = simulate(model, method=method, rtol=1e-11)
    assert run.success, run.message
    for name, rate in (("s0", 2.0), ("s1", 2.001), ("s2", 2.0), ("s3", 2.001)):
        angle = angle_of(model, run.q, name)
        assert np.max(np.abs(angle - angle[0] - rate * run.t)) <= 1e-8, name
    energy = np.sum(model.energy(run.q, run.u), axis=0)
    assert np.ptp(energy) <= 1e-10 * energy[0]


@pytest.mark.parametrize("miss", [1e-3, 1e-5, *map(hard, (1e-2, 1e-4, 1e-6, 1e-7))])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_loop_that_all_but_closes_in_line_is_no_crossing(sign: float, miss: float, workshop: Workshop) -> None:
    """It turns there, or goes on as the other way of closing does: energy and lengths stay, which a motion along a
    crossing would leave."""
    model = workshop.model(
        COUPLING_ROD
        + "[start]\nangles = { crank = 1.2, side_rod = 0, wheel = 1.2 }\nangular_velocities = { crank = 9 }\n"
    )
    model = model.with_parameters({"side_rod.points.B.x": 1.5 * (1.0 + sign * miss)})
    q, u = model.start()
    run = simulate(model, q, u, rtol=1e-10)
    assert run.success, run.message
    assert run.closure_max <= 1e-12
    assert run.energy_drift <= 1e-7 * float(np.ptp(model.energy(run.q, run.u)[0]))
