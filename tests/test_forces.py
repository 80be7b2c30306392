"""Forces of contacts and joints at rest, over whole runs, and in impacts: closed forms, and Newton's laws."""

from __future__ import annotations

import copy
import math
import pickle
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene, loop
from ccgen.runtime import simulate

from .conftest import Workshop
from .hard.bodies import block, rod
from .oracles import closed_contacts, newton
from .oracles.maximal import Array
from .test_mechanism_scenes import SCENES

G = 9.81
LEANING = """
name = "leaning"
[ground_link]
points = { O = [0, 0.5] }
[[link]]
name = "rod"
mass = 2
inertia = 0.1667
com = [0.5, 0]
points = { A = [0, 0], T = [1, 0] }
[[joint]]
name = "hinge"
between = ["ground.O", "rod.A"]
[gravity]
[[ground]]
restitution = 0
contacts = ["rod.T"]
[run]
until = 2
"""
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
        ({TIP: "glued"}, r"found 'glued' for \(rod.T, ground_0\), expected one of: smooth; touches;"),
    ):
        with pytest.raises(ValueError, match=match):
            leaning.acceleration(q[0], [0.0], contacts=contacts)


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
        signs = [1.0 if run.model.outboard[j].startswith("wheel") else -1.0 for j in range(2)]
        for j, force in enumerate((np.array([drives, rear]), np.array([drags, front]))):
            wanted = wheel * np.array([a, G]) - force
            assert reactions[j] == pytest.approx(np.array([*(signs[j] * wanted), 0.0]), rel=1e-9, abs=1e-9)


WALKER = """
name = "crawler"
[[link]]
name = "body"
mass = 2.0
inertia = 0.2
com = [0.0, 0.1]
points = { A = [-0.4, 0], B = [0.4, 0], C = [0, 0.3] }
[[link]]
name = "leg"
mass = 0.5
inertia = 0.02
com = [0.25, 0]
points = { H = [0, 0], F = [0.5, 0] }
[[link]]
name = "arm"
mass = 0.7
inertia = 0.03
com = [0.3, 0.05]
points = { H = [0, 0], F = [0.6, 0] }
[[joint]]
name = "hip"
between = ["body.A", "leg.H"]
[[joint]]
name = "shoulder"
between = ["body.B", "arm.H"]
[[stop]]
joint = "hip"
lowest = "-1.9 rad"
highest = "-1.4 rad"
restitution = 0.1
[start]
position = [0.0, 0.75]
angles = { body = 0.1, leg = -1.7, arm = -1.2 }
velocity = [0.6, 0.0]
[gravity]
[[ground]]
name = "floor"
normal = [0.1, 1.0]
restitution = 0.1
friction = 0.4
contacts = ["body.A", "body.B", "leg.F", "arm.F"]
radius = [0.0, 0.05, 0.03, 0.0]
[run]
until = 1.5
rtol = 1e-12
"""
CARRIERS = {"body.A": 0.0, "body.B": 0.05, "leg.F": 0.03, "arm.F": 0.0}


@pytest.fixture(scope="module")
def crawler(workshop: Workshop) -> Any:
    """A run of a rough mechanism with feet, a stop, impacts, sliding and sticking."""
    run = simulate(workshop.model(WALKER))
    how = {way for phase in run.phases for way in phase.how}
    assert run.success and {"sticks", "slides forward", "slides backward"} <= how
    assert len(run.impacts) > 50 and any(ground != "floor" for impact in run.impacts for _, ground in impact.contacts)
    return run


def touching(model: Any, q: Array, contact: tuple[str, str]) -> tuple[int, Array, Array, Array]:
    """Of a contact with the floor: link, place, normal and direction along."""
    normal = np.array([0.1, 1.0]) / math.hypot(0.1, 1.0)
    link = model.links.index(contact[0].partition(".")[0])
    return link, model.point(contact[0], q) - CARRIERS[contact[0]] * normal, normal, np.array([normal[1], -normal[0]])


def by_contacts(model: Any, q: Array, pushed: Array) -> Array:
    """What the contacts of the crawler do to each link, about its mass centre, (links, 3)."""
    found = np.zeros((len(model.links), 3))
    for contact, (normal_force, friction) in zip(model.contacts, pushed, strict=True):
        if contact[1] == "floor":
            link, place, normal, along = touching(model, q, contact)
            found += newton.push(model, q, link, place, normal_force * normal + friction * along)
        else:
            sign = 1.0 if contact[1].endswith("lowest") else -1.0
            found[model.links.index("leg"), 2] += sign * normal_force
            found[model.links.index("body"), 2] -= sign * normal_force
    return found


def test_each_link_obeys_newton_along_a_run(crawler: Any) -> None:
    """m a = joints + contacts + weight, for every link and its turning too, with accelerations by differences."""
    model = crawler.model
    for t in np.linspace(0.0, 1.5, 61):
        q, u = crawler.at(t)
        u_dot = crawler.motion(np.array([t]), q[None], u[None]).u_dot[0]
        pushed, reactions = crawler.contact_forces(t), crawler.reactions(t)
        given = by_contacts(model, q, pushed) + newton.by_joints(model, q, reactions)
        given[:, 1] -= newton.masses(model)[0] * G
        changes = newton.rate(lambda a, b: newton.momenta(model, a, b), q, u, u_dot)
        assert np.max(np.abs(changes - given)) <= 1e-9 * max(30.0, np.max(np.abs(given)))


def stretches(run: Any) -> list[tuple[float, float]]:
    """Between impacts and changes of contact: where forces are smooth."""
    times = sorted({float(t) for phase in run.phases for t in (phase.start, phase.end)})
    return [(a, b) for a, b in pairwise(times) if b - a > 1e-4]


def pieces(run: Any, a: float, b: float) -> list[tuple[float, float]]:
    """Parts of a stretch, from row to row."""
    rows = [t for t in run.t.tolist() if a < t < b]
    ends = [a, *rows, b]
    return [(x, y) for x, y in pairwise(ends) if y > x]


def before(run: Any, t: float) -> tuple[Array, Array]:
    """The state right before t, where an impact or a change of contact may be at t."""
    row = int(np.searchsorted(run.t, t, side="left"))
    return run.q[row], run.u[row]


NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)


def integral(function: Any, a: float, b: float) -> Any:
    """By Gauss's formula with eight nodes."""
    times = 0.5 * (a + b) + 0.5 * (b - a) * NODES
    return 0.5 * (b - a) * sum(w * function(t) for t, w in zip(times, WEIGHTS, strict=True))


def test_forces_of_a_run_add_up_to_its_changes_of_momentum(crawler: Any) -> None:
    """Over every stretch: momentum, and angular momentum about the origin, change by the integral of what contacts and
    weight give; energy by what friction takes."""
    model = crawler.model
    masses = newton.masses(model)[0]

    def acting(t: float) -> Array:
        q, u = crawler.at(t)
        pushed = crawler.contact_forces(t)
        given = by_contacts(model, q, pushed)
        given[:, 1] -= masses * G
        places = newton.centres(model, q)
        turning = places[:, 0] * given[:, 1] - places[:, 1] * given[:, 0] + given[:, 2]
        slips = np.zeros(len(pushed))
        for k, contact in enumerate(model.contacts):
            if contact[1] == "floor":
                link, place, _, along = touching(model, q, contact)
                pose, (vx, vy, spin) = model.poses(q)[link], model.velocities(q, u)[link]
                x, y = place - pose[:2]
                slips[k] = along @ [vx - spin * y, vy + spin * x]
        return np.array([*given[:, :2].sum(axis=0), turning.sum(), pushed[:, 1] @ slips])

    seen = 0.0
    for a, b in stretches(crawler):
        start, end = crawler.at(a), before(crawler, b)
        change = newton.whole(model, *end) - newton.whole(model, *start)
        energies = [sum(model.energy(*state)) for state in (start, end)]
        total = sum(integral(acting, x, y) for x, y in pieces(crawler, a, b))
        assert np.max(np.abs(change - total[:3])) <= 1e-9 * masses.sum() * G * 1.0
        assert abs(energies[1] - energies[0] - total[3]) <= 1e-10 * masses.sum() * G
        seen += abs(total[3])
    assert seen > 0.1  # J: friction has taken something


def test_impulses_are_what_each_link_gains_in_an_impact(crawler: Any) -> None:
    model = crawler.model
    for impact in crawler.impacts:
        q = crawler.q[np.searchsorted(crawler.t, impact.t)]
        pushed = np.zeros((len(model.contacts), 2))
        for contact, normal, friction in zip(impact.contacts, impact.impulses, impact.friction, strict=True):
            pushed[model.contacts.index(contact)] = normal, friction
        assert np.all(np.abs(pushed[:, 1]) <= 0.4 * pushed[:, 0] + 1e-15 * newton.masses(model)[0].sum() * 1.0)
        change = newton.momenta(model, q, impact.u_plus) - newton.momenta(model, q, impact.u_minus)
        given = by_contacts(model, q, pushed) + newton.by_joints(model, q, impact.reactions)
        assert np.max(np.abs(change - given)) <= 1e-12 * max(1.0, np.max(np.abs(change)))
        assert np.max(np.abs(impact.reactions)) > 1e-3 * impact.impulses.max() or impact.impulses.max() < 1e-6


def test_states_of_a_run_have_its_forces(crawler: Any) -> None:
    """What a model decides for a state is what the run held there, away from where it changes."""
    model = crawler.model
    for a, b in stretches(crawler):
        times = np.linspace(a, b, 7)[1:-1]
        q, u = crawler.at(times)
        assert np.allclose(model.contact_forces(q, u, times), crawler.contact_forces(times), rtol=1e-9, atol=1e-9)
        assert np.allclose(model.reactions(q, u, times), crawler.reactions(times), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("friction", [0.1, 0.6])
def test_the_forces_of_a_state_are_those_of_a_consistent_motion(friction: float, workshop: Workshop) -> None:
    """A rod that stands on one end or lies on both, at rest or sliding, against every combination of ways."""
    model = workshop.model(rod(friction, 0.4, (0.0, 0.0)))
    for angle, speed, spin in ((0.4, 0.0, 0.0), (0.4, 0.7, 0.0), (1.3, -0.5, 0.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)):
        q = np.array([0.0, 0.0, angle])
        u = np.array([speed, 0.0, spin])
        closed = [0, 1] if angle == 0.0 else [0]
        W, b = closed_contacts.rows(model, q, u)
        pick = closed + [2 + c for c in closed]
        slides = np.sign(np.round(np.full(len(closed), speed), 9))
        found = closed_contacts.motions(W[np.ix_(pick, pick)], b[pick], friction, slides)
        forces = model.contact_forces(q, u)
        both = np.concatenate([forces[closed, 0], forces[closed, 1]])
        moved = W[np.ix_(pick, pick)] @ both + b[pick]
        assert any(np.allclose(moved, motion.accelerations, rtol=1e-9, atol=1e-9) for motion in found)
        assert np.all(np.abs(forces[:, 1]) <= friction * forces[:, 0] + 1e-12)


def test_forces_are_recorded(crawler: Any, tmp_path: Any) -> None:
    with np.load(crawler.save(tmp_path / "run.npz")) as file:
        impulses = np.concatenate([impact.friction for impact in crawler.impacts])
        assert np.array_equal(file["impact_friction"], impulses)
        assert np.array_equal(file["impact_reactions"], [impact.reactions for impact in crawler.impacts])
    data = crawler.to_xarray()
    assert data["joint_impulse"].dims == ("impact", "joint", "component")
    assert list(data["joint"].values) == list(crawler.model.joints)
    assert np.array_equal(data["friction_impulse"], impulses)


def test_a_body_without_joints_is_recorded(workshop: Workshop, tmp_path: Any) -> None:
    """Impacts of a free rod have no impulses of joints, in shapes that tell so."""
    run = simulate(workshop.model(rod(0.4, 0.5, (0.0, -1.0))), until=0.2)
    assert run.impacts and run.impacts[0].reactions.shape == (0, 3)
    assert run.reactions([0.0, 0.1]).shape == (2, 0, 3)
    with np.load(run.save(tmp_path / "run.npz")) as file:
        assert file["impact_reactions"].shape == (len(run.impacts), 0, 3)
    assert "joint" not in run.to_xarray().dims


def test_a_pickled_run_gives_the_same_forces(leaning: Any) -> None:
    run = simulate(leaning)
    copied = pickle.loads(pickle.dumps(run))
    times = np.linspace(0.0, 2.0, 9)
    assert np.array_equal(copied.contact_forces(times), run.contact_forces(times))
    assert np.array_equal(copy.deepcopy(run).reactions(times), run.reactions(times))


def test_inputs_that_change_are_part_of_the_forces(workshop: Workshop) -> None:
    """The leaning rod is pressed down at its tip by a force from a table, and by a controller: all of it goes into the
    ground."""
    press = '[[input]]\nname = "press"\npoint = "rod.T"\ndirection = [0, -1]\n'
    text = LEANING.replace("[run]\nuntil = 2\n", "") + press + '[start]\nangles = { rod = "-30 deg" }\n'
    model = workshop.model(text)
    times = np.linspace(0.0, 1.0, 11)
    for inputs in ({"t": [0.0, 1.0], "press": [0.0, 5.0]}, lambda t, q, u: {"press": 5.0 * t}):
        run = simulate(model, until=1.0, inputs=inputs)
        assert run.contact_forces(times)[:, 0, 0] == pytest.approx(G + 5.0 * times, rel=1e-12)
        assert run.reactions(times)[:, 0, 1] == pytest.approx(np.full(11, G), rel=1e-12)
    assert model.contact_forces(*model.start(), 0.0, {"press": 2.0})[0, 0] == pytest.approx(G + 2.0, rel=1e-12)


def test_forces_of_a_rough_loop_add_up_too(workshop: Workshop) -> None:
    """A ring of five falls onto a rough slope: momentum, angular momentum and energy over every stretch."""
    ground = [{"normal": [0.2, 1.0], "restitution": 0.2, "friction": 0.5}]
    model = workshop.model(loop(5, gravity=True, start={"height": 0.1, "tilt": "20 deg"}, ground=ground))
    run = simulate(model, until=0.8, rtol=1e-12)
    assert run.success and any(phase.kind == "contact" for phase in run.phases)
    normal = np.array([0.2, 1.0]) / math.hypot(0.2, 1.0)
    along, weight = np.array([normal[1], -normal[0]]), newton.masses(model)[0].sum() * G

    def acting(t: float) -> Array:
        q, u = run.at(t)
        pushed = run.contact_forces(t)
        forces = pushed[:, :1] * normal + pushed[:, 1:] * along
        places = np.array([model.point(name, q) for name, _ in model.contacts])
        turning = places[:, 0] * forces[:, 1] - places[:, 1] * forces[:, 0]
        falling = -G * (newton.masses(model)[0] * newton.centres(model, q)[:, 0]).sum()
        slips = model.kernels.of_state("slips", q[None], u[None])[0]
        return np.array([*(forces.sum(axis=0) - [0.0, weight]), turning.sum() + falling, pushed[:, 1] @ slips])

    for a, b in stretches(run):
        start, end = run.at(a), before(run, b)
        change = [*(newton.whole(model, *end) - newton.whole(model, *start))]
        change.append(sum(model.energy(*end)) - sum(model.energy(*start)))
        total = sum(integral(acting, x, y) for x, y in pieces(run, a, b))
        assert np.max(np.abs(change[:3] - total[:3])) <= 1e-9 * weight
        assert abs(change[3] - total[3]) <= 1e-10 * weight
