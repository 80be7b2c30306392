"""What else is asked of a model obeys its laws: equilibria, torques, ensembles, periodic motions."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from ccgen.runtime import (
    driving_torque,
    ensemble,
    find_orbit,
    follow,
    inverse_dynamics,
    linearise,
    simulate,
    static_equilibrium,
)

from ..support.c_library import Library
from ..support.folders import ROOT
from ..support.workshop import Workshop
from .test_laws import ARM, MASS, PD, PENDULUM

CLIPPED = PD.replace('torque = "lift"', 'torque = "clip(lift, -4, 4)"')
INERTIA, WEIGHT = 1.2 * 0.8**2 / 3, 1.2 * 9.81 * 0.4
"""Of the rod about its hinge (kg m²), and its moment when it is level (N m)."""


def lift(angle: float, rate: float) -> float:
    return -30.0 * (angle - 0.3) - 2.0 * rate


def clipped(angle: float, rate: float) -> float:
    return min(max(lift(angle, rate), -4.0), 4.0)


def test_an_equilibrium_is_that_of_the_law(workshop: Workshop) -> None:
    """Rates at rest: kp (φ - 0.3) = -m g l/2 cos φ."""
    found = static_equilibrium(workshop.model(PENDULUM + PD))
    angle = brentq(lambda x: lift(x, 0.0) - WEIGHT * math.cos(x), -1.0, 1.0, xtol=1e-15)
    assert found.q[0] == pytest.approx(angle, abs=1e-10)


def test_an_equilibrium_under_rates_is_not_called_stable(workshop: Workshop) -> None:
    """x'' = -x + c x' grows for c > 0 with a stiffness of 1: the poles tell, and stiffnesses alone do where no load of
    the state has a rate."""
    law = '[[law]]\nname = "pull"\nvalue = "c*rate(guide) - slide(guide)"\nparameters = { c = 0.3 }\n'
    motor = '[[motor]]\njoint = "guide"\nforce = "pull"\n'
    model = workshop.model(MASS + law + motor, derivatives=True)
    found = static_equilibrium(model)
    assert found.stability == "undetermined" and found.stiffness == pytest.approx([1.0], rel=1e-7)
    assert found.note.startswith("motor_0.force depends on rates, which are zero here: stiffnesses do not tell")
    assert np.linalg.eigvals(linearise(model, found.q).A).real == pytest.approx([0.15, 0.15], rel=1e-9)
    rated = static_equilibrium(workshop.model(MASS + law.replace("c*rate(guide)", "c*t") + motor))
    assert rated.stability == "stable" and rated.note == ""


def test_an_equilibrium_under_a_load_without_potential_is_not_called_stable(workshop: Workshop) -> None:
    """Torques that each follow the other joint's angle: K is not symmetric."""
    text = ARM + '[[torsion]]\njoint = "hip"\nstiffness = 40\n[[torsion]]\njoint = "knee"\nstiffness = 40\n'
    text += '[[motor]]\njoint = "knee"\ntorque = "9*angle(hip)"\n'
    found = static_equilibrium(workshop.model(text))
    assert found.stability == "undetermined" and "depends on the state and has no potential" in found.note
    without = text.replace("[start]", '[start]\noff = ["motor_0"]') + '[[event]]\nwhen = "t - 1"\non = ["motor_0"]\n'
    off = static_equilibrium(workshop.model(without))
    assert off.stability == "stable" and off.note == ""


def test_torques_are_what_the_law_leaves(workshop: Workshop) -> None:
    model = workshop.model(PENDULUM + CLIPPED)
    for q, u, a in ((0.2, 0.0, 3.0), (0.29, 0.4, -1.0), (-0.6, 1.0, 0.5)):
        expected = INERTIA * a + WEIGHT * math.cos(q) - clipped(q, u)
        assert inverse_dynamics(model, [q], [u], [a], ["hip"])[0] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("rate", [0.0, 2.5])
def test_a_turn_needs_what_the_law_leaves(rate: float, workshop: Workshop) -> None:
    """The state is that of the turn: its angle counted, and its rate, which is zero where the mechanism rests."""
    law = '[[law]]\nname = "slow"\nvalue = "-c*rate(hip) + 2*sin(3*angle(hip))"\nparameters = { c = 0.8 }\n'
    model = workshop.model(PENDULUM + law + '[[motor]]\njoint = "hip"\ntorque = "slow"\n')
    turn = driving_torque(model, "hip", rate)
    expected = WEIGHT * np.cos(turn.angle) + 0.8 * rate - 2 * np.sin(3 * turn.angle)
    assert turn.torque == pytest.approx(expected, abs=1e-11)
    assert turn.mean == pytest.approx(0.8 * rate, abs=1e-11)


def test_a_motion_that_is_followed_needs_what_the_law_leaves(workshop: Workshop) -> None:
    model = workshop.model(PENDULUM + PD)
    t = np.linspace(0, 1, 7)
    path = np.array([0.3 * np.sin(t), 0.3 * np.cos(t), -0.3 * np.sin(t)])
    found = follow(model, [0.0], angles={"rod": path})
    torque = inverse_dynamics(model, found.q, found.u, found.u_dot, ["hip"])[:, 0]
    expected = INERTIA * path[2] + WEIGHT * np.cos(path[0]) - np.array([lift(*one) for one in path[:2].T])
    assert torque == pytest.approx(expected, rel=1e-9)


def test_ensembles_are_runs_with_other_gains(workshop: Workshop) -> None:
    """To the bit, kinks on the way."""
    model = workshop.model(PENDULUM + CLIPPED)
    gains = np.array([10.0, 30.0, 55.0])
    table = ensemble(model, {"lift.kp": gains}, observe=["rod.angle", "lift"], at=[0.5, 1.5], until=1.5)
    for row, gain in enumerate(gains):
        run = simulate(model, params={"lift.kp": gain}, until=1.5)
        values = run.values("rod.angle", "lift", t=[0.5, 1.5])
        assert np.array_equal(table["rod.angle"][row], values["rod.angle"])
        assert np.array_equal(table["lift"][row], values["lift"])


def test_van_der_pols_limit_cycle(workshop: Workshop) -> None:
    """x'' = (1 - x²) x' - x: its period and its amplitude to the digits that are known; the multiplier is exp of the
    integral of the trace, 1 - x², over a period."""
    model = workshop.model(
        MASS + '[[law]]\nname = "pump"\nvalue = "mu*(1 - slide(guide)**2)*rate(guide) - slide(guide)"\n'
        'parameters = { mu = 1 }\n[[motor]]\njoint = "guide"\nforce = "pump"\n[start]\nslides = { guide = 2.0 }\n',
        derivatives=True,
    )
    orbit = find_orbit(model, section=("guide.slide", 0.0), until=30.0)
    assert orbit.period == pytest.approx(6.6632868593231301, abs=1e-9)
    assert orbit.run["guide.slide"].max() <= 2.0086198609 + 1e-6
    assert orbit.stable
    around = simulate(model, orbit.q, orbit.u, until=orbit.period, rtol=1e-12)
    t = np.linspace(0, orbit.period, 20001)
    x = around.values("guide.slide", t=t)["guide.slide"]
    assert x.max() == pytest.approx(2.00861986087, abs=1e-7)
    grown = np.exp(np.trapezoid(1 - x**2, t))
    assert orbit.multipliers[0].real == pytest.approx(grown, rel=1e-6)


def test_a_cycle_through_kinks_has_multipliers(workshop: Workshop) -> None:
    """x'' = clip(x', -0.5, 0.5) - 0.4 x' - x: energy comes in while slow, and goes out while fast; the multiplier is
    exp of the integral of the trace, 1 while |x'| < 0.5 and -0.4 always."""
    model = workshop.model(
        MASS + '[[motor]]\njoint = "guide"\nforce = "clip(rate(guide), -0.5, 0.5) - 0.4*rate(guide) - slide(guide)"\n'
        "[start]\nslides = { guide = 1.5 }\n",
        derivatives=True,
    )
    orbit = find_orbit(model, section=("guide.slide", 0.0), until=40.0)
    run = simulate(model, orbit.q, orbit.u, until=orbit.period, rtol=1e-12)
    t = np.linspace(0, orbit.period, 400001)
    slow = np.abs(run.values("guide.slide_rate", t=t)["guide.slide_rate"]) < 0.5
    grown = np.exp(np.mean(slow) * orbit.period - 0.4 * orbit.period)
    assert orbit.multipliers[0].real == pytest.approx(grown, rel=1e-4)
    assert orbit.missed < 1e-9


def test_programs_in_c_have_the_law(workshop: Workshop, tmp_path: Path) -> None:
    """The core without Python comes to the same end, by the same bits, through the limit."""
    library = Library(ROOT / "runtime", tmp_path / "libccgen.so")
    model = workshop.model(PENDULUM + CLIPPED)
    outcome, made = library.create(model, rtol=1e-11)
    assert outcome == "done" and made.reset(*model.start()) == "done"
    outcome, event = made.step_to_event(model.duration)
    assert (outcome, event.t) == ("done", model.duration)
    run = simulate(model)
    t, q, u = made.motion()
    assert t == run.t[-1] and np.array_equal(q, run.q[-1]) and np.array_equal(u, run.u[-1])
