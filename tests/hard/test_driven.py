"""Mechanisms with a driven joint on rough ground: what contacts do there goes on by time stepping as without drives."""

from __future__ import annotations

import numpy as np
import pytest

from ccgen.runtime import simulate

from ..support.tiers import many
from ..support.workshop import Workshop
from .driven import Driven, driven, faults, run, scene

JAMS = Driven("chain", 4, "stronge", 1.9129226794567744, 0.5, -0.911382299728144, 110966536)
"""Found by random runs: at 0.76 s friction jams what slides by less than 1e-6 of its speeds, which comes to rest."""
STEPS = Driven("chain", 3, "poisson", 1.2743270407757898, 0.5, 0.9869895613795077, 176539825)
"""Of the survey below: it does not get further from event to event, as it would not where no drive is."""
MOST = 1
"""In a hundred that stop, or five hundred of more: loops that the drive forces through their line."""


def test_a_driven_chain_that_jams_goes_on(workshop: Workshop) -> None:
    found = run(workshop.model, JAMS)
    assert found.success, found.message
    assert all(phase.kind != "steps" for phase in found.phases) and 0.0 < found.rest_speed < 1e-6
    assert not faults(found, JAMS)


def test_a_driven_chain_goes_on_by_steps(workshop: Workshop) -> None:
    found = run(workshop.model, STEPS)
    assert found.success, found.message
    assert any(phase.kind == "steps" for phase in found.phases)
    assert not faults(found, STEPS)


@pytest.mark.parametrize("step", [2e-3, 1e-3, 5e-4, 2.5e-4])
def test_steps_in_time_keep_to_a_prescribed_motion(step: float, workshop: Workshop) -> None:
    """Of two rods that land on their ends, slide, and come down with the joint between them: of first order, beside a
    run event by event that is far more exact."""
    model = workshop.model(scene("chain", 2)).with_parameters(
        {"ground_0.restitution": 0.0, "ground_0.friction": 0.5, "drive_0.speed": 1.5}
    )
    q, u = model.start()
    q[1] += 0.1 - model.gaps(q).min()
    exact = simulate(model, q, u, until=1.0, rtol=1e-12)
    found = simulate(model, q, u, until=1.0, method="moreau", step=step)
    assert exact.success and found.success, found.message
    assert np.max(np.abs(found.q[-1] - exact.q[-1])) <= 3.0 * step
    turned = found.q[-1, 3] - found.q[-1, 2] - (q[3] - q[2])
    assert turned == pytest.approx(1.5, abs=1e-12) and found.penetration_max <= 1e-12


@pytest.mark.hard
@pytest.mark.parametrize(("seed", "number"), [(7, 325), (7, 699), (8, 111), (8, 830)])
def test_what_drives_move_against_each_other_does_not_rest(seed: int, number: int, workshop: Workshop) -> None:
    """Two contacts of which a drive lifts one from the other by 4e-7 m/s, and two that it slides: both were to rest in
    a crowd of events, which takes the drive's row for rounding; the next step gave it back, and none kept the energy.
    And a loop that strikes after forces of 1e13 N: against those all others were rounding. In the last one drives give
    energy as contacts come to rest, which was in no impact: 4e-5 of that in motion."""
    one = driven(1000, seed)[number]
    found = run(workshop.model, one)
    assert found.success, found.message
    assert not faults(found, one)
    assert found.energy_drift <= 1e-9 * float(np.max(found.model.energy(found.q, found.u)[0]))


@pytest.mark.hard
def test_a_loop_that_a_drive_folds_flat_reaches_its_end(workshop: Workshop) -> None:
    """A loop of six within 1e-9 of the ground, whose contacts let go by rounding of their forces until no step kept the
    energy."""
    one = driven(528, 7)[527]
    found = run(workshop.model, one)
    assert found.success, found.message
    assert not faults(found, one)
    assert found.energy_drift <= 1e-6 * float(np.max(found.model.energy(found.q, found.u)[0]))


@pytest.mark.hard
@pytest.mark.parametrize(("seed", "number"), [(7, 130), (8, 799)])
def test_an_impact_beside_a_line_loses_no_energy_unsaid(seed: int, number: int, workshop: Workshop) -> None:
    """Impacts of loops that a drive folds flat, 1e-10 of their length from it, leave with velocities of no branch: the
    next step had other ones, and a ten-thousandth of the energy was taken for what rounding hides there."""
    found = run(workshop.model, driven(number + 1, seed)[number])
    assert found.success or "line" in found.message or "change point" in found.message
    assert found.energy_drift <= 1e-6 * float(np.max(found.model.energy(found.q, found.u)[0]))


@pytest.mark.hard
def test_random_driven_mechanisms_reach_their_end(workshop: Workshop) -> None:
    wrong, stopped = [], []
    runs = driven(many(100, 1000), 7)
    for one in runs:
        found = run(workshop.model, one)
        wrong += [f"{one}: {fault}" for fault in faults(found, one)]
        stopped += [] if found.success else [f"{one}: {found.message}"]
    print("\n".join([*wrong, *stopped, f"{len(runs) - len(stopped)} of {len(runs)} reach their end"]))
    assert not wrong, "\n".join(wrong)
    assert len(stopped) <= MOST * max(1, len(runs) // 500), "\n".join(stopped)
