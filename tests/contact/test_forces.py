"""Forces of contacts and joints in states, at rest and in steady motion: closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene, loop
from ccgen.runtime import simulate

from ..support.bodies import block
from ..support.folders import SCENES
from ..support.leaning_rod import LEANING, G
from ..support.sliding_rod import ROD
from ..support.workshop import Workshop

TIP = ("rod.T", "ground_0")


@pytest.fixture(scope="module")
def leaning(workshop: Workshop) -> Any:
    return workshop.model(LEANING)


def test_a_rod_that_leans_on_smooth_ground(leaning: Any) -> None:
    """Its weight is shared between hinge and ground: 9.81 N each, upright; while it falls, the hinge has it all."""
    run = simulate(leaning)
    (impact,) = run.impacts
    assert run.contact_forces(2.0) == pytest.approx(np.array([[G, 0.0]]), rel=1e-12)
    assert run.reactions(2.0) == pytest.approx(np.array([[0.0, G, 0.0]]), rel=1e-12, abs=1e-12)
    times = np.linspace(0.0, 2.0, 41)
    pushed = run.contact_forces(times)
    assert pushed.shape == (41, 1, 2) and run.reactions(times).shape == (41, 1, 3)
    assert np.all(pushed[times < impact.t] == 0.0) and np.allclose(pushed[times >= impact.t, 0, 0], G, rtol=1e-12)
    assert run.contact_forces(impact.t)[0, 0] == pytest.approx(G, rel=1e-11)  # after it
    early, about = 0.9 * impact.t, 0.1667 + 2.0 * 0.25
    (angle,), (rate,) = run.at(early)
    turn = -2.0 * G * 0.5 * math.cos(angle) / about
    along, across = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
    wanted = 2.0 * (0.5 * turn * across - 0.5 * rate**2 * along) + [0.0, 2.0 * G]
    assert run.reactions(early)[0] == pytest.approx(np.array([*wanted, 0.0]), rel=1e-12)


@pytest.mark.sample(2)
@pytest.mark.parametrize("friction", [0.05, 0.1, 0.3, 1.0])
def test_a_rod_that_cannot_move_leans_within_coulombs_law(friction: float, workshop: Workshop) -> None:
    """One contact that sticks shares its friction with the hinge: never more than it can bear, and in balance."""
    text = LEANING.replace("restitution = 0", f"restitution = 0\nfriction = {friction}\npoint = [0, 0]")
    model = workshop.model(text.replace("until = 2", "until = 1") + '[start]\nangles = { rod = "-30 deg" }\n')
    run = simulate(model)
    ((push, drag),) = run.contact_forces(0.5)
    assert push > 0.0 and abs(drag) <= friction * push * (1.0 + 1e-12)
    level, down = math.cos(math.radians(30.0)), math.sin(math.radians(30.0))
    assert push * level + drag * down == pytest.approx(2.0 * G * 0.5 * level, rel=1e-9)  # moments about the hinge
    assert model.contact_forces(*run.at(0.5)) == pytest.approx(np.array([[push, drag]]), rel=1e-9)


def test_no_states_have_no_forces(leaning: Any) -> None:
    none = np.zeros((0, 1))
    for contacts in (None, (), [TIP], {TIP: "smooth"}):
        assert leaning.contact_forces(none, none, contacts=contacts).shape == (0, 1, 2)


def test_states_in_contact_have_the_forces_of_contact(leaning: Any) -> None:
    q, u = np.array([-math.pi / 6]), np.zeros(1)
    assert leaning.reactions(q, u) == pytest.approx(np.array([[0.0, G, 0.0]]), rel=1e-13, abs=1e-13)
    assert leaning.contact_forces(q, u) == pytest.approx(np.array([[G, 0.0]]), rel=1e-13)
    assert leaning.acceleration(q, u) == pytest.approx([0.0], abs=1e-13)
    free = leaning.acceleration(q, u, contacts=())
    assert free == pytest.approx([-2.0 * G * 0.5 * math.cos(math.pi / 6) / (0.1667 + 0.5)], rel=1e-13)
    assert np.all(leaning.contact_forces(q, u, contacts=()) == 0.0)
    above = np.array([0.3])
    assert np.all(leaning.contact_forces(above, u) == 0.0)
    held = leaning.contact_forces(above, u, contacts=[TIP])[0, 0]
    assert held == pytest.approx(2.0 * G * 0.5, rel=1e-13)  # any contact that is named is held, where it is
    assert np.array_equal(leaning.contact_forces(above, u, contacts={TIP: "smooth"}), [[held, 0.0]])
    leaves = np.array([3.0])
    assert np.all(leaning.contact_forces(q, leaves) == 0.0)
    assert np.array_equal(leaning.acceleration(q, leaves), leaning.acceleration(q, leaves, contacts=()))


def test_a_batch_of_states_in_flight_and_in_contact(leaning: Any) -> None:
    q = np.array([[0.3], [-math.pi / 6], [1.0], [-math.pi / 6], [0.0], [0.1], [0.2], [0.4], [0.5]])
    u, times = np.zeros_like(q), np.linspace(0.0, 1.0, 9)
    for method in (leaning.acceleration, leaning.reactions, leaning.contact_forces, leaning.multipliers):
        single = np.array([method(a, b) for a, b in zip(q, u, strict=True)])
        assert np.allclose(method(q, u), single, rtol=1e-14, atol=1e-14)
        assert np.allclose(method(q, u, times), single, rtol=1e-14, atol=1e-14)
    assert np.all((leaning.contact_forces(q, u)[:, 0, 0] > 0.0) == (q[:, 0] < 0.0))


def test_states_in_flight_are_as_without_contacts(workshop: Workshop) -> None:
    """Not a bit differs between a model's states with all contacts open, and those with contacts left out."""
    model = workshop.model(load_scene(SCENES / "falling-hexagon.toml"))
    q, u = (np.tile(x, (37, 1)) for x in model.start())
    u = u + np.random.default_rng(1).normal(size=u.shape)
    for method in (model.acceleration, model.multipliers, model.reactions):
        assert np.array_equal(method(q, u), method(q, u, contacts=()))
        assert np.array_equal(method(q[0], u[0]), method(q[0], u[0], contacts=()))


def test_states_without_forces_of_contact_are_refused(leaning: Any) -> None:
    q = np.array([[0.3], [-math.pi / 6]])
    with pytest.raises(
        ValueError, match=r"state 1 is before an impact: rod.T strikes ground_0 at 1.73205 m/s; .*impact"
    ):
        leaning.reactions(q, [[0.0], [-2.0]])
    with pytest.raises(ValueError, match=r"state 0 has rod.T behind ground_0 by 0.3414\d* m; .*contacts=\(\)"):
        leaning.acceleration([-1.0], [0.0])
    for contacts, match in (
        ([("rod.A", "ground_0")], "found contact .*'rod.A'.*, expected one of"),
        ([TIP, TIP], "expected each once"),
        ({TIP: "sticks"}, r"found 'sticks' for \(rod.T, ground_0\), which has no friction"),
        (TIP, r"contacts: found \('rod.T', 'ground_0'\), expected a list of \(point, ground\), \(\) for none"),
        (False, "contacts: found False, expected a list"),
        ({TIP: "glued"}, r"found 'glued' for \(rod.T, ground_0\), expected one of: smooth; touches;"),
    ):
        with pytest.raises(ValueError, match=match):
            leaning.acceleration(q[0], [0.0], contacts=contacts)


@pytest.mark.sample(1)
@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_a_hexagon_at_rest_has_its_weight_under_it(friction: float, workshop: Workshop) -> None:
    """It has fallen flat: all that its contacts push is its weight, and friction adds up to nothing."""
    ground = [{"restitution": 0.0} | ({"friction": friction} if friction else {})]
    model = workshop.model(loop(6, gravity=True, start={"height": 0.05, "tilt": "10 deg"}, ground=ground))
    q, u = model.start()
    run = simulate(model, *model.project(q, u + 0.5 * np.random.default_rng(3).normal(size=u.size)), until=6.0)
    assert run.success and run.phases[-1].kind == "contact"
    assert np.max(np.abs(run.u[-1, 1:])) <= 1e-9  # smooth ground leaves it the velocity along itself
    weight = 6.0 * G
    for t in np.linspace(run.phases[-1].start, 6.0, 5):
        pushed = run.contact_forces(t)
        assert np.all(pushed[:, 0] >= 0.0)
        assert abs(pushed[:, 0].sum() - weight) <= 1e-12 * weight
        assert abs(pushed[:, 1].sum()) <= 1e-12 * weight
        assert np.all(np.abs(pushed[:, 1]) <= friction * pushed[:, 0] * (1.0 + 1e-12))
        assert np.all(np.isfinite(run.reactions(t)))
        assert abs(run.model.contact_forces(*run.at(t))[:, 0].sum() - weight) <= 1e-12 * weight


@pytest.mark.parametrize(("friction", "slides"), [(0.8, False), (0.2, True)])
def test_a_block_on_a_slope(friction: float, slides: bool, workshop: Workshop) -> None:
    """Normal forces at its two corners from the balance of moments, friction m g sin or mu N; least norm shares what
    sticks equally."""
    slope, width, height, mass = 0.4, 1.0, 0.6, 2.0
    run = simulate(workshop.model(block(width, height, friction, slope)), until=0.3)
    normal = mass * G * math.cos(slope)
    total = friction * normal if slides else mass * G * math.sin(slope)  # it slides backward, down the slope
    tipping = total * 0.5 * height / width
    wanted = np.array([0.5 * normal + tipping, 0.5 * normal - tipping])
    for t in (0.0, 0.1, 0.3):
        pushed = run.contact_forces(t)
        assert pushed[:, 0] == pytest.approx(wanted, rel=1e-9)
        assert pushed[:, 1].sum() == pytest.approx(total, rel=1e-9)
        if slides:
            assert pushed[:, 1] == pytest.approx(friction * wanted, rel=1e-9)
        else:
            assert np.all(np.abs(pushed[:, 1]) <= friction * pushed[:, 0])
        q, u = run.at(t)
        assert run.model.contact_forces(q, u)[:, 0] == pytest.approx(wanted, rel=1e-9)


CART = """
name = "cart"
[[link]]
name = "frame"
mass = 2.0
inertia = 0.1
com = [0.05, 0.1]
points = { rear = [-0.3, 0], front = [0.3, 0] }
[[link]]
name = "wheel_r"
mass = 0.3
inertia = 0.0015
com = [0, 0]
points = { hub = [0, 0] }
[[link]]
name = "wheel_f"
mass = 0.3
inertia = 0.0015
com = [0, 0]
points = { hub = [0, 0] }
[[joint]]
name = "axle_r"
between = ["frame.rear", "wheel_r.hub"]
[[joint]]
name = "axle_f"
between = ["frame.front", "wheel_f.hub"]
[start]
position = [0, 0.1]
[gravity]
[[motor]]
joint = "axle_r"
torque = -0.3
[[ground]]
restitution = 0.0
friction = 0.7
contacts = ["wheel_r.hub", "wheel_f.hub"]
radius = 0.1
"""


def test_a_cart_that_a_motor_drives(workshop: Workshop) -> None:
    """Rolling wheels: the motor's torque accelerates masses and wheels, the front wheel is pushed to turn, and the
    frame nods back."""
    run = simulate(workshop.model(CART), until=1.0)
    torque, r, inertia, frame, wheel = 0.3, 0.1, 0.0015, 2.0, 0.3
    whole = frame + 2 * wheel
    a = torque / r / (whole + 2 * inertia / r**2)
    alpha = -a / r
    # per wheel: inertia alpha = moment of the motor + r F
    drives, drags = (inertia * alpha + torque) / r, inertia * alpha / r
    # moments of everything about the rear wheel's place on the ground: dL/dt = weights and the front wheel's force
    turning = -frame * a * 0.2 - 2 * wheel * a * r + 2 * inertia * alpha
    front = (turning + frame * G * 0.35 + wheel * G * 0.6) / 0.6
    rear = whole * G - front
    for t in (0.0, 0.4, 1.0):
        pushed = run.contact_forces(t)
        assert pushed == pytest.approx(np.array([[rear, drives], [front, drags]]), rel=1e-9)
        reactions = run.reactions(t)
        for j, force in enumerate((np.array([drives, rear]), np.array([drags, front]))):
            wanted = wheel * np.array([a, G]) - force
            assert reactions[j] == pytest.approx(np.array([*wanted, 0.0]), rel=1e-9, abs=1e-9)


def test_a_state_in_which_friction_jams_says_so(workshop: Workshop) -> None:
    """Painleve's rod: pushed along at 58 degrees no force holds its tip, drawn along one does (closed form)."""
    model = workshop.model(ROD)
    q, u = model.start()
    for ask in (model.contact_forces, model.acceleration, model.reactions):
        with pytest.raises(ValueError, match=r"friction jams .* have no solution"):
            ask(q, u)
    ((push, drag), _), (ahead, up) = model.contact_forces(q, -u), (math.cos(q[2]), math.sin(q[2]))
    assert drag == pytest.approx(-1.5 * push, rel=1e-12)
    # the tip's acceleration along the ground's normal is none: G = (1 + 3 c (c + mu s)) P for a uniform rod
    assert push == pytest.approx(G / (1.0 + 3.0 * ahead * (ahead + 1.5 * up)), rel=1e-9)
