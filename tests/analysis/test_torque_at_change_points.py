"""The torque of a crank that turns a linkage through its change points, against closed forms and driven runs."""

from __future__ import annotations

import numpy as np
import pytest

from ccgen.runtime import driving_torque, simulate

from ..support.tiers import hard
from ..support.two_cranks import TWO_CRANKS
from ..support.workshop import Workshop

WEIGHT = 0.2 * 9.81 * (0.5 + 2.0 + 0.5)
"""N m: what both cranks and the coupler take where they are level."""


@pytest.mark.parametrize("start", [1.2217304763960306, *map(hard, (1.0, -2.3, 0.02, 3.1))])
@pytest.mark.parametrize("rate", [3.0, 1000.0, *map(hard, (0.0, 10.0, 100.0, -100.0))])
def test_a_parallelogram_takes_what_its_weights_take(rate: float, start: float, workshop: Workshop) -> None:
    """Its coupler does not turn, and no speed changes: the torque is WEIGHT cos(angle), whatever the rate. Rounding is
    of what each link takes, which goes as the rate squared."""
    text = f"{TWO_CRANKS}angles = {{ crank = {start!r}, coupler = 0, rocker = {start!r} }}\n"
    found = driving_torque(workshop.model(text), "axle", rate=rate)
    near = 1e-11 * (1.0 + rate**2)
    assert np.max(np.abs(found.torque - WEIGHT * np.cos(found.angle))) <= near
    assert found.largest[0] == pytest.approx(WEIGHT, abs=near)
    assert found.smallest[0] == pytest.approx(-WEIGHT, abs=near)


@pytest.mark.parametrize("shorter", [1e-3, *map(hard, (1e-2, 1e-4, 1e-5))])
def test_what_misses_a_change_point_is_no_limit(shorter: float, workshop: Workshop) -> None:
    """A crank that is shorter passes the line of the links by, and all turns quickly there: as a driven run has it."""
    text = TWO_CRANKS.replace("B = [0.2, 0]", f"B = [{0.2 - shorter!r}, 0]", 1)
    start = "angles = { crank = 1.2, coupler = 0, rocker = 1.2 }\n"
    driven = workshop.model(f'{text}{start}[[drive]]\njoint = "axle"\nspeed = 7.0\n')
    found = driving_torque(workshop.model(text + start), "axle", rate=7.0, q=driven.start()[0])
    run = simulate(driven, until=1.0, rtol=1e-12)
    assert run.success, run.message
    t = (found.angle - found.angle[0]) / 7.0
    wanted = run.reactions(t)[:, driven.joints.index("axle"), 2]
    assert np.max(np.abs(found.torque - wanted)) <= 1e-10 * np.max(np.abs(wanted))


SMALL = """
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "crank"
mass = 0.01
inertia = 0
com = [0, 0]
points = { A = [0, 0], B = [0.0025, 0] }
[[link]]
name = "rod"
mass = 0
inertia = 0
com = [0, 0]
points = { A = [0, 0], B = [0.0075, 0] }
[[link]]
name = "slider"
mass = 0.03
inertia = 1e-6
com = [0, 0]
points = { S = [0, 0] }
[[joint]]
name = "axle"
between = ["ground.O", "crank.A"]
[[joint]]
between = ["crank.B", "rod.A"]
[[joint]]
between = ["rod.B", "slider.S"]
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "slider.S"]
axis = [1, 0]
[[joint_friction]]
joints = ["guide"]
dry = 2.0
rate = 1e-4
[start]
angles = { crank = 1.0, rod = -0.3 }
"""


@pytest.mark.parametrize("scale", [1.0, *map(hard, (0.1, 1e3))])
def test_what_turns_round_at_a_dead_centre_keeps_its_corner(scale: float, workshop: Workshop) -> None:
    """Dry friction of a slider changes its sign where the crank is in line with the rod: rows are far from dependent
    there, whatever the size of the mechanism, and nothing is smoothed."""
    a, b, rate = 0.0025 * scale, 0.0075 * scale, 5.0
    model = workshop.model(SMALL).with_parameters({"crank.points.B.x": a, "rod.points.B.x": b})
    found = driving_torque(model, "axle", rate=rate)
    swing = -np.arcsin(a * np.sin(found.angle) / b)
    turn = -a * np.cos(found.angle) / (b * np.cos(swing))
    bend = (a * np.sin(found.angle) + b * np.sin(swing) * turn**2) / (b * np.cos(swing))
    slides = -a * np.sin(found.angle) - b * np.sin(swing) * turn
    turns = -a * np.cos(found.angle) - b * np.cos(swing) * turn**2 - b * np.sin(swing) * bend
    wanted = slides * (0.03 * turns * rate**2 + 2.0 * np.tanh(slides * rate / 1e-4))
    assert np.max(np.abs(found.torque - wanted)) <= 1e-10 * np.max(np.abs(wanted))
