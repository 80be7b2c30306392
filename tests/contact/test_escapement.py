"""A pendulum clock's escapement of one polygon and two pins: ``scenes/escapement.toml``."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import ellipk

from ccgen.generator import load_scene
from ccgen.runtime import simulate

from ..support.folders import ROOT
from ..support.workshop import Workshop

PITCH = math.radians(24.0)
FREE = math.radians(1.8)
"""The pendulum's angle at which a tooth leaves a pin, and up to which it drives the pendulum."""


class Swings(NamedTuple):
    """Each swing to and fro, from one passage of the vertical to the next, and the wheel's angles at these."""

    periods: NDArray[np.float64]
    amplitudes: NDArray[np.float64]
    wheel: NDArray[np.float64]


class Pendulum(NamedTuple):
    """The pendulum without its wheel: frequency of small swings (rad/s), quality factor, damping (N m s/rad)."""

    frequency: float
    quality: float
    damping: float

    def period(self, amplitude: NDArray[np.float64]) -> NDArray[np.float64]:
        """Of swings of this amplitude without damping (s): the complete elliptic integral of the first kind."""
        return np.asarray(4.0 / self.frequency * ellipk(np.sin(amplitude / 2.0) ** 2))


def pendulum(model: Any) -> Pendulum:
    of = model.parameters
    mass, below, damping = of["pendulum.mass"], -of["pendulum.com.y"], of["joint_friction_0.viscous"]
    inertia = of["pendulum.inertia"] + mass * below**2
    frequency = math.sqrt(mass * of["gravity.g"] * below / inertia)
    return Pendulum(frequency, inertia * frequency / damping, damping)


def swings(run: Any) -> Swings:
    """By states at 2000 instants a second and straight lines between them, which miss passages by less than 1e-8 s."""
    times = np.linspace(0.0, run.t[-1], round(2000 * run.t[-1]) + 1)
    poses = run.model.poses(run.at(times)[0])
    wheel, angle = (poses[:, run.model.links.index(name), 2] for name in ("wheel", "pendulum"))
    at = np.flatnonzero((angle[:-1] < 0) & (angle[1:] >= 0))
    passed = times[at] - angle[at] * (times[1] - times[0]) / (angle[at + 1] - angle[at])
    halves = [(angle[a:b].max() - angle[a:b].min()) / 2.0 for a, b in pairwise(at)]
    return Swings(np.diff(passed), np.array(halves), np.interp(passed, times, wheel))


def check(run: Any) -> Swings:
    """What holds of any stretch of the clock's going: a tooth a swing, no energy from nowhere, event by event."""
    assert run.success and run.energy_drift < 1e-10
    assert not any(phase.step for phase in run.phases)
    seen = swings(run)
    assert len(seen.periods) >= run.t[-1] - 2.0
    turns = seen.wheel - seen.wheel[0]
    assert (
        np.max(np.abs(turns + PITCH * np.arange(len(turns)))) < 0.02 * PITCH
    )  # where the wheel is at a passage depends on the swing
    free = pendulum(run.model)
    late = seen.periods / free.period(seen.amplitudes) - 1.0
    airy = math.tan(math.asin(FREE / seen.amplitudes.min())) / (2.0 * free.quality)
    assert np.all(late > 0.0) and np.all(late < airy)
    return seen


def balanced(run: Any, seen: Swings, last: int) -> float:
    """The amplitude at which damping takes what the wheel's torque gives in a swing, less what impacts take (rad)."""
    of = run.model.parameters
    start = run.t[-1] - last * seen.periods[-1]
    lost = sum(impact.energy_loss for impact in run.impacts if impact.t > start) / last
    gained = -of["motor_0.torque"] * PITCH - lost
    return math.sqrt(gained * seen.periods[-1] / (2.0 * math.pi**2 * pendulum(run.model).damping))


@pytest.fixture(scope="module")
def usual(workshop: Workshop) -> Any:
    """A minute of the clock as it is shipped."""
    return simulate(workshop.model(load_scene(ROOT / "scenes" / "escapement.toml")))


@pytest.fixture(scope="module")
def steady(usual: Any) -> float:
    """Its amplitude in the end (rad)."""
    return float(check(usual).amplitudes[-1])


@pytest.mark.hard
def test_the_wheel_goes_on_by_a_tooth_at_each_swing(usual: Any) -> None:
    """For a minute, with the period of the free pendulum within Airy's bound, at the amplitude that energy balances.

    Impulses after the middle of a swing slow it by cot(phase)/(2 Q), at most as much as their last instant would.
    The square of the amplitude settles as exp(-w t/Q), by a fortieth in a minute. The harmonic balance leaves out A²/8.
    """
    seen = check(usual)
    assert np.ptp(seen.amplitudes[-10:]) < 1e-4 * seen.amplitudes[-1]
    assert seen.amplitudes[-1] == pytest.approx(balanced(usual, seen, 10), rel=1e-3)


@pytest.mark.hard
@pytest.mark.large(1)
@pytest.mark.parametrize("degrees", [3.2, 4.5])
def test_other_swings_come_to_the_same(degrees: float, usual: Any, steady: float) -> None:
    model = usual.model
    q, u = model.start()
    q[list(model.links).index("pendulum")] = math.radians(degrees)
    run = simulate(model, q0=q, u0=u, until=120.0)
    seen = check(run)
    assert abs(seen.amplitudes[0] - steady) > 0.1 * steady
    assert seen.amplitudes[-1] == pytest.approx(steady, rel=1e-3)
