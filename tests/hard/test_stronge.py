"""Stronge's law of impact: restitution gives back e² of the work that the normal impulse takes in compression."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.generator import chain, loop
from ccgen.runtime import simulate

from ..oracles import polygons
from ..oracles.impact_process import strike
from ..support.bodies import penetration, rise, rod
from ..support.folders import ROOT
from ..support.hinged_rod import HINGED, STRUCK
from ..support.reach import Reach
from ..support.tiers import hard
from ..support.workshop import Workshop
from .fuzz import Toss, faults, run, scene

SLIDER_CRANK = (ROOT / "scenes" / "slider-crank.toml").read_text()
LAWS = ("newton", "poisson", "stronge")
STEEP = float(np.arctan(2.0))
IMPACTS = {
    "slides throughout": (0.1, 1.0, (-3.0, -2.0), 0.6),
    "comes to stick": (0.5, 1.0, (-0.4, -2.0), 0.6),
    "slides back": (0.2, 1.0, (0.3, -2.0), 0.7),
    "sticks, e = 1": (0.6, 0.8, (0.5, -1.0), 1.0),
    "is pulled in at first": (2.0, STEEP, (-1.0, -0.5), 0.5),
    "is pulled in for long": (2.0, STEEP, (-3.0, -0.1), 0.5),
    "sticks from the start": (0.9, 0.9, (0.0, -1.0), 0.4),
}
"""Friction, angle of the rod, velocity of its lower end, and e. With μ = 2 the impulse at first speeds it inwards."""


def _lawful(text: str, law: str, e: float) -> str:
    return text.replace("restitution = 0.0", f'restitution = {e}\nlaw = "{law}"')


@pytest.mark.sample(2)
@pytest.mark.parametrize("case", IMPACTS.values(), ids=IMPACTS.keys())
def test_a_rod_strikes_rough_ground(case: Any, workshop: Workshop, reach: Reach) -> None:
    """Against the process of the impact, marched along the normal impulse in small steps."""
    mu, angle, velocity, e = case
    model = workshop.model(_lawful(rod(mu, angle, velocity), "stronge", e))
    found = simulate(model, until=1e-4).impacts[0]
    x, y = -0.5 * np.cos(angle), -0.5 * np.sin(angle)
    W = np.array([[1 + 12 * x * x, -12 * x * y], [-12 * x * y, 1 + 12 * y * y]])
    impulse, after, taken, given = strike(W, mu, e, np.array([velocity[1], velocity[0]]))
    name = f"Stronge, mu = {mu}, v = {velocity}"
    reach(f"{name}: normal impulse, relative", abs(found.impulses[0] / impulse[0] - 1), 1e-10)
    reach(f"{name}: velocity after, m/s", np.max(np.abs(found.u_plus[:2] - after[::-1])), 1e-10)
    reach(f"{name}: work given back, relative", abs(given / taken - e**2), 1e-10)
    lost = -0.5 * impulse @ (after + np.array(velocity)[::-1])
    reach(f"{name}: energy lost, J", abs(found.energy_loss - lost), 1e-10)
    assert found.energy_loss >= 0.0


@pytest.mark.hard
@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_three_laws_agree_without_friction(e: float, workshop: Workshop, reach: Reach) -> None:
    """At one contact, and at several of one e, struck at once."""
    fallen = {}
    for law in LAWS:
        text = _lawful(rod(0.3, 1.0, (-3.0, -2.0)), law, e).replace("friction = 0.3\n", "")
        one = simulate(workshop.model(text), until=1e-4).impacts[0]
        edge = loop(6, gravity=True, start={"height": 1.0}, ground=[{"restitution": 0.5, "law": law}])
        model = workshop.model(edge)
        poses = polygons.regular(6, tilt=-np.pi / 6)
        q, u = model.state_from_poses(poses, np.tile([0.0, -1.7, 0.0], (6, 1)))
        both = model.impact(q, u, [("joint_0", "ground_0"), ("joint_1", "ground_0")], e)[1]
        fallen[law] = np.array([one.impulses[0], *both])
    for law in LAWS[1:]:
        reach(
            f"{law} less Newton, smooth, e = {e}: impulses, N s", np.max(np.abs(fallen[law] - fallen["newton"])), 1e-12
        )


def test_several_rough_contacts_give_back_their_part(workshop: Workshop, reach: Reach) -> None:
    """Two feet of a chain with their own e: of the work of normal impulses e² comes back, and no energy is added."""
    angles, gained, worst, struck = [0.9, -0.7], 0.0, 0.0, 0
    ground = [{"restitution": 0.6, "friction": 0.4, "law": "stronge", "contacts": ["link_0.A", "link_1.B"]}]
    model = workshop.model(chain(2, gravity=True, start={"angles": angles, "height": 0.0}, ground=ground))
    q, _ = model.start()
    for seed in range(40):
        u = np.random.default_rng(seed).normal(size=model.start()[1].size)
        contacts = [contact for contact, rate in zip(model.contacts, model.gap_rates(q, u), strict=True) if rate < 0.0]
        if len(contacts) < 2:
            continue
        after, _ = model.impact(q, u, contacts, [0.6, 0.3])
        struck += 1
        gained = max(gained, model.energy(q, after)[0] - model.energy(q, u)[0])
        worst = max(worst, -float(np.min(model.gap_rates(q, after))))
    assert struck >= 5
    reach("Stronge at two feet: energy gained, J", gained, 0.0)
    reach("Stronge at two feet: approach after, m/s", worst, 1e-12)


def test_kanes_pendulum_by_stronges_law(workshop: Workshop, reach: Reach) -> None:
    """By Newton's law it would gain energy; by Stronge's with e = 1 it loses what friction takes."""
    angles = np.radians([-70.0, -60.0])
    depth = float(np.sum(np.sin(angles)))
    for e in (0.7, 1.0):
        ground = [
            {"point": [0.0, depth], "restitution": e, "friction": 0.5, "law": "stronge", "contacts": ["link_1.B"]}
        ]
        model = workshop.model(chain(2, hinged=True, gravity=True, ground=ground))
        found = simulate(model, angles, [-0.1, -0.2], until=0.001)
        assert found.success, found.message
        reach(f"Kane's double pendulum, Stronge, e = {e}: energy gained, J", -found.impacts[0].energy_loss, 0.0)


@pytest.mark.parametrize("e", [0.3, 0.9, 1.0])
@pytest.mark.parametrize("friction", [0.1, 1.2])
def test_tosses_by_stronges_law(e: float, friction: float, workshop: Workshop, reach: Reach) -> None:
    """No impact adds energy, whatever the friction."""
    toss = Toss(3, 1, True, "stronge", e, friction, 7)
    found = run(workshop.model(scene(3, True)), toss)
    assert found.success and not faults(found), found.message
    reach(f"toss by Stronge's law, e = {e}, mu = {friction}: rise of energy", rise(found), 1e-9)
    reach(f"toss by Stronge's law, e = {e}, mu = {friction}: penetration, m", penetration(found), 1e-9)


GUIDED = """
name = "guided"
[ground_link]
points = { O = [0.0, 0.0] }
[[link]]
name = "block"
mass = 2.0
inertia = 0.1
com = [0.0, 0.0]
points = { A = [0.0, 0.0] }
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "block.A"]
axis = [0, 1]
[start]
slides = { guide = 0.0 }
"""
ASIDE = """
[[ground]]
name = "aside"
point = [-100.0, 0.0]
normal = [1, 0]
restitution = 0.0
contacts = ["{point}"]
"""


def _one_freedom(J: Any, inertia: float, mu: float, e: float, u: float) -> tuple[float, float]:
    """Velocity after and normal impulse where the point moves at J u (normal, tangential): one variable."""
    normal, along = J
    into, out = abs(normal) + mu * abs(along), abs(normal) - mu * abs(along)
    stops = abs(u) * inertia / into
    taken = 0.5 * abs(normal * u) * stops
    if out <= 0.0:
        return 0.0, stops
    back = e * np.sqrt(2.0 * taken * inertia / (abs(normal) * out))
    return -float(np.sign(u)) * out / inertia * back, stops + back


@pytest.mark.parametrize(("precision", "bound"), [hard("float", 1e-4), ("double", 1e-11), hard("wide", 1e-11)])
def test_a_hinged_rod_strikes_rough_ground(precision: str, bound: float, workshop: Workshop, reach: Reach) -> None:
    """Sliding and compression end at once. Where friction then holds the point it is a wedge and gives nothing back."""
    model = workshop.model(HINGED + STRUCK.format(point="rod.B", y=-0.5), precision)
    impulse, after, wedged = 0.0, 0.0, 0
    for degrees in (*range(-85, 90, 5), -89, -0.1, 0.1, 89):
        angle = float(np.radians(degrees))
        J = np.array([np.cos(angle), -np.sin(angle)])
        for mu in (0.0, 0.1, 0.5, 0.8, 1.3, 2.0, 5.0):
            if abs(J[0]) / (mu * abs(J[1]) or 1.0) == pytest.approx(1.0, abs=0.01):
                continue  # at the wedge's limit it is for rounding to say
            rough = model.with_parameters({"ground_0.friction": mu})
            for e in (0.0, 0.5, 1.0):
                u, P = rough.impact([angle], [-1.0], [("rod.B", "ground_0")], e)
                expected = _one_freedom(J, 0.33, mu, e, -1.0)
                wedged += expected[0] == 0.0 < e
                after = max(after, abs(u[0] - expected[0]))
                impulse = max(impulse, abs(P[0] / expected[1] - 1.0))
    assert wedged > 50
    reach(f"Stronge, hinged rod, {precision}: speed after, rad/s", after, bound)
    reach(f"Stronge, hinged rod, {precision}: normal impulse, relative", impulse, bound)


def test_a_rod_of_a_slider_crank_strikes_rough_ground(workshop: Workshop, reach: Reach) -> None:
    """One freedom of a loop, whose W comes from its closure too; at what it passes in a turn, either way round."""
    text = SLIDER_CRANK + STRUCK.format(point="rod.middle", y=-100.0) + ASIDE.format(point="rod.middle")
    model = workshop.model(text.replace("[gravity]\ng = 9.81\n", "", 1))
    passed = simulate(model, until=0.6)
    impulse, after, wedged = 0.0, 0.0, 0
    for q, forth in (model.project(*passed.at(t)) for t in np.linspace(0.0, 0.6, 60)):
        for u in (forth, -forth):
            J = model.gap_rates(q, u)
            if J[0] > -1e-3:
                continue
            for mu in (0.1, 0.7, 3.0):
                rough = model.with_parameters({"ground_0.friction": mu})
                found, P = rough.impact(q, u, [("rod.middle", "ground_0")], 0.6)
                rate, normal = _one_freedom(
                    J, 2.0 * (model.energy(q, u)[0] - model.energy(q, 0.0 * u)[0]), mu, 0.6, 1.0
                )
                wedged += rate == 0.0
                after = max(after, float(np.max(np.abs(found + abs(rate) * u))) / float(np.max(np.abs(u))))
                impulse = max(impulse, abs(P[0] / normal - 1.0))
    assert wedged > 50
    reach("Stronge, slider-crank: velocity after, relative", after, 1e-11)
    reach("Stronge, slider-crank: normal impulse, relative", impulse, 1e-11)


@pytest.mark.parametrize("height", [-0.35, -0.5, -0.6])
@pytest.mark.parametrize("mu", [0.8, 1.2, 2.0])
def test_a_hinged_rod_falls_on_rough_ground(height: float, mu: float, workshop: Workshop) -> None:
    model = workshop.model(HINGED + STRUCK.format(point="rod.B", y=-0.5))
    found = simulate(model, params={"ground_0.restitution": 0.5, "ground_0.friction": mu, "ground_0.point.y": height})
    assert found.success, found.message


@pytest.mark.parametrize("tilt", [0.0, 1e-17])
def test_a_block_in_an_upright_guide_strikes_rough_ground(tilt: float, workshop: Workshop, reach: Reach) -> None:
    """No impulse moves it along the ground, and there is no friction."""
    model = workshop.model(GUIDED.replace("[0, 1]", f"[{tilt}, 1]") + STRUCK.format(point="block.A", y=0.0))
    q, u = model.start()
    for e in (0.0, 0.5, 1.0):
        u, P = model.impact(q, [-1.0], [("block.A", "ground_0")], e)
        reach(f"Stronge, upright guide, e = {e}: speed after, m/s", abs(u[0] - e), 1e-14)
        reach(f"Stronge, upright guide, e = {e}: normal impulse, N s", abs(P[0] - 2.0 * (1.0 + e)), 1e-14)
