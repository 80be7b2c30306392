"""Events: what happens inside a step, at the start, at one instant, and what must not be taken for an event.

A ring of three rods is rigid: between impacts its mass centre flies a parabola and it turns evenly, so every height is
known in closed form. The references find their roots on a fine grid by bisection.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from ..oracles import maximal, polygons
from ..oracles.maximal import Array
from ..support.workshop import Workshop

G = 9.81
Height = Callable[[Any], Any]
RADIUS = 1 / np.sqrt(3)
"""From the centre of a unit triangle to its corners."""


@pytest.fixture(scope="module")
def triangle(workshop: Workshop) -> Any:
    """A rigid triangle that falls on y = 0."""
    from ccgen.generator import loop

    return workshop.model(loop(3, gravity=True, start={"height": 5.0}, ground=[{"restitution": 0.5}]))


@pytest.fixture(scope="module")
def weightless(workshop: Workshop) -> Any:
    """The same without gravity: the steps are as long as the method ever takes them."""
    from ccgen.generator import loop

    return workshop.model(loop(3, start={"height": 5.0}, ground=[{"restitution": 0.5}]))


def thrown(model: Any, height: float, velocity: tuple[float, float], spin: float, tilt: float) -> tuple[Array, Array]:
    """State of a unit triangle with its centre at ``height``."""
    poses = polygons.regular(3, tilt=tilt)
    centre = poses[:, :2].mean(axis=0)
    poses[:, :2] += (0.0, height) - centre
    arms = poses[:, :2] - (0.0, height)
    velocities = np.column_stack([velocity[0] - spin * arms[:, 1], velocity[1] + spin * arms[:, 0], np.full(3, spin)])
    q, u = model.state_from_poses(poses, velocities)
    return q, u


def lowest(height: float, rise: float, spin: float, tilt: float, weight: float) -> list[Height]:
    """Heights of the three corners over time; joint 0 starts at the angle -90 degrees + tilt seen from the centre."""

    def corner(k: int) -> Height:
        phase = tilt - np.pi / 2 + 2 * np.pi * k / 3
        return lambda t: height + rise * t - weight * t**2 / 2 + RADIUS * np.sin(phase + spin * t)

    return [corner(k) for k in range(3)]


def first_contact(corners: list[Height], end: float) -> tuple[float, int]:
    """First root of any corner's height, on a grid of 2 microseconds and then by bisection."""
    times = np.linspace(0.0, end, int(end / 2e-6) + 1)
    found = []
    for k, corner in enumerate(corners):
        below = np.flatnonzero(np.asarray(corner(times)) < 0)
        if below.size:
            found.append((brentq(corner, times[below[0] - 1], times[below[0]], xtol=1e-15, rtol=1e-15), k))
    return min(found)


DIPS = [1e-3, 1e-5, 1e-7, 1e-9]
"""Depths (m) of the dip under the ground."""


@pytest.mark.sample(1)
@pytest.mark.parametrize("depth", DIPS)
@pytest.mark.parametrize("weight", [0.0, G], ids=["weightless", "falling"])
def test_a_dip_inside_one_step_is_caught(triangle: Any, weightless: Any, weight: float, depth: float) -> None:
    """A corner passes under the ground and comes back, all within a small part of one step."""
    from ccgen.runtime import simulate

    model = triangle if weight else weightless
    spin, tilt, end = 7.0, 1.9, 0.62
    rise = weight * end / 2 if weight else 0.0
    times = np.linspace(0.05, end, 200_001)
    clear = min(float(np.min(corner(times))) for corner in lowest(0.0, rise, spin, tilt, weight))
    height = -clear - depth
    corners = lowest(height, rise, spin, tilt, weight)
    time, joint = first_contact(corners, end)
    stay = np.count_nonzero(np.asarray(corners[joint](times)) < 0) * (times[1] - times[0])
    assert stay < 0.05

    rtol = min(1e-8, depth / 100)
    q, u = thrown(model, height, (0.4, rise), spin, tilt)
    free = simulate(model, *thrown(model, height + 2 * depth, (0.4, rise), spin, tilt), until=end, rtol=rtol)
    assert not free.impacts
    steps = np.diff(free.t)
    around = np.searchsorted(free.t, time) - 1
    assert steps[around] > 2 * stay

    run = simulate(model, q, u, until=time + 0.01, rtol=rtol)
    assert run.impacts[0].t == pytest.approx(time, abs=rtol / np.sqrt(depth))
    assert run.impacts[0].contacts == ((f"joint_{joint}", "ground_0"),)


@pytest.mark.parametrize("clearance", [1e-3, 1e-6, 1e-8])
def test_grazing_without_touching_is_no_impact(weightless: Any, clearance: float) -> None:
    """The lowest corner turns past the ground at a small clearance, many times over."""
    from ccgen.runtime import simulate

    q, u = thrown(weightless, RADIUS + clearance, (0.3, 0.0), 5.0, 1.0)
    run = simulate(weightless, q, u, until=5.0, rtol=1e-11)
    assert run.success
    assert not run.impacts
    assert weightless.gaps(run.q).min() > 0


@pytest.mark.parametrize("tilt", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("rtol", [1e-6, 1e-9, 1e-12])
def test_event_times_are_the_closed_form(triangle: Any, tilt: float, rtol: float) -> None:
    """First impact of a spinning triangle to the tolerance, and its height there to rounding."""
    from ccgen.runtime import simulate

    spin = 2.3
    time, joint = first_contact(lowest(1.4, 0.7, spin, tilt, G), 1.0)
    run = simulate(triangle, *thrown(triangle, 1.4, (-0.2, 0.7), spin, tilt), until=time + 0.01, rtol=rtol)
    assert run.impacts[0].t == pytest.approx(time, abs=max(rtol, 1e-13))
    assert run.impacts[0].contacts == ((f"joint_{joint}", "ground_0"),)
    row = np.flatnonzero(run.t == run.impacts[0].t)[0]
    assert abs(run.model.point(f"joint_{joint}", run.q[row])[1]) <= 1e-12


def test_an_impact_at_the_start(triangle: Any) -> None:
    """A corner on the ground that moves down strikes at t = 0, exactly once."""
    from ccgen.runtime import simulate

    q, u = thrown(triangle, RADIUS, (0.0, -1.0), 0.0, 0.0)
    run = simulate(triangle, q, u, until=0.05, rtol=1e-9)
    assert run.success
    assert len(run.impacts) == 1
    assert run.impacts[0].t == 0.0
    assert run.impacts[0].contacts == (("joint_0", "ground_0"),)
    assert run.impacts[0].impulses == pytest.approx([3 * 1.5], rel=1e-12)
    assert list(run.t[:2]) == [0.0, 0.0]
    assert triangle.velocities(run.q[0], run.u[0])[:, 1] == pytest.approx(-1.0, abs=1e-12)
    assert triangle.velocities(run.q[1], run.u[1])[:, 1] == pytest.approx(0.5, abs=1e-12)
    assert np.array_equal(run.at(0.0)[1], run.u[1])


def test_no_impact_at_a_start_that_leaves(triangle: Any) -> None:
    """A corner on the ground that moves up flies off and strikes again only when it is back."""
    from ccgen.runtime import simulate

    q, u = thrown(triangle, RADIUS, (0.0, 1.0), 0.0, 0.0)
    run = simulate(triangle, q, u, until=0.25, rtol=1e-11)
    assert run.success
    assert [impact.t for impact in run.impacts] == pytest.approx([2 / G], abs=1e-11)


@pytest.mark.sample(1)
@pytest.mark.parametrize("n", [3, 4, 6])
def test_two_contacts_at_one_instant(n: int, workshop: Workshop) -> None:
    """A ring that lands flat on an edge: one impact with both joints, no turning."""
    from ccgen.generator import loop
    from ccgen.runtime import simulate

    model = workshop.model(loop(n, gravity=True, start={"height": 1.0}, ground=[{"restitution": 0.5}]))
    poses = polygons.regular(n, tilt=-np.pi / n, height=1.0)
    q, u = model.state_from_poses(poses, 0 * poses)
    run = simulate(model, q, u, until=0.5, rtol=1e-10)
    assert len(run.impacts) == 1
    impact = run.impacts[0]
    assert impact.t == pytest.approx(np.sqrt(2 / G), abs=1e-10)
    assert sorted(impact.contacts) == [("joint_0", "ground_0"), ("joint_1", "ground_0")]
    assert impact.impulses[0] == pytest.approx(impact.impulses[1], rel=1e-9)
    row = np.flatnonzero(run.t == impact.t)[0]
    corners = [polygons.corner(n, 0), polygons.corner(n, 1)]
    velocities = model.velocities(run.q[row], impact.u_minus)
    jump = maximal.impact(polygons.ring(n), model.poses(run.q[row]), velocities, corners, 0.5)
    assert impact.impulses == pytest.approx(jump.impulses.astype(float), rel=1e-12)
    after = model.velocities(run.q[row], impact.u_plus)
    assert np.max(np.abs(after - jump.velocities.astype(float))) <= 1e-12


def test_one_instant_on_two_grounds(workshop: Workshop) -> None:
    """A square that falls upright between two slopes strikes both with its lower sides' outer joints at once."""
    from ccgen.generator import loop
    from ccgen.runtime import simulate

    slopes = [{"normal": [s, 1.0], "point": [0.0, -1.0], "restitution": 0.5} for s in (1.0, -1.0)]
    model = workshop.model(loop(4, gravity=True, start={"height": 1.0}, ground=slopes))
    poses = polygons.regular(4, tilt=-np.pi / 4, height=1.0)
    poses[:, 0] -= 0.5
    q, u = model.state_from_poses(poses, 0 * poses)
    run = simulate(model, q, u, until=0.75, rtol=1e-11)
    # corners at (-+0.5, 1): the slopes are at height -0.5 there
    assert run.impacts[0].t == pytest.approx(np.sqrt(2 * 1.5 / G), abs=1e-11)
    assert sorted(run.impacts[0].contacts) == [("joint_0", "ground_0"), ("joint_1", "ground_1")]
    assert run.impacts[0].impulses[0] == pytest.approx(run.impacts[0].impulses[1], rel=1e-9)
    assert len(run.impacts) == 1


def test_a_contact_pushed_in_by_an_impact_strikes_at_the_same_instant(workshop: Workshop) -> None:
    """One edge joint strikes, which drives the other into the ground: a second impact of its own, at the same time."""
    from ccgen.generator import loop
    from ccgen.runtime import simulate

    model = workshop.model(loop(6, gravity=True, start={"height": 1.0}, ground=[{"restitution": 0.5}]))
    system = polygons.ring(6, gravity=G)
    poses = polygons.regular(6, tilt=-np.pi / 6)
    spin = 1.01  # about the middle of the edge: joint 0 goes down at 1 m/s, joint 1 up at 0.01 m/s
    arms = poses[:, :2] - (0.5, 0.0)
    turning = np.column_stack([-spin * arms[:, 1], spin * arms[:, 0] - 0.495, np.full(6, spin)])
    q, u = model.state_from_poses(poses, turning)
    run = simulate(model, q, u, until=0.001, rtol=1e-10)

    velocities = model.velocities(q, u)
    expected: list[tuple[list[int], Array]] = []
    corners = [polygons.corner(6, 0), polygons.corner(6, 1)]
    while len(expected) < 10:
        rows = maximal.contact_rows(system, poses[:, 2], corners)
        speeds = rows @ maximal.centre_velocities(system, poses, velocities).ravel()
        chosen = [k for k in (0, 1) if speeds[k] < -1e-12]
        if not chosen:
            break
        jump = maximal.impact(system, poses, velocities, [corners[k] for k in chosen], 0.5)
        expected.append((chosen, jump.impulses.astype(float)))
        velocities = jump.velocities
    assert len(expected) >= 2
    assert [chosen for chosen, _ in expected][:2] == [[0], [1]]
    at_start = [impact for impact in run.impacts if impact.t == 0.0]
    assert len(at_start) == len(expected)
    for impact, (chosen, impulses) in zip(at_start, expected, strict=True):
        assert [point for point, _ in impact.contacts] == [f"joint_{k}" for k in chosen]
        assert impact.impulses == pytest.approx(impulses, rel=1e-11)
    found = model.velocities(q, at_start[-1].u_plus)
    assert np.max(np.abs(found - velocities.astype(float))) <= 1e-12


def test_a_swinging_link_touches_below(workshop: Workshop) -> None:
    """A hinged rod whose tip sweeps 1e-4 m under the ground at the bottom of its swing, against an own integration."""
    from ccgen.generator import chain
    from ccgen.runtime import simulate

    drop = 1.0 - 1e-4
    ground = [{"point": [0.0, -drop], "restitution": 0.25, "contacts": ["link_0.B"]}]
    model = workshop.model(chain(1, hinged=True, gravity=True, ground=ground))
    angle = -np.arcsin(drop)

    def reached(_: float, y: Array) -> float:
        return float(y[0] - angle)

    reached.direction, reached.terminal = -1, True  # type: ignore[attr-defined]

    def slope(_: float, y: Array) -> list[float]:
        return [y[1], -1.5 * G * np.cos(y[0])]

    swing = solve_ivp(slope, (0, 2), [0.0, 0.0], "DOP853", rtol=1e-13, atol=1e-13, events=reached)
    time, (_, rate) = swing.t_events[0][0], swing.y_events[0][0]
    run = simulate(model, np.zeros(1), np.zeros(1), until=time + 1e-3, rtol=1e-11)
    assert run.impacts[0].t == pytest.approx(time, abs=1e-11)
    assert run.impacts[0].u_minus == pytest.approx([rate], rel=1e-10)
    assert run.impacts[0].u_plus == pytest.approx([-0.25 * rate], rel=1e-10)


@pytest.mark.sample(2)
@pytest.mark.parametrize("spin", [30.0, 300.0])
@pytest.mark.parametrize("method", ["dop853", "gauss", "radau"])
def test_no_turn_of_a_steady_rotor_is_missed(spin: float, method: str, workshop: Workshop) -> None:
    """Steps of an even rotation may take many turns; its tip meets a fixed disc in each, and bounces without loss."""
    from ccgen.runtime import simulate

    model = workshop.model(
        "[ground_link]\npoints = { O = [0, 0], P = [0, -1.0] }\n[[link]]\nmass = 1.0\ninertia = 0.1\ncom = [0, 0]\n"
        'points = { O = [0, 0], T = [1.0, 0] }\n[[joint]]\nbetween = ["ground.O", "link_0.O"]\n'
        '[[touch]]\nbetween = ["link_0.T", "ground.P"]\nradius = 0.02\nrestitution = 1.0\n'
    )
    run = simulate(model, u0=np.array([spin]), until=5.0, method=method)
    aside = 2 * np.arcsin(0.02)  # the angle between the discs' centres where they touch
    first, turn = (1.5 * np.pi - aside) / spin, 2 * (np.pi - aside) / spin
    times = np.arange(first, 5.0, turn)
    assert [impact.t for impact in run.impacts] == pytest.approx(times, abs=1e-11)
