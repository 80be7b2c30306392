"""Discs on links that touch each other: coming to rest, standing, and whatever happens to what is tossed."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ccgen.runtime import simulate

from ..support.bodies import penetration, rise
from ..support.reach import Reach
from ..support.tiers import LARGE, hard
from ..support.touching_scenes import G, cradle, free_body
from ..support.workshop import Workshop


def test_a_ball_comes_to_rest_between_two(workshop: Workshop, reach: Reach) -> None:
    """Dropped beside the middle, e = 0.5, into the groove of two discs that are held: at rest where it touches both."""
    body = free_body("ball", 1.0, 0.005, "C = [0, 0]")
    pairs = "".join(
        f'[[touch]]\nbetween = ["ball.C", "ground.{p}"]\nradius = 0.1\nrestitution = 0.5\nfriction = 0.2\n'
        for p in "OQ"
    )
    model = workshop.model(
        f"[ground_link]\npoints = {{ O = [-0.12, 0], Q = [0.12, 0] }}\n{body}{pairs}"
        f"[gravity]\ng = {G}\n[start]\nslides = {{ x_ball = 0.03, y_ball = 0.5 }}\n"
    )
    run = simulate(model, until=4.0)
    assert run.success, run.message
    assert set(run.phases[-1].contacts) == {("ball.C", "touch_0"), ("ball.C", "touch_1")}
    place = run.model.point("ball.C", run.q[-1])
    reach("in a groove: place of rest, m", np.max(np.abs(place - [0.0, 0.16])), 1e-12)
    reach("in a groove: speed at rest", np.max(np.abs(run.u[-1])), 1e-10)
    reach("in a groove: penetration, m", penetration(run), 1e-12)
    reach("in a groove: energy, J", run.energy_drift, 1e-8)


@pytest.mark.parametrize(("mu", "stands"), [(0.268, True), (0.267, False)])
def test_a_pyramid_of_three(mu: float, stands: bool, workshop: Workshop, reach: Reach) -> None:
    """Three equal cylinders, two on the ground: it stands from mu = tan 15 degrees = 0.268 between them on."""
    radius = 0.1
    height = radius * (1 + np.sqrt(3))
    bodies = "".join(free_body(name, 1.0, 0.5 * radius**2, "C = [0, 0]") for name in ("left", "right", "top"))
    pairs = "".join(
        f'[[touch]]\nbetween = ["top.C", "{side}.C"]\nradius = {radius}\nrestitution = 0.0\nfriction = 0.3\n'
        for side in ("left", "right")
    )
    model = workshop.model(
        f"[ground_link]\npoints = {{ O = [0, 0] }}\n{bodies}{pairs}[[ground]]\nrestitution = 0.0\nfriction = 0.5\n"
        f'contacts = ["left.C", "right.C"]\nradius = {radius}\n[gravity]\ng = {G}\n[start]\n'
        f"slides = {{ x_left = {-radius}, y_left = {radius}, x_right = {radius}, y_right = {radius}, "
        f"x_top = 0.0, y_top = {float(height)!r} }}\n"
    )
    model = model.with_parameters({"touch_0.friction": mu, "touch_1.friction": mu})
    run = simulate(model, until=0.5)
    assert run.success, run.message
    moved = float(np.hypot(*(run.model.point("top.C", run.q[-1]) - [0, height])))
    if stands:
        reach("a pyramid that stands: moved, m", moved, 1e-12)
    else:
        assert moved > 1e-4
        reach("a pyramid that falls apart: energy, J", run.energy_drift, 1e-8)


def pile(mu: float, e: float) -> str:
    """Ten discs above the floor between two walls, each of which may touch every other."""
    names = [f"ball_{k}" for k in range(10)]
    bodies = "".join(free_body(name, 1.0, 0.5 * 0.1**2, "C = [0, 0]") for name in names)
    how = f"radius = 0.1\nrestitution = {e}\nfriction = {mu}\n"
    touches = "".join(f'[[touch]]\nbetween = ["{a}.C", "{b}.C"]\n{how}' for a, b in combinations(names, 2))
    all_of_them = ", ".join(f'"{name}.C"' for name in names)
    grounds = "".join(
        f"[[ground]]\nnormal = [{x}, {y}]\npoint = [{-0.4 * x}, 0]\ncontacts = [{all_of_them}]\n{how}"
        for x, y in ((0, 1), (1, 0), (-1, 0))
    )
    places = ", ".join(f"x_{n} = {0.24 * (k % 3 - 1)}, y_{n} = {0.15 + 0.25 * (k // 3)}" for k, n in enumerate(names))
    return (
        f"[ground_link]\npoints = {{ O = [0, 0] }}\n{bodies}{touches}{grounds}[gravity]\ng = {G}\n[start]\n"
        f"slides = {{ {places} }}\n"
    )


@pytest.mark.hard
@pytest.mark.parametrize(
    ("mu", "e", "seed", "by_steps"),
    [
        (0.2, 0.0, 1, 1e-3),
        (0.8, 0.7, 1, 1e-3),
        (0.5, 0.3, 0, 1e-3),
        (1.0, 0.5, 2, 1e-3),
        *([(0.2, 0.0, 0, 1e-3)] if LARGE else []),
    ],
)
def test_ten_rough_discs_come_to_lie(
    mu: float, e: float, seed: int, by_steps: float, workshop: Workshop, reach: Reach
) -> None:
    """Through some thousand impacts, in the end with more contacts than the discs have freedoms; in the last a row of
    discs stands between the walls (docs/hard-cases.md)."""
    model = workshop.model(pile(mu, e))
    rng = np.random.default_rng(seed)
    q, u = model.start()
    q, u = q + rng.uniform(-0.015, 0.015, q.size), 0.5 * rng.normal(size=u.size)
    run = simulate(model, q, u, until=3.0)
    assert run.success, run.message
    steps = sum(phase.end - phase.start for phase in run.phases if phase.kind == "steps")
    reach(f"ten discs, mu {mu}, e {e}, {seed}: penetration, m", penetration(run), 1e-10)
    reach(f"ten discs, mu {mu}, e {e}, {seed}: rise of energy, of that at the start", rise(run), 1e-9)
    reach(f"ten discs, mu {mu}, e {e}, {seed}: part of the time by time stepping", steps / 3.0, by_steps)


@pytest.mark.hard
def test_what_a_wall_holds_up_is_not_let_go_and_held_again(workshop: Workshop) -> None:
    """A disc leans on a wall with friction at its limit, another hardly presses: as if they stuck, forces would pull.
    Let go and held again without time between, the pile went by time stepping three times."""
    model = workshop.model(pile(0.5, 0.3))
    rng = np.random.default_rng(0)
    q, u = model.start()
    q, u = q + rng.uniform(-0.015, 0.015, q.size), 0.5 * rng.normal(size=u.size)
    run = simulate(model, q, u, until=0.47)
    assert run.success, run.message
    assert not [phase for phase in run.phases if phase.kind == "steps"]


@pytest.mark.parametrize("rough", ["", hard('friction = 0.3\nlaw = "poisson"')])
def test_a_hexagon_whose_joints_touch_each_other(rough: str, workshop: Workshop, reach: Reach) -> None:
    """A ring dropped on one corner, discs about all joints that are no neighbours."""
    pairs = ((0, 3), (1, 4), (2, 5), (0, 2), (1, 3), (2, 4), (3, 5), (0, 4), (1, 5))
    touches = "".join(
        f'[[touch]]\nbetween = ["link_{(a - 1) % 6}.B", "link_{(b - 1) % 6}.B"]\nradius = 0.1\n'
        f"restitution = 0.5\n{rough}\n"
        for a, b in pairs
    )
    model = workshop.model(
        '[loop]\nlinks = 6\n[start]\nheight = 1.0\ntilt = "7 deg"\n[gravity]\n[[ground]]\nrestitution = 0.5\n'
        f"{rough}\n{touches}"
    )
    run = simulate(model, until=4.0)
    assert run.success, run.message
    assert sum(any(ground.startswith("touch") for _, ground in impact.contacts) for impact in run.impacts) > 50
    how = "rough" if rough else "smooth"
    reach(f"a hexagon whose joints touch, {how}: penetration, m", penetration(run), 1e-10)
    reach(f"a hexagon whose joints touch, {how}: closure, m", run.closure_max, 1e-11)
    reach(f"a hexagon whose joints touch, {how}: energy, J", run.energy_drift, 1e-7)


@pytest.mark.parametrize("mu", [None, 0.3])
def test_over_the_corners_of_a_hill(mu: float | None, workshop: Workshop, reach: Reach) -> None:
    """Fixed edges with common ends: at a corner both touch, and all go over it, or rest."""
    corners = ((-1.0, -0.5), (-0.5, -0.1), (0.0, 0.0), (0.5, -0.1), (1.0, -0.5))
    points = ", ".join(f"P{k} = [{x}, {y}]" for k, (x, y) in enumerate(corners))
    edges = "".join(
        f'[[touch]]\nbetween = ["ball.C", ["ground.P{k}", "ground.P{k + 1}"]]\nradius = [0.1, 0.02]\n'
        f"restitution = 0.3\n{f'friction = {mu}' if mu else ''}\n"
        for k in range(len(corners) - 1)
    )
    model = workshop.model(
        f"[ground_link]\npoints = {{ O = [0, 0], {points} }}\n{free_body('ball', 0.5, 0.0025, 'C = [0, 0]')}{edges}"
        f"[gravity]\ng = {G}\n[start]\nslides = {{ x_ball = -0.1, y_ball = 0.3 }}\n"
    )
    deepest, drift, ended, tosses, rng = 0.0, 0.0, 0, 12, np.random.default_rng(3)
    for _ in range(tosses):
        q, u = model.start()
        run = simulate(model, q, rng.normal(size=u.size) * [5.0, 1.0, 1.0], until=3.0, rtol=1e-10)
        ended += run.success
        deepest, drift = max(deepest, penetration(run)), max(drift, run.energy_drift)
    how = "rough" if mu else "smooth"
    reach(f"over corners, {how}: penetration, m", deepest, 1e-10)
    reach(f"over corners, {how}: energy, J", drift, 1e-7)
    reach(f"over corners, {how}: share that stops", 1 - ended / tosses, 0.0)


TOSSED = """
[chain]
links = 4
length = [0.9, 1.3, 0.7, 1.1]
mass = [1.0, 0.6, 2.0, 0.8]
[gravity]
[[ground]]
restitution = 0.4
ROUGH
[[touch]]
between = ["link_0.A", "link_3.B"]
radius = [0.1, 0.15]
restitution = 0.5
ROUGH
[[touch]]
between = ["link_0.A", "link_2"]
radius = [0.1, 0.03]
restitution = 0.2
ROUGH
[[touch]]
between = ["link_0.B", "link_3"]
radius = 0.08
restitution = 0.7
ROUGH
[[touch]]
between = ["link_3.B", "link_0"]
radius = [0.05, 0.02]
restitution = 0.3
ROUGH
[start]
height = 2.0
"""


@pytest.mark.hard
@pytest.mark.parametrize("rough", ["", hard('friction = 0.4\nlaw = "stronge"')])
def test_tossed_chains_that_touch_themselves(rough: str, workshop: Workshop, reach: Reach) -> None:
    """Discs and edges of a chain of four, thrown: what must hold whether a run ends or stops and says why."""
    model, rng = workshop.model(TOSSED.replace("ROUGH", rough)), np.random.default_rng(7)
    deepest, risen, struck, ended, tosses = 0.0, 0.0, 0, 0, 20
    for _ in range(tosses):
        while True:
            q = rng.uniform(-3, 3, len(model.q_names))
            q[1] = 3.0
            if model.gaps(q).min() > 0:
                break
        run = simulate(model, q0=q, u0=rng.normal(scale=3.0, size=q.size), until=2.5, rtol=1e-11)
        assert np.all(np.isfinite(run.q)) and np.all(np.isfinite(run.u))
        ended += run.success
        struck += sum(any(ground.startswith("touch") for _, ground in impact.contacts) for impact in run.impacts)
        deepest, risen = max(deepest, penetration(run)), max(risen, rise(run))
    how = "rough" if rough else "smooth"
    reach(f"tossed chains that touch themselves, {how}: penetration, m", deepest, 1e-9)
    reach(f"tossed chains that touch themselves, {how}: rise of energy", risen, 1e-9)
    reach(f"tossed chains that touch themselves, {how}: share that stops", 1 - ended / tosses, 0.0)
    assert struck > 100


@pytest.mark.parametrize("count", [2, 3, hard(4), hard(5)])
def test_pendulums_that_swing_as_one(count: int, workshop: Workshop, reach: Reach) -> None:
    """e = 0: after the strike all share its momentum and touch without a force: they swing as one would alone."""
    model = workshop.model(cradle(count, 0.0))
    run = simulate(model, until=5.0, rtol=1e-11, params={f"touch_{k}.restitution": 0.0 for k in range(count - 1)})
    assert run.success, run.message
    strike = run.impacts[0]
    assert len(run.impacts) == 1
    assert run.phases[-1].how == ("smooth",) * (count - 1)
    inertia, weight = 1.0 + 0.5 * 0.25**2, G
    alone = solve_ivp(
        lambda t, y: [y[1], -weight / inertia * np.sin(y[0])],
        (strike.t, 5.0),
        [0.0, strike.u_minus[0] / count],
        method="DOP853",
        rtol=1e-13,
        atol=1e-13,
    )
    reach(f"{count} pendulums as one: angle after 5 s, rad", np.max(np.abs(run.q[-1] - alone.y[0, -1])), 1e-9)
    reach(f"{count} pendulums as one: gap, m", np.max(np.abs(model.gaps(run.q[run.t > strike.t]))), 1e-12)


@pytest.mark.parametrize("law", ["newton", "poisson"])
@pytest.mark.parametrize("count", [2, 3, hard(4), hard(5)])
def test_pendulums_side_by_side(count: int, law: str, workshop: Workshop, reach: Reach) -> None:
    """A cradle of balls that rub against each other: what bounces comes to swing together in twos and threes."""
    model = workshop.model(cradle(count, 0.0, touch=f'friction = 0.1\nlaw = "{law}"'))
    deepest = risen = 0.0
    touched = 0
    for e in (0.0, 0.3, 0.5, 0.9):
        for mu in (0.1, 0.5):
            pairs = [f"touch_{k}" for k in range(count - 1)]
            params = {f"{pair}.restitution": e for pair in pairs} | {f"{pair}.friction": mu for pair in pairs}
            run = simulate(model, until=5.0, params=params)
            assert run.success, f"e = {e}, mu = {mu}: {run.message}"
            assert run.impacts
            touched += any("touches" in phase.how for phase in run.phases)
            deepest, risen = max(deepest, penetration(run)), max(risen, rise(run))
    assert touched
    reach(f"{count} rubbing pendulums, {law}: penetration, m", deepest, 1e-10)
    reach(f"{count} rubbing pendulums, {law}: rise of energy", risen, 1e-9)
