"""Links that give way where they touch: discs on discs and on edges, against the law written out and in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from ccgen.generator.scene import SceneError
from ccgen.runtime import Model, simulate

from ..oracles.maximal import Array
from ..support.touching_scenes import disc_on_plank, free_body
from ..support.workshop import Workshop

MASSES, INERTIAS, RADII = (2.0, 3.0), (0.01, 0.2), (0.1, 0.05)
GROUND = "[ground_link]\npoints = { O = [0, 0] }\n"
DISC = free_body("disc", MASSES[0], INERTIAS[0], "C = [0, 0]")
OTHER = free_body("other", MASSES[1], INERTIAS[1], "C = [0, 0], A = [-0.3, 0.1], B = [0.4, 0.2]")
NAMES = ["slide_0", "slide_1", "theta_2", "slide_3", "slide_4", "theta_5"]
"""Coordinates x, y and angle of both."""
ENDS = np.array([[-0.3, 0.1], [0.4, 0.2]])


def pair(workshop: Workshop, other: str, *lines: str) -> Model:
    table = f'[[compliant_touch]]\nname = "pads"\nbetween = ["disc.C", {other}]\nradius = [0.1, 0.05]\n'
    start = "[start]\nslides = { x_disc = -2.0, y_disc = 0.0, x_other = 0.0, y_other = 0.0 }\n"
    return workshop.model('name = "pads"\n' + GROUND + DISC + OTHER + table + "\n".join(lines) + "\n" + start)


def order(model: Model) -> list[int]:
    """Where x, y and angle of both are among the coordinates."""
    return [model.q_names.index(name) for name in NAMES]


def wrench(x: Array, v: Array, edge: bool, c: float) -> Array:
    """Forces and moments of load 3 (d/0.1)^1.5 (1 + c ḋ) and friction 0.4 tanh(slip/0.05) of it on both bodies, by
    vectors of the plane."""
    turn = np.array([[math.cos(x[5]), -math.sin(x[5])], [math.sin(x[5]), math.cos(x[5])]])
    centre, foot = x[:2], x[3:5]
    if edge:
        a, b = (x[3:5] + turn @ end for end in ENDS)
        along = float((centre - a) @ (b - a) / ((b - a) @ (b - a)))
        foot = a + min(max(along, 0.0), 1.0) * (b - a)
    normal = (centre - foot) / np.linalg.norm(centre - foot)
    tangent = np.array([normal[1], -normal[0]])
    places = [centre - RADII[0] * normal, foot + RADII[1] * normal]
    arms = [places[0] - x[:2], places[1] - x[3:5]]
    speeds = [v[3 * i : 3 * i + 2] + v[3 * i + 2] * np.array([-arm[1], arm[0]]) for i, arm in enumerate(arms)]
    depth, relative = sum(RADII) - np.linalg.norm(centre - foot), speeds[0] - speeds[1]
    push = 3.0 * (max(depth, 0.0) / 0.1) ** 1.5 * max(1.0 - c * float(normal @ relative), 0.0)
    force = push * (normal - 0.4 * math.tanh(float(tangent @ relative) / 0.05) * tangent)
    moments = [arm[0] * force[1] - arm[1] * force[0] for arm in arms]
    return np.concatenate([force, [moments[0]], -force, [-moments[1]]])


@pytest.mark.parametrize("other", ['"other.C"', '["other.A", "other.B"]'])
def test_forces_of_discs_and_edges(other: str, workshop: Workshop) -> None:
    """Beside an edge and past both its ends, in and out, on both links."""
    lines = ["load = 3", "depth = 0.1", "damping = 0.3", "friction = 0.4", "slip_speed = 0.05"]
    model = pair(workshop, other, *lines)
    at, rng = order(model), np.random.default_rng(4)
    masses = np.repeat(MASSES, 3)
    masses[[2, 5]] = INERTIAS
    deep, reach = 0, 0.5 if "A" in other else 0.15
    for _ in range(300):
        x = np.concatenate(
            [rng.uniform(-reach, reach, 2), rng.uniform(-3, 3, 1), rng.uniform(-0.1, 0.1, 2), rng.uniform(-3, 3, 1)]
        )
        v = rng.normal(size=6)
        q, u = np.empty(6), np.empty(6)
        q[at], u[at] = x, v
        wanted = wrench(x, v, "A" in other, 0.3)
        deep += bool(np.abs(wanted).max() > 0.0)
        assert model.acceleration(q, u)[at] * masses == pytest.approx(wanted, rel=1e-9, abs=1e-11)
    assert deep >= 50


def lankarani(e: float) -> float:
    """Restitution in closed form: χ(1 + ε) = ln((1 + χ)/(1 − χ ε)), χ = ¾(1 − e²)."""
    chi = 0.75 * (1.0 - e * e)
    return float(brentq(lambda r: chi * (1 + r) - math.log((1 + chi) / (1 - chi * r)), 1e-6, 1.0, xtol=1e-15))


@pytest.mark.parametrize("other", ['"other.C"', '["other.A", "other.B"]'])
def test_two_free_bodies_strike_each_other(other: str, workshop: Workshop) -> None:
    """Momentum is kept and speeds along the line of centres part by the restitution of the law; an edge strikes with
    what its body's inertia leaves, which turns it."""
    model = pair(workshop, other, 'load = "3000 kN"', "depth = 1.0", "restitution = 0.6")
    at = order(model)
    q, u = np.zeros(6), np.zeros(6)
    q[at], u[at] = [-1.0, 0.1, 0.2, 0.2, 0.1, 0.0], [1.5, 0.0, 0.3, -0.2, 0.0, 0.0]
    run = simulate(model, q, u, until=1.0, rtol=1e-12)
    before, after = u[at], run.u[-1][at]
    assert MASSES @ after[[0, 3]] == pytest.approx(MASSES @ before[[0, 3]], abs=1e-12)
    assert run.energy_drift <= 1e-9
    assert after[2] == pytest.approx(0.3, abs=1e-12)
    if "A" not in other:
        assert after[3] - after[0] == pytest.approx(lankarani(0.6) * 1.7, abs=1e-9)
        assert after[5] == pytest.approx(0.0, abs=1e-12)
        return
    assert abs(after[5]) > 0.01
    assert _moment(model, run.q[-1], run.u[-1], at) == pytest.approx(_moment(model, q, u, at), abs=1e-10)


def _moment(model: Model, q: Array, u: Array, at: list[int]) -> float:
    """Moment of momentum about the origin."""
    x, v = q[at], u[at]
    orbits = (
        MASSES[i] * (x[3 * i] * v[3 * i + 1] - x[3 * i + 1] * v[3 * i]) + INERTIAS[i] * v[3 * i + 2] for i in (0, 1)
    )
    return float(sum(orbits))


@pytest.mark.parametrize("method", ["gauss", "dop853"])
def test_a_disc_that_comes_past_the_end_of_an_edge(method: str, workshop: Workshop) -> None:
    """The curvature of the surface jumps there: steps end at it, and the energy is kept to the tolerance."""
    model = pair(workshop, '["other.A", "other.B"]', "load = 300", "depth = 0.01", "exponent = 2")
    at = order(model)
    q, u = np.zeros(6), np.zeros(6)
    q[at], u[at] = [0.3, 0.5, 0.0, 0.0, 0.0, 0.0], [0.8, -1.5, 0.0, 0.0, 0.0, 0.0]
    fine = simulate(model, q, u, until=1.0, rtol=1e-13)
    for rtol in (1e-6, 1e-9):
        run = simulate(model, q, u, until=1.0, rtol=rtol, method=method)
        assert run.u[-1] == pytest.approx(fine.u[-1], abs=100 * rtol)
        assert run.energy_drift <= 100 * rtol
    assert abs(fine.u[-1][at][4]) > 0.1


def test_hertz_of_two_discs(workshop: Workshop) -> None:
    """K = 4/(3π (h₁ + h₂)) √(R₁R₂/(R₁ + R₂)); of an edge, flat, √R₁."""
    h = (1 - 0.3**2) / (math.pi * 70e9)
    for other, round_ in (('"other.C"', RADII[0] * RADII[1] / sum(RADII)), ('["other.A", "other.B"]', RADII[0])):
        model = pair(workshop, other, 'young = "70 GPa"', "poisson = 0.3")
        at = order(model)
        q, depth = np.zeros(6), 3e-6
        foot = 0.5 * (ENDS[0] + ENDS[1]) if "A" in other else np.zeros(2)
        along = (ENDS[1] - ENDS[0]) / np.linalg.norm(ENDS[1] - ENDS[0])
        q[at[:2]] = foot + (sum(RADII) - depth) * np.array([-along[1], along[0]])
        push = MASSES[0] * np.linalg.norm(model.acceleration(q, np.zeros(6))[at[:2]])
        assert push == pytest.approx(4.0 / (3.0 * math.pi * 2 * h) * math.sqrt(round_) * depth**1.5, rel=1e-8)


def test_the_rigid_touch_is_its_limit(workshop: Workshop) -> None:
    """A disc that falls on a plank that is held, elastic: what is off goes as the time of contact."""
    rigid = workshop.model(disc_on_plank(0.0, 0.3, "restitution = 1.0"))
    soft_text = disc_on_plank(0.0, 0.3, "load = 1e4\nexponent = 1").replace("[[touch]]", "[[compliant_touch]]")
    soft = workshop.model(soft_text)
    q, u = rigid.start()
    q = q.copy()
    q[rigid.q_names.index("slide_1")] += 0.2
    reference = simulate(rigid, q, u, until=0.35, rtol=1e-12)
    off = []
    for load in (1e4, 1e6, 1e8):
        run = simulate(soft, q, u, until=0.35, rtol=1e-11, params={"compliant_touch_0.load": load})
        off.append(float(np.abs(run.u[-1] - reference.u[-1]).max()))
    assert len(reference.impacts) >= 1
    assert off[1] / off[0] == pytest.approx(0.1, rel=0.3) and off[2] / off[1] == pytest.approx(0.1, rel=0.3)


THROWN = [(-0.8275, -0.5514, 0.5136), (-0.9358, -0.1471, 0.3722), (-0.968, -0.2707, 0.3655), (-0.8525, -0.2278, 0.3821)]
"""Places, and times in which parabolas come down on an edge at 0, 0: a step each, but for the edge."""


@pytest.mark.parametrize(("x", "y", "time"), THROWN)
def test_a_ball_does_not_fly_through_an_edge_within_a_step(x: float, y: float, time: float, workshop: Workshop) -> None:
    """Its gap to the edge falls, rises and falls in one step; it comes back up, with the energy that it had."""
    model = workshop.model(
        'name = "court"\n[ground_link]\npoints = { O = [0, 0], A = [-0.3, 0], B = [0.3, 0] }\n'
        '[[link]]\nname = "ball"\ndisc = { mass = 0.5, radius = 0.05 }\npoints = { C = [0, 0] }\n[gravity]\n'
        '[[compliant_touch]]\nbetween = ["ball.C", ["ground.A", "ground.B"]]\nradius = [0.05, 0]\nload = 1e4\n'
        "depth = 0.001\nexponent = 1.5\n[start]\nposition = [-1, 1]\n"
    )
    q, u = np.array([x, y, 0.0]), np.array([-x / time, -y / time + 0.5 * 9.81 * time, 0.0])
    run = simulate(model, q, u, until=time + 1.5)
    over = np.array([run.at(t)[0][:2] for t in np.linspace(0.8 * time, 1.5 * time, 200)])
    over = over[np.abs(over[:, 0]) < 0.28]
    assert len(over) >= 10
    assert over[:, 1].min() >= 0.049
    assert run.u[-1][0] == pytest.approx(u[0], rel=1e-9)
    assert run.energy_drift <= 1e-8


WRONG = [
    ('between = ["disc.C", "other.C"]\nradius = 0.1\nload = 1\nexponent = 1.2', "exponent", "choose one"),
    ('between = ["disc.C", "disc.C"]\nradius = 0.1\nload = 1', "between", "two links"),
    ('between = ["disc.C", "other.C"]\nradius = 0.0\nload = 1', "radius", "points have no common normal"),
    ('between = ["disc.C", "other.C"]\nradius = [0.1, 0]\nyoung = "2 GPa"', "young", "a disc of radius 0"),
    ('between = ["disc.C", "other.C"]\nradius = 0.1\nyoung = "2 N"', "young", "that is a force, not a pressure"),
    ('between = ["disc.C", "other.C"]\nradius = 0.1', "", "found neither load nor young"),
]


@pytest.mark.parametrize(("lines", "key", "words"), WRONG)
def test_wrong_tables(lines: str, key: str, words: str, workshop: Workshop) -> None:
    with pytest.raises(SceneError) as caught:
        workshop.scene('name = "pads"\n' + GROUND + DISC + OTHER + "[[compliant_touch]]\n" + lines + "\n")
    assert [fault.key for fault in caught.value.faults] == ["compliant_touch[0]" + (f".{key}" if key else "")]
    assert words in caught.value.faults[0].message
