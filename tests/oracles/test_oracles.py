"""The references themselves, against closed forms and against each other."""

from __future__ import annotations

import numpy as np
import pytest

from . import maximal, mechanisms, polygons, textbook

MATERIALS = [(1.0, 1.0, 0.5), (0.7, 1.3, 0.3)]


@pytest.mark.parametrize("landing", polygons.LANDINGS, ids=lambda landing: landing.name)
@pytest.mark.parametrize(("length", "mass", "e"), MATERIALS)
def test_maximal_impact_is_the_closed_form(landing: polygons.Landing, length: float, mass: float, e: float) -> None:
    speed = 1.7
    system = polygons.ring(landing.n, length, mass)
    poses = polygons.regular(landing.n, length, landing.tilt)
    falling = np.tile([0.0, -speed, 0.0], (landing.n, 1))
    contacts = [polygons.corner(landing.n, j) for j in landing.joints]
    jump = maximal.impact(system, poses, falling, contacts, e)
    centre = maximal.centre_velocities(system, poses, jump.velocities).mean(axis=0)
    assert np.allclose(jump.inverse * mass, landing.inverse, rtol=0, atol=2e-15)
    assert np.allclose(jump.impulses, landing.impulse * (1 + e) * mass * speed, rtol=2e-15)
    assert np.allclose(centre[:2], (0, -speed + landing.lift * (1 + e) * speed), rtol=0, atol=5e-15)
    spins = np.asarray(landing.spins) * (1 + e) * speed / length
    assert np.allclose(jump.velocities[:, 2], spins, rtol=0, atol=2e-14)
    assert jump.loss == pytest.approx((1 - e**2) * landing.loss * mass * speed**2 / 2, rel=1e-14)


@pytest.mark.parametrize("family", mechanisms.FAMILIES)
def test_power_of_the_motion_is_that_of_gravity(family: str) -> None:
    """d/dt of the kinetic energy and of the momenta, from the accelerations."""
    drawing = mechanisms.FAMILIES[family](3 if family == "ladder" else 7)
    system, poses = drawing.system, drawing.poses
    assert maximal.opening(system, poses) < 1e-14
    rng = np.random.default_rng(3)
    velocities = maximal.project(system, poses, rng.normal(size=poses.shape))
    motion = maximal.accelerate(system, poses, velocities)
    centre = maximal.centre_velocities(system, poses, velocities)
    arm = maximal.turned(poses[:, 2].astype(maximal.WIDE), system.com)
    pull = motion.frames.copy()
    pull[:, 0] -= motion.frames[:, 2] * arm[:, 1] + velocities[:, 2] ** 2 * arm[:, 0]
    pull[:, 1] += motion.frames[:, 2] * arm[:, 0] - velocities[:, 2] ** 2 * arm[:, 1]
    inertia = np.stack([system.mass, system.mass, system.inertia], axis=1)
    power = (inertia * centre * pull).sum()
    assert power == pytest.approx(-(system.mass * system.gravity * centre[:, 1]).sum(), rel=1e-13, abs=1e-13)
    if not any(maximal.GROUND in (pin.a, pin.b) for pin in system.pins):
        assert np.allclose(system.mass @ pull[:, :2] / system.mass.sum(), (0, -system.gravity), rtol=0, atol=1e-13)


def test_pendulum_reaction() -> None:
    """A rod let go level: a = 3 g / 2 l, and the hinge carries a quarter of the weight."""
    system = maximal.System(
        np.array([2.0]), np.array([2.0 / 12]), np.array([[0.5, 0.0]]),
        (maximal.Pin(maximal.GROUND, (0.0, 0.0), 0, (0.0, 0.0)),), 9.81,
    )  # fmt: skip
    motion = maximal.accelerate(system, np.zeros((1, 3)), np.zeros((1, 3)))
    assert motion.frames[0] == pytest.approx([0, 0, -1.5 * 9.81], abs=1e-14)
    assert motion.forces[0] == pytest.approx([0, 2.0 * 9.81 / 4], abs=1e-14)


def test_complementary_drops_the_contact_that_would_pull() -> None:
    matrix = np.array([[2.0, -1.0], [-1.0, 2.0]])
    assert maximal.complementary(matrix, np.array([-2.0, 1.0])) == pytest.approx([1.0, 0.0])
    assert maximal.complementary(matrix, np.array([-1.0, -1.0])) == pytest.approx([1.0, 1.0])
    assert maximal.complementary(matrix, np.array([1.0, 1.0])) == pytest.approx([0.0, 0.0])


@pytest.mark.sample(2)
@pytest.mark.parametrize("method", ["kane", pytest.param("lagrange", marks=pytest.mark.hard)])
@pytest.mark.parametrize(("family", "n"), [("open", 2), ("open", 3), ("hinged", 2), ("pinned", 3), ("floating", 3)])
def test_textbook_methods_agree_with_maximal(method: str, family: str, n: int) -> None:
    drawing = mechanisms.FAMILIES[family](n)
    system, poses = mechanisms.in_a_row(drawing), drawing.poses
    rng = np.random.default_rng(11)
    velocities = maximal.project(system, poses, rng.normal(size=poses.shape)).astype(float)
    motion = maximal.accelerate(system, poses, velocities)
    free = not any(maximal.GROUND in (pin.a, pin.b) for pin in system.pins)
    rates, force = getattr(textbook, method)(system)(
        *(np.concatenate([x[0, :2], x[:, 2]] if free else [x[:, 2]]) for x in (poses, velocities))
    )
    wanted = np.concatenate([motion.frames[0, :2], motion.frames[:, 2]] if free else [motion.frames[:, 2]])
    assert rates == pytest.approx(wanted.astype(float), rel=1e-12, abs=1e-12)
    if force.size:
        assert force == pytest.approx(motion.forces[-1].astype(float), rel=1e-12, abs=1e-12)
