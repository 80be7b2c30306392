"""Springs whose ends meet: their force jumps there, and runs go through as exactly as elsewhere."""

from __future__ import annotations

import math

import numpy as np
import pytest

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


def test_derivatives_are_refused_from_where_the_ends_meet(workshop: Workshop) -> None:
    """Before, they are differences of the closed form by the stiffness; the place at t has t sqrt(k) in it alone."""
    model = workshop.model(BODY + SPRING + SLIDING, derivatives=True)
    wrt, outputs = ["spring_0.stiffness"], ["guide.slide"]
    found = sensitivities(model, wrt, outputs, until=0.2).jacobian
    steps = [along(0.2 * math.sqrt(1.0 + part * 1e-5)) for part in (1.0, -1.0)]
    assert np.ravel(found)[-1] == pytest.approx((steps[0] - steps[1]) / (2e-5 * STIFFNESS), rel=1e-7)
    with pytest.raises(ValueError, match=r"the ends of spring_0 to meet at t = 0\.331\d* s"):
        sensitivities(model, wrt, outputs, until=1.0)
