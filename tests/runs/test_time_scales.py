"""Pulses between times at which nothing happens: no step passes over one."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ccgen.runtime import ensemble, simulate
from ccgen.runtime.model.time_scales import ends_of_pieces

from ..support.tiers import hard
from ..support.workshop import Workshop

ARM = """
[ground_link]
points = {{ O = [0, 0] }}
[[link]]
name = "arm"
rod = {{ mass = 1 }}
points = {{ A = [0, 0], B = [1, 0] }}
[[joint]]
name = "h"
between = ["ground.O", "arm.A"]
[[motor]]
joint = "h"
torque = "{torque}"
[run]
until = {until}
"""
INERTIA = 1 / 3


def arm(torque: str, until: float = 5.0) -> str:
    return ARM.format(torque=torque, until=until)


@pytest.mark.parametrize("method", ["gauss", hard("dop853"), hard("dopri5"), hard("radau")])
@pytest.mark.parametrize(("at", "width"), [(1.234, 0.03), (4.9, 0.01), hard(0.31, 0.1), hard(2.5, 0.003)])
def test_a_pulse_is_met(workshop: Workshop, method: str, at: float, width: float) -> None:
    """A bell of torque on an arm at rest: what it gives is its integral, 20 w √π, to the tolerance. By steps as long as
    a resting arm has, it was passed over, without a word."""
    run = simulate(workshop.model(arm(f"20*exp(-((t - {at})/{width})**2)")), method=method)
    area = 10.0 * width * math.sqrt(math.pi) * (math.erf((5.0 - at) / width) + math.erf(at / width))
    assert run.u[-1, 0] == pytest.approx(area / INERTIA, rel=1e-7)


def test_pulses_of_a_run_that_lasts_longer(workshop: Workshop) -> None:
    """Pieces are those of the run, also of many runs and of a model with other masses; a pulse in a table too."""
    model = workshop.model(arm("20*exp(-((t - 17)/0.03)**2)"))
    speed = 20.0 * 0.03 * math.sqrt(math.pi) / INERTIA
    assert simulate(model).u[-1, 0] == 0.0
    assert simulate(model, until=20.0).u[-1, 0] == pytest.approx(speed, rel=1e-7)
    masses = np.array([1.0, 2.0])
    table = ensemble(model, {"arm.mass": masses}, observe=["arm.angular_velocity"], until=20.0)
    assert table["arm.angular_velocity"] == pytest.approx(speed * INERTIA / (1 / 12 + masses / 4), rel=1e-7)


def test_what_is_alike_everywhere_has_no_pieces(workshop: Workshop) -> None:
    """Slow loads, even oscillations, models without time: steps end where they did."""
    pulse = workshop.model(arm("20*exp(-((t - 2)/0.03)**2)"))
    pieces = ends_of_pieces(pulse, [], 5.0)
    assert 4 <= len(pieces) <= 20 and min(abs(t - 2.0) for t in pieces) < 0.1
    for torque in ("3*sin(2*t)", "0.3*sin(400*t)", "2 + 0.1*t**2", "2"):
        assert ends_of_pieces(workshop.model(arm(torque)), [], 5.0) == []


def test_steps_of_fixed_length_keep_it(workshop: Workshop) -> None:
    run = simulate(workshop.model(arm("20*exp(-((t - 2)/0.03)**2)")), step=0.01)
    assert np.diff(run.t) == pytest.approx(0.01, rel=1e-9)


def test_a_load_that_jumps_ends_the_looking(workshop: Workshop) -> None:
    """Beside a jump no piece is like a polynomial: halving ends there, and the run meets it."""
    model = workshop.model(arm("10 + 10*(t - 2.2)/abs(t - 2.2)"))
    assert len(ends_of_pieces(model, [], 5.0)) < 200
    assert simulate(model).u[-1, 0] == pytest.approx(20.0 * 2.8 / INERTIA, rel=1e-6)
