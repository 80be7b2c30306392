"""Discs on links that touch discs and edges of other links: impacts, rolling, sliding and leaving, by closed forms."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import simulate

from ..support.bodies import penetration
from ..support.reach import Reach
from ..support.touching_scenes import G, cradle, disc_on_plank, free_body, free_discs
from ..support.workshop import Workshop


def speeds(run: Any, name: str) -> Any:
    """Velocity (x, y) and spin of a link at the end of a run."""
    return run.model.velocities(run.q[-1], run.u[-1])[run.model.links.index(name)]


# -- impacts -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("gap", "meant", "wanted"), [(0.0, "touching", (-1 / 3, 2 / 3, 2 / 3)), (1e-6, "a gap apart", (0.0, 0.0, 1.0))]
)
def test_a_cradle_of_three(gap: float, meant: str, wanted: tuple[float, ...], workshop: Workshop, reach: Reach) -> None:
    """Balls that touch strike together, by the simultaneous law; with a gap of a micrometre it is one after another."""
    model = workshop.model(cradle(3, 0.0)).with_parameters({"ground.points.P2.x": 1.0 + gap})
    run = simulate(model, until=0.6, rtol=1e-13)
    assert run.success, run.message
    pairs = [impact.contacts for impact in run.impacts]
    both = [("ball_0.C", "touch_0"), ("ball_1.C", "touch_1")]
    assert pairs == ([tuple(both)] if not gap else [(both[0],), (both[1],)])
    found = run.impacts[-1].u_plus / run.impacts[-1].u_minus.max()
    reach(f"cradle of three, {meant}: speeds, of the first's", np.max(np.abs(found - wanted)), 1e-12)
    speed = np.sqrt(2 * G * (1 - np.cos(0.5)) / (1 + 0.5 * 0.25**2))
    reach(f"cradle of three, {meant}: the first's speed, relative", abs(run.impacts[0].u_minus[0] / speed - 1), 1e-12)
    reach(f"cradle of three, {meant}: energy, J", run.energy_drift, 1e-12)


@pytest.mark.parametrize(("gap", "wanted"), [(0.0, (-1 / 3, 2 / 3, 2 / 3)), (1e-6, (0.0, 0.0, 1.0))])
def test_three_free_balls_in_a_row(gap: float, wanted: tuple[float, ...], workshop: Workshop, reach: Reach) -> None:
    model = workshop.model(free_discs([(-1.0, 0.0), (0.0, 0.0), (0.4, 0.0)], 1.3, 0.2, "restitution = 1.0"))
    q, u = model.start()
    q[model.q_names.index("slide_6")] += gap
    u[model.u_names.index("sliding_0")] = 2.0
    run = simulate(model, q0=q, u0=u, until=1.0)
    found = [speeds(run, f"ball_{k}")[0] / 2 for k in range(3)]
    meant = "touching" if not gap else "a gap apart"
    reach(f"three free balls, {meant}: speeds, of the first's", np.max(np.abs(np.subtract(found, wanted))), 1e-12)
    reach(f"three free balls, {meant}: time of the strike, s", abs(run.impacts[0].t - 0.3), 1e-12)
    reach(f"three free balls, {meant}: energy, J", run.energy_drift, 1e-12)


MASSES, RADII, INERTIAS = (1.2, 0.7), (0.3, 0.2), (0.05, 0.02)


def two_discs(touch: str) -> str:
    """Two unequal discs, ball 0 at rest at the origin, ball 1 to its upper right; neither falls."""
    bodies = "".join(
        free_body(f"ball_{k}", m, i, "C = [0, 0]") for k, (m, i) in enumerate(zip(MASSES, INERTIAS, strict=True))
    )
    return (
        f"[ground_link]\npoints = {{ O = [0, 0] }}\n{bodies}[[touch]]\n"
        f'between = ["ball_1.C", "ball_0.C"]\nradius = [{RADII[1]}, {RADII[0]}]\n{touch}\n'
        "[start]\nslides = { x_ball_0 = 0.0, y_ball_0 = 0.0, x_ball_1 = 0.9, y_ball_1 = 0.7 }\n"
    )


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    ("law", "mu", "spins", "how"),
    [
        ("newton", 0.0, (1.0, -2.0), "smooth"),
        ("newton", 0.9, (0.0, 0.0), "sticks"),
        ("newton", 0.1, (9.0, 5.0), "slides"),
        ("poisson", 0.1, (9.0, 5.0), "slides"),
    ],
)
def test_discs_collide_obliquely(
    law: str, mu: float, spins: tuple[float, float], how: str, workshop: Workshop, reach: Reach
) -> None:
    """P = (1 + e) v_n / W_n, and F that ends the sliding or is at its limit; W = sums of 1/m, and of 1/m + r²/I."""
    model = workshop.model(two_discs(f'restitution = 0.6\n{"friction = 0.9" if mu else ""}\nlaw = "{law}"'))
    if mu:
        model = model.with_parameters({"touch_0.friction": mu})
    u = np.zeros(len(model.u_names))
    places = [
        (model.q_names.index(f"theta_{3 * k + 2}"), *(model.q_names.index(f"slide_{3 * k + j}") for j in (0, 1)))
        for k in (0, 1)
    ]
    for (turn, _, _), spin in zip(places, spins, strict=True):
        u[turn] = spin
    u[list(places[1][1:])] = (-1.1, -0.7)
    run = simulate(model, u0=u, until=2.0)
    (impact,) = run.impacts
    before, after = (
        np.array([[w[x], w[y], w[turn]] for turn, x, y in places]) for w in (impact.u_minus, impact.u_plus)
    )
    q, _ = run.at(impact.t)
    x = np.array([[q[i] for i in place[1:]] for place in places])
    normal = (x[1] - x[0]) / np.hypot(*(x[1] - x[0]))
    assert np.hypot(*(x[1] - x[0])) == pytest.approx(sum(RADII), abs=1e-14)
    tangent = np.array([normal[1], -normal[0]])
    relative = before[1, :2] - before[0, :2]
    push = -1.6 * normal @ relative / sum(1 / m for m in MASSES)
    slip = tangent @ relative + RADII[0] * spins[0] + RADII[1] * spins[1]
    yields = sum(1 / m + r**2 / i for m, r, i in zip(MASSES, RADII, INERTIAS, strict=True))
    pull = -np.sign(slip) * min(abs(slip) / yields, mu * push)
    assert (abs(slip) / yields < mu * push) == (how == "sticks")
    impulse = push * normal + pull * tangent
    wanted = before.copy()
    for k, sign in enumerate((-1, 1)):
        wanted[k, :2] += sign * impulse / MASSES[k]
        wanted[k, 2] += RADII[k] * pull / INERTIAS[k]
    reach(f"oblique collision, {how}, {law}: velocities, m/s", np.max(np.abs(after - wanted)), 1e-13)
    momentum = [np.array(MASSES) @ v[:, :2] for v in (before, after)]
    reach(f"oblique collision, {how}, {law}: momentum, N s", np.max(np.abs(momentum[1] - momentum[0])), 1e-14)
    turning = [
        sum(m * (c[0] * v[1] - c[1] * v[0]) + i * v[2] for m, i, c, v in zip(MASSES, INERTIAS, x, state, strict=True))
        for state in (before, after)
    ]
    reach(f"oblique collision, {how}, {law}: angular momentum, N m s", abs(turning[1] - turning[0]), 1e-14)
    reach(f"oblique collision, {how}, {law}: energy, J", run.energy_drift, 1e-12)


# -- rolling and sliding -----------------------------------------------------------------------------------------------

SLOPE = float(np.radians(20))


@pytest.mark.parametrize(
    ("mu", "how", "share"),
    [
        (None, "smooth", np.sin(SLOPE)),
        (0.5, "sticks", np.sin(SLOPE) * 2 / 3),
        (0.05, "slides forward", np.sin(SLOPE) - 0.05 * np.cos(SLOPE)),
    ],
)
def test_down_a_tilted_plank_and_off_its_end(
    mu: float | None, how: str, share: float, workshop: Workshop, reach: Reach
) -> None:
    """a = g sin; 2/3 of it rolling, less mu g cos sliding; flies off where its centre is above the end."""
    model = workshop.model(
        disc_on_plank(SLOPE, 0.2, "restitution = 0.0\nfriction = 0.5" if mu else "restitution = 0.0")
    )
    if mu:
        model = model.with_parameters({"touch_0.friction": mu})
    run = simulate(model, until=1.2)
    assert run.success, run.message
    assert [(phase.kind, phase.how) for phase in run.phases] == [("contact", (how,)), ("flight", ())]
    a = G * share
    reach(f"down a plank, {how}: time of its end, relative", abs(run.phases[1].start / np.sqrt(1.6 / a) - 1), 1e-9)
    q, u = run.at(0.4)
    speed = np.hypot(*run.model.velocities(q, u)[run.model.links.index("disc"), :2])
    reach(f"down a plank, {how}: speed, relative", abs(speed / (0.4 * a) - 1), 1e-11)
    reach(f"down a plank, {how}: penetration, m", penetration(run), 1e-12)
    reach(f"down a plank, {how}: energy, J", run.energy_drift, 1e-9)


@pytest.mark.parametrize("mu", [None, 0.2])
def test_off_the_end_at_any_speed_and_tolerance(mu: float | None, workshop: Workshop) -> None:
    """Where the flat edge ends the force of contact jumps to a pull: the disc is let go there, and not held anew."""
    model = workshop.model(disc_on_plank(0.3, 0.2, f"restitution = 0.0\n{f'friction = {mu}' if mu else ''}"))
    q, u = model.start()
    for spin in np.linspace(-30.0, 30.0, 13):
        u[model.u_names.index("w_3")] = spin
        for rtol in (1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12):
            run = simulate(model, q, u, until=2.0, rtol=rtol)
            assert run.success, f"{spin}, {rtol}: {run.message}"
            assert run.phases[-1].kind == "flight"
            x, y = model.point("disc.C", run.at(run.phases[-1].start)[0])
            assert x * np.cos(0.3) - y * np.sin(0.3) == pytest.approx(1.0, abs=1e-9)


def quadrature(speed: Callable[[float], float], angle: float, reach: float) -> float:
    """Time over an arc of radius ``reach`` to an angle."""
    from scipy.integrate import quad

    return float(quad(lambda x: reach / speed(x), 0.0, angle, epsabs=1e-14, epsrel=1e-14)[0])


def first_root(function: Callable[[float], float], low: float, high: float) -> float:
    from scipy.optimize import brentq

    return float(brentq(function, low, high, xtol=1e-15))


def test_a_smooth_disc_over_the_round_end_of_a_plank(workshop: Workshop, reach: Reach) -> None:
    """From the level plank onto its end and off it where cos = 2/3 + v²/(3 g D); the time by quadrature."""
    model = workshop.model(disc_on_plank(0.0, 0.9, "restitution = 0.0"))
    v, apart = 0.3, 0.12
    u = np.zeros(len(model.u_names))
    u[model.u_names.index("sliding_0")] = v
    run = simulate(model, u0=u, until=0.8, rtol=1e-11)
    assert [phase.kind for phase in run.phases] == ["contact", "flight"]
    angle = np.arccos(2 / 3 + v**2 / (3 * G * apart))
    q, _ = run.at(run.phases[0].end)
    x, y = run.model.point("disc.C", q)
    reach("over the end, smooth: angle of leaving, rad", abs(np.arctan2(x - 1.0, y) - angle), 1e-8)
    wanted = 0.1 / v + quadrature(lambda z: np.sqrt(v**2 + 2 * G * apart * (1 - np.cos(z))), angle, apart)
    reach("over the end, smooth: time of leaving, s", abs(run.phases[0].end - wanted), 1e-8)
    reach("over the end, smooth: energy, J", run.energy_drift, 1e-9)


def test_a_rolling_disc_over_the_round_end_of_a_plank(workshop: Workshop, reach: Reach) -> None:
    """Rolls until friction reaches its limit: g sin/3 = mu (g cos - v²/D), with v² = v0² + 4/3 g D (1 - cos)."""
    mu, v, apart, radius = 0.8, 0.3, 0.12, 0.1
    model = workshop.model(disc_on_plank(0.0, 0.9, f"restitution = 0.0\nfriction = {mu}"))
    u = np.zeros(len(model.u_names))
    u[model.u_names.index("sliding_0")], u[model.u_names.index("w_3")] = v, -v / radius
    run = simulate(model, u0=u, until=0.8, rtol=1e-11)
    assert [phase.how for phase in run.phases] == [("sticks",), ("slides forward",), ()]

    def square(z: float) -> float:
        return float(v**2 + 4 / 3 * G * apart * (1 - np.cos(z)))

    angle = first_root(lambda z: G * np.sin(z) / 3 - mu * (G * np.cos(z) - square(z) / apart), 0.0, 1.0)
    q, _ = run.at(run.phases[0].end)
    x, y = run.model.point("disc.C", q)
    reach("over the end, rolling: angle of slipping, rad", abs(np.arctan2(x - 1.0, y) - angle), 1e-8)
    wanted = 0.1 / v + quadrature(lambda z: np.sqrt(square(z)), angle, apart)
    reach("over the end, rolling: time of slipping, s", abs(run.phases[0].end - wanted), 1e-8)


def ball_on_disc(touch: str, axle: bool) -> str:
    """A uniform disc of 0.25 m at 0.1 rad from the top of one of 1 m: which is fixed, or turns about an axle, 3 kg."""
    place = 1.25 * np.sin(0.1), 1.25 * np.cos(0.1)
    wheel = (
        '[[link]]\nname = "wheel"\nmass = 3.0\ninertia = 1.5\ncom = [0, 0]\npoints = { C = [0, 0] }\n'
        '[[joint]]\nname = "axle"\nbetween = ["ground.O", "wheel.C"]\n'
    )
    body = free_body("ball", 2.0, 0.5 * 2.0 * 0.25**2, "C = [0, 0]")
    wheel, under = (wheel, "wheel.C") if axle else ("", "ground.O")
    return (
        f"[ground_link]\npoints = {{ O = [0, 0] }}\n{wheel}{body}[[touch]]\n"
        f'between = ["ball.C", "{under}"]\nradius = [0.25, 1.0]\nrestitution = 0.0\n{touch}\n'
        f"[gravity]\ng = {G}\n[start]\nslides = {{ x_ball = {float(place[0])!r}, y_ball = {float(place[1])!r} }}\n"
    )


def test_a_smooth_ball_leaves_a_fixed_disc(workshop: Workshop, reach: Reach) -> None:
    """Where cos = 2/3 of the cosine it was let go at."""
    run = simulate(workshop.model(ball_on_disc("", axle=False)), until=1.5, rtol=1e-11)
    assert [phase.kind for phase in run.phases] == ["contact", "flight"]
    x, y = run.model.point("ball.C", run.at(run.phases[0].end)[0])
    reach("off a fixed disc, smooth: cosine of leaving", abs(y / np.hypot(x, y) / np.cos(0.1) - 2 / 3), 1e-9)


@pytest.mark.sample(2)
@pytest.mark.parametrize(("axle", "mu"), [(False, 0.5), (False, 1e6), (True, 0.5), (True, 1e6)])
def test_a_ball_rolls_off_a_disc(axle: bool, mu: float, workshop: Workshop, reach: Reach) -> None:
    """Both surfaces roll on each other: the centre gains g sin/k, k = 1 + M/(2 (M + m)), or 3/2 on a disc that is held.

    It slips where (1 - 1/k) sin = mu (cos - 2 (cos 0.1 - cos)/k), without a limit of friction at 2/(2 + k): 4/7.
    """
    model = workshop.model(ball_on_disc("friction = 0.5", axle)).with_parameters({"touch_0.friction": mu})
    run = simulate(model, until=1.6, rtol=1e-11)
    assert run.success and run.phases[0].how == ("sticks",), run.message
    k, c0 = 1 + (0.5 * 3 / 5 if axle else 0.5), np.cos(0.1)
    angle = first_root(lambda z: (1 - 1 / k) * np.sin(z) - mu * (np.cos(z) - 2 * (c0 - np.cos(z)) / k), 0.1, 1.5)
    x, y = run.model.point("ball.C", run.at(run.phases[0].end)[0])
    held = "turning" if axle else "fixed"
    reach(f"off a {held} disc, rolling, mu = {mu:g}: angle of slipping, rad", abs(np.arctan2(x, y) - angle), 1e-8)
    if mu > 1e3:
        last = next(phase for phase in run.phases if phase.kind == "flight").start
        x, y = run.model.point("ball.C", run.at(last)[0])
        reach(f"off a {held} disc, rolling: cosine of leaving", abs(y / np.hypot(x, y) / c0 - 2 / (2 + k)), 1e-5)
    reach(f"off a {held} disc, rolling, mu = {mu:g}: energy, J", run.energy_drift, 1e-9)


SEE_SAW = """
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "beam"
mass = 3.0
inertia = 0.4
com = [0, 0]
points = { M = [0, 0], A = [-1, 0], B = [1, 0] }
[[joint]]
name = "axle"
between = ["ground.O", "beam.M"]
BODY
[[touch]]
between = ["ball.C", ["beam.A", "beam.B"]]
radius = [0.2, 0.05]
restitution = 0.0
FRICTION
[gravity]
g = 9.81
[start]
angles = { beam = 0.1 }
slides = { x_ball = XX, y_ball = YY }
"""


@pytest.mark.parametrize("rolls", [True, False])
def test_a_disc_on_a_see_saw(rolls: bool, workshop: Workshop, reach: Reach) -> None:
    """The edge turns under the disc: against Lagrange's equations in the beam's angle and the way along it (SciPy)."""
    import sympy as sp
    from scipy.integrate import solve_ivp

    mass, radius, apart, start = 2.0, 0.2, 0.25, 0.3
    x = start * np.cos(0.1) - apart * np.sin(0.1)
    y = start * np.sin(0.1) + apart * np.cos(0.1)
    text = SEE_SAW.replace("BODY", free_body("ball", mass, 0.5 * mass * radius**2, "C = [0, 0]"))
    text = text.replace("FRICTION", "friction = 5.0" if rolls else "")
    run = simulate(
        workshop.model(text.replace("XX", repr(float(x))).replace("YY", repr(float(y)))), until=0.3, rtol=1e-12
    )
    assert [phase.how for phase in run.phases] == [("sticks",) if rolls else ("smooth",)]

    t = sp.Symbol("t")
    theta, s = sp.Function("theta")(t), sp.Function("s")(t)
    place = sp.Matrix([s * sp.cos(theta) - apart * sp.sin(theta), s * sp.sin(theta) + apart * sp.cos(theta)])
    spin = theta.diff(t) - s.diff(t) / radius if rolls else 0
    kinetic = (0.4 * theta.diff(t) ** 2 + mass * place.diff(t).dot(place.diff(t)) + mass * radius**2 / 2 * spin**2) / 2
    lagrangian = kinetic - mass * G * place[1]
    equations = [lagrangian.diff(v.diff(t)).diff(t) - lagrangian.diff(v) for v in (theta, s)]
    unknown = [theta.diff(t, 2), s.diff(t, 2)]
    matrix, right = sp.linear_eq_to_matrix(equations, unknown)
    names = sp.symbols("a b c d")
    given = dict(zip([theta.diff(t), s.diff(t), theta, s], [names[2], names[3], names[0], names[1]], strict=True))
    parts = sp.lambdify(names, [matrix.subs(given), right.subs(given)])

    def rates(_: float, z: Any) -> Any:
        m, r = parts(*z)
        return [z[2], z[3], *np.linalg.solve(np.array(m, dtype=float), np.array(r, dtype=float).ravel())]

    found = solve_ivp(rates, (0, 0.3), [0.1, start, 0, 0], method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    beam = run.q[-1, run.model.q_names.index("theta_0")]
    centre = complex(*run.model.point("ball.C", run.q[-1]))
    way = (centre * np.exp(-1j * beam)).real
    how = "rolling" if rolls else "smooth"
    reach(f"on a see-saw, {how}: angle of the beam, rad", abs(beam - found[0]), 1e-10)
    reach(f"on a see-saw, {how}: way along it, m", abs(way - found[1]), 1e-10)
    reach(f"on a see-saw, {how}: energy, J", run.energy_drift, 1e-10)
