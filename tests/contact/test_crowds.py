"""Slow contacts rest where events crowd, and only there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ccgen.runtime import simulate

from ..support.bodies import block
from ..support.c_library import Library
from ..support.folders import RUNTIME
from ..support.workshop import Workshop


def pendulums(count: int) -> str:
    """Rods on pivots of their own, without gravity, each between elastic stops."""
    text = 'name = "pendulums"\n[ground_link]\npoints = { O = [0, 0] }\n'
    for i in range(count):
        text += (
            f'[[link]]\nname = "rod{i}"\nmass = 1.0\ninertia = {1 / 12}\ncom = [0.5, 0]\n'
            f'points = {{ A = [0, 0] }}\n[[joint]]\nname = "pivot{i}"\nbetween = ["ground.O", "rod{i}.A"]\n'
            f'[[stop]]\njoint = "pivot{i}"\nlowest = -0.1\nhighest = 0.1\nrestitution = 1.0\n'
        )
    return text + f"[start]\nangles = {[0.0] * count}\n"


def test_many_that_strike_now_and_then_are_no_crowd(workshop: Workshop, tmp_path: Path) -> None:
    """20 pendulums, more than 50 impacts in a characteristic time, though no more than three of each stop. With few
    events allowed, as from C, they lost energy when all events were one crowd."""
    model, rng = workshop.model(pendulums(20)), np.random.default_rng(1)
    q, u = rng.uniform(-0.05, 0.05, 20), rng.uniform(0.2, 0.9, 20) * rng.choice([-1.0, 1.0], 20)
    _, run = Library(RUNTIME, tmp_path / "core.so").create(model, rate_budget=4000)
    assert run.reset(q, u) == "done"
    events = 0
    while (event := run.step_to_event(10.0))[1].kind:
        assert event[0] == "done"
        events += 1
    assert events > 400
    _, _, after = run.motion()
    np.testing.assert_allclose(np.abs(after), np.abs(u), rtol=1e-12)


def test_a_shaken_block_goes_on_to_slide(workshop: Workshop) -> None:
    """Stick and slip in turn, 1,600 events: none of a contact that slides is rattling, and it is told as sliding."""
    text = block(1.0, 0.4, 0.3) + '\n[[force]]\npoint = "block.C"\nvector = ["12*sin(2*pi*10*t)", 0]\n'
    run = simulate(workshop.model(text.replace("points = {", "points = { C = [0, -0.15], ")), until=80.0)
    assert run.success and sum(phase.how != () for phase in run.phases) > 1500
    late = [phase.how for phase in run.phases if phase.start > 40.0]
    assert any("slides" in how for modes in late for how in modes)
    assert not [modes for modes in late if any("limit" in how for how in modes)]


def test_the_speed_that_is_told_is_that_of_a_contact_that_came_to_rest(workshop: Workshop) -> None:
    """A hammer on its anvil, with e = 0.999: its last blow has no rebound. Contacts could have rested up to a speed
    that doubles with the events of the window, and is larger, but not than a millionth of what moves."""
    text = (
        'name = "hammer"\n[gravity]\n[ground_link]\npoints = { O = [0, 0] }\n'
        '[[link]]\nname = "head"\nmass = 1.0\ninertia = 0.1\ncom = [0, 0]\npoints = { A = [0, 0] }\n'
        '[[joint]]\nname = "guide"\ntype = "prismatic"\nbetween = ["ground.O", "head.A"]\naxis = [0, 1]\n'
        '[[stop]]\njoint = "guide"\nlowest = 0.0\nrestitution = 0.999\n[start]\nangles = [0.0]\n'
    )
    model = workshop.model(text)
    run = simulate(model, np.array([0.01]), np.array([0.0]), until=100.0)
    assert run.success, run.message
    stopped = [abs(impact.u_minus[0]) for impact in run.impacts if abs(impact.u_plus[0]) < 1e-15]
    assert stopped
    assert run.rest_speed == pytest.approx(max(stopped), rel=1e-14)
    assert 1e-10 < run.rest_speed < 1e-6 * max(abs(impact.u_minus[0]) for impact in run.impacts)
