"""Derivatives of runs with closed forms, and with digits that others have published."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.runtime import sensitivities

from ..support.workshop import Workshop

G = 9.81
TIGHT = 1e-12


def guided(bodies: dict[str, float | None], axis: str = "[1, 0]", mass: float = 1.0) -> str:
    """Bodies that slide along one line, and how far they are along it at first, None of what is driven."""
    links = "".join(
        f'[[link]]\nname = "{name}"\nmass = {mass}\ninertia = 1\ncom = [0, 0]\npoints = {{ C = [0, 0] }}\n'
        f'[[joint]]\nname = "at_{name}"\ntype = "prismatic"\nbetween = ["ground.O", "{name}.C"]\naxis = {axis}\n'
        for name in bodies
    )
    slides = ", ".join(f"at_{name} = {place!r}" for name, place in bodies.items() if place is not None)
    return f"[ground_link]\npoints = {{ O = [0, 0] }}\n{links}[start]\nslides = {{ {slides} }}\n"


BALLS = (
    'name = "two-balls"\n' + guided({"one": 0.0, "other": 1.0}) + '[[touch]]\nbetween = ["one.C", "other.C"]\n'
    "radius = [0.1, 0.1]\nrestitution = 1\n"
)


def test_two_equal_balls_exchange_their_ways(workshop: Workshop) -> None:
    """Where the other is at t = 1: by the places and the speed of the one and the other (1, 0, 1, 0).

    Their centres meet 0.2 m apart, so that the other goes on from where the one would be, 0.2 m ahead.
    """
    model = workshop.model(BALLS, derivatives=True)
    q, _ = model.start()
    found = sensitivities(model, ("q0", "u0"), ["at_one.slide", "at_other.slide"], q, [3.0, 0.5], until=1.0, rtol=1e-13)
    assert len(found.run.impacts) == 1
    assert found["at_other.slide"] == pytest.approx([1, 0, 1, 0], abs=TIGHT)
    assert found["at_one.slide"] == pytest.approx([0, 1, 0, 1], abs=TIGHT)


BOUNCE = """
name = "bounce"
[[link]]
name = "ball"
mass = 2.0
inertia = 1.0
com = [0.0, 0.0]
points = { C = [0.0, 0.0] }
[start]
position = [0.0, 1.0]
[gravity]
g = 9.81
[[ground]]
restitution = 0.7
contacts = ["ball.C"]
"""


def test_an_elastic_bounce_without_gravity_turns_the_way_round(workshop: Workshop) -> None:
    """The height at T is -(y + v T)."""
    text = BOUNCE.replace("[gravity]\ng = 9.81\n", "").replace("0.7", "1")
    model = workshop.model(text, derivatives=True)
    found = sensitivities(model, ("q0", "u0"), "ball.y", u0=[0, -4.0, 0], until=0.7)
    assert found["ball.y"] == pytest.approx([0, -1, 0, 0, -0.7, 0], abs=TIGHT)


def test_a_ball_that_bounces_once(workshop: Workshop) -> None:
    """h - g t^2 / 2 = 0 at t1; behind it y = e g t1 s - g s^2 / 2, s = t - t1."""
    model = workshop.model(BOUNCE, derivatives=True)
    until, e = 0.8, 0.7
    found = sensitivities(
        model,
        ("q0", "gravity.g", "ground_0.restitution"),
        ["ball.y", "ball.vy", "impact_times"],
        until=until,
        rtol=1e-13,
    )
    t1 = np.sqrt(2.0 / G)
    s = until - t1
    by_h, by_g = 1.0 / np.sqrt(2.0 * G), -t1 / (2.0 * G)  # of t1
    y_by_t1 = e * G * s - e * G * t1 + G * s
    wanted = [y_by_t1 * by_h, e * t1 * s - s**2 / 2 + y_by_t1 * by_g, G * t1 * s]
    assert found["ball.y"][[1, 3, 4]] == pytest.approx(wanted, rel=TIGHT)
    wanted = [(e * G + G) * by_h, e * t1 - s + (e * G + G) * by_g, G * t1]
    assert found["ball.vy"][[1, 3, 4]] == pytest.approx(wanted, rel=TIGHT)
    assert found["impact_times"][0, [1, 3, 4]] == pytest.approx([by_h, by_g, 0.0], rel=TIGHT, abs=TIGHT)


# -- a slope -----------------------------------------------------------------------------------------------------------

SLOPE, MU = 0.3, 0.2


def on_slope(speed: float, height: float = 0.0) -> str:
    """A point on a slope that rises to the right, with an angle of 0.3 rad, thrown along it."""
    normal, along = [-float(np.sin(SLOPE)), float(np.cos(SLOPE))], np.array([np.cos(SLOPE), np.sin(SLOPE)])
    place = height * np.array(normal)
    return (
        'name = "slope"\n[[link]]\nname = "point"\nmass = 1.5\ninertia = 1\ncom = [0, 0]\npoints = { C = [0, 0] }\n'
        f"[start]\nposition = {place.tolist()}\nvelocity = {(speed * along).tolist()}\n[gravity]\ng = {G}\n"
        f"[[ground]]\nnormal = {normal}\nrestitution = 0.5\nfriction = {MU}\n"
        'contacts = ["point.C"]\n'
    )


def along_slope(found: Any, part: str) -> Any:
    """Of the first two coordinates, or rates, the part along the slope."""
    return np.cos(SLOPE) * found[part][0] + np.sin(SLOPE) * found[part][1]


def test_sliding_down_a_slope(workshop: Workshop) -> None:
    """s = v t - g (sin b - mu cos b) t^2 / 2, downwards."""
    model = workshop.model(on_slope(-1.0), derivatives=True)
    t = 0.6
    direction = np.array([[np.cos(SLOPE)], [np.sin(SLOPE)], [0.0]])
    by = {
        "u0": np.hstack([direction, 0 * direction, 0 * direction]),
        "gravity.g": [0, 1, 0],
        "ground_0.friction": [0, 0, 1],
    }
    found = sensitivities(model, by, until=t)
    pull = np.sin(SLOPE) - MU * np.cos(SLOPE)
    assert along_slope(found, "q") == pytest.approx([t, -pull * t**2 / 2, G * np.cos(SLOPE) * t**2 / 2], rel=TIGHT)
    assert along_slope(found, "u") == pytest.approx([1, -pull * t, G * np.cos(SLOPE) * t], rel=TIGHT)


def test_sliding_up_a_slope_until_it_sticks(workshop: Workshop) -> None:
    """It comes to rest at v^2 / (2 a), a = g (sin b + mu cos b), and stays: mu > tan b."""
    v, mu = 1.0, 0.4
    model = workshop.model(on_slope(v).replace(f"friction = {MU}", f"friction = {mu}"), derivatives=True)
    direction = np.array([[np.cos(SLOPE)], [np.sin(SLOPE)], [0.0]])
    by = {
        "u0": np.hstack([direction, 0 * direction, 0 * direction]),
        "gravity.g": [0, 1, 0],
        "ground_0.friction": [0, 0, 1],
    }
    found = sensitivities(model, by, until=1.0, rtol=1e-13)
    assert [phase.how for phase in found.run.phases] == [("slides forward",), ("sticks",)]
    a = G * (np.sin(SLOPE) + mu * np.cos(SLOPE))
    wanted = [v / a, -(v**2) / (2 * a * G), -(v**2) / (2 * a**2) * G * np.cos(SLOPE)]
    assert along_slope(found, "q") == pytest.approx(wanted, rel=1e-11)
    assert np.max(np.abs(found["u"])) < 1e-11
    assert found.passed[0].kind == "sliding ends"
    assert found.passed[0].dt[0] == pytest.approx(1.0 / a, rel=1e-11)


def test_a_bounce_with_friction_on_a_slope(workshop: Workshop) -> None:
    """Sliding through it: the speed along the slope falls by mu (1 + e) times that of approach."""
    height, v = 0.4, 3.0
    model = workshop.model(on_slope(v, height), derivatives=True)
    found = sensitivities(model, ("ground_0.friction", "ground_0.restitution"), "u", until=0.4, rtol=1e-13)
    assert len(found.run.impacts) == 1
    approach = np.sqrt(2.0 * height * G * np.cos(SLOPE))
    assert along_slope(found, "u") == pytest.approx([-1.5 * approach, -MU * approach], rel=TIGHT)


# -- a table that moves ------------------------------------------------------------------------------------------------


def table(law: str, height: float, speed: float, e: float) -> str:
    """A ball above a table that a drive moves up and down."""
    return (
        'name = "shaking"\n'
        + guided({"table": None, "ball": height}, "[0, 1]")
        + f"sliding_velocities = {{ at_ball = {speed!r} }}\n[gravity]\ng = {G}\n"
        f'[[drive]]\njoint = "at_table"\nposition = "{law}"\n'
        f'[[touch]]\nbetween = ["table.C", "ball.C"]\nradius = [0.1, 0.1]\nrestitution = {e!r}\n'
    )


def test_a_ball_on_a_paddle(workshop: Workshop) -> None:
    """The paddle is at 0.25 sin 4 pi t: by the recursion of impacts, each differentiated by the rule of implicit
    functions."""
    e, until = 0.6, 4.5
    model = workshop.model(table("0.25*sin(4*pi*t)", 1.2, 0.3, e), derivatives=True)
    found = sensitivities(
        model, ("q0", "u0", "gravity.g", "touch_0.restitution"), ["q", "u", "impact_times"], until=until, rtol=1e-13
    )
    times = [impact.t for impact in found.run.impacts]
    assert len(times) >= 3
    w = 4.0 * np.pi
    y, v, t = 1.2 - 0.2, 0.3, 0.0
    dy, dv, dt = np.array([1.0, 0, 0, 0]), np.array([0, 1.0, 0, 0]), np.zeros(4)
    by_g, by_e = np.array([0, 0, 1.0, 0]), np.array([0, 0, 0, 1.0])
    for k, t1 in enumerate([*times, until]):
        s = t1 - t
        ball, speed = y + v * s - G * s**2 / 2, v - G * s
        moved = dy + dv * s - by_g * s**2 / 2 - speed * dt  # at a fixed time
        turned = dv - by_g * s + G * dt
        if k == len(times):
            break
        place, rate, bend = 0.25 * np.sin(w * t1), 0.25 * w * np.cos(w * t1), -0.25 * w**2 * np.sin(w * t1)
        assert ball == pytest.approx(place, abs=1e-12)
        later = -moved / (speed - rate)
        assert found["impact_times"][k, [1, 3, 4, 5]] == pytest.approx(later, rel=1e-11, abs=1e-12)
        y, v, t, dt = place, rate - e * (speed - rate), t1, later
        dy = rate * later
        dv = (1 + e) * bend * later - e * (turned - G * later) - by_e * (speed - rate)
    assert found["q"][1, [1, 3, 4, 5]] == pytest.approx(moved, rel=1e-10)
    assert found["u"][1, [1, 3, 4, 5]] == pytest.approx(turned, rel=1e-10)


@pytest.mark.parametrize(("e", "phase"), [(0.5, 0.2), (0.8, 0.05)])
def test_a_ball_that_a_shaken_table_keeps_up(e: float, phase: float, workshop: Workshop) -> None:
    """The map of one period of the table A sin(w t) has det e^2 and trace 1 + e^2 - (1 + e)^2 A w^2 sin(phase) / g."""
    period = 0.4
    w = 2.0 * np.pi / period
    A = float(G * period * (1 - e) / (2 * (1 + e)) / (w * np.cos(phase)))
    struck = float(A * np.sin(phase))
    height = 0.2 + struck + G * period**2 / 8
    shift = phase - w * period / 2
    model = workshop.model(table(f"{A!r}*sin({w!r}*t + {shift!r})", height, 0.0, e), derivatives=True)
    found = sensitivities(model, ("q0", "u0"), until=period, rtol=1e-13)
    assert found.run.q[-1, 1] == pytest.approx(height, rel=1e-12) and abs(found.run.u[-1, 1]) < 1e-11
    turn = np.vstack([found["q"][1], found["u"][1]])[:, [1, 3]]
    assert np.linalg.det(turn) == pytest.approx(e**2, rel=1e-11)
    wanted = 1 + e**2 - (1 + e) ** 2 * A * w**2 * np.sin(phase) / G
    assert np.trace(turn) == pytest.approx(wanted, rel=1e-11)


# -- walking -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("inertia", [0.01, 0.25])
def test_the_rimless_wheel(inertia: float, workshop: Workshop) -> None:
    """Eight spokes of 1 m go down a slope of 0.08 rad, g = 1: from a strike to the next the rate is multiplied by mu,
    and gains what the way down gives; the square of it decides. With an inertia of 1/4 the digits are published
    ones."""
    a, slope = np.pi / 8, 0.08
    mu = (np.cos(2 * a) + inertia) / (1 + inertia)
    rate = float(np.sqrt(2 * (np.cos(slope - a) - np.cos(slope + a)) / (1 + inertia) / (1 - mu**2))) * float(mu)
    period, multiplier = 2.5491225591891925, mu**2
    if inertia == 0.25:
        assert rate == pytest.approx(0.37239359446168101, rel=1e-14)
        assert multiplier == pytest.approx(0.58627416997969521, rel=1e-14)
    feet = [[np.sin(a + 2 * a * k), -np.cos(a + 2 * a * k)] for k in range(8)]
    points = ", ".join(f"F{k} = [{x!r}, {y!r}]" for k, (x, y) in enumerate(np.array(feet).tolist()))
    text = (
        f'name = "wheel"\n[[link]]\nname = "wheel"\nmass = 1\ninertia = {inertia}\ncom = [0, 0]\npoints = '
        f"{{ {points} }}\n"
        f"[start]\nposition = [0, {float(np.cos(a))!r}]\nvelocity = [{float(rate * np.cos(a))!r}, "
        f"{float(rate * np.sin(a))!r}]\nangular_velocities = [{-rate!r}]\n[gravity]\ng = 1\ndirection = "
        f"[{float(np.sin(0.08))!r}, {-float(np.cos(0.08))!r}]\n[[ground]]\nrestitution = 0\nfriction = 1\ncontacts "
        f"= [" + ", ".join(f'"wheel.F{k}"' for k in range(8)) + "]\n"
    )
    model = workshop.model(text, derivatives=True)
    turn = np.array([[np.cos(a)], [np.sin(a)], [-1.0]])
    found = sensitivities(model, {"u0": turn}, "impact_times", until=3.6, rtol=1e-13)
    (impact,) = found.run.impacts
    if inertia == 0.25:
        assert impact.t == pytest.approx(period, rel=1e-12)
    assert impact.u_plus[2] == pytest.approx(-rate, rel=1e-12)
    assert found.passed[0].behind[5, 0] / turn[2, 0] == pytest.approx(multiplier, rel=1e-11)
