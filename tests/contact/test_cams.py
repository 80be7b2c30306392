"""Cams: rows against geometry, eccentrics against discs and closed forms, designers' laws, lift-off, the order of
methods where pieces meet, and a cam and follower of the literature."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from ccgen.runtime import simulate, static_equilibrium

from ..support.player_page import data_of
from ..support.workshop import Workshop

G = 9.81
MASS, INERTIA = 0.5, 0.02


def bench(
    cam: str,
    start: str,
    shaft: str = '[[drive]]\njoint = "axle"\nspeed = 10.0\n',
    off: float = 0.0,
    spring: tuple[float, float] | None = None,
    gravity: bool = True,
) -> str:
    """A shaft about O and a lifter that slides along the vertical ``off`` beside it, its point P at the height of the
    slide; ``spring``: stiffness, and the force that it pushes down with at height zero."""
    text = (
        f"[ground_link]\npoints = {{ O = [0, 0], G = [{off!r}, 0], H = [{off!r}, 2] }}\n"
        f'[[link]]\nname = "shaft"\nmass = 2\ninertia = {INERTIA}\ncom = [0, 0]\n'
        "points = { O = [0, 0], E = [0.01, 0] }\n"
        f'[[link]]\nname = "lifter"\nmass = {MASS}\ninertia = 0.001\ncom = [0, 0.05]\n'
        "points = { A = [-0.1, 0], B = [0.1, 0], P = [0, 0] }\n"
        '[[joint]]\nname = "axle"\nbetween = ["ground.O", "shaft.O"]\n'
        '[[joint]]\nname = "guide"\ntype = "prismatic"\naxis = [0, 1]\n'
        'between = ["ground.G", "lifter.P"]\n'
    )
    text += "[gravity]\n" if gravity else ""
    if spring:
        stiffness, force = spring
        length = 2.0 + force / stiffness
        text += f'[[spring]]\nbetween = ["ground.H", "lifter.P"]\nstiffness = {stiffness!r}\nlength = {length!r}\n'
    return text + cam + shaft + start


def cam(follower: str, base: float, lift: str, friction: float = 0.0, more: str = "", restitution: float = 0.0) -> str:
    rough = f"friction = {friction}\n" if friction else ""
    lift = lift if lift.startswith("[") else f'"{lift}"'
    return (
        f'[[cam]]\ncentre = "shaft.O"\nfollower = {follower}\nbase = {base!r}\nlift = {lift}\n'
        f"restitution = {restitution}\n{rough}{more}"
    )


FACE, POINT = '["lifter.A", "lifter.B"]', '"lifter.P"'


def slid(run: Any) -> Any:
    return run.q[:, run.model.q_names.index("slide_1")]


def turned(run: Any) -> Any:
    return run.q[:, run.model.q_names.index("theta_0")]


def at_height(height: float, angle: float = 0.0, spin: float = 0.0) -> str:
    spinning = f"angular_velocities = {{ shaft = {spin!r} }}\n" if spin else ""
    return f"[start]\nslides = {{ guide = {height!r} }}\nangles = {{ shaft = {angle!r} }}\n{spinning}"


# -- rows --------------------------------------------------------------------------------------------------------------

LINKS = """
[ground_link]
points = { Q = [1.4, 0.5] }
[[link]]
name = "a"
mass = 1.0
inertia = 0.2
com = [0.4, 0.1]
points = { B = [1.0, -0.1], M = [0.5, 0.3] }
[[link]]
name = "b"
mass = 1.5
inertia = 0.1
com = [0.3, 0]
points = { A = [0, 0], B = [0.8, 0], C = [0.9, 0.3] }
[[joint]]
between = ["a.B", "b.A"]
"""
WAVY = "0.02*cos(angle) + 0.01*sqrt(2 + sin(3*angle)) + 0.003*exp(cos(angle))*tanh(sin(angle))"
ROUND = "0.02*cos(angle) + 0.01*sqrt(2 + sin(2*angle))"
TURNED = (
    '[{ to = "100 deg", lift = 0.05, law = "3-4-5" }, { to = "150 deg" }, '
    '{ to = "230 deg", lift = "0.035 + 0.015*cos((angle - 5*pi/6)*9/4)" }, '
    '{ to = "300 deg", lift = 0.01, law = "4-5-6-7" }, { to = "360 deg", lift = 0 }]'
)
ROWS = (
    f'[[cam]]\ncentre = "a.M"\nfollower = "b.B"\nbase = 0.1\nradius = 0.03\nangle = 0.4\n'
    f'clockwise = true\nlift = "{WAVY}"\n'
    "restitution = 0.3\nfriction = 0.3\n"
    f'[[cam]]\ncentre = "a.M"\nfollower = ["b.B", "b.C"]\nbase = 0.1\nangle = -0.7\nlift = "{ROUND}"\n'
    "restitution = 0.3\nfriction = 0.3\n"
    f'[[cam]]\ncentre = "b.B"\nfollower = "ground.Q"\nbase = 0.1\nlift = {TURNED}\n'
    "restitution = 0.3\nfriction = 0.2\n"
)
FIRST = [1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280]
SECOND = [-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560]


def kernel(model: Any, name: str, q: Any, u: Any) -> Any:
    return model.kernels.of_state(name, q[None].copy(), u[None].copy())[0]


def test_rows_are_derivatives_of_the_gaps_everywhere(workshop: Workshop) -> None:
    """Rates and biases at random states, in contact or far from it, on every piece of a profile."""
    model = workshop.model(LINKS + ROWS + "[start]\nangles = { a = 0.3, b = 1.2 }\n")
    rng, n, h = np.random.default_rng(4), len(model.q_names), 2e-3
    pieces = set()
    for _ in range(60):
        q, u = 2.0 * rng.normal(size=n), 0.3 * rng.normal(size=n)
        pose = model.poses(q)[1]
        off = (complex(1.4, 0.5) - complex(*model.point("b.B", q))) * np.exp(-1j * pose[2])
        seen = math.degrees(np.angle(off)) % 360.0
        near = min(abs(seen - end) for end in (0.0, 100.0, 150.0, 230.0, 300.0, 360.0))
        fine = [True, True, near > 5.0]  # so that no difference reaches over an end of a piece
        if fine[2]:
            pieces.add(int(np.searchsorted([100.0, 150.0, 230.0, 300.0], seen)))
        gaps = [model.gaps(q + k * h * u) for k in range(-4, 5)]
        slips = [kernel(model, "slips", q + k * h * u, u) for k in range(-4, 5)]
        for name, values, weights, power, accuracy in (
            ("gap_rates", gaps, FIRST, 1, 1e-11),
            ("gap_bias", gaps, SECOND, 2, 1e-7),
            ("slip_bias", slips, FIRST, 1, 1e-10),
        ):
            wanted = sum(c * v for c, v in zip(weights, values, strict=True)) / h**power
            assert kernel(model, name, q, u)[fine] == pytest.approx(wanted[fine], abs=accuracy), name
    assert pieces == {0, 1, 2, 3, 4}


# -- closed forms ------------------------------------------------------------------------------------------------------


def test_a_flat_follower_on_an_eccentric_lifts_by_its_closed_form(workshop: Workshop) -> None:
    """e (1 − cos φ), the force m (g + e ω² cos φ), and the torque that the drive needs, to rounding.

    The face is seen from the cam at a right angle less the shaft's angle.
    """
    e, speed = 0.01, 10.0
    start = at_height(0.05) + f"sliding_velocities = {{ guide = {-e * speed} }}\n"
    model = workshop.model(bench(cam(FACE, 0.04, f"{e}*(1 - cos(angle))"), start))
    run = simulate(model, until=1.3)
    assert run.success and not run.impacts
    seen = 0.5 * math.pi - turned(run)
    assert slid(run) == pytest.approx(0.04 + e * (1.0 - np.cos(seen)), abs=1e-12)
    forces = run.contact_forces(run.t)[:, 0, 0]
    assert forces == pytest.approx(MASS * (G + e * speed**2 * np.cos(seen)), rel=1e-9)
    torques = run.reactions(run.t)[:, model.joints.index("axle"), 2]
    assert torques == pytest.approx(-forces * e * np.sin(seen), abs=1e-10)


@pytest.mark.sample(2)
@pytest.mark.parametrize("law", ["cycloidal", "3-4-5", "4-5-6-7", "harmonic"])
def test_a_roller_follows_the_designers_laws(law: str, workshop: Workshop) -> None:
    """Lift and force of a rise, and the shaft's torque, against the law by its textbook; the guide's drive of a lifter
    that is moved so without a cam needs what the cam gives."""
    base, radius, top, speed, rise = 0.05, 0.01, 0.012, 8.0, 2.0
    laws = {
        "cycloidal": lambda x: x - np.sin(2 * np.pi * x) / (2 * np.pi),
        "3-4-5": lambda x: 10 * x**3 - 15 * x**4 + 6 * x**5,
        "4-5-6-7": lambda x: 35 * x**4 - 84 * x**5 + 70 * x**6 - 20 * x**7,
        "harmonic": lambda x: 0.5 * (1 - np.cos(np.pi * x)),
    }
    pieces = (
        f'[{{ to = "90 deg" }}, {{ to = {0.5 * math.pi + rise!r}, lift = {top}, law = "{law}" }}, '
        f'{{ to = "240 deg" }}, {{ to = "360 deg", lift = 0, law = "{law}" }}]'
    )
    text = cam(POINT, base, pieces, more=f"radius = {radius}\n")
    shaft = f'[[drive]]\njoint = "axle"\nspeed = {-speed}\n'
    model = workshop.model(bench(text, at_height(base + radius), shaft))
    run = simulate(model, until=rise / speed, rtol=1e-11)
    assert run.success and not run.impacts
    t = np.linspace(0.01, 0.99, 40) * rise / speed

    def lift(x: Any) -> Any:
        return top * laws[law](x)

    x, h = t * speed / rise, 1e-3
    bends = sum(c * lift(x + k * h) for k, c in zip(range(-4, 5), SECOND, strict=True)) / h**2 * (speed / rise) ** 2
    slopes = sum(c * lift(x + k * h) for k, c in zip(range(-4, 5), FIRST, strict=True)) / h / rise
    heights = np.array([run.at(s)[0][model.q_names.index("slide_1")] for s in t])
    assert heights == pytest.approx(base + radius + lift(x), abs=1e-9)
    lean = np.arctan(slopes / heights)
    upwards = MASS * (G + bends)
    assert run.contact_forces(t)[:, 0, 0] * np.cos(lean) == pytest.approx(upwards, rel=1e-6)
    # the shaft turns clockwise: what lifts holds it back
    torques = run.reactions(t)[:, model.joints.index("axle"), 2]
    assert -torques == pytest.approx(upwards * slopes, abs=1e-6)
    written = (
        {
            "cycloidal": "x - sin(2*pi*x)/(2*pi)",
            "3-4-5": "10*x**3 - 15*x**4 + 6*x**5",
            "4-5-6-7": "35*x**4 - 84*x**5 + 70*x**6 - 20*x**7",
            "harmonic": "0.5*(1 - cos(pi*x))",
        }[law]
        .replace("exp", "EXP")
        .replace("x", f"(t*{speed / rise!r})")
    )
    drive = f'[[drive]]\njoint = "guide"\nposition = "{base + radius!r} + {top}*({written})"\n'
    moved = workshop.model(bench("", "[start]\n", shaft + drive))
    alone = simulate(moved, until=0.99 * rise / speed, rtol=1e-11)
    needed = alone.reactions(t[:-1])[:, moved.joints.index("guide"), 1]
    assert needed == pytest.approx(upwards[:-1], rel=1e-6)


SPRING = (200.0, 20.0)
SWING, REST = math.sqrt(SPRING[0] / MASS), -(MASS * G + SPRING[1]) / SPRING[0]


def lift_off_scene(speed: float, restitution: float = 0.0) -> str:
    text = cam(FACE, 0.04, "0.01*(1 - cos(angle))", restitution=restitution)
    shaft = f'[[drive]]\njoint = "axle"\nspeed = {speed!r}\n'
    return bench(text, at_height(0.04, 0.5 * math.pi), shaft, spring=SPRING)


def test_a_follower_with_a_spring_lifts_off_at_its_closed_form(workshop: Workshop) -> None:
    """N = A + (m e ω² − k e) cos φ with A = m g + F₀ + k (b + e): at ω² = (A/e + k)/m it vanishes on top. Beyond, the
    follower leaves at that angle, swings on its spring, and comes down where sine and cosine meet the cam."""
    e, (stiffness, force) = 0.01, SPRING
    load = MASS * G + force + stiffness * (0.04 + e)
    critical = math.sqrt((load / e + stiffness) / MASS)
    model = workshop.model(lift_off_scene(1.0))
    for share, leaves in ((0.999, False), (1.001, True), (1.2, True)):
        speed = share * critical
        faster = model.with_parameters({"drive_0.speed": speed})
        run = simulate(faster, until=4.0 * math.pi / speed, rtol=1e-11)
        flights = [phase for phase in run.phases if phase.kind == "flight" and phase.start > 0.0]
        assert bool(flights) == leaves
        if not leaves:
            continue
        angle = math.acos(-load / (MASS * e * speed**2 - stiffness * e))
        start = angle / speed
        assert flights[0].start == pytest.approx(start, abs=1e-8 / speed)
        y0, v0 = 0.04 + e * (1 - math.cos(angle)), e * speed * math.sin(angle)

        def apart(t: float, y: float = y0, v: float = v0, begin: float = start, w: float = speed) -> float:
            s = SWING * (t - begin)
            fallen = REST + (y - REST) * math.cos(s) + v / SWING * math.sin(s)
            return fallen - 0.04 - e * (1 - math.cos(w * t))

        times = np.linspace(start + 0.02 / speed, start + 2.0 * math.pi / speed, 4000)
        signs = [apart(t) for t in times]
        first = next(k for k, s in enumerate(signs) if s < 0)
        down = brentq(apart, times[first - 1], times[first], xtol=1e-15)
        assert run.impacts[0].t == pytest.approx(down, abs=1e-9)


# -- an eccentric disc -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("driven", [False, True])
def test_an_eccentric_circle_is_the_disc_that_touches(driven: bool, workshop: Workshop) -> None:
    """A roller beside the shaft's line, with friction and impacts, on the polar form of a circle and on a disc: the
    same falls, impacts and slides. Energy is lost to friction and impacts alone."""
    e, radius, roller = 0.01, 0.04, 0.008
    reach = radius + roller
    polar = f"{e}*cos(angle) + sqrt({reach}**2 - ({e}*sin(angle))**2) - {reach}"
    friction = 0.0 if driven else 0.3
    as_cam = cam(POINT, radius, polar, friction, f"radius = {roller}\n", restitution=0.5)
    as_disc = f'[[touch]]\nbetween = ["lifter.P", "shaft.E"]\nradius = [{roller}, {radius}]\nrestitution = 0.5\n' + (
        f"friction = {friction}\n" if friction else ""
    )
    shaft = '[[drive]]\njoint = "axle"\nspeed = -20.0\n' if driven else ""
    start = at_height(0.075, 0.3, 0.0 if driven else -20.0)
    cams, discs = (
        simulate(workshop.model(bench(text, start, shaft, off=0.004)), until=0.8, rtol=1e-11, atol=1e-13)
        for text in (as_cam, as_disc)
    )
    assert cams.success and discs.success and min(len(cams.impacts), len(discs.impacts)) > 10
    for one, other in zip(cams.impacts[:10], discs.impacts[:10], strict=True):
        assert one.t == pytest.approx(other.t, abs=1e-9)
        assert one.impulses == pytest.approx(other.impulses, abs=1e-8)
    times = np.linspace(0.0, 0.8, 30)
    for t in times:
        assert np.concatenate(cams.at(t)) == pytest.approx(np.concatenate(discs.at(t)), abs=1e-7)
    assert cams.contact_forces(times)[:, 0] == pytest.approx(discs.contact_forces(times)[:, 0], abs=1e-5)
    assert any(phase.kind == "contact" for phase in cams.phases)
    if not driven:
        energies = np.array([sum(cams.model.energy(q, u)) for q, u in zip(cams.q, cams.u, strict=True)])
        assert np.max(np.diff(energies)) <= 1e-11


def test_a_free_shaft_keeps_the_energy(workshop: Workshop) -> None:
    """A flywheel lifts and lets down a roller over pieces of all laws without friction; the sum stays."""
    pieces = (
        '[{ to = "80 deg", lift = 0.01, law = "3-4-5" }, { to = "110 deg" }, '
        '{ to = "200 deg", lift = -0.002, law = "4-5-6-7" }, { to = "360 deg", lift = 0.0, law = "cycloidal" }]'
    )
    text = cam(POINT, 0.05, pieces, more="radius = 0.01\n")
    model = workshop.model(bench(text, at_height(0.06, 0.5 * math.pi, -20.0), "", spring=(300.0, 60.0)))
    run = simulate(model, until=3.0, rtol=1e-11)
    assert run.success and not run.impacts and abs(turned(run)[-1]) > 4.0 * math.pi
    energies = np.array([sum(model.energy(q, u)) for q, u in zip(run.q, run.u, strict=True)])
    assert energies == pytest.approx(energies[0], abs=1e-10)


@pytest.mark.parametrize("follower", [FACE, POINT])
def test_methods_keep_their_order_where_pieces_meet(follower: str, workshop: Workshop) -> None:
    """Gauss' method of order 8 with fixed steps over rises and rests whose third derivatives jump where they meet."""
    pieces = (
        '[{ to = "60 deg" }, { to = "150 deg", lift = 0.01, law = "3-4-5" }, { to = "200 deg" }, '
        '{ to = "310 deg", lift = 0, law = "3-4-5" }, { to = "360 deg" }]'
    )
    radius = 0.01 if follower == POINT else 0.0
    text = cam(follower, 0.06, pieces, more=f"radius = {radius}\n" if radius else "")
    model = workshop.model(bench(text, at_height(0.06 + radius, 0.9, -6.0), "", spring=(300.0, 60.0)))
    exact = simulate(model, until=0.6, rtol=1e-13, atol=1e-15)
    steps = (0.04, 0.02, 0.01)
    errors = [np.abs(simulate(model, until=0.6, method="gauss", step=h).u[-1] - exact.u[-1]).max() for h in steps]
    assert exact.success and not exact.impacts
    assert errors[1] <= 1e-8 and errors[2] <= 1e-11
    assert math.log2(errors[0] / errors[1]) > 6.0


def test_statics_put_the_follower_where_forces_balance(workshop: Workshop) -> None:
    """A torque T on the shaft of a flat follower's eccentric: F e sin φ = T, with F = m g + F₀ + k y."""
    e, torque = 0.01, 0.15
    text = cam(FACE, 0.04, f"{e}*(1 - cos(angle))")
    shaft = f'[[torque]]\nlink = "shaft"\ntorque = {torque}\n'
    model = workshop.model(bench(text, at_height(0.04, 0.5 * math.pi), shaft, spring=SPRING))
    found = static_equilibrium(model)
    seen = 0.5 * math.pi - found.q[model.q_names.index("theta_0")]
    height = 0.04 + e * (1 - math.cos(seen))
    force = MASS * G + SPRING[1] + SPRING[0] * height
    assert found.contact_forces[0] == pytest.approx([force, 0.0], abs=1e-8)
    assert force * e * math.sin(seen) == pytest.approx(-torque, abs=1e-9)
    assert found.q[model.q_names.index("slide_1")] == pytest.approx(height, abs=1e-10)


# -- a cam of the literature -------------------------------------------------------------------------------------------

RIG_MASS, RIG_STIFFNESS, RPM = 1.221, 1430.8, 358.0
RIG_REST = 0.3
ARCS = {"k1": 0.45, "rho1": 0.85, "k2": 0.40393320723821, "rho3": 0.15, "rho2": 0.55393320723821, "base": 0.4}
FLANK, NOSE = 1.050328174371336, 1.22173047639603


def rig_profile(beta: Any) -> tuple[float, float]:
    """The distance of the follower from the centre, and its derivative, of the cam of Alzate, di Bernardo, Montanaro
    and Santini as it stands in Siconos' example of a cam and follower: base circle, flank, nose and its rest."""
    turned_ = beta % (2 * math.pi)
    sign = 1.0 if turned_ <= math.pi else -1.0
    b = turned_ if sign > 0 else 2 * math.pi - turned_
    if b <= math.pi / 2:
        return ARCS["base"], 0.0
    if b <= math.pi / 2 + FLANK:
        k, rho = ARCS["k1"], ARCS["rho1"]
        root = math.sqrt(rho**2 - (k * math.cos(b)) ** 2)
        return root - k * math.sin(b), sign * (k * k * math.sin(b) * math.cos(b) / root - k * math.cos(b))
    if b <= math.pi / 2 + NOSE:
        k, rho, c = ARCS["k2"], ARCS["rho3"], b + math.pi / 9
        root = math.sqrt(rho**2 - (k * math.sin(c)) ** 2)
        return root - k * math.cos(c), sign * (k * math.sin(c) - k * k * math.sin(c) * math.cos(c) / root)
    return ARCS["rho2"], 0.0


def rig_scene() -> str:
    """The same as pieces of a cam."""
    flank = "sqrt(0.85**2 - (0.45*cos({0}))**2) - 0.45*sin({0}) - 0.4"
    nose = "sqrt(0.15**2 - (0.40393320723821*sin({0} + pi/9))**2) - 0.40393320723821*cos({0} + pi/9) - 0.4"
    ends = [math.pi / 2, math.pi / 2 + FLANK, math.pi / 2 + NOSE]
    ends += [2 * math.pi - end for end in reversed(ends)]
    back = "(2*pi - angle)"
    laws = [None, flank.format("angle"), nose.format("angle"), None, nose.format(back), flank.format(back)]
    pieces = [
        f"{{ to = {end!r}" + (f', lift = "{law}"' if law else "") + " }" for end, law in zip(ends, laws, strict=True)
    ]
    text = (
        "[ground_link]\npoints = { O = [0, 0], G = [0, 0] }\n"
        '[[link]]\nname = "shaft"\nmass = 1\ninertia = 0.1\ncom = [0, 0]\npoints = { O = [0, 0] }\n'
        f'[[link]]\nname = "lifter"\nmass = {RIG_MASS}\ninertia = 0.1\ncom = [0, 0]\n'
        "points = { P = [0, 0], T = [0, 2] }\n"
        '[[joint]]\nname = "axle"\nbetween = ["ground.O", "shaft.O"]\n'
        '[[joint]]\nname = "guide"\ntype = "prismatic"\naxis = [0, 1]\n'
        'between = ["ground.G", "lifter.P"]\n'
        f'[[spring]]\nbetween = ["ground.O", "lifter.T"]\nstiffness = {RIG_STIFFNESS}\nlength = {2.0 + RIG_REST}\n'
        f'[[drive]]\njoint = "axle"\nspeed = "{RPM} rpm"\n'
        f'[[cam]]\ncentre = "shaft.O"\nfollower = "lifter.P"\nbase = 0.4\nlift = [{", ".join(pieces)}, '
        '{ to = "360 deg" }]\nclockwise = true\nangle = "-90 deg"\nrestitution = 0.8\n'
    )
    return text + "[start]\nslides = { guide = 0.4 }\nangles = { shaft = 1.5707963267948966 }\n"


def test_a_cam_and_follower_of_the_literature(workshop: Workshop) -> None:
    """A cam of arcs whose curvature jumps, under a follower on a spring with restitution 0.8 at 358 rpm, from rest:
    impacts as an integration of the one equation of the follower finds them, the cam's arcs by their own formulas."""
    run = simulate(workshop.model(rig_scene()), until=0.6, rtol=1e-10, atol=1e-12)
    assert run.success
    speed = RPM * math.pi / 30.0

    def high(t: float) -> float:
        return rig_profile(speed * t + 0.5 * math.pi)[0]

    def gap(t: float, y: Any) -> float:
        return float(y[0]) - high(t)

    gap.terminal, gap.direction = True, -1.0  # type: ignore[attr-defined]

    def rates(t: float, y: Any) -> tuple[float, float]:
        return y[1], -RIG_STIFFNESS / RIG_MASS * (y[0] - RIG_REST)

    first = run.impacts[0]
    t = first.t
    assert len(run.impacts) >= 5
    y, v = high(t), float(first.u_plus[run.model.u_names.index("sliding_1")])
    for impact in run.impacts[1:5]:
        flight = solve_ivp(
            rates, (t, 1.0), (y, v), events=gap, rtol=1e-12, atol=1e-14, method="DOP853", first_step=1e-5
        )
        t, (y, fallen) = float(flight.t_events[0][0]), flight.y_events[0][0]
        risen = rig_profile(speed * t + 0.5 * math.pi)[1] * speed
        v = risen - 0.8 * (fallen - risen)
        assert impact.t == pytest.approx(t, abs=1e-8)
        assert impact.u_plus[run.model.u_names.index("sliding_1")] == pytest.approx(v, abs=1e-6)


def test_a_profile_is_drawn(workshop: Workshop, tmp_path: Path) -> None:
    """As a closed curve of its link, a roller's radius inside of its way; the page that plays a run has it, and a
    figure."""
    run = simulate(
        workshop.model(bench(cam(POINT, 0.05, "0.01*cos(2*angle)", more="radius = 0.01\n"), at_height(0.07))), until=0.1
    )
    profile = next(disc for disc in run.model.discs if disc.around is not None)
    assert profile.link == run.model.links.index("shaft")
    corners = profile.outline @ np.array([1.0, 1j])
    assert corners[0] == pytest.approx(corners[-1], abs=1e-15)
    angles = np.linspace(0.0, 2 * np.pi, 20001)
    way = (0.06 + 0.01 * np.cos(2 * angles)) * np.exp(1j * angles)
    away = np.array([np.abs(way - corner).min() for corner in corners])
    assert away == pytest.approx(0.01, abs=1e-6)
    run.animate(tmp_path / "cam.html")
    shown = data_of((tmp_path / "cam.html").read_text(encoding="utf-8"))
    assert len(shown["links"][profile.link]["edges"][0]) == len(corners)
    run.plot(tmp_path / "cam.png")
    assert (tmp_path / "cam.png").stat().st_size > 1000
