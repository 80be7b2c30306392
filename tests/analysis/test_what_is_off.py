"""Questions that need no run, to scenes with effects that are off at the start: against closed forms."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import driving_torque, inverse_dynamics, linearise, reach, simulate, static_equilibrium

from ..support.command_line import ccgen
from ..support.workshop import Workshop

ROD = """
name = "off-load"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "rod"
rod = { mass = 1 }
points = { O = [0, 0], T = [1, 0] }
[[joint]]
name = "hinge"
between = ["ground.O", "rod.O"]
[[torque]]
name = "load"
link = "rod"
torque = -40
[[torsion]]
name = "coil"
joint = "hinge"
stiffness = 3
[[stop]]
name = "bumper"
joint = "hinge"
lowest = "-30 deg"
restitution = 0
[[event]]
when = "t - 0.1"
on = ["load", "bumper"]
off = ["coil"]
[start]
off = ["load", "bumper"]
[gravity]
"""
"""At the start a rod of 1 m and 1 kg hangs on a torsion spring; later a torque of -40 N m presses it onto a stop."""


@pytest.fixture
def model(workshop: Workshop) -> Any:
    return workshop.model(ROD, derivatives=True)


def test_questions_are_about_what_acts_at_the_start(model: Any) -> None:
    hangs = -0.9818  # where 4.905 cos a = -3 a; refined below
    for _ in range(20):
        hangs -= (4.905 * np.cos(hangs) + 3.0 * hangs) / (3.0 - 4.905 * np.sin(hangs))
    found = static_equilibrium(model)
    assert found.q[0] == pytest.approx(hangs, abs=1e-9) and not found.closed
    assert found.stiffness == pytest.approx([3.0 - 4.905 * np.sin(hangs)], rel=1e-7)
    assert np.array_equal(found.contact_forces, np.zeros((1, 2)))
    turn = driving_torque(model, "hinge", 2.0)
    assert turn.torque == pytest.approx(4.905 * np.cos(turn.angle) + 3.0 * turn.angle, abs=1e-10)
    asked = inverse_dynamics(model, [0.4], [0.0], [2.0], ["hinge"])
    assert asked == pytest.approx([2.0 / 3.0 + 4.905 * np.cos(0.4) + 1.2], rel=1e-12)
    with pytest.raises(ValueError, match="which is off, expected zero there"):
        inverse_dynamics(model, [0.4], [0.0], [2.0], ["hinge"], contact_forces=[[1.0, 0.0]])
    assert reach(model, [0.0], angles={"hinge": -0.9}) == pytest.approx([-0.9], abs=1e-12)
    small = linearise(model, [hangs])
    assert np.allclose(small.A, [[0.0, 1.0], [-3.0 * found.stiffness[0], 0.0]], rtol=1e-6, atol=1e-12)


def test_gaps_of_what_is_off_are_infinite_and_outputs_have_none(model: Any) -> None:
    """And it is neither drawn nor among what is on."""
    run = simulate(model, until=0.3)
    later = run.model_at(0.2)
    assert set(model.off) == {"load", "bumper"} and later.off == ("coil",)
    assert np.isinf(model.gaps([0.4])).all() and later.gaps([0.4]) == pytest.approx([0.4 + np.pi / 6.0])
    gap = run.values("bumper.lowest.hinge.gap", t=[0.05, 0.2])["bumper.lowest.hinge.gap"]
    assert np.isnan(gap[0]) and gap[1] == pytest.approx(run.at(0.2)[0][0] + np.pi / 6.0)
    drawn = [{part.name for part in one.parts} for one in (model, later)]
    assert "coil" in drawn[0] - drawn[1] and {"load", "bumper"} <= drawn[1] - drawn[0]


def test_questions_to_a_later_model_are_about_what_acts_then(model: Any) -> None:
    run = simulate(model, until=0.3)
    later, first = run.model_at(0.2), run.model_at(0.0)
    pressed = static_equilibrium(later)
    assert pressed.q[0] == pytest.approx(-np.pi / 6.0, abs=1e-9) and pressed.closed == (("hinge", "bumper.lowest"),)
    assert pressed.contact_forces[0, 0] == pytest.approx(40.0 + 4.905 * np.cos(np.pi / 6.0), rel=1e-9)
    assert static_equilibrium(first).q[0] == static_equilibrium(model).q[0]
    assert inverse_dynamics(later, [0.4], [0.0], [0.0], ["hinge"])[0] == pytest.approx(40.0 + 4.905 * np.cos(0.4))


def test_everything_on_is_no_start(workshop: Workshop) -> None:
    """Also where at a later time all effects act, which is another thing than the start."""
    run = simulate(workshop.model(ROD.replace('off = ["coil"]\n', "")), until=0.3)
    with_all = run.model_at(0.2)
    assert inverse_dynamics(with_all, [0.4], [0.0], [0.0], ["hinge"])[0] == pytest.approx(41.2 + 4.905 * np.cos(0.4))


def test_commands_leave_out_what_is_off(tmp_path: Path) -> None:
    (tmp_path / "rod.toml").write_text(ROD)
    told = ccgen("torque", "rod.toml", "hinge", "--set", "coil.stiffness=0.5", at=tmp_path).stdout.splitlines()
    assert float(told[1].split()[1]) == pytest.approx(0.5 * np.pi, rel=1e-8)
    rest = ccgen("equilibrium", "rod.toml", at=tmp_path).stdout
    assert rest.startswith("off-load: stable equilibrium") and "contact" not in rest
    assert "at the start bumper, load are off" in ccgen("show", "rod.toml", at=tmp_path).stdout
