"""Periodic motions by a coordinate that passes a value: a pendulum that a torque keeps whirling."""

from __future__ import annotations

import math
from typing import Any

import pytest
from scipy.integrate import solve_ivp

from ccgen.runtime import continue_orbit, find_orbit

from ..support.tiers import hard
from ..support.workshop import Workshop

MASS, INERTIA, DAMPING, TORQUE, G = 1.0, 1.0, 0.8, 14.0, 9.81
"""A point mass on a rod of length 1; its weight's largest moment is 9.81 N m."""
WHIRL = f"""
name = "whirl"
[ground_link]
points = {{ O = [0, 0] }}
[[link]]
name = "rod"
points = {{ O = [0, 0], A = [1, 0] }}
point_mass = {{ at = [1, 0], mass = {MASS} }}
[[joint]]
name = "pin"
between = ["ground.O", "rod.O"]
[[torsion]]
joint = "pin"
damping = {DAMPING}
[[torque]]
link = "rod"
torque = {TORQUE}
[gravity]
g = {G}
[run]
until = 50
rtol = 1e-12
"""


@pytest.fixture(scope="module")
def whirl(workshop: Workshop) -> Any:
    return workshop.model(WHIRL, derivatives=True)


def speed_after_a_turn(speed: float) -> tuple[float, float]:
    """By SciPy, with the angle as what runs: w dw/dangle = (torque - c w - m g cos angle) / I, and the time."""

    def by_angle(angle: float, x: Any) -> list[float]:
        return [(TORQUE - DAMPING * x[0] - MASS * G * math.cos(angle)) / (INERTIA * x[0]), 1.0 / x[0]]

    end = solve_ivp(by_angle, (0.3, 0.3 + 2 * math.pi), [speed, 0.0], "DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    return float(end[0]), float(end[1])


@pytest.mark.parametrize("segments", [hard(1), 3])
def test_a_pendulum_that_whirls(segments: int, whirl: Any) -> None:
    """It comes back with the same speed after a turn; small differences of it shrink by exp(- c T / I)."""
    found = find_orbit(whirl, [0.0], [15.0], section=("rod.angle", 0.3), advances=["rod.angle"], segments=segments)
    assert found.q[0] % (2 * math.pi) == pytest.approx(0.3, abs=1e-12)
    speed, time = speed_after_a_turn(float(found.u[0]))
    assert speed == pytest.approx(float(found.u[0]), abs=1e-9)
    assert found.period == pytest.approx(time, abs=1e-10)
    assert found.multipliers == pytest.approx([math.exp(-DAMPING / INERTIA * time)], abs=1e-9)
    assert found.stable


@pytest.mark.hard
def test_it_is_followed_along_its_damping(whirl: Any) -> None:
    orbit = find_orbit(whirl, [0.0], [15.0], section=("rod.angle", 0.3), advances=["rod.angle"])
    branch = continue_orbit(orbit, "torsion_0.damping", (0.6, 1.0), step=0.2)
    assert branch.values[[0, -1]] == pytest.approx([0.6, 1.0]) and not branch.bifurcations
    for value, one in zip(branch.values, branch.orbits, strict=True):
        assert one.multipliers[0].real == pytest.approx(math.exp(-value * one.period), abs=1e-9)


def test_what_passes_and_comes_back(whirl: Any) -> None:
    """Small swings about where weight and torque balance, no damping: the section is passed once in each, growing."""
    still = whirl.with_parameters({"torsion_0.damping": 0.0, "gravity.g": 20.0})
    rest = -math.acos(TORQUE / 20.0)
    found = find_orbit(still, [rest + 1e-3], [0.0], section=("rod.angle", rest))
    assert found.period == pytest.approx(2 * math.pi / math.sqrt(20.0 * math.sin(-rest)), rel=1e-6)
    assert found.multipliers == pytest.approx([1.0], abs=1e-7) and found.u[0] > 0.0
    assert found.neutral and not found.stable  # on whichever side of 1 the multiplier was rounded


def test_one_of_a_family_has_no_branch(whirl: Any) -> None:
    """Swings of any height come back where energy is kept: there is no curve of them along the weight."""
    still = whirl.with_parameters({"torsion_0.damping": 0.0, "gravity.g": 20.0})
    found = find_orbit(still, [-1.0], [0.0], section=("rod.angle", -math.acos(TORQUE / 20.0)))
    with pytest.raises(ValueError, match=r"found one of a family of periodic motions at one value of gravity\.g"):
        continue_orbit(found, "gravity.g", (18.0, 22.0))


def test_what_rests_on_the_section_passes_nothing(whirl: Any) -> None:
    """The rate with which it leaves is rounding, and a multiplier would be the quotient of two such."""
    still = whirl.with_parameters({"torsion_0.damping": 0.0, "gravity.g": 20.0})
    rest = -math.acos(TORQUE / 20.0)
    with pytest.raises(ValueError, match=r"found (rod\.angle at .* with a rate of|0 passages of rod\.angle)"):
        find_orbit(still, [rest], [0.0], section=("rod.angle", rest))


def test_a_range_that_the_parameter_cannot_have(whirl: Any) -> None:
    """It is refused before anything is followed, and not where the branch gets there."""
    orbit = find_orbit(whirl, [0.0], [15.0], section=("rod.angle", 0.3), advances=["rod.angle"], segments=3)
    with pytest.raises(ValueError, match=r"^between: torsion_0\.damping: found -1\.0, expected a (positive )?number"):
        continue_orbit(orbit, "torsion_0.damping", (-1.0, 1.0))


def test_a_crossing_is_not_waited_for_to_the_end(whirl: Any) -> None:
    """A run of the time that may be taken would be one of millions of turns."""
    found = find_orbit(whirl, [0.0], [15.0], section=("rod.angle", 0.3), advances=["rod.angle"], until=1e7)
    assert speed_after_a_turn(float(found.u[0]))[0] == pytest.approx(float(found.u[0]), abs=1e-9)


def test_wrong_sections_are_told(whirl: Any) -> None:
    with pytest.raises(ValueError, match=r"section: found \('rod', 0\.3\), expected one of the coordinates rod\.angle"):
        find_orbit(whirl, section=("rod", 0.3))
    with pytest.raises(ValueError, match=r"found 0 passages of rod\.angle = 0\.3 in 0\.001 s, expected 1"):
        find_orbit(whirl, [1.0], [0.0], section=("rod.angle", 0.3), until=1e-3)
    with pytest.raises(ValueError, match="expected a time in s above 0, a contact"):
        find_orbit(whirl, section=None)  # type: ignore[arg-type]
