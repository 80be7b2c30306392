"""The falling hexagon against independently computed digits, and contact where its impacts accumulate."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ..oracles import maximal, polygons
from ..support.folders import ROOT
from ..support.workshop import Workshop

IMPACTS = (
    (0.4515236409857, (0,), -4.4294469181, 7.3085874148, 109.626750000),
    (0.5497839476458, (1, 5), -5.5574692024, 16.9704401049, 62.4704008830),
    (0.7701908095116, (0,), -1.7758695811, 2.8748494802, 61.1940614475),
    (0.9241375542824, (0,), -0.9113049152, 2.1441771281, 60.7055616585),
    (0.9461333789875, (3,), -3.6884589011, 15.8650497918, 46.0761656284),
    (0.9512380368467, (0,), -1.2059028786, 3.1062090704, 45.1397190135),
)
"""Time, joints, normal velocity before, impulse at each joint, energy after."""
LATER = (1.1398, 1.2182, 1.2558, 1.2743, 1.2835, 1.2881)
"""Times of the impacts of joint 0 that follow, to the digits known."""
ACCUMULATION = 1.292646
"""Where the times of the reference converge; 1.29263 is what the six above extrapolate to."""
START_ENERGY = 117.72


@pytest.fixture(scope="module")
def model(workshop: Workshop) -> Any:
    from ccgen.generator import loop

    return workshop.model(loop(6, gravity=True, start={"height": 1.0}, ground=[{"restitution": 0.5}]))


@pytest.fixture(scope="module")
def run(model: Any) -> Any:
    from ccgen.runtime import simulate

    return simulate(model, until=1.2, rtol=1e-12)


@pytest.mark.quick
def test_the_end_is_reached(run: Any) -> None:
    assert run.success
    assert run.t[-1] == 1.2
    assert len(run.impacts) == len(IMPACTS) + 1
    assert [phase.kind for phase in run.phases] == ["flight", "impact"] * 7 + ["flight"]


@pytest.mark.quick
@pytest.mark.parametrize("number", range(6))
def test_impact(run: Any, number: int) -> None:
    """Time to 1e-11 s, velocity, impulse and energy to 1e-9 relative."""
    time, joints, speed, impulse, energy = IMPACTS[number]
    impact = run.impacts[number]
    assert impact.t == pytest.approx(time, abs=1e-11)
    assert sorted(impact.contacts) == [(f"joint_{j}", "ground_0") for j in joints]
    assert impact.impulses == pytest.approx([impulse] * len(joints), rel=1e-9)
    left = START_ENERGY - sum(before.energy_loss for before in run.impacts[: number + 1])
    assert left == pytest.approx(energy, rel=1e-9)
    after = np.flatnonzero(run.t == impact.t)
    assert len(after) == 2
    for row, velocity in zip(after, (speed, -0.5 * speed), strict=True):
        assert sum(run.model.energy(run.q[row], run.u[row])) == pytest.approx(
            energy + (impact.energy_loss if row == after[0] else 0.0), rel=1e-9
        )
        velocities = run.model.velocities(run.q[row], run.u[row])
        assert velocities[list(joints), 1] == pytest.approx(velocity, rel=1e-9)
    assert np.array_equal(run.u[after[0]], impact.u_minus)
    assert np.array_equal(run.u[after[1]], impact.u_plus)


@pytest.mark.quick
def test_the_impacts_are_those_of_the_dense_solve(run: Any) -> None:
    """Each recorded jump against the reference, from the recorded state before it."""
    system = polygons.ring(6, gravity=9.81)
    assert len(run.impacts) >= 6
    for impact in run.impacts:
        row = np.flatnonzero(run.t == impact.t)[0]
        poses, before = run.model.poses(run.q[row]), run.model.velocities(run.q[row], impact.u_minus)
        corners = [polygons.corner(6, int(point.removeprefix("joint_"))) for point, _ in impact.contacts]
        jump = maximal.impact(system, poses, before, corners, 0.5)
        after = run.model.velocities(run.q[row], impact.u_plus)
        assert np.max(np.abs(after - jump.velocities.astype(float))) <= 1e-12 * np.abs(before).max()
        assert impact.impulses == pytest.approx(jump.impulses.astype(float), rel=1e-12)
        assert impact.energy_loss == pytest.approx(jump.loss, rel=1e-11)


@pytest.mark.quick
def test_the_motion_stays_symmetric(run: Any) -> None:
    """Link k mirrors link 5 - k: theta_k + theta_(5-k) = 2 pi."""
    angles = run.model.poses(run.q)[:, :, 2]
    assert np.max(np.abs(angles + angles[:, ::-1] - 2 * np.pi)) < 1e-8


@pytest.mark.quick
def test_audits(run: Any) -> None:
    assert run.closure_max <= 1e-13
    assert run.energy_drift <= 1e-11 * START_ENERGY
    heights = run.model.poses(run.q)[:, :, 1]
    assert heights.min() >= -1e-12


@pytest.mark.quick
def test_between_the_rows(run: Any) -> None:
    """At an impact time the state after it; elsewhere a closed state."""
    for impact in run.impacts:
        q, u = run.at(impact.t)
        assert np.array_equal(u, impact.u_plus)
        q, u = run.at(impact.t - 1e-9)
        assert u == pytest.approx(impact.u_minus, abs=1e-6)
    q, u = run.at(np.linspace(0, 1.2, 97))
    assert np.max(np.abs(run.model.closure(q))) <= 1e-13
    energies = np.sum(run.model.energy(q, u), axis=0)
    times = np.linspace(0, 1.2, 97)
    wanted = START_ENERGY - np.array([sum(i.energy_loss for i in run.impacts if i.t <= t) for t in times])
    assert energies == pytest.approx(wanted, rel=1e-10)


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10])
def test_event_times_follow_the_tolerance(model: Any, rtol: float) -> None:
    """Six impacts on, each wrong by what the tolerance allows: errors of earlier impacts grow from one to the next."""
    from ccgen.runtime import simulate

    run = simulate(model, until=1.0, rtol=rtol)
    assert run.success
    assert len(run.impacts) == 6
    errors = [abs(impact.t - known[0]) for impact, known in zip(run.impacts, IMPACTS, strict=True)]
    assert errors[0] <= 1e-12
    assert max(errors) <= rtol


def test_the_scene_of_the_repository(workshop: Workshop) -> None:
    """``scenes/falling-hexagon.toml`` is this motion, to its own end and tolerance."""

    from ccgen.generator import load_scene
    from ccgen.runtime import simulate

    scene = ROOT / "scenes" / "falling-hexagon.toml"
    run = simulate(workshop.model(load_scene(scene)))
    assert run.success
    assert run.t[-1] == 1.2
    assert len(run.impacts) == 7
    for impact, (time, joints, *_) in zip(run.impacts, IMPACTS, strict=False):
        assert impact.t == pytest.approx(time, abs=1e-9)
        assert len(impact.contacts) == len(joints)


@pytest.mark.quick
def test_accumulating_impacts_hand_over_to_contact(model: Any, run: Any) -> None:
    """Run to 1.4 s, joint 0 stands on the ground from 1.2926 s on."""
    from ccgen.runtime import simulate

    long = simulate(model, until=1.4, rtol=1e-12)
    assert long.success, long.message
    stands = next(phase for phase in long.phases if phase.kind == "contact")
    assert stands.start == pytest.approx(ACCUMULATION, abs=1e-6)
    assert stands.contacts == (("joint_0", "ground_0"),)
    assert long.phases[-1].end == long.t[-1] == 1.4
    for kept, known in zip(long.impacts, run.impacts, strict=False):
        assert kept.t == pytest.approx(known.t, abs=1e-12)
        assert kept.impulses == pytest.approx(known.impulses, rel=1e-10)
    later = [impact.t for impact in long.impacts[6:]]
    assert later[: len(LATER)] == pytest.approx(LATER, abs=5.1e-5)
    assert all(impact.contacts == (("joint_0", "ground_0"),) for impact in long.impacts[6:] if impact.t < stands.start)
    assert long.closure_max <= 1e-13
    assert long.energy_drift <= 1e-10 * START_ENERGY
    assert model.gaps(long.q).min() >= -1e-10
