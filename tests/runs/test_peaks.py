"""Where quantities of a run are largest between the instants that are looked at."""

from __future__ import annotations

import numpy as np
import pytest

from ccgen.generator.cli.forces import Told
from ccgen.runtime import Run, simulate
from ccgen.runtime.record.force_history import history, with_peaks
from ccgen.runtime.record.peaks import find_peaks

from ..support.driven_crank import CRANK
from ..support.tiers import hard
from ..support.two_cranks import TWO_CRANKS
from ..support.workshop import Workshop


@pytest.mark.parametrize("looks", [97, 201, 1000])
def test_equal_peaks_are_equal_wherever_they_are_looked_at(looks: int) -> None:
    """Ten periods of a sine and of one whose crests grow; of the second the last alone is looked for."""

    def of(t: np.ndarray) -> np.ndarray:
        return np.column_stack([np.sin(t), (1.0 + 0.1 * t) * np.sin(t), np.ones_like(t)])

    t = np.linspace(0.0, 20.0 * np.pi, looks)
    peaks = find_peaks(t, of(t), of, np.ones(of(t).shape, dtype=bool))
    found = peaks.t
    assert looks < 200 or not peaks.spikes.any()
    crests = np.pi / 2.0 + 2.0 * np.pi * np.arange(10)
    near = np.array([found[np.argmin(np.abs(found - crest))] for crest in crests])
    assert np.max(np.abs(near - crests)) <= 1e-6 and np.min(np.sin(near)) >= 1.0 - 1e-12
    # (1 + t/10) sin t is highest where tan t = -(10 + t)
    last = 18.5 * np.pi
    for _ in range(50):
        last = 19.0 * np.pi - np.arctan(10.0 + last)
    assert np.min(np.abs(found - last)) <= 1e-6
    assert len(found) <= 13


def test_beside_a_jump_and_where_nothing_is_known_there_is_no_peak() -> None:
    t = np.array([0.0, 1.0, 1.0, 2.0, 3.0, 4.0])
    sizes = np.array([0.0, 1.0, 5.0, 4.0, 4.5, 0.0])[:, None]
    known = np.array([True, True, True, True, False, True])[:, None]

    def never(t: np.ndarray) -> np.ndarray:
        raise AssertionError

    assert len(find_peaks(t, sizes, never, known).row) == 0


@pytest.mark.hard
def test_the_first_of_equal_peaks_is_told(workshop: Workshop) -> None:
    """A crank that turns evenly needs in every turn what it needs in the first; the largest torque of a turn, told of
    runs of 1 and of 9 turns, is at one instant, whatever instants are looked at."""
    model = workshop.model(CRANK + '[[drive]]\njoint = "axle"\nspeed = 5.0\n')
    turn = 2.0 * np.pi / 5.0
    for until in (1.1 * turn, 3.7, 9.3 * turn):
        run = simulate(model, until=until)
        times = [t for _, _, t, _ in Told(run).rows]
        assert all(t <= turn for t in times), times
    fine = history(run, 200_000)
    sizes = np.hypot(*fine.reactions[:, 0, :2].T)
    told = {name: float(size.split()[0]) for name, size, _, _ in Told(run).rows}
    name = run.model.joints[0]
    assert told[name] == pytest.approx(sizes.max(), rel=1e-5)


@pytest.mark.parametrize("speed", [100.0, *map(hard, (99.0, 101.0, 77.7))])
def test_what_a_drive_needs_at_a_change_point_does_not_bring_forces_without_bound(
    speed: float, workshop: Workshop
) -> None:
    """Its torque is largest there, and that instant is looked at. A crank that hangs carries itself and half the
    coupler: 0.3 kg m of that which turns, 2 kg of weight; what falls from a pole is no largest force."""
    parallel = "angles = { crank = 1.2217, coupler = 0, rocker = 1.2217 }\n"
    model = workshop.model(f'{TWO_CRANKS}{parallel}[[drive]]\njoint = "axle"\nspeed = {speed}\n')
    run = simulate(model, until=0.5)
    axle, pivot = (largest_of(run, joint) for joint in ("axle", "pivot"))
    assert axle == pytest.approx(0.3 * speed**2 + 19.62, rel=1e-4)
    assert 0.3 * speed**2 - 19.62 <= pivot * (1.0 + 1e-4) and pivot <= axle * (1.0 + 1e-9)


@pytest.mark.parametrize("speed", [15.0, *map(hard, (14.9, 16.0, 16.3))])
def test_forces_on_the_other_side_of_a_pole_are_none_of_the_largest(speed: float, workshop: Workshop) -> None:
    """Whichever instants are looked at beside a line of links: crossed cranks that are alike carry as much."""
    crossed = (
        f"angles = {{ crank = 1.2217, coupler = -0.7, rocker = -1.92 }}\nangular_velocities = {{ crank = {speed} }}\n"
    )
    run = simulate(workshop.model(TWO_CRANKS + crossed), until=5.0)
    assert largest_of(run, "axle") == pytest.approx(largest_of(run, "pivot"), rel=1e-3)


def largest_of(run: Run, joint: str) -> float:
    """The largest force of a joint that is told (N)."""
    found, _ = with_peaks(run, history(run))
    return float(found.away[:, found.first_joint + run.model.joints.index(joint)].max())


SHORT_ROD = """
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "crank"
rod = { mass = 1 }
points = { A = [0, 0], B = [0.1, 0] }
[[link]]
name = "rod"
rod = { mass = 1 }
points = { A = [0, 0], B = [0.08, 0] }
[[link]]
name = "slider"
mass = 1
inertia = 0.01
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
[start]
angles = { crank = 0.2, rod = -0.3 }
[gravity]
[run]
until = 1
"""


@pytest.mark.parametrize("speed", [2.0, 20.0])
def test_what_grows_towards_a_dead_point_is_no_largest_force(speed: float, workshop: Workshop) -> None:
    """There links pull as 1 / (t* - t)^(3/2), for as long as digits last, and drives with them. What is told lies
    before the rise: the guide's force at the start, or nothing."""
    run = simulate(workshop.model(f'{SHORT_ROD}[[drive]]\njoint = "axle"\nspeed = {speed}\n'))
    assert not run.success and "no motion closes the loops beyond" in run.message
    told = Told(run)
    assert told.stops
    rows = {name: float(size.split()[0]) for name, size, _, _ in told.rows}
    start = np.abs(run.values("guide.force", t=[0.0])["guide.force"][0])
    assert (
        rows == {} if speed == 20.0 else rows["guide"] == pytest.approx(start, rel=1e-5) and max(rows.values()) < 20.0
    )
