"""Bodies that leave what they rest on, with all points at once, one after another, or for a moment. ``CCGEN_LIFTS``
says how many random lifts there are (``make hard``: 200, ``make figures``: 1,000; ``make test`` takes the first 20)."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from ccgen.generator import loop
from ccgen.runtime import Model, simulate

from ..support.bodies import G, penetration
from ..support.reach import Reach
from ..support.tiers import hard
from ..support.workshop import Workshop
from .lifts import COMPILED, METHODS, lift, scene, standing

LIFTS = int(os.environ.get("CCGEN_LIFTS", "1000" if "CCGEN_LARGE" in os.environ else "200"))


@pytest.mark.hard
@pytest.mark.parametrize("count", [20, hard(LIFTS)])
def test_random_even_lifts(count: int, workshop: Workshop, reach: Reach) -> None:
    """All points leave at once, when the force reaches the weight; then the block rises without a turn."""
    models = [(workshop.model(scene(rough)), "") for rough in (False, True)]
    models += [(workshop.model(scene(True, expression)), expression) for expression in COMPILED]
    wrong, time, height, turn, energy = [], 0.0, 0.0, 0.0, 0.0
    for seed in range(count):
        one = lift(*models[seed % len(models)], seed)
        if not one.run.success or one.run.impacts:
            wrong.append(f"{one.what}: {one.run.message}, {len(one.run.impacts)} impacts")
        time = max(time, abs(one.left - one.leaves) * min(1.0, one.rate) / max(1.0, one.leaves))
        height = max(height, one.missed / one.rtol)
        turn = max(turn, one.turned)
        moves = float(np.max(np.sum(np.abs(one.run.model.energy(one.run.q, one.run.u)), axis=0)))
        energy = max(energy, one.run.energy_drift / moves / one.rtol)
    assert not wrong, "\n".join(wrong)
    reach(f"{count} even lifts: time of leaving, times the rate of the force", time, 1e-14)
    reach(f"{count} even lifts: height at the end, in tolerances", height, 100.0)
    reach(f"{count} even lifts: turn, rad", turn, 1e-12)
    reach(f"{count} even lifts: energy from nothing, in tolerances", energy, 100.0)


def test_lifted_off_the_centre(workshop: Workshop, reach: Reach) -> None:
    """Two smooth points leave one after the other, against an integration of the block about the one that is left."""
    model, rng = workshop.model(scene(rough=False)), np.random.default_rng(5)
    first, second, place = 0.0, 0.0, 0.0
    for number in range(40):
        a, b = -float(rng.uniform(0.1, 0.3)), float(rng.uniform(0.1, 0.3))
        inertia, steep = float(rng.uniform(0.005, 0.05)), float(rng.uniform(5.0, 15.0))
        arm = float(rng.choice([-1.0, 1.0]) * 10 ** rng.uniform(-9, -1.3))
        params = standing([a, b]) | {"block.inertia": inertia}
        times, place_at = _one_after_the_other(a, b, inertia, steep, arm)
        found = simulate(
            model,
            until=times[1] + 0.05,
            params=params,
            method=METHODS[number % 4],
            rtol=1e-10,
            inputs=lambda t, q, u, s=steep, x=arm: [s * t, 0.0, s * t * x],
        )
        assert found.success, found.message
        first = max(first, abs(found.phases[0].end - times[0]))
        second = max(second, abs(found.phases[-1].start - times[1]))
        place = max(place, float(np.max(np.abs(found.q[-1] - place_at(found.t[-1])))))
    reach("40 uneven lifts: first point leaves, s", first, 1e-12)
    reach("40 uneven lifts: last point leaves, s", second, 2e-7)  # at once, if that changes speeds by 1e-13
    reach("40 uneven lifts: place at the end, m and rad", place, 1e-7)


def _one_after_the_other(a: float, b: float, inertia: float, steep: float, arm: float) -> Any:
    """When the points at a < 0 < b leave (s), and the place from then on: a force of steep t, ``arm`` off centre."""
    stays = a if arm > 0 else b
    start = brentq(lambda t: (G - steep * t) * stays + steep * t * arm, 0.0, G / steep, xtol=1e-16, rtol=1e-15)

    def pressing(t: float, y: Any) -> tuple[float, float]:
        across, along = stays * np.sin(y[0]) - 0.1 * np.cos(y[0]), stays * np.cos(y[0]) + 0.1 * np.sin(y[0])
        lost = G + across * y[1] ** 2 - steep * t
        spin = (steep * t * arm + along * lost) / (inertia + along**2)
        return spin, lost - along * spin

    def gone(t: float, y: Any) -> float:
        return pressing(t, y)[1]

    gone.terminal, gone.direction = True, -1.0  # type: ignore[attr-defined]
    options = {"rtol": 1e-13, "atol": 1e-15, "method": "DOP853"}
    one = solve_ivp(lambda t, y: [y[1], pressing(t, y)[0]], (start, 2 * G / steep), [0.0, 0.0], events=gone, **options)
    t, (angle, spin) = one.t[-1], one.y[:, -1]
    height = -stays * np.sin(angle) + 0.1 * np.cos(angle)
    climb = -(stays * np.cos(angle) + 0.1 * np.sin(angle)) * spin

    def place(until: float) -> Any:
        s = until - t
        fall = 0.5 * (steep * t - G) * s**2 + steep * s**3 / 6
        turn = arm / inertia * (0.5 * steep * t * s**2 + steep * s**3 / 6)
        return np.array([0.0, height + climb * s + fall, angle + spin * s + turn])

    return (start, t), place


@pytest.mark.parametrize("rough", [False, True])
@pytest.mark.parametrize("points", [2, 5])
def test_a_load_that_comes_and_goes(points: int, rough: bool, workshop: Workshop, reach: Reach) -> None:
    """Forces that are lost for a moment, or nearly so: a step of a body at rest may be longer than that."""
    model = workshop.model(scene(rough))
    params = standing([-0.2, 0.2, 0.07, -0.1, 0.13][:points])
    time, moved = 0.0, 0.0
    for number, short in enumerate([0.0, 1e-14, 1e-12, 1e-9, 1e-6, 1e-4, 1e-2, 0.3]):
        for width in (1.0, 0.1):
            for sign in (-1, 1):

                def load(t: float, q: Any, u: Any, top: float = 1 + sign * short, w: float = width) -> list[float]:
                    return [G * (top - ((t - 1.3) / w) ** 2), 0.0, 0.0]

                found = simulate(model, until=1.5, params=params, method=METHODS[number % 4], inputs=load)
                assert found.success, found.message
                flights = [phase.start for phase in found.phases if phase.kind == "flight"]
                assert float(np.max(np.abs(found.q[:, 2]))) < 1e-12
                if sign > 0 and short * width >= 1e-9:
                    time = max(time, abs(flights[0] - (1.3 - width * np.sqrt(short))))
                elif sign < 0 or short < 1e-13:
                    moved = max(moved, float(np.max(np.abs(found.q[:, 1] - 0.1))))
    reach(f"loads that come and go, {points} points, rough {rough}: time of leaving, s", time, 1e-9)
    reach(f"loads that come and go, {points} points, rough {rough}: moved without, m", moved, 1e-13)


def test_a_load_faster_than_the_steps_of_a_body_at_rest(workshop: Workshop, reach: Reach) -> None:
    """At rest nothing limits a step but the load: the first time that it lifts must not be stepped over."""
    model, rng, time = workshop.model(scene(rough=True)), np.random.default_rng(1), 0.0
    for _ in range(40):
        speed, more = float(np.exp(rng.uniform(np.log(6.0), np.log(300.0)))), float(10 ** rng.uniform(-1.5, 0))

        def load(t: float, q: Any, u: Any, w: float = speed, top: float = 1 + more) -> list[float]:
            return [G * top * float(np.sin(w * t)) * (0.2 + 0.3 * t), 0.0, 0.0]

        grid = np.arange(0.0, 5.0, 0.001 / speed)
        above = (1 + more) * np.sin(speed * grid) * (0.2 + 0.3 * grid) > 1
        first = int(np.argmax(above))
        leaves = brentq(lambda t: load(t, 0, 0)[0] - G, grid[first - 1], grid[first], xtol=1e-15)
        found = simulate(model, until=leaves + 0.1 / speed, params=standing([-0.2, 0.1]), inputs=load)
        assert found.success, found.message
        time = max(time, abs(next(phase.end for phase in found.phases if phase.kind == "contact") - leaves))
    reach("40 loads that swing: first time that they lift, s", time, 1e-10)


LOADS: dict[str, tuple[Callable[[float], float], float]] = {
    "noise of 1e-9 N": (lambda t: 4.0 + 1e-9 * (43758.5453 * np.sin(1e6 * t + 0.1) % 1.0), 1e3),
    "noise of 1e-3 N": (lambda t: 4.0 + 1e-3 * (43758.5453 * np.sin(1e6 * t + 0.1) % 1.0), 1e3),
    "held for 1 ms": (lambda t: 4.0 + 1e-3 * (43758.5453 * np.sin(np.floor(t * 1e3) + 0.1) % 1.0), 1e3),
    "switched at 1 kHz": (lambda t: 8.0 if t * 1e3 % 1.0 < 0.5 else 0.0, 4e4),
    "switched at 20 kHz": (lambda t: 8.0 if t * 2e4 % 1.0 < 0.5 else 0.0, 4e4),
}
"""Forces (N) that lift nothing and that no window shows, and how often a run of 1 s may ask for them."""


@pytest.mark.parametrize("name", LOADS)
def test_loads_that_no_window_shows_cost_little(name: str, workshop: Workshop, reach: Reach) -> None:
    """A block rests under them: looking for the loss of its forces ends where shorter windows show no more."""
    force, most = LOADS[name]
    asked = 0

    def load(t: float, q: Any, u: Any) -> list[float]:
        nonlocal asked
        asked += 1
        return [force(t), 0.0, 0.0]

    found = simulate(workshop.model(scene(rough=True)), until=1.0, params=standing([-0.1, 0.1]), inputs=load)
    assert found.success and not found.impacts and len(found.phases) == 1, found.message
    reach(f"block at rest, load {name}: times it is asked for", asked, most)


@pytest.mark.parametrize("n", [6, hard(12)])
@pytest.mark.parametrize("mass", [1e-6, 1.0, 1e3])
def test_looking_at_forces_costs_few_evaluations(n: int, mass: float, workshop: Workshop, reach: Reach) -> None:
    """Rings fall and slide along the ground for 20 s, nearly flat, where forces are known to few digits."""
    model = workshop.model(loop(n, gravity=True, start={"height": 1.0}, ground=[{"restitution": 0.2}]))
    model = model.with_parameters({"link_3.mass": mass, "link_3.inertia": mass / 12.0})
    q, u = model.start()
    run = simulate(model, *model.project(q, u + 3.0 * (np.arange(u.size) == 0)), until=20.0)
    assert run.success, run.message
    reach(f"ring of {n}, a link of {mass:g} kg, slides: evaluations per row", run.nfev / len(run.t), 80.0)


@pytest.mark.parametrize("beside", [0.0, 1e-15, -1e-15, 1e-12, -1e-12, 1e-9, -1e-9, 1e-6, -1e-6])
@pytest.mark.parametrize("after", [-5.0, 0.0, 30.0])
def test_a_row_of_a_table_beside_the_lift_off(beside: float, after: float, workshop: Workshop) -> None:
    """The load has a kink there, beyond which it grows at another rate, stays, or falls."""
    model, steep, leaves = workshop.model(scene(rough=True)), 5.0, 2.0
    kink = leaves + beside
    load = G + steep * (kink - leaves)
    table = {"t": [0.0, kink, 3.0], "lift": [G - steep * leaves, load, load + after * (3.0 - kink)]}
    rises = beside >= 1e-9 or after > 0.0  # else no force that a double shows lifts it
    wanted = leaves if beside >= 0.0 else kink + (G - load) / max(after, 1e-300)
    highest = max(after, 0.0) * 0.5**3 / 6.0 + steep * abs(
        beside
    )  # of the load's two parts, each as if for all the time
    for method in METHODS:
        found = simulate(model, until=2.5, params=standing([-0.2, 0.1, 0.15]), method=method, inputs=table)
        assert found.success and (not found.impacts or (beside > 0.0 and after < 0.0)), found.message
        flights = [phase.start for phase in found.phases if phase.kind == "flight"]
        assert (flights and abs(flights[0] - wanted) <= 1e-9) or not rises
        rise = float(np.max(found.q[:, 1])) - 0.1
        assert -1e-12 <= rise <= highest * (1.0 + 1e-6) + 1e-12
        assert float(np.max(np.abs(found.q[:, 2]))) <= 1e-12


@pytest.mark.hard
@pytest.mark.parametrize("law", [hard("newton"), "poisson", hard("stronge")])
def test_a_slider_with_clearance(law: str, workshop: Workshop, reach: Reach) -> None:
    """Between two rails, sliding on two corners, it is lifted by a force that grows: it leaves with both at once,
    strikes the other rail with both, slides there, and is let down again."""
    clearance = 1e-3
    rail = "restitution = 0.0\nfriction = {mu}\n"
    text = f"""
name = "slider"
[[link]]
name = "slider"
mass = 1.0
inertia = 0.01
com = [0, 0]
points = {{ C = [0, 0], A = [-0.1, -0.02], B = [0.1, -0.02], D = [-0.1, 0.02], E = [0.1, 0.02] }}
[[input]]
name = "lift"
point = "slider.C"
direction = [0, 1]
[gravity]
g = {G}
[[ground]]
contacts = ["slider.A", "slider.B"]
{rail.format(mu=0.2)}
[[ground]]
normal = [0, -1]
point = [0, {0.04 + clearance}]
contacts = ["slider.D", "slider.E"]
{rail.format(mu=0.1)}
[start]
position = [0, 0.02]
velocity = [20.0, 0]
"""
    one, rng = workshop.model(text), np.random.default_rng(2)
    model = Model(one._descriptor, {**one.data, "law": law})
    stopped, time, speed, deepest, turned = 0, 0.0, 0.0, 0.0, 0.0
    for number in range(40):
        period, more = float(rng.uniform(0.3, 1.5)), float(rng.uniform(0.05, 1.0))
        mu = [float(rng.uniform(0.01, 1.5)) for _ in range(2)]
        params = {f"ground_{k}.friction": mu[k] for k in range(2)}

        def load(t: float, q: Any, u: Any, w: float = np.pi / period, top: float = 1 + more) -> list[float]:
            return [G * top * float(np.sin(w * t)) ** 2]

        found = simulate(model, until=2 * period, params=params, inputs=load, method=METHODS[number % 4], rtol=1e-10)
        stopped += not found.success
        leaves = brentq(lambda t: load(t, 0, 0)[0] - G, 0.0, 0.5 * period, xtol=1e-16)
        left = found.phases[0]
        assert left.kind == "contact" and len(left.contacts) == 2
        swing = leaves / 2 - np.sin(2 * np.pi / period * leaves) * period / (4 * np.pi)  # integral of sin^2
        time = max(time, abs(left.end - leaves))
        speed = max(speed, abs(found.at(leaves)[1][0] - (20.0 - mu[0] * G * (leaves - (1 + more) * swing))))
        deepest = max(deepest, penetration(found))
        turned = max(turned, float(np.max(np.abs(found.q[:, 2]))) if max(mu) < 0.1 else 0.0)
    assert not stopped
    reach(f"slider with clearance, {law}: both corners leave, s", time, 1e-9)
    reach(f"slider with clearance, {law}: its speed then, m/s", speed, 1e-8)
    reach(f"slider with clearance, {law}: penetration, m", deepest, 1e-10)
