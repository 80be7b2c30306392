"""Long flight: exact invariants, an independent integration, the order of the method, and states between the rows."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ..oracles import flight, maximal, mechanisms, polygons
from ..oracles.maximal import Array
from ..support.tiers import hard
from ..support.workshop import Workshop

G = 9.81
END = 10.0


@pytest.fixture(scope="module", params=[0.0, G], ids=["weightless", "falling"])
def gravity(request: pytest.FixtureRequest) -> float:
    return float(request.param)


@pytest.fixture(scope="module")
def model(workshop: Workshop, gravity: float) -> Any:
    from ccgen.generator import loop

    return workshop.model(loop(6, gravity=bool(gravity)))


@pytest.fixture(scope="module")
def start(model: Any) -> tuple[Array, Array]:
    q, u = model.state_from_poses(*polygons.perturbed(6))
    return q, u


@pytest.fixture(scope="module")
def run(model: Any, start: tuple[Array, Array]) -> Any:
    from ccgen.runtime import simulate

    return simulate(model, *start, until=END, rtol=1e-12)


@pytest.fixture(scope="module")
def reference(model: Any, gravity: float) -> tuple[Array, Array, Array]:
    """Times, poses and velocities of the independent integration."""
    times = np.linspace(0.0, END, 41)
    return times, *flight.fly(polygons.ring(6, gravity=gravity), *polygons.perturbed(6), times)


def ring_opening(angles: Array) -> float:
    """How far a ring of unit rods is from closed, from the angles alone."""
    wide = angles.astype(maximal.WIDE)
    return float(max(np.abs(np.cos(wide).sum(axis=-1)).max(), np.abs(np.sin(wide).sum(axis=-1)).max()))


def test_momenta(run: Any, gravity: float) -> None:
    """Horizontal momentum, vertical momentum + M g t, and angular momentum about the mass centre, to 1e-11."""
    system = polygons.ring(6, gravity=gravity)
    found = []
    for t, q, u in zip(run.t, run.q, run.u, strict=True):
        momenta = maximal.momenta(system, run.model.poses(q), run.model.velocities(q, u))
        momenta[1] += 6 * gravity * t
        found.append(momenta)
    drift = np.abs(np.array(found) - found[0]).max(axis=0)
    assert np.all(drift <= 1e-11)


def test_energy(run: Any, gravity: float) -> None:
    """To 1e-11 of its value, by the model's account and by the reference's."""
    system = polygons.ring(6, gravity=gravity)
    energies = np.sum(run.model.energy(run.q, run.u), axis=0)
    assert np.max(np.abs(energies / energies[0] - 1)) <= 1e-11
    states = zip(run.model.poses(run.q), run.model.velocities(run.q, run.u), strict=True)
    energies = np.array([sum(maximal.energy(system, *state)) for state in states])
    assert np.max(np.abs(energies / energies[0] - 1)) <= 1e-11
    assert run.energy_drift <= 1e-11 * energies[0]


def test_closure(run: Any) -> None:
    """At every recorded row and between the rows, by the model's account and from the angles alone."""
    assert run.success
    assert run.t[-1] == END
    between, _ = run.at(np.linspace(0.0, END, 301))
    for q in (run.q, between):
        assert np.max(np.abs(run.model.closure(q))) <= 1e-13
        assert ring_opening(run.model.poses(q)[:, :, 2]) <= 1e-13
    assert run.closure_max <= 1e-13


def test_recorded_velocities_keep_the_loop_shut(run: Any) -> None:
    for q, u in zip(run.q[::7], run.u[::7], strict=True):
        poses, velocities = run.model.poses(q), run.model.velocities(q, u)
        system = polygons.ring(6)
        centre = maximal.centre_velocities(system, poses, velocities).ravel()
        centre[1::3] -= centre[1::3].mean()
        speeds = maximal.jacobian(system, poses[:, 2]) @ centre
        assert np.max(np.abs(speeds)) <= 1e-12


@pytest.mark.sample(1)
def test_motion_is_that_of_the_reference(run: Any, reference: tuple[Array, Array, Array]) -> None:
    """All poses and velocities of all links at 41 times, most of them between the run's own rows."""
    times, poses, velocities = reference
    q, u = run.at(times)
    assert np.max(np.abs(run.model.poses(q)[:, :, 2] - poses[:, :, 2])) <= 1e-10
    assert np.max(np.abs(run.model.velocities(q, u)[:, :, 2] - velocities[:, :, 2])) <= 1e-10
    assert np.max(np.abs(run.model.poses(q)[:, :, :2] - poses[:, :, :2])) <= 1e-10
    assert np.max(np.abs(run.model.velocities(q, u)[:, :, :2] - velocities[:, :, :2])) <= 1e-10


def test_change_of_shape_does_not_feel_gravity(workshop: Workshop) -> None:
    from ccgen.generator import loop
    from ccgen.runtime import simulate

    angles = []
    for weight in (False, True):
        model = workshop.model(loop(6, gravity=weight))
        q, u = model.state_from_poses(*polygons.perturbed(6))
        run = simulate(model, q, u, until=3.0, rtol=1e-12)
        angles.append(model.poses(run.q[-1])[:, 2])
    assert np.max(np.abs(angles[1] - angles[0])) <= 1e-11


def _end_error(model: Any, start: tuple[Array, Array], wanted: Array, rtol: float) -> tuple[float, int]:
    """Largest error of an angle after 2 s, and the evaluations that it took."""
    from ccgen.runtime import simulate

    run = simulate(model, *start, until=2.0, rtol=rtol, method="dop853")
    assert run.success
    return float(np.max(np.abs(run.model.poses(run.q[-1])[:, 2] - wanted))), run.nfev


SMOOTH = [("open", 3, (32, 40, 48, 56)), ("floating", 5, (24, 32, 40, 48))]
"""Weightless motions, and numbers of steps between the last wild and the first rounding-limited one."""


@pytest.mark.sample(1)
@pytest.mark.parametrize(("family", "n", "counts"), SMOOTH, ids=str)
def test_order_of_the_method(family: str, n: int, counts: tuple[int, ...], workshop: Workshop) -> None:
    """With fixed steps the error of DOP853 falls with the eighth power of the step."""
    from ccgen.runtime import simulate

    drawing = mechanisms.FAMILIES[family](n)
    drawing = replace(drawing, system=drawing.system.with_gravity(0.0), name=f"weightless_{drawing.name}")
    model = workshop.model(drawing.toml())
    q, _ = model.state_from_poses(drawing.poses, 0 * drawing.poses)
    q, u = model.project(q, np.random.default_rng(1).normal(size=len(model.u_names)))
    times = np.linspace(0.0, 4.0, 9)
    wanted = flight.fly(drawing.system, model.poses(q), model.velocities(q, u), times)[0][:, :, 2]
    errors = []
    for count in counts:
        run = simulate(model, q, u, until=4.0, rtol=1e-3, step=4.0 / count, method="dop853")
        assert run.success
        assert len(run.t) == count + 1
        errors.append(np.sqrt(np.mean((model.poses(run.q[:: count // 8])[:, :, 2] - wanted) ** 2)))
    order = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert 7.5 <= order <= 9.0


def test_error_follows_the_tolerance(model: Any, start: tuple[Array, Array], gravity: float) -> None:
    """The error of DOP853 stays near the tolerance asked, and costs evaluations as an eighth-order method's does."""
    system = polygons.ring(6, gravity=gravity)
    wanted = flight.fly(system, *polygons.perturbed(6), np.array([0.0, 2.0]))[0][-1, :, 2]
    tolerances = 10.0 ** -np.arange(4, 12)
    found = [_end_error(model, start, wanted, rtol=float(rtol)) for rtol in tolerances]
    errors, evaluations = np.array(found).T
    assert np.all(errors <= 10 * tolerances)
    assert 6.5 <= -np.polyfit(np.log(evaluations), np.log(errors), 1)[0] <= 10.5


@pytest.mark.sample(1)
@pytest.mark.parametrize("family", [hard("pinned"), "open", hard("hinged"), "two_loops", hard("ladder")])
def test_other_mechanisms_fly_as_the_reference(family: str, workshop: Workshop) -> None:
    """Random link data, held or free, one second."""
    from ccgen.runtime import simulate

    drawing = mechanisms.FAMILIES[family]({"two_loops": 7, "ladder": 2}.get(family, 5))
    model = workshop.model(drawing.toml())
    rng = np.random.default_rng(2)
    q, _ = model.state_from_poses(drawing.poses, 0 * drawing.poses)
    q, u = model.project(q, rng.normal(size=len(model.u_names)))
    times = np.linspace(0.0, 1.0, 5)
    poses, velocities = flight.fly(drawing.system, model.poses(q), model.velocities(q, u), times)
    run = simulate(model, q, u, until=1.0, rtol=1e-12)
    assert run.success
    assert run.closure_max <= 1e-13
    found_q, found_u = run.at(times)
    assert np.max(np.abs(model.poses(found_q) - poses)) <= 1e-10
    assert np.max(np.abs(model.velocities(found_q, found_u) - velocities)) <= 1e-9
