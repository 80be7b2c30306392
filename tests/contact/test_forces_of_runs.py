"""Forces of contacts and joints over whole runs, and in impacts: Newton's laws for every link."""

from __future__ import annotations

import copy
import math
import pickle
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from ccgen.generator import loop
from ccgen.runtime import simulate

from ..oracles import closed_contacts, newton
from ..oracles.maximal import Array
from ..support.bodies import rod
from ..support.leaning_rod import LEANING, G
from ..support.workshop import Workshop

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


@pytest.mark.hard
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
    assert crawler.impacts
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


def test_a_pickled_run_gives_the_same_forces(workshop: Workshop) -> None:
    run = simulate(workshop.model(LEANING))
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


@pytest.mark.hard
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
