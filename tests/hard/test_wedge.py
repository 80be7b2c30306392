"""Rough impacts at one freedom, where sliding ends with the approach and friction may then hold any impulse."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import linprog

from ccgen.runtime import simulate

from ..oracles.impact_process import poisson
from ..support.bodies import penetration, rise, rod
from ..support.hinged_rod import HINGED, STRUCK
from ..support.reach import Reach
from ..support.tiers import hard
from ..support.workshop import Workshop

INERTIA = 0.33
"""Of the hinged rod about its pin, kg m²."""
ANGLES = [float(np.radians(degrees)) for degrees in (*range(-80, 81, 10), -53.13, -35.0, -0.1, 25.0)]
FRICTION = (0.0, 0.1, 0.5, 0.8, 1.3, 2.0, 3.0)
WALL = """
[[ground]]
name = "wall"
point = [-100.0, 0.0]
normal = [{x}, {y}]
restitution = 0.0
friction = 0.3
law = "poisson"
contacts = ["rod.B"]
"""


def _hinged(law: str, workshop: Workshop, precision: str = "double", extra: str = "") -> Any:
    text = HINGED + STRUCK.format(point="rod.B", y=-0.5).replace("stronge", law) + extra
    return workshop.model(text, precision)


def _at_limit(J: Any, mu: float) -> bool:
    return mu > 0.0 and abs(abs(J[0]) / (mu * abs(J[1]) or 1e-300) - 1.0) < 0.01


@pytest.mark.parametrize(("precision", "bound"), [hard("float", 1e-4), ("double", 1e-11), hard("wide", 1e-11)])
def test_poissons_law_at_one_freedom(precision: str, bound: float, workshop: Workshop, reach: Reach) -> None:
    """Impulse, speed and energy against the process of the impact, either way of sliding."""
    model = _hinged("poisson", workshop, precision)
    after, impulse, gained, wedged = 0.0, 0.0, -np.inf, 0
    for angle in ANGLES:
        J = np.array([np.cos(angle), -np.sin(angle)])
        W = np.outer(J, J) / INERTIA
        for mu in FRICTION:
            if _at_limit(J, mu):
                continue  # at the wedge's limit it is for rounding to say
            rough = model.with_parameters({"ground_0.friction": mu})
            for e in (0.0, 0.3, 0.7, 1.0):
                u, P = rough.impact([angle], [-1.0], [("rod.B", "ground_0")], e)
                marched, v, _ = poisson(W, mu, e, -J)
                after = max(after, abs(u[0] - v[0] / J[0]))
                impulse = max(impulse, abs(P[0] / marched[0] - 1.0))
                gained = max(gained, rough.energy([angle], u)[0] - rough.energy([angle], [-1.0])[0])
                wedged += e > 0.0 and v[0] == 0.0
    assert wedged > 50
    reach(f"Poisson, hinged rod, {precision}: speed after, rad/s", after, bound)
    reach(f"Poisson, hinged rod, {precision}: normal impulse, relative", impulse, bound)
    reach(f"Poisson, hinged rod, {precision}: energy gained, J", gained, bound)


def test_newtons_law_at_one_freedom(workshop: Workshop, reach: Reach) -> None:
    """Friction is against the sliding back that follows; where that is a wedge there is no such impulse."""
    model = _hinged("newton", workshop)
    after, impulse, none = 0.0, 0.0, 0
    for angle in ANGLES:
        normal, along = np.cos(angle), abs(np.sin(angle))
        for mu in FRICTION:
            if _at_limit((normal, along), mu):
                continue
            rough = model.with_parameters({"ground_0.friction": mu})
            for e in (0.0, 0.3, 1.0):
                into = normal - mu * along if e else normal + mu * along
                if into < 0.0:
                    none += 1
                    with pytest.raises(ValueError, match="jammed"):
                        rough.impact([angle], [-1.0], [("rod.B", "ground_0")], e)
                    continue
                u, P = rough.impact([angle], [-1.0], [("rod.B", "ground_0")], e)
                after = max(after, abs(u[0] - e))
                impulse = max(impulse, abs(P[0] * into / ((1.0 + e) * INERTIA) - 1.0))
    assert none > 50
    reach("Newton, hinged rod: speed after, rad/s", after, 1e-11)
    reach("Newton, hinged rod: normal impulse, relative", impulse, 1e-11)


def test_three_laws_agree_at_one_freedom(workshop: Workshop, reach: Reach) -> None:
    """Where nothing is given back, and without friction where it is."""
    laws = [_hinged(law, workshop) for law in ("newton", "poisson", "stronge")]
    worst = 0.0
    for angle in ANGLES:
        for mu, e in [*((mu, 0.0) for mu in FRICTION), (0.0, 0.5), (0.0, 1.0)]:
            found = [
                law.with_parameters({"ground_0.friction": mu}).impact([angle], [-1.0], [("rod.B", "ground_0")], e)
                for law in laws
            ]
            together = np.array([[u[0], P[0]] for u, P in found])
            worst = max(worst, float(np.max(np.ptp(together, axis=0))))
    reach("three laws at one freedom: speeds and impulses, rad/s and N s", worst, 1e-13)


def test_poissons_law_at_a_free_rod(workshop: Workshop, reach: Reach) -> None:
    """Where no sliding turns round in compression or expansion, the law is that of the process, W being regular."""
    model = workshop.model(rod(0.3, 1.0, (0.0, 0.0)).replace("restitution = 0.0", 'restitution = 0.0\nlaw = "poisson"'))
    rng, worst, compared = np.random.default_rng(3), 0.0, 0
    for _ in range(300):
        angle, mu, e = rng.uniform(-1.5, 1.5), rng.choice(FRICTION), rng.uniform(0.0, 1.0)
        x, y = -0.5 * np.cos(angle), -0.5 * np.sin(angle)
        W = np.array([[1 + 12 * x * x, -12 * x * y], [-12 * x * y, 1 + 12 * y * y]])
        vx, vy = rng.normal(), -abs(rng.normal())
        if W[0, 0] - mu * abs(W[0, 1]) < 0.05:
            continue  # friction may draw it in: Painleve
        marched, v, turned = poisson(W, mu, e, np.array([vy, vx]))
        if turned:
            continue
        rough = model.with_parameters({"ground_0.friction": mu})
        q, u = rough.state_from_poses([[0.0, 0.0, angle]], [[vx, vy, 0.0]])
        after, P = rough.impact(q, u, [("rod.A", "ground_0")], e)
        worst = max(worst, abs(P[0] - marched[0]), float(np.max(np.abs(rough.velocities(q, after)[0][:2] - v[::-1]))))
        compared += 1
    assert compared > 150
    reach("Poisson, free rod: impulse and velocity, N s and m/s", worst, 1e-11)


def test_two_contacts_at_one_freedom(workshop: Workshop, reach: Reach) -> None:
    """A point in a corner: of the impulses that stop it the least as they load contacts, by linear programming."""
    worst, compared = 0.0, 0
    for slope in (0.4, 1.1, 2.0):
        normal = np.array([np.sin(slope), np.cos(slope)])
        model = _hinged("poisson", workshop, extra=WALL.format(x=normal[0], y=normal[1]))
        for angle in ANGLES:
            moves = np.array([-np.sin(angle), np.cos(angle)])
            J = np.array([moves[1], normal @ moves, moves[0], normal[1] * moves[0] - normal[0] * moves[1]])
            if min(J[:2]) < 0.02:
                continue
            for mu in FRICTION:
                rough = model.with_parameters({"ground_0.friction": mu, "wall.friction": mu})
                u, P = rough.impact([angle], [-1.0], [("rod.B", "ground_0"), ("rod.B", "wall")], 0.0)
                corners = np.array([J[0] + mu * J[2], J[0] - mu * J[2], J[1] + mu * J[3], J[1] - mu * J[3]])
                weights = np.repeat(J[:2], 2)  # as roots of the compliances, both over that of the inertia
                least = linprog(weights, A_eq=corners[None], b_eq=[INERTIA]).fun
                worst = max(worst, abs(u[0]), (J[:2] @ P / least - 1.0) if mu else 0.0)
                compared += 1
    assert compared > 100
    reach("two rough contacts at one freedom: speed after, and impulses above the least", worst, 1e-9)


@pytest.mark.parametrize("height", [-0.35, -0.5, -0.6])
@pytest.mark.parametrize("mu", [0.8, 1.2, 2.0])
@pytest.mark.parametrize("e", [0.0, 0.5])
def test_a_hinged_rod_falls_and_wedges(e: float, mu: float, height: float, workshop: Workshop) -> None:
    values = {"ground_0.restitution": e, "ground_0.friction": mu, "ground_0.point.y": height}
    found = simulate(_hinged("poisson", workshop), params=values)
    assert found.success, found.message
    assert found.impacts
    assert rise(found) <= 1e-9
    assert penetration(found) <= 1e-10
