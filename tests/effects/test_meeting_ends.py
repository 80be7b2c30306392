"""Springs whose ends meet: their force jumps there, and runs go through as exactly as elsewhere."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ccgen.runtime import sensitivities, simulate

from ..support.workshop import Workshop

STIFFNESS, LENGTH, START = 40.0, 0.5, 1.5
BODY = """
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "ram"
mass = 1.0
inertia = 0.01
com = [0, 0]
points = { C = [0, 0] }
"""
SPRING = '[[spring]]\nbetween = ["ground.O", "ram.C"]\nstiffness = 40\nlength = 0.5\n'
SLIDING = """
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "ram.C"]
axis = [3, 4]
angle = 0
[start]
slides = { guide = 1.5 }
"""
FREE = BODY.replace('name = "ram"', 'name = "ram"\nfree = true') + "[start]\nposes = { ram = [0.9, 1.2, 0] }\n"


def along(t: float) -> float:
    """The place (m) on the line of a mass of 1 kg that is let go at START: F = -k (x - L0 sign x)."""
    omega, reach = math.sqrt(STIFFNESS), START - LENGTH
    through = math.acos(-LENGTH / reach) / omega
    turns, t = divmod(t, 2.0 * through)
    side = -1.0 if turns % 2 else 1.0
    x = LENGTH + reach * math.cos(omega * t) if t < through else -LENGTH - reach * math.cos(omega * (2.0 * through - t))
    return side * x


def energy(x: float, speed: float) -> float:
    return speed**2 / 2.0 + STIFFNESS * (abs(x) - LENGTH) ** 2 / 2.0


@pytest.mark.parametrize(("method", "most"), [("gauss", 1.0), ("dop853", 40.0), ("radau", 10.0)])
def test_a_slide_goes_through_its_anchor(method: str, most: float, workshop: Workshop) -> None:
    model = workshop.model(BODY + SPRING + SLIDING)
    for rtol in (1e-6, 1e-9):
        run = simulate(model, until=8.0, rtol=rtol, method=method)
        assert run.q[-1, 0] == pytest.approx(along(8.0), abs=most * rtol)
        drift = max(abs(energy(x, u) / energy(START, 0.0) - 1.0) for x, u in zip(run.q[:, 0], run.u[:, 0], strict=True))
        assert drift <= most * rtol


def test_steps_of_fixed_length_end_there(workshop: Workshop) -> None:
    """By `gauss` all steps but those across are exact to rounding."""
    run = simulate(workshop.model(BODY + SPRING + SLIDING), until=8.0, step=0.02)
    assert run.q[-1, 0] == pytest.approx(along(8.0), abs=1e-9)


@pytest.mark.parametrize("missed", [0.0, 1e-9, 1e-6, 1e-3])
def test_a_free_mass_meets_its_anchor_or_just_misses_it(missed: float, workshop: Workshop) -> None:
    """Nothing but its motion keeps it there. With a speed of `missed` across it is at the same places but for some
    hundred times as much, and energy and moment of momentum are conserved."""
    model = workshop.model(FREE + SPRING)
    q, u = model.start()
    u[:2] = -0.8 * missed, 0.6 * missed
    run = simulate(model, q, u, until=8.0, rtol=1e-9)
    places = np.array([along(t) for t in run.t])[:, None] * (0.6, 0.8)
    assert np.abs(run.q[:, :2] - places).max() <= 1e-8 + 200.0 * missed
    assert run.energy_drift <= 1e-6
    turning = run.q[:, 0] * run.u[:, 1] - run.q[:, 1] * run.u[:, 0]
    assert np.abs(turning - START * missed).max() <= 1e-13


def test_where_the_ends_turn_round_steps_are_as_long_as_ever(workshop: Workshop) -> None:
    """Let go nearer than twice its length at rest it comes back before its anchor."""
    model = workshop.model(BODY + SPRING + SLIDING)
    run = simulate(model, [0.9], [0.0], until=8.0, rtol=1e-9)
    omega = math.sqrt(STIFFNESS)
    assert run.q[:, 0] == pytest.approx(LENGTH + 0.4 * np.cos(omega * run.t), abs=1e-8)
    assert len(run.t) < 60


SWINGING = """
[ground_link]
points = { O = [0.3, 0.7], P = [0.9, -0.1] }
[[link]]
name = "crank"
mass = 1.0
inertia = 0.25
com = [0.5, 0]
points = { A = [0, 0], B = [1, 0] }
[[joint]]
name = "pin"
between = ["ground.O", "crank.A"]
[start]
angles = { crank = -0.4 }
"""
STRUT = """
[[spring]]
between = ["ground.P", "crank.B"]
stiffness = 40
[[damper]]
between = ["ground.P", "crank.B"]
damping = 4
"""


@pytest.mark.parametrize("damping", [4.0, 40.0])
def test_a_strut_comes_to_rest_where_its_ends_meet(damping: float, workshop: Workshop) -> None:
    """They stay within rounding of each other, as differences of other places. The angle x from there has the couples
    -k sin x and -c cos(x / 2)^2 dx/dt."""
    model = workshop.model(SWINGING + STRUT)
    run = simulate(model, until=40.0, rtol=1e-9, params={"damper_0.damping": damping})
    assert run.success and len(run.t) < 1000
    met = math.atan2(-0.8, 0.6)

    def motion(_: float, state: np.ndarray) -> list[float]:
        x, u = state
        return [u, (-STIFFNESS * math.sin(x) - damping * math.cos(x / 2.0) ** 2 * u) / 0.5]

    wanted = solve_ivp(motion, (0.0, 3.0), [-0.4 - met, 0.0], rtol=1e-12, atol=1e-13, t_eval=np.linspace(0.5, 3.0, 6))
    found = np.array([run.at(t)[0][0] for t in wanted.t]) - met
    assert np.abs(found - wanted.y[0]).max() <= 1e-8
    assert abs(run.q[-1, 0] - met) <= 1e-9


def test_derivatives_are_refused_from_where_the_ends_meet(workshop: Workshop) -> None:
    """Before, they are differences of the closed form by the stiffness; the place at t has t sqrt(k) in it alone."""
    model = workshop.model(BODY + SPRING + SLIDING, derivatives=True)
    wrt, outputs = ["spring_0.stiffness"], ["guide.slide"]
    found = sensitivities(model, wrt, outputs, until=0.2).jacobian
    steps = [along(0.2 * math.sqrt(1.0 + part * 1e-5)) for part in (1.0, -1.0)]
    assert np.ravel(found)[-1] == pytest.approx((steps[0] - steps[1]) / (2e-5 * STIFFNESS), rel=1e-7)
    with pytest.raises(ValueError, match=r"the ends of spring_0 to meet at t = 0\.331\d* s"):
        sensitivities(model, wrt, outputs, until=1.0)


@pytest.mark.parametrize("start", [1e-1, 1e-4, 1e-6])
def test_derivatives_are_refused_however_short_the_spring_stays(start: float, workshop: Workshop) -> None:
    """Of a link a thousand times and more as long: what is near is measured by that."""
    spring = '[[spring]]\nbetween = ["ground.P", "crank.B"]\nstiffness = 40\nlength = 0.1\n'
    model = workshop.model(SWINGING + spring, derivatives=True)
    met = math.atan2(-0.8, 0.6)
    with pytest.raises(ValueError, match="the ends of spring_0 to meet"):
        sensitivities(model, ["spring_0.stiffness"], ["q"], [met + start], [-2.0], until=start)


def test_derivatives_by_a_damper_whose_direction_is_rounding_are_refused(workshop: Workshop) -> None:
    """They were wrong by a thousandth and more. Before they are those of the equation of motion, and on a guide, whose
    direction is known where its anchor is its origin, those of the closed form through any number of meetings."""
    wrt = ["spring_0.stiffness", "damper_0.damping"]
    swinging = workshop.model(SWINGING + STRUT, derivatives=True)
    with pytest.raises(ValueError, match=r"the ends of damper_0 to meet at t = 0\.2563\d* s.*direction is rounding"):
        sensitivities(swinging, wrt, ["q"], until=0.3)
    sliding = workshop.model(
        BODY + STRUT.replace("ground.P", "ground.O").replace("crank.B", "ram.C") + SLIDING, derivatives=True
    )

    def place(k: float, c: float, t: float = 3.0) -> float:
        omega = math.sqrt(k - c * c / 4.0)
        return START * math.exp(-c * t / 2.0) * (math.cos(omega * t) + c / (2.0 * omega) * math.sin(omega * t))

    found = np.ravel(sensitivities(sliding, wrt, ["guide.slide"], until=3.0, rtol=1e-10).jacobian)
    part = 1e-4
    by_k = (place(STIFFNESS + part, 4.0) - place(STIFFNESS - part, 4.0)) / (2.0 * part)
    by_c = (place(STIFFNESS, 4.0 + part) - place(STIFFNESS, 4.0 - part)) / (2.0 * part)
    assert found == pytest.approx([by_k, by_c], rel=1e-6)
