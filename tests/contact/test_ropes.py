"""Ropes: slack and taut against parabolas and circles, over eyelets against Atwood's machine, words and pictures."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import inverse_dynamics, simulate, static_equilibrium

from ..support.player_page import data_of
from ..support.touching_scenes import free_body
from ..support.workshop import Workshop

G = 9.81


def ball(length: float, restitution: float, start: str, extra: str = "") -> str:
    """A ball of 2 kg on a rope from the origin."""
    return (
        '[ground_link]\npoints = { O = [0, 0] }\n[[link]]\nname = "ball"\nmass = 2.0\ninertia = 0.01\ncom = [0, 0]\n'
        'points = { C = [0, 0] }\n[[rope]]\nbetween = ["ground.O", "ball.C"]\n'
        f"length = {length!r}\nrestitution = {restitution!r}\n[gravity]\ng = {G}\n[start]\n{start}\n{extra}"
    )


def taut_again(place: complex, velocity: complex, length: float) -> float:
    """When a parabola from inside a circle about the origin, or from its rim inwards, meets it."""
    p, v, g = np.array([place.real, place.imag]), np.array([velocity.real, velocity.imag]), np.array([0.0, -G])
    square = [g @ g / 4, g @ v, v @ v + g @ p, 2 * p @ v, p @ p - length**2]
    roots = np.roots(square)
    real = roots[np.abs(roots.imag) < 1e-9].real
    return float(min(real[real > 1e-6]))


def test_a_ball_that_bounces_on_its_rope(workshop: Workshop) -> None:
    """Parabolas from one impact to the next, each of which turns six tenths of the radial speed round."""
    length, e = 1.0, 0.6
    run = simulate(
        workshop.model(ball(length, e, "position = [0.5, 0.1]\nvelocity = [0.3, 1.2]")), until=2.0, rtol=1e-12
    )
    place, velocity, t = 0.5 + 0.1j, 0.3 + 1.2j, 0.0
    for impact in run.impacts[:6]:
        flight = taut_again(place, velocity, length)
        t += flight
        place, velocity = place + velocity * flight - 0.5j * G * flight**2, velocity - 1j * G * flight
        out = place / abs(place)
        radial = (velocity * out.conjugate()).real
        assert impact.t == pytest.approx(t, abs=1e-10)
        assert impact.impulses[0] == pytest.approx(2.0 * (1 + e) * radial, rel=1e-9)
        assert impact.energy_loss == pytest.approx((1 - e**2) * radial**2, rel=1e-9)
        velocity -= (1 + e) * radial * out
    assert len(run.impacts) > 6
    assert run.energy_drift <= 1e-10


@pytest.mark.parametrize("cosine", [-0.3, -0.45])
def test_a_pendulum_that_goes_slack_and_taut(cosine: float, workshop: Workshop) -> None:
    """Thrown from the bottom with v² = gL (2 − 3 cos θ), it leaves the circle at θ and meets it again where the angles
    of the four points at which a parabola meets a circle have the sum 0: at −3 (θ − 90°)."""
    length = 1.2
    speed = math.sqrt(G * length * (2 - 3 * cosine))
    text = ball(length, 0.0, f"position = [0, {-length!r}]\nvelocity = [{speed!r}, 0]")
    run = simulate(workshop.model(text), until=2.0, rtol=1e-12)
    held = next(phase for phase in run.phases if phase.kind == "contact")
    q, u = run.at(held.end)
    above = math.acos(cosine) - math.pi / 2
    assert math.atan2(q[1], q[0]) == pytest.approx(above, abs=1e-9)
    assert u[0] ** 2 + u[1] ** 2 == pytest.approx(G * length * math.sin(above), rel=1e-9)
    (impact,) = run.impacts[:1]
    place, _ = run.at(impact.t)
    assert math.remainder(math.atan2(place[1], place[0]) + 3 * above, 2 * math.pi) == pytest.approx(0.0, abs=1e-7)
    flight = taut_again(*(complex(x[0], x[1]) for x in (q * (1 - 1e-15), u)), length)
    assert impact.t - held.end == pytest.approx(flight, rel=1e-4)  # a root of four, of which three are almost one
    times = np.linspace(0.0, held.end, 30)[1:-1]
    states = [run.at(t) for t in times]
    tension = [2.0 * ((u @ u - u[2] ** 2) / length - G * q[1] / length) for q, u in states]
    assert run.contact_forces(times)[:, 0, 0] == pytest.approx(np.array(tension), rel=1e-9)


def test_a_weight_that_falls_from_its_hook(workshop: Workshop) -> None:
    """Both ends of a rope may be at one place; it falls by its length."""
    run = simulate(workshop.model(ball(0.8, 0.0, "position = [0, 0]")), until=1.0)
    (impact,) = run.impacts
    assert impact.t == pytest.approx(math.sqrt(1.6 / G), rel=1e-12)
    assert run.contact_forces(0.9)[0, 0] == pytest.approx(2.0 * G, rel=1e-10)


def weights(masses: tuple[float, ...], heights: tuple[float, ...], rope: str, extra: str = "") -> str:
    """Weights that slide along one vertical line, x = 0, below eyelets at P, Q and R on it."""
    text = "[ground_link]\npoints = { O = [0, 0], P = [0, 3], Q = [0.7, 3], R = [0, 3] }\n"
    for k, mass in enumerate(masses):
        text += (
            f'[[link]]\nname = "weight_{k}"\nmass = {mass!r}\ninertia = 0.1\ncom = [0, 0]\npoints = {{ C = [0, 0] }}\n'
            f'[[joint]]\nname = "line_{k}"\ntype = "prismatic"\nbetween = ["ground.O", "weight_{k}.C"]\naxis = [0, 1]\n'
        )
    slides = ", ".join(f"line_{k} = {height!r}" for k, height in enumerate(heights))
    return f"{text}[[rope]]\n{rope}\nrestitution = 0.0\n[gravity]\ng = {G}\n[start]\nslides = {{ {slides} }}\n{extra}"


def test_atwoods_machine(workshop: Workshop) -> None:
    """Over two eyelets on the ground, with the length of its way at the start."""
    heavy, light = 3.0, 1.25
    rope = 'between = ["weight_0.C", "weight_1.C"]\nover = ["ground.P", "ground.R"]'
    model = workshop.model(weights((heavy, light), (1.5, 0.25), rope.replace('"ground.R"', '"ground.Q", "ground.R"')))
    assert model.parameters["rope_0.length"] == pytest.approx(1.5 + 2.75 + 1.4, rel=1e-12)
    a, tension = G * (heavy - light) / (heavy + light), 2 * G * heavy * light / (heavy + light)
    q, u = model.start()
    assert model.acceleration(q, u) == pytest.approx([-a, a], rel=1e-12)
    run = simulate(model, until=0.5)
    assert run.q[-1] == pytest.approx([1.5 - a / 8, 0.25 + a / 8], rel=1e-10)
    assert run.contact_forces(0.3)[0] == pytest.approx([tension, 0.0], rel=1e-10)
    assert run.energy_drift <= 1e-9
    held = inverse_dynamics(model, q, u, np.zeros(2), ["line_0"], contact_forces=[[light * G, 0.0]])
    assert held == pytest.approx([(heavy - light) * G], rel=1e-12)


def test_a_moving_pulley(workshop: Workshop) -> None:
    """A load m₁ in a loop of the rope, m₂ at its end: T = m₂ (g + 2a), a = g (m₁ − 2m₂)/(m₁ + 4m₂)."""
    load, end = 5.0, 1.5
    rope = 'between = ["ground.P", "weight_1.C"]\nover = ["weight_0.C", "ground.R"]'
    model = workshop.model(weights((load, end), (1.0, 0.5), rope))
    a = G * (load - 2 * end) / (load + 4 * end)
    q, u = model.start()
    assert model.acceleration(q, u) == pytest.approx([-a, 2 * a], rel=1e-12)
    assert model.contact_forces(q, u)[0, 0] == pytest.approx(end * (G + 2 * a), rel=1e-12)


def test_a_jerk_shares_the_momentum_along_the_rope(workshop: Workshop) -> None:
    """m₂ stands on the ground while m₁ falls by h; then both go on with m₁ v/(m₁ + m₂), and no ground stops m₂."""
    falls, stands, h = 1.5, 4.0, 0.7
    rope = f'between = ["weight_0.C", "weight_1.C"]\nover = ["ground.P"]\nlength = {1.0 + h + 3.0!r}'
    ground = '[[ground]]\nrestitution = 0.0\ncontacts = ["weight_1.C"]\n'
    run = simulate(workshop.model(weights((falls, stands), (2.0, 0.0), rope, ground)), until=0.6)
    impact = next(impact for impact in run.impacts if ("weight_1.C", "rope_0") in impact.contacts)
    v = math.sqrt(2 * G * h)
    assert impact.t == pytest.approx(v / G, rel=1e-11)
    after = falls * v / (falls + stands)
    _, u = run.at(impact.t)
    assert u == pytest.approx([-after, after], rel=1e-10)
    assert impact.energy_loss == pytest.approx(0.5 * falls * stands / (falls + stands) * v**2, rel=1e-10)
    rise = after**2 / (2 * G * (stands - falls) / (falls + stands))
    assert max(q[1] for q in run.q) == pytest.approx(rise, rel=1e-3)


def test_momenta_stay_over_an_eyelet_that_moves(workshop: Workshop) -> None:
    """Three free bodies, a rope from one over an eyelet of another to the third: no impact changes their momenta."""
    masses = {"a": 1.0, "b": 0.7, "c": 2.0}
    bodies = "".join(free_body(name, mass, 0.03, "C = [0, 0], E = [0.1, 0.05]") for name, mass in masses.items())
    text = (
        f"[ground_link]\npoints = {{ O = [0, 0] }}\n{bodies}"
        '[[rope]]\nbetween = ["a.E", "c.E"]\nover = ["b.E"]\nlength = 2.5\nrestitution = 0.7\n'
        "[start]\nslides = { x_a = 0.0, y_a = 0.0, x_b = 1.0, y_b = 0.4, x_c = 2.0, y_c = -0.1 }\n"
        "sliding_velocities = { x_a = -1.0, y_a = 0.3, x_b = 0.1, y_b = 0.9, x_c = 0.6, y_c = -0.4 }\n"
        "angular_velocities = { a = 2.0, b = -1.0, c = 0.5 }\n"
    )
    run = simulate(workshop.model(text), until=3.0)
    model, mass = run.model, np.array([*masses.values()])
    assert len(run.impacts) >= 2

    def momenta(q: Any, u: Any) -> list[float]:
        links = [model.links.index(name) for name in "abc"]
        poses, velocities = model.poses(q)[links], model.velocities(q, u)[links]
        turning = poses[:, 0] * velocities[:, 1] - poses[:, 1] * velocities[:, 0]
        return [*(mass @ velocities[:, :2]), float(mass @ turning + 0.03 * velocities[:, 2].sum())]

    found = np.array([momenta(q, u) for q, u in zip(run.q, run.u, strict=True)])
    assert np.max(np.abs(found - found[0])) <= 1e-9
    assert np.min(run.model.gaps(run.q)) >= -1e-12


def test_what_a_rope_carries_at_rest_and_in_a_given_motion(workshop: Workshop) -> None:
    """A ball hangs with its weight on the rope; to swing it as it would swing by itself takes nothing but the rope."""
    model = workshop.model(ball(1.0, 0.0, "position = [0.6, -0.8]"))
    found = static_equilibrium(model)
    assert found.q[:2] == pytest.approx([0.0, -1.0], abs=1e-8)
    assert found.contact_forces[0] == pytest.approx([2.0 * G, 0.0], rel=1e-9)
    angle, speed = 0.4, 1.3
    q = np.array([math.sin(angle), -math.cos(angle), 0.0])
    u = speed * np.array([math.cos(angle), math.sin(angle), 0.0])
    contact = model.contacts[0]
    bias = -G * math.sin(angle) * u / speed + np.append(-(speed**2) * q[:2], 0.0)
    assert model.acceleration(q, u) == pytest.approx(bias, abs=1e-11)
    tension = 2.0 * (speed**2 + G * math.cos(angle))
    assert model.contact_forces(q, u)[0, 0] == pytest.approx(tension, rel=1e-12)
    assert model.contacts == (contact,) and contact == ("ball.C", "rope_0")


def test_ropes_are_drawn_and_told(workshop: Workshop, tmp_path: Path) -> None:
    from ccgen.generator.documents.show import show_text

    rope = 'name = "line"\nbetween = ["weight_0.C", "weight_1.C"]\nover = ["ground.P"]'
    text = weights((1.0, 2.0), (1.0, 0.5), rope)
    assert "line: weight_0.C - ground.P - weight_1.C, line.length = 4.5" in show_text(
        workshop.scene(text), False, False
    )
    model = workshop.model(text)
    (drawn,) = model.ropes
    q, _ = model.start()
    assert drawn.way(model.poses(q)) == pytest.approx(np.array([[0, 1.0], [0, 3.0], [0, 0.5]]), abs=1e-15)
    assert drawn.way(np.repeat(model.poses(q)[None], 4, axis=0)).shape == (4, 3, 2)
    run = simulate(model, until=0.1)
    run.plot(tmp_path / "run.png")
    content = data_of(run.animate(tmp_path / "run.html").read_text(encoding="utf-8"))
    assert content["ropes"] == [[[0, 0.0, 0.0], [-1, 0.0, 3.0], [1, 0.0, 0.0]]]
    with pytest.raises(ValueError, match=r"the start needs line to be longer by 0\.5 m; change the start, or make it"):
        simulate(model, until=0.1, params={"line.length": 4.0})
    with pytest.raises(ValueError, match=r"line\.length: found 0.0, expected a positive number"):
        model.with_parameters({"line.length": 0.0})


YOYO = """
[let]
r = 0.005
R = 0.03
m = 0.1
L = 0.4
tiny = 1e-7
[ground_link]
points = { hand = [0, 0] }
[[link]]
name = "hub"
mass = 0
inertia = 0
com = [0, 0]
points = { C = [0, 0] }
[[link]]
name = "disc"
mass = "m"
inertia = "m*R**2/2"
com = [0, 0]
points = { C = [0, 0] }
[[link]]
name = "left"
mass = "tiny"
inertia = 0
com = [0, 0]
points = { E = [0, 0] }
[[link]]
name = "right"
mass = "tiny"
inertia = 0
com = [0, 0]
points = { E = [0, 0] }
[[joint]]
name = "fall"
type = "prismatic"
axis = "-90 deg"
angle = 0
between = ["ground.hand", "hub.C"]
[[joint]]
name = "spin"
between = ["hub.C", "disc.C"]
[[joint]]
name = "wound_left"
type = "prismatic"
axis = "-90 deg"
angle = 0
between = ["hub.C", "left.E"]
[[joint]]
name = "wound_right"
type = "prismatic"
axis = "-90 deg"
angle = 0
between = ["hub.C", "right.E"]
[[rack]]
pinion = "spin"
slide = "wound_left"
radius = "r"
[[rack]]
pinion = "spin"
slide = "wound_right"
radius = "r"
reverse = true
[[rope]]
between = ["ground.hand", "left.E"]
length = "L"
restitution = 0
[[rope]]
between = ["ground.hand", "right.E"]
length = "L"
restitution = 0
[gravity]
g = 9.8
[run]
until = 12
rtol = 1e-11
[start]
slides = { fall = "L/2", wound_left = "L/2", wound_right = "-L/2" }
"""


def test_the_yoyo_of_siconos_turns_round_at_the_end_of_its_string(workshop: Workshop) -> None:
    """Radii, mass, string and start of Siconos' example Yoyo, with the hand at rest. The string winds up on one side of
    the axle or on the other; where it is all unwound the yo-yo goes over from one to the other and loses all but
    e = (I - m r²)/(I + m r²) of its speed, though the string does not bounce. The ends of the string have a mass μ
    here, with which it is (I - m r²)/(I + m r² + 4 μ r²), by angular momentum about the string."""
    r, m, length, g, tiny = 0.005, 0.1, 0.4, 9.8, 1e-7
    inertia = 0.5 * m * 0.03**2
    e = (inertia - m * r * r) / (inertia + m * r * r + 4.0 * tiny * r * r)
    fall = (m + 2.0 * tiny) * g / (m + inertia / r**2 + 4.0 * tiny)
    first = np.sqrt(length / fall)
    run = simulate(workshop.model(YOYO))
    assert run.success, run.message
    times = first + 2.0 * first * np.cumsum(np.append(0.0, e ** np.arange(1, 14)))
    met = times[times < 12.0]
    assert [impact.t for impact in run.impacts] == pytest.approx(met, rel=1e-9)
    speeds = [np.max(np.abs(impact.u_minus)) * r for impact in run.impacts]
    assert speeds == pytest.approx(fall * first * e ** np.arange(len(met)), rel=1e-9)
    assert [phase.contacts[0][1] for phase in run.phases if phase.kind == "contact"] == [
        f"rope_{k % 2}" for k in range(len(met) + 1)
    ]
