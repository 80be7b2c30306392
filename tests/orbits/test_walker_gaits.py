"""The simplest walker's gaits by its return map: published digits, and where they lose their stability."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from ccgen.runtime import continue_orbit, double_period, find_orbit
from ccgen.runtime.orbits.settled import settled

from ..support.simplest_walker import SEARCH, STONES, massless_gait, with_feet
from ..support.workshop import Workshop

PULL = "gravity.direction.x"
STABLE = (0.200310900544247089, -0.199832473004952355, 3.88246375285137414)
MULTIPLIER = -0.1900998410658881 + 0.5575987766820683j


@pytest.fixture(scope="module")
def walker(workshop: Workshop) -> Any:
    return workshop.model(STONES, derivatives=True)


def test_the_stable_gait_from_a_rough_guess(walker: Any) -> None:
    """By one search, of feet of 2e-5 and 1e-5; what they differ by leads to feet without mass."""
    coarse, fine = (find_orbit(with_feet(walker, foot), **SEARCH) for foot in (2e-5, 1e-5))
    assert fine.stable and fine.runs <= 6
    found = 2 * np.array([fine.q[2] - math.pi / 2, fine.u[2], fine.period])
    found -= [coarse.q[2] - math.pi / 2, coarse.u[2], coarse.period]
    assert found == pytest.approx(STABLE, abs=1e-8)
    assert fine.q[3] - math.pi / 2 == pytest.approx(math.pi / 2 - fine.q[2], abs=1e-9)  # both feet are on the ground
    multipliers = [one.multipliers[np.argmax(one.multipliers.imag)] for one in (coarse, fine)]
    assert abs(2 * multipliers[1] - multipliers[0] - MULTIPLIER) <= 1e-6
    assert np.abs(fine.multipliers[2:]).max() <= 1e-8  # a strike tells nothing of how the legs swung


@pytest.mark.hard
def test_where_the_gait_doubles(walker: Any) -> None:
    """The slope at which it does, by SciPy's integration of the paper's equations; about 0.0151 there. Gravity that
    leans more is a steeper slope, and stronger, which changes no gait but its time."""

    def turned(slope: float) -> float:
        angle = STABLE[0] * (slope / 0.009) ** (1 / 3)  # as the paper's section 4 has it
        return float(np.linalg.eigvals(massless_gait(slope, (angle, -0.98 * angle))[1]).real.min() + 1.0)

    expected = brentq(turned, 0.0145, 0.0155, xtol=1e-9)
    assert expected == pytest.approx(0.0151, abs=5e-5)
    slopes = []
    for foot in (2e-4, 1e-4):
        orbit = find_orbit(with_feet(walker, foot), **SEARCH)
        branch = continue_orbit(orbit, PULL, (0.008, 0.016), way="up", step=0.2)
        (flip,) = branch.bifurcations
        assert flip.kind == "flip" and branch.stable[0] and not branch.stable[-1]
        slopes.append(math.atan(flip.value / -orbit.return_map.model.parameters["gravity.direction.y"]))
    assert 2 * slopes[1] - slopes[0] == pytest.approx(expected, abs=1e-7)
    doubled = double_period(flip)
    assert doubled.stable and doubled.period == pytest.approx(2 * flip.orbit.period, rel=0.02)
    (first, second) = doubled.states
    assert abs(first[2] - second[2]) > 1e-3  # one step is longer than the other
    slope = doubled.return_map.model.parameters[PULL]
    _, angles = settled(doubled, PULL, np.array([slope]), "swing.angle", crossings=40, last=4)
    assert len(np.unique(np.round(angles, 6))) == 2  # runs that settle show both
