"""Impacts that would gain energy: what decides, and that smooth ones are asked as well."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.runtime import simulate

from ..support.workshop import Workshop

DRIVEN = """name = "driven"
[ground_link]
points = { O = [0, 0] }
[[drive]]
joint = "p0"
speed = 2.0
[gravity]
[[ground]]
point = [0, -1.2]
restitution = 0.7
friction = 0.5
contacts = ["r2.B"]
[start]
angles = [0.0, -0.5, -0.5]
""" + "".join(
    f"""[[link]]
name = "r{i}"
mass = 1.0
inertia = {length**2 / 12}
com = [{length / 2}, 0]
points = {{ A = [0, 0], B = [{length}, 0] }}
[[joint]]
name = "p{i}"
between = ["{"ground.O" if i == 0 else f"r{i - 1}.B"}", "r{i}.A"]
"""
    for i, length in enumerate((0.5, 1.0, 1.0))
)


def given(model: Any, q: Any, u: Any, after: Any, P: Any) -> float:
    """Energy (J) that the contact gives: half the impulse times the rates before and after."""
    of = [[model.kernels.of_state(name, q[None], x[None])[0] for x in (u, after)] for name in ("gap_rates", "slips")]
    return float(sum(0.5 * impulse * (one[0] + two[0]) for impulse, (one, two) in zip(P, of, strict=True)))


def test_restitution_beside_a_drive_is_decided_by_what_contacts_give(workshop: Workshop) -> None:
    """A drive does work in an impact, at e = 0 too, which is no fault of restitution: the run goes on with the largest
    part of restitution with which the contact gives nothing, as a bisection by hand finds it."""
    model, rng = workshop.model(DRIVEN), np.random.default_rng(0)
    contact, found = np.array([0], dtype=np.int32), 0
    for _ in range(20000):
        q, u = rng.uniform(-np.pi, np.pi, 3), np.array([2.0, *rng.normal(size=2) * 4])
        if model.kernels.impact(q, u, contact, np.array([0.7]))[2] != "gained":
            continue
        below, above = 0.0, 1.0
        for _ in range(40):
            share = 0.5 * (below + above)
            after, P, outcome = model.kernels.impact(q, u, contact, np.array([0.7 * share]))
            more = outcome != "done" or given(model, q, u, after, P) > 0.0
            below, above = (below, share) if more else (share, above)
        height = 0.5 * np.sin(q[0]) + np.sin(q[1]) + np.sin(q[2]) - 1e-7
        run = simulate(model.with_parameters({"ground_0.point.y": float(height)}), q, u, until=1e-4)
        assert run.success, run.message
        if run.impacts:
            found += 1
            assert run.impacts[0].restitution_share == pytest.approx(below, abs=1e-4)
        if found == 25:
            return
    pytest.fail(f"only {found} of 20,000 states gain energy and strike")


HINGED = """name = "hinged"
[[link]]
name = "rod"
rod = { mass = 1.0 }
points = { A = [0, 0], B = [1.0, 0] }
[ground_link]
points = { O = [0, 0] }
[[joint]]
name = "pin"
between = ["ground.O", "rod.A"]
[start]
angles = { rod = "100 deg" }
angular_velocities = { rod = -3 }
[gravity]
[[ground]]
name = "wall"
point = [0.8, 0]
normal = [-1, 0]
restitution = 0.3
friction = 1.5
contacts = ["rod.B"]
"""


@pytest.mark.parametrize(("friction", "springs"), [(1.5, False), (0.8, False), (0.7, True), (0.2, True)])
def test_a_hinged_rod_springs_back_unless_it_is_wedged(friction: float, springs: bool, workshop: Workshop) -> None:
    """Its end strikes the wall 0.8 beside and 0.6 above the pin. Springing back it slides down, so friction μ P at the
    arm 0.8 works against the wall's push P at the arm 0.6: from μ = 3/4 on nothing lets it come back."""
    run = simulate(workshop.model(HINGED), until=0.5, params={"wall.friction": friction})
    assert run.success, run.message
    assert not [phase for phase in run.phases if phase.kind == "steps"]
    impact = run.impacts[0]
    moving = 0.5 * impact.u_minus[0] ** 2 / 3.0
    if springs:
        assert impact.restitution_share == 1.0
        assert impact.u_plus[0] == pytest.approx(-0.3 * impact.u_minus[0], rel=1e-12)
        assert impact.energy_loss == pytest.approx((1.0 - 0.3**2) * moving, rel=1e-12)
    else:
        assert impact.restitution_share < 1e-6
        assert abs(impact.u_plus[0]) < 1e-6 * abs(impact.u_minus[0])
        assert impact.energy_loss == pytest.approx(moving, rel=1e-12)


ROD = """name = "rod"
[[link]]
name = "rod"
mass = 1.0
inertia = 0.08333333333333333
com = [0.5, 0]
points = { A = [0, 0], B = [1.0, 0] }
[gravity]
[[ground]]
name = "elastic"
restitution = 1.0
contacts = ["rod.A"]
[[ground]]
name = "dead"
restitution = 0.0
contacts = ["rod.B"]
"""


@pytest.mark.parametrize("leaving", [0.5, 1e-3, 1e-6])
def test_smooth_impacts_are_asked_what_they_gain(leaving: float, workshop: Workshop) -> None:
    """A rod strikes with an elastic end while its dead end leaves: Newton's law would keep that from leaving, and the
    rod would gain a third of its energy, or a tenth of ``leaving`` of it."""
    model = workshop.model(ROD)
    q, u = np.zeros(3), np.array([0.0, -1.0, 1.0 + leaving])
    both = np.array([0, 1], dtype=np.int32)
    after, _, outcome = model.kernels.impact(q, u, both, np.array([1.0, 0.0]))
    energies = [float(np.sum(model.energy(q[None], x[None]))) for x in (u, after)]
    assert outcome == "gained" and energies[1] > energies[0]
    resting = np.array([0.0, -1.0, 1.0 - leaving])  # it approaches too: nothing is gained
    after, _, outcome = model.kernels.impact(q, resting, both, np.array([1.0, 0.0]))
    energies = [float(np.sum(model.energy(q[None], x[None]))) for x in (resting, after)]
    assert outcome == "done" and energies[1] <= energies[0] * (1 + 1e-12)
