"""Ground that gives way: its restitution in closed form, rolling, and the rigid ground as its limit."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from ccgen.generator import loop
from ccgen.generator.scene import SceneError
from ccgen.runtime import HybridState, Model, simulate, static_equilibrium

from ..support.workshop import Workshop

MASS, INERTIA, RADIUS = 2.0, 0.01, 0.1
BALL = (
    f'name = "ball"\n[[link]]\nname = "ball"\nmass = {MASS}\ninertia = {INERTIA}\ncom = [0, 0]\n'
    "points = { C = [0, 0] }\n[start]\nposes = { ball = [0.0, 1.0, 0.0] }\n"
)
GROUND = '[[compliant_ground]]\nname = "mat"\nload = "1 kN"\ncontacts = ["ball.C"]\n'


def ball(workshop: Workshop, *lines: str, gravity: bool = False) -> Model:
    return workshop.model(BALL + ("[gravity]\n" if gravity else "") + GROUND + "\n".join(lines) + "\n")


def rebound(c: float, v: float) -> float:
    """Restitution of a body that comes with v (m/s): ∫ v dv/(1 + c v) from −v to 0 is that from 0 to e v."""
    most = 1.0 / (c * v) if c * v > 1.0 else 1.0
    return float(
        brentq(
            lambda e: c * v * (1 + e) - math.log((1 + c * v) / (1 - c * v * e)), 1e-3, most * (1 - 1e-14), xtol=1e-15
        )
    )


@pytest.mark.sample(5)
@pytest.mark.parametrize("exponent", [1, 1.5, 2, 2.5, 3])
@pytest.mark.parametrize("damping", [0.0, 0.05, 0.9])
def test_restitution_is_that_of_the_law(exponent: float, damping: float, workshop: Workshop) -> None:
    """Whatever the exponent; the ball's way along the ground and its turn go on as they are."""
    model = ball(workshop, f"exponent = {exponent}", f"damping = {damping}")
    for speed in (0.3, 1.7):
        run = simulate(model, [0.0, 0.05, 0.0], [0.3, -speed, 2.0], until=0.5, rtol=1e-12)
        e = rebound(damping, speed) if damping else 1.0
        assert run.u[-1] == pytest.approx([0.3, e * speed, 2.0], abs=1e-9)
        assert run.energy_drift <= 1e-9


@pytest.mark.parametrize("method", ["gauss", "dop853", "dopri5"])
def test_errors_are_those_that_are_allowed(method: str, workshop: Workshop) -> None:
    """A force that begins with the power 3/2 of time is hard to step across for a method of high order."""
    model = ball(workshop, "damping = 0.3")
    for rtol in (1e-6, 1e-9, 1e-11):
        run = simulate(model, [0.0, 0.05, 0.0], [0.0, -1.7, 0.0], until=0.5, rtol=rtol, method=method)
        assert run.u[-1, 1] / 1.7 == pytest.approx(rebound(0.3, 1.7), abs=30 * rtol)


@pytest.mark.parametrize("exponent", [1, 1.5, 3])
def test_a_weight_rests_at_its_depth(exponent: float, workshop: Workshop) -> None:
    model = ball(workshop, f"exponent = {exponent}", "damping = 3", gravity=True)
    depth = 1e-3 * (MASS * 9.81 / 1000.0) ** (1.0 / exponent)
    assert static_equilibrium(model, [0.0, -0.9 * depth, 0.0]).q[1] == pytest.approx(-depth, abs=1e-11)


def test_a_disc_that_slides_comes_to_roll(workshop: Workshop) -> None:
    """Its moment of momentum about the ground is kept: v = v₀/(1 + I/(m r²)) whatever friction does until then."""
    model = ball(workshop, f"radius = {RADIUS}", "friction = 0.3", "slip_speed = 1e-4", "damping = 1", gravity=True)
    q = static_equilibrium(model, [0.0, RADIUS - 1e-5, 0.0]).q
    run = simulate(model, q, [1.0, 0.0, 0.0], until=1.0, rtol=1e-10, method="radau")
    v = 1.0 / (1.0 + INERTIA / (MASS * RADIUS**2))
    assert run.u[-1] == pytest.approx([v, 0.0, -v / RADIUS], abs=1e-8)
    assert run.energy_drift <= 1e-7


def test_forces_on_a_slope(workshop: Workshop) -> None:
    """Against the law written out, deep and outside, approaching and leaving faster than the ground follows."""
    lines = ["normal = [-3, 4]", "point = [0.2, 0.1]", f"radius = {RADIUS}", "friction = 0.4", "damping = 0.5"]
    model = ball(workshop, *lines, "exponent = 2.5")
    normal, along = np.array([-0.6, 0.8]), np.array([0.8, 0.6])
    rng = np.random.default_rng(0)
    signs = set()
    for _ in range(200):
        q = np.array([0.2, 0.1, 0.0]) + rng.normal(size=3) * 0.02 + np.append(RADIUS * normal, 0.0)
        u = rng.normal(size=3) * [2.0, 2.0, 20.0]
        depth = RADIUS - normal @ (q[:2] - [0.2, 0.1])
        swelling = 1.0 - 0.5 * (normal @ u[:2])
        push = 1000.0 * (max(depth, 0.0) / 1e-3) ** 2.5 * max(swelling, 0.0)
        drag = -0.4 * push * math.tanh((along @ u[:2] + RADIUS * u[2]) / 1e-3)
        wanted = np.append((push * normal + drag * along) / MASS, drag * RADIUS / INERTIA)
        assert model.acceleration(q, u) == pytest.approx(wanted, rel=1e-11, abs=1e-9)
        signs.add((depth > 0.0, swelling > 0.0))
    assert len(signs) == 4


def test_the_rigid_ground_is_its_limit(workshop: Workshop) -> None:
    """A hexagon on a corner, nothing lost: what is off goes as the time of contact, one over the root of stiffness."""
    start = {"gravity": True, "start": {"height": 1.0}}
    rigid = simulate(workshop.model(loop(6, **start, ground=[{"restitution": 1.0}])), until=0.5, rtol=1e-11)
    soft = workshop.model(loop(6, **start, compliant_ground=[{"load": 1e4, "exponent": 1.0}]))
    off = []
    for load in (1e4, 1e6, 1e8):
        run = simulate(soft, until=0.5, rtol=1e-10, params={"compliant_ground_0.load": load})
        assert run.energy_drift <= 1e-8
        off.append(np.abs(run.u[-1] - rigid.u[-1]).max())
    assert off[0] <= 1.0
    assert off[1] / off[0] == pytest.approx(0.1, rel=0.3) and off[2] / off[1] == pytest.approx(0.1, rel=0.3)


BOUND_TO = 0.75
"""Factor of 1 - e² in the damping after Lankarani and Nikravesh."""


def lankarani(e: float) -> float:
    """Restitution under that law: work along the way, ∫ v dv/(1 + χ v) to 0 and from 0, by quadrature; whatever the
    speed and the stiffness."""
    chi = BOUND_TO * (1.0 - e * e)
    compression = quad(lambda v: v / (1.0 + chi * v), 0.0, 1.0, epsabs=1e-13, epsrel=1e-12)[0]

    def missing(back: float) -> float:
        return compression - float(quad(lambda v: v / (1.0 - chi * v), 0.0, back, epsabs=1e-13, epsrel=1e-12)[0])

    return float(brentq(missing, 1e-6, 1.0, xtol=1e-15)) if chi else 1.0


@pytest.mark.parametrize("method", ["gauss", "radau", "dop853", "dopri5"])
@pytest.mark.parametrize("e", [0.05, 0.6, 1.0])
def test_restitution_after_lankarani_and_nikravesh(e: float, method: str, workshop: Workshop) -> None:
    """Each impact has the damping of its own approach, and of every method the accuracy that is asked for."""
    model = ball(workshop, "restitution = 0.5")
    for speed in (0.3, 1.7):
        params = {"mat.restitution": e}
        run = simulate(model, [0.0, 0.05, 0.0], [0.3, -speed, 2.0], 0.5, 1e-11, method=method, params=params)
        assert run.u[-1] == pytest.approx([0.3, lankarani(e) * speed, 2.0], abs=1e-9)
        assert run.energy_drift <= 5e-9


def test_a_ball_that_bounces_three_times(workshop: Workshop) -> None:
    """Without gravity between two grounds: after each contact the damping is that of the speed with which it came."""
    roof = '[[compliant_ground]]\nnormal = [0, -1]\npoint = [0, 0.1]\nload = "2 kN"\n'
    roof += 'restitution = 0.7\ncontacts = ["ball.C"]\n'
    model = ball(workshop, "restitution = 0.7", roof)
    run = simulate(model, [0.0, 0.05, 0.0], [0.0, -1.7, 0.0], until=0.5, rtol=1e-12)
    assert abs(run.u[-1, 1]) == pytest.approx(1.7 * lankarani(0.7) ** 5, abs=1e-10)
    assert run.energy_drift <= 1e-10


def test_below_the_slowest_approach_damping_grows_no_more(workshop: Workshop) -> None:
    """A ball comes with a tenth of that speed: it is that of Hunt and Crossley with a damping of χ/slowest."""
    model = ball(workshop, "restitution = 0.6", "slowest = 1.0")
    run = simulate(model, [0.0, 0.01, 0.0], [0.0, -0.1, 0.0], until=0.5, rtol=1e-12)
    assert run.u[-1, 1] == pytest.approx(0.1 * rebound(BOUND_TO * (1 - 0.36), 0.1), abs=1e-11)


@pytest.mark.parametrize(("method", "order", "step"), [("dopri5", 5, 8e-4), ("radau", 5, 8e-4), ("dop853", 8, 8e-4)])
def test_methods_keep_their_order_while_a_value_is_held(
    method: str, order: int, step: float, workshop: Workshop
) -> None:
    """A linear ground, so that nothing but the ends of contacts is not smooth."""
    model = ball(workshop, "restitution = 0.7", "exponent = 1")
    wanted = lankarani(0.7) * 1.7
    runs = [
        simulate(model, [0.0, 0.05, 0.0], [0.0, -1.7, 0.0], until=0.3, step=part * step, method=method)
        for part in (1.0, 0.5)
    ]
    coarse, fine = (abs(run.u[-1, 1] - wanted) for run in runs)
    assert math.log2(coarse / fine) >= order - 0.7


def test_what_is_held_is_part_of_the_state(workshop: Workshop, tmp_path: Path) -> None:
    """A run that is left within a contact goes on with the same bits as one that stops there, also from a file; between
    rows, in both directions, states and accelerations are those of the run."""
    model = ball(workshop, "restitution = 0.4", gravity=True)
    start = ([0.0, 0.05, 0.0], [0.3, -1.7, 2.0])
    whole = simulate(model, *start, until=0.5, rtol=1e-11)
    touched = np.linspace(0.0294, 0.0306, 6)
    depths = -whole.at(touched)[0][:, 1]
    assert (depths[1:] > 1e-5).sum() >= 4
    for t in touched:
        left = simulate(model, *start, until=t, rtol=1e-11)
        assert left.state is not None
        left.state.save(tmp_path / "left.npz")
        ends = [
            simulate(model, until=0.5, state=state) for state in (left.state, HybridState.load(tmp_path / "left.npz"))
        ]
        assert np.array_equal(ends[0].q, ends[1].q) and np.array_equal(ends[0].u, ends[1].u)
        assert ends[0].u[-1] == pytest.approx(whole.u[-1], abs=1e-9)
        q, u = whole.at(t)
        assert np.concatenate([q, u]) == pytest.approx(np.concatenate([left.q[-1], left.u[-1]]), abs=1e-8)
        ahead, behind = whole.at(t + 1e-6)[1], whole.at(t - 1e-6)[1]
        slope = (ahead - behind) / 2e-6
        assert whole.accelerations(t) == pytest.approx(slope, rel=1e-4, abs=1e-3)


def test_hertz_from_radius_and_materials(workshop: Workshop) -> None:
    """K = 4/(3π (h₁ + h₂)) √R with h = (1 − ν²)/(π E): steel on glass, against the force written out."""
    lines = [f"radius = {RADIUS}", 'young = ["210 GPa", "70 GPa"]', "poisson = [0.3, 0.2]"]
    model = workshop.model(BALL + GROUND.replace('load = "1 kN"\n', "") + "\n".join(lines) + "\n")
    h = [(1 - 0.3**2) / (math.pi * 210e9), (1 - 0.2**2) / (math.pi * 70e9)]
    stiffness = 4.0 / (3.0 * math.pi * sum(h)) * math.sqrt(RADIUS)
    found = model.acceleration([0.0, RADIUS - 2e-6, 0.3], [0.0, 0.0, 0.0])
    assert found == pytest.approx([0.0, stiffness * 2e-6**1.5 / MASS, 0.0], rel=1e-9)


WRONG = [
    ("exponent = 1.2", "exponent", "expected 1, 1.5, 2, 2.5 or 3"),
    ("slip_speed = 0.1", "slip_speed", "found it without friction"),
    ("normal = [0, 0]", "normal", "both zero"),
    ('depth = "2 N"', "depth", "that is a force, not a length"),
    ("restitution = 1.5", "restitution", "from 0 to 1"),
    ("slowest = 0.1", "slowest", "found it without restitution"),
    ("poisson = 0.3", "poisson", "found it without young"),
    ("restitution = 0.5\ndamping = 0.1", "damping", "found damping and restitution"),
    ('young = "210 GPa"', "load", "found load beside young"),
    ("damping = -1", "damping", "zero or positive"),
]


@pytest.mark.parametrize(("line", "key", "words"), WRONG)
def test_wrong_tables(line: str, key: str, words: str, workshop: Workshop) -> None:
    with pytest.raises(SceneError) as caught:
        workshop.scene(BALL + GROUND + line + "\n")
    assert [fault.key for fault in caught.value.faults] == [f"compliant_ground[0].{key}"]
    assert words in caught.value.faults[0].message


def test_hertz_needs_round_bodies(workshop: Workshop) -> None:
    with pytest.raises(SceneError) as caught:
        workshop.scene(BALL + GROUND.replace('load = "1 kN"', 'young = "210 GPa"'))
    assert "points that have no radius" in caught.value.faults[0].message
    with pytest.raises(SceneError) as caught:
        workshop.scene(BALL + GROUND.replace('load = "1 kN"\n', ""))
    assert "found neither load nor young" in caught.value.faults[0].message
