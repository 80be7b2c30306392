"""Bouncing to rest, resting, landing on several points at once, grazing."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.generator import loop
from ccgen.runtime import simulate

from ..oracles import polygons
from ..support.bodies import G, penetration, rise, speed, tossed_hexagon
from ..support.bouncing_ball import BALL, FIRST
from ..support.reach import Reach
from ..support.workshop import Workshop

ASKEW = 1e-15
"""m by which one rod is longer where sensitivity is measured: five times the rounding of its length."""


@pytest.fixture(scope="module")
def ball(workshop: Workshop) -> Any:
    return workshop.model(BALL)


@pytest.fixture(scope="module")
def hexagon(workshop: Workshop) -> Any:
    return workshop.model(loop(6, gravity=True, start={"height": 1.0}, ground=[{"restitution": 0.5}]))


@pytest.mark.parametrize("e", [0.0, 0.3, 0.5, 0.7, 0.8])
def test_the_falling_hexagon_comes_to_rest(hexagon: Any, e: float, reach: Reach) -> None:
    """All six joints end on the ground, the loop flat: its closure has lost rank and holds all contacts' redundancy."""
    run = simulate(hexagon, until=30.0, params={"ground_0.restitution": e})
    assert run.success, run.message
    reach(f"hexagon to rest, e = {e}: penetration, m", penetration(run), 1e-10)
    reach(f"hexagon to rest, e = {e}: rise of energy", rise(run), 1e-9)
    reach(f"hexagon to rest, e = {e}: speed at rest, m/s", speed(run), 1e-8)
    reach(f"hexagon to rest, e = {e}: closure, m", run.closure_max, 1e-11)
    assert run.phases[-1].kind == "contact"


def test_rattling_below_rounding_comes_to_rest(hexagon: Any, reach: Reach) -> None:
    """Impacts that hand a motion of 1e-9 m/s from corner to corner, by steps that positions cannot show."""
    run = simulate(hexagon, until=30.0, params={"ground_0.restitution": 0.0}, method="gauss")
    assert run.success, run.message
    reach("hexagon that rattles: speed at rest, m/s", speed(run), 1e-8)
    reach("hexagon that rattles: rise of energy", rise(run), 1e-9)


@pytest.mark.parametrize("e", [0.5, 0.9, 0.97])
def test_a_ball_rests_at_the_limit_of_its_series(ball: Any, e: float, reach: Reach) -> None:
    limit = FIRST * (1 + e) / (1 - e)
    run = simulate(ball, until=limit + 1.0, params={"ground_0.restitution": e})
    assert run.success, run.message
    rest = next(phase.start for phase in run.phases if phase.kind == "contact")
    reach(f"ball, e = {e}: time of rest, relative", abs(rest / limit - 1), 1e-9)


def test_a_hexagon_tossed_from_half_a_metre(hexagon: Any, reach: Reach) -> None:
    """Thrown with random velocities, through accumulation after accumulation."""
    q, u = tossed_hexagon(hexagon)
    run = simulate(hexagon, q, u, until=5.0, params={"ground_0.restitution": 0.7})
    assert run.success, run.message
    assert run.impacts[0].t == pytest.approx(0.321655587659338, abs=1e-9)
    reach("hexagon tossed, e = 0.7, 5 s: penetration, m", penetration(run), 1e-10)
    reach("hexagon tossed, e = 0.7, 5 s: rise of energy", rise(run), 1e-9)


@pytest.mark.parametrize("n", [4, 6])
def test_landing_flat_on_an_edge(n: int, workshop: Workshop, reach: Reach) -> None:
    """Mirror-symmetric in exact arithmetic. What must keep it so ends where the motion itself makes more of the least
    asymmetry that a mechanism in doubles can have, with rods that are off in the last digits either way: six rods fold
    through a line at 0.63 s, where branches cross."""
    model = workshop.model(loop(n, gravity=True, start={"height": 1.0}, ground=[{"restitution": 0.5}]))
    poses = polygons.regular(n, tilt=-np.pi / n, height=0.3)
    q, u = model.state_from_poses(poses, 0 * poses)
    run, times = simulate(model, q, u, until=0.7), np.linspace(0.0, 0.7, 701)
    assert run.success, run.message
    found, measured = asymmetry(run, times), np.zeros(times.size)
    for signs in np.random.default_rng(3).choice((-1.0, 1.0), size=(8, n)):
        longer = model.with_parameters({f"link_{k}.length": 1.0 + sign * ASKEW for k, sign in enumerate(signs)})
        measured = np.maximum(measured, asymmetry(simulate(longer, *longer.project(q, u), until=0.7), times))
    before = np.cumsum(measured > 1e-12) == 0
    assert sum(impact.t < times[before][-1] for impact in run.impacts) >= 4
    reach(f"{n} rods on an edge: asymmetry, m", found[before].max(), 1e-12)
    reach(f"{n} rods on an edge: the same by that of rods off by 1e-15, at most", found.max() / measured.max(), 1.0)
    reach(f"{n} rods on an edge: penetration, m", penetration(run), 1e-10)


def asymmetry(run: Any, t: Any) -> Any:
    """How much higher joints stand than those on the other side (m) at the times t."""
    q, n = run.at(t)[0], len(run.model.links)
    heights = np.array([run.model.point(f"joint_{k}", q)[:, 1] for k in range(n)])
    return np.max([np.abs(heights[k] - heights[(1 - k) % n]) for k in range(n)], axis=0)


def test_a_square_in_the_corner_of_two_planes(workshop: Workshop, reach: Reach) -> None:
    slopes = [{"normal": [s, 1.0], "point": [0.0, -1.0], "restitution": 0.3} for s in (1.0, -1.0)]
    model = workshop.model(loop(4, gravity=True, start={"height": 1.0}, ground=slopes))
    poses = polygons.regular(4, tilt=-np.pi / 4, height=1.0)
    poses[:, 0] -= 0.5
    q, u = model.state_from_poses(poses, 0 * poses)
    run = simulate(model, q, u, until=1.0, rtol=1e-11)
    reach("square in a corner: penetration, m", penetration(run), 1e-10)
    reach("square in a corner: rise of energy", rise(run), 1e-9)


def test_six_joints_land_at_once(hexagon: Any, reach: Reach) -> None:
    """A flattened hexagon dropped flat: its closure has lost rank, six contacts, e = 0."""
    q, u = hexagon.start()
    q[:2], q[2:] = (0.0, 0.2), [0.0, 0.0, 0.0, np.pi, np.pi, np.pi]
    run = simulate(hexagon, q, u, until=1.0, params={"ground_0.restitution": 0.0})
    assert run.success, run.message
    assert len(run.impacts) == 1
    reach("six joints at once: time of impact, s", abs(run.impacts[0].t - np.sqrt(0.4 / G)), 1e-12)
    reach(
        "six joints at once: total impulse, relative",
        abs(sum(run.impacts[0].impulses) / (6 * np.sqrt(0.4 * G)) - 1),
        1e-12,
    )
    reach("six joints at once: speed at rest, m/s", speed(run), 1e-12)
    reach("six joints at once: penetration, m", penetration(run), 1e-12)


def test_a_hundred_impacts_without_loss(ball: Any, reach: Reach) -> None:
    run = simulate(ball, until=202 * FIRST, params={"ground_0.restitution": 1.0})
    assert len(run.impacts) == 101  # at FIRST, 3 FIRST, ... 201 FIRST
    energy = np.sum(ball.energy(run.q, run.u), axis=0)
    reach("100 impacts with e = 1: energy, relative", np.max(np.abs(energy / energy[0] - 1)), 1e-10)


def test_a_drop_height_changed_by_rounding(hexagon: Any, reach: Reach) -> None:
    """1e-15 m more height moves the first impact by 1e-15 / v, not by more."""
    q, u = hexagon.start()
    times = []
    for raised in (0.0, 1e-15):
        q[1] += raised
        times.append(simulate(hexagon, q, u, until=0.46).impacts[0].t)
    reach("drop height + 1e-15 m: first impact, s", abs(times[1] - times[0]), 1e-14)


def test_placed_on_the_ground(ball: Any, reach: Reach) -> None:
    run = simulate(ball, [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], until=1.0)
    assert run.success
    assert [phase.kind for phase in run.phases] == ["contact"]
    reach("placed on the ground: speed after 1 s, m/s", speed(run), 1e-13)


def test_touching_without_speed(ball: Any, reach: Reach) -> None:
    """Thrown along the ground it slides; lifted by a hair it falls back and slides on."""
    run = simulate(ball, [0.0, 1e-13, 0.0], [1.0, 0.0, 0.0], until=1.0)
    assert run.success, run.message
    reach("grazing: way after 1 s, m", abs(run.q[-1, 0] - 1.0), 1e-12)
    reach("grazing: penetration, m", penetration(run), 1e-12)


def test_velocities_into_the_ground_at_the_start(ball: Any, reach: Reach) -> None:
    run = simulate(ball, [0.0, 0.0, 0.0], [0.0, -2.0, 0.0], until=0.05)
    assert run.impacts[0].t == 0.0
    reach("into the ground at t = 0: speed after, m/s", abs(run.impacts[0].u_plus[1] - 1.0), 1e-14)


def test_an_impact_beside_a_contact_that_rests(workshop: Workshop, reach: Reach) -> None:
    """A hinge stands on the ground, its two rods fall flat: the outer ends strike while the middle rests."""
    ground = [{"restitution": 0.4, "contacts": ["joint_1", "link_0.A", "link_1.B"]}]
    model = workshop.model(_hinge(ground))
    q, u = model.start()
    run = simulate(model, q, u, until=3.0)
    assert run.success, run.message
    reach("two rods fall beside a resting hinge: penetration, m", penetration(run), 1e-10)
    reach("two rods fall beside a resting hinge: rise of energy", rise(run), 1e-9)
    reach("two rods fall beside a resting hinge: speed at rest, m/s", speed(run), 1e-8)


def _hinge(ground: list[dict[str, Any]]) -> Any:
    from ccgen.generator import chain

    return chain(2, gravity=True, start={"angles": [-0.6, 0.5], "height": 0.0}, ground=ground)


@pytest.mark.sample(2)
@pytest.mark.parametrize("angles", [(-14.0, 21.0), (10.0, -35.0), (-40.0, 70.0), (5.0, 5.5)])
def test_phases_say_what_is_closed(angles: tuple[float, float], workshop: Workshop, reach: Reach) -> None:
    """Two links dropped: after many impacts that let go of what was held, phases say how it went on, and states between
    rows, which are steps with the contacts of their phase, stay outside the ground."""
    tilts = ", ".join(f'"{angle} deg"' for angle in angles)
    model = workshop.model(
        f"[chain]\nlinks = 2\n[start]\nheight = 0.2\nangles = [{tilts}]\n[gravity]\n[[ground]]\nrestitution = 0.5\n"
    )
    run = simulate(model, until=1.0)
    assert run.success, run.message
    open_ = 0.0
    for phase in run.phases:
        rows = (run.t > phase.start) & (run.t < phase.end)
        for contact in phase.contacts if phase.kind == "contact" else ():
            gaps = model.gaps(run.q[rows])[:, list(model.contacts).index(contact)]
            open_ = max(open_, float(np.abs(gaps).max(initial=0.0)))
    between = model.gaps(run.at(np.linspace(0.0, 1.0, 4001))[0])
    reach(f"two links dropped at {angles} deg: gap of contacts that phases call closed, m", open_, 1e-12)
    reach(f"two links dropped at {angles} deg: penetration between rows, m", -float(between.min()), 1e-10)
