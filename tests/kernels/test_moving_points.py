"""Velocities and accelerations of points, joint angles, masses and motions, against closed forms and differences."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest

from ccgen.generator import load_scene

from ..oracles.maximal import GROUND, Array
from ..support.drawn_linkages import BASE, COUPLER, CRANK, ROCKER, four_bar
from ..support.folders import SCENES
from ..support.mixed_joints import KINDS, mixed
from ..support.workshop import Workshop

HINGED = 'name = "hinged"\n[chain]\nlinks = 1\nhinged = true\nlength = 2.0\nmass = 3.0\n[gravity]\ng = 9.81\n'
DOUBLE = HINGED.replace("links = 1", "links = 2").replace('"hinged"', '"double"')


@pytest.fixture(params=range(len(KINDS)))
def mechanism(request: pytest.FixtureRequest, workshop: Workshop) -> tuple[Any, Array, Array]:
    return mixed(workshop, request.param)


def derivative(values: Array, h: float) -> Array:
    """First derivative in the middle of nine values h apart, to h⁸."""
    weights = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
    return np.asarray(np.tensordot(weights, values, axes=1) / h)


# -- points ------------------------------------------------------------------------------------------------------------


@pytest.mark.quick
def test_tip_of_a_turning_rod(workshop: Workshop) -> None:
    model, r, w, turning = workshop.model(HINGED), 2.0, 3.0, 5.0
    c, s = np.cos(0.3), np.sin(0.3)
    assert model.point_velocity("link_0.B", [0.3], [w]) == pytest.approx([-r * w * s, r * w * c], rel=1e-15)
    wanted = [-r * w**2 * c - r * turning * s, -r * w**2 * s + r * turning * c]
    assert model.point_acceleration("link_0.B", [0.3], [w], u_dot=[turning]) == pytest.approx(wanted, rel=1e-15)
    falling = -3.0 * 9.81 * c / 4.0  # of a rod of length 2 about its end
    wanted = [-r * w**2 * c - r * falling * s, -r * w**2 * s + r * falling * c]
    assert model.point_acceleration("link_0.B", [0.3], [w]) == pytest.approx(wanted, rel=1e-14)
    assert model.point_jacobian("link_0.B", [[0.3], [0.4]]).shape == (2, 2, 1)
    many = model.point_acceleration("link_0.B", [[0.3], [0.4]], [[w], [0.0]], u_dot=[[turning], [1.0]])
    assert many[1] == pytest.approx([-r * np.sin(0.4), r * np.cos(0.4)], rel=1e-15)
    for still in (model.point_velocity("joint_0", [0.3], [w]), model.point_acceleration("joint_0", [0.3], [w])):
        assert np.array_equal(still, [0.0, 0.0])


@pytest.mark.parametrize(("precision", "digits"), [("float", 1e-6), ("wide", 1e-15)])
def test_points_in_other_numbers(precision: str, digits: float, workshop: Workshop) -> None:
    model = workshop.model(HINGED, precision)
    found = model.point_acceleration("link_0.B", [0.3], [3.0], u_dot=[5.0])
    wanted = [-18.0 * np.cos(0.3) - 10.0 * np.sin(0.3), -18.0 * np.sin(0.3) + 10.0 * np.cos(0.3)]
    assert found.dtype == model.core.REAL and np.max(np.abs(found - wanted)) <= 20.0 * digits
    assert model.mass_matrix([0.3]).dtype == model.core.REAL
    with pytest.raises(ValueError, match=rf'found a model in precision="{precision}", expected "double" for motions'):
        model.motions([0.3])


def test_piston(workshop: Workshop) -> None:
    """x = r cos θ + √(l² − r² sin² θ), differentiated twice."""
    model, r, length = workshop.model(load_scene(SCENES / "slider-crank.toml")), 0.2, 0.6
    q, u = model.start()
    turn = model.acceleration(q, u)[0]
    with mpmath.workdps(40):
        way = lambda a: r * mpmath.cos(a) + mpmath.sqrt(length**2 - r**2 * mpmath.sin(a) ** 2)  # noqa: E731
        slope, bend = (float(mpmath.diff(way, mpmath.mpf(float(q[0])), n)) for n in (1, 2))
    assert model.point_velocity("slider.C", q, u) == pytest.approx([slope * u[0], 0.0], rel=1e-13, abs=1e-13)
    wanted = [bend * u[0] ** 2 + slope * turn, 0.0]
    assert model.point_acceleration("slider.C", q, u) == pytest.approx(wanted, rel=1e-12, abs=1e-11)
    assert model.slide_rates(q, u)["guide"] == pytest.approx(slope * u[0], rel=1e-13)


def test_coupler_of_a_four_bar(workshop: Workshop) -> None:
    """The coupler's angle by Freudenstein's equation, solved for its half tangent; its mid-point from that."""
    model = workshop.model(four_bar({"angles": {"crank": 1.0, "coupler": 0.6, "rocker": 1.8}}))
    q, _ = model.start()
    u = 4.0 * model.motions(q)[:, 0]
    turning = model.acceleration(q, u)

    def middle(crank: Any) -> Any:
        """Of crank a, coupler b, rocker c and base d, in the plane of complex numbers."""
        a, b, c, d = (mpmath.mpf(x) for x in (CRANK, COUPLER, ROCKER, BASE))
        k1, k4, k5 = d / a, d / b, (c**2 - d**2 - a**2 - b**2) / (2 * a * b)
        big = mpmath.cos(crank) - k1 + k4 * mpmath.cos(crank) + k5
        mid, small = -2 * mpmath.sin(crank), k1 + (k4 - 1) * mpmath.cos(crank) + k5
        root = mpmath.sqrt(mid**2 - 4 * big * small)
        angles = [2 * mpmath.atan((-mid + sign * root) / (2 * big)) for sign in (1, -1)]
        coupler = min(angles, key=lambda angle: abs(mpmath.sin((angle - q[1]) / 2)))
        return a * mpmath.expj(crank) + b / 2 * mpmath.expj(coupler)

    with mpmath.workdps(40):
        place, slope, bend = (complex(mpmath.diff(middle, mpmath.mpf(float(q[0])), n)) for n in (0, 1, 2))
    ends = [model.point(f"coupler.{end}", q) for end in "AB"]
    assert np.mean(ends, axis=0) == pytest.approx([place.real, place.imag], abs=1e-14)
    found = np.mean([model.point_velocity(f"coupler.{end}", q, u) for end in "AB"], axis=0)
    wanted = slope * u[0]
    assert found == pytest.approx([wanted.real, wanted.imag], rel=1e-12)
    found = np.mean([model.point_acceleration(f"coupler.{end}", q, u) for end in "AB"], axis=0)
    wanted = bend * u[0] ** 2 + slope * turning[0]
    assert found == pytest.approx([wanted.real, wanted.imag], rel=1e-11)


def test_points_of_random_mechanisms(mechanism: tuple[Any, Array, Array]) -> None:
    """All points, for any u and u̇, against differences of places along q + u t + u̇ t²/2."""
    model, q, u = mechanism
    u_dot, h = np.random.default_rng(4).normal(size=len(q)), 1e-2
    t = h * np.arange(-4, 5)[:, None]
    path, rates = q + u * t + u_dot * t**2 / 2, u + u_dot * t
    for name in model.points:
        velocity, acceleration = model.point_velocity(name, q, u), model.point_acceleration(name, q, u, u_dot=u_dot)
        assert velocity == pytest.approx(derivative(model.point(name, path), h), abs=1e-9)
        assert acceleration == pytest.approx(derivative(model.point_velocity(name, path, rates), h), abs=1e-9)
        assert model.point_jacobian(name, q) @ u == pytest.approx(velocity, abs=1e-13)


def test_joints_of_random_mechanisms(mechanism: tuple[Any, Array, Array]) -> None:
    model, q, u = mechanism
    h = 1e-2
    path, poses = q + u * h * np.arange(-4, 5)[:, None], model.poses(q)
    angles, rates = model.joint_angles(q), model.joint_rates(q, u)
    slides = {name for name, line in model.data["lines"].items() if line["angle"] is not None}
    assert set(angles) == set(rates) == set(model.joints) - slides
    for name, angle in model.joint_angles(path).items():
        first, second = model.data["between"][model.joints.index(name)]
        sides = [0.0 if link == GROUND else poses[link, 2] for link in (first, second)]
        assert angles[name] == sides[1] - sides[0]
        assert rates[name] == pytest.approx(derivative(angle, h), abs=1e-10)
    for name, length in model.slides(path).items():
        assert model.slide_rates(q, u)[name] == pytest.approx(derivative(length, h), abs=1e-9)


# -- masses and motions ------------------------------------------------------------------------------------------------


def test_masses_of_a_double_pendulum(workshop: Workshop) -> None:
    """In absolute angular velocities: m (l²/3 + l²), m l²/3 and m l²/2 cos(θ₁ − θ₀), for rods of 3 kg and 2 m."""
    model = workshop.model(DOUBLE)
    across = 6.0 * np.cos(0.8)
    assert np.allclose(model.mass_matrix([0.3, 1.1]), [[16.0, across], [across, 4.0]], rtol=1e-15)
    assert model.mass_matrix([[0.3, 1.1], [0.0, 0.0]]).shape == (2, 2, 2)


def test_masses_of_random_mechanisms(mechanism: tuple[Any, Array, Array]) -> None:
    model, q, _ = mechanism
    mass = model.mass_matrix(q)
    assert np.array_equal(mass, mass.T)
    for u in np.random.default_rng(5).normal(size=(20, len(q))):
        assert u @ mass @ u / 2.0 == pytest.approx(model.energy(q, u)[0], rel=1e-12)


def test_motions_of_random_mechanisms(mechanism: tuple[Any, Array, Array]) -> None:
    model, q, u = mechanism
    check_motions(model, q, model.dof)
    found = model.motions(q)
    assert found @ (found.T @ model.mass_matrix(q) @ u) == pytest.approx(u, abs=1e-11)  # u keeps loops shut


def check_motions(model: Any, q: Array, count: int) -> None:
    found = model.motions(q)
    assert found.shape == (len(q), count)
    if model.rows:
        assert np.max(np.abs(model.jacobian(q) @ found)) <= 1e-13 * model.length * np.max(np.abs(found))
    assert np.allclose(found.T @ model.mass_matrix(q) @ found, np.eye(count), rtol=0, atol=1e-11)
    for k in range(count):  # each column has a coordinate that moves forward in it and in no later one
        assert any(found[i, k] > 0.0 and not np.any(found[i, k + 1 :]) for i in range(len(q)))
    assert np.array_equal(model.motions(q), found)


def test_motions_are_what_impulses_give(workshop: Workshop) -> None:
    """Of a double pendulum: the first by an impulse at the upper rod, the second with that rod at rest."""
    model = workshop.model(DOUBLE)
    q = np.array([0.3, 1.1])
    found = model.motions(q)
    jump = np.linalg.inv(model.mass_matrix(q))
    assert found[:, 0] == pytest.approx(jump[:, 0] / np.sqrt(jump[0, 0]), rel=1e-13)
    assert found[:, 1] == pytest.approx([0.0, 0.5], rel=1e-13)  # of a rod with m l²/3 = 4


def test_a_parallelogram_in_line_has_one_motion_more(workshop: Workshop) -> None:
    model = workshop.model(load_scene(SCENES / "parallelogram.toml"))
    q, _ = model.start()
    check_motions(model, q, 1)
    alike = 1.0 / np.sqrt(1 / 3 + 1 / 3 + 1.5)  # two rods of 1 kg that turn, and 1.5 kg that go with their ends
    assert model.motions(q)[:, 0] == pytest.approx([alike, 0.0, alike], abs=1e-14)
    check_motions(model, np.zeros(3), 2)


def test_motions_hold_driven_joints_still(workshop: Workshop) -> None:
    driven = workshop.model(DOUBLE + '[[drive]]\njoint = "joint_1"\nspeed = 2.0\n')
    found = driven.motions([0.3, 1.1])
    assert found.shape == (2, 1) and found[0, 0] == pytest.approx(found[1, 0], rel=1e-14)
    held = workshop.model(HINGED + '[[drive]]\njoint = "joint_0"\nspeed = 2.0\n')
    assert held.motions([0.3]).shape == (1, 0)


# -- wrong use ---------------------------------------------------------------------------------------------------------


@pytest.mark.quick
def test_wrong_questions_are_refused(workshop: Workshop) -> None:
    model = workshop.model(HINGED)
    for ask in (model.point_velocity, model.point_acceleration):
        with pytest.raises(ValueError, match=r"found point 'tip', expected one of: joint_0, link_0\.A, link_0\.B"):
            ask("tip", [0.3], [1.0])
    with pytest.raises(ValueError, match=r"u_dot: found 2 rows, expected 1, one per state"):
        model.point_acceleration("link_0.B", [0.3], [1.0], u_dot=[[1.0], [2.0]])
    with pytest.raises(ValueError, match=r"u_dot: found beside inputs or contacts, expected alone"):
        model.point_acceleration("link_0.B", [0.3], [1.0], u_dot=[1.0], contacts=())
    with pytest.raises(ValueError, match=r"q: found shape \(2, 1\), expected \(1,\): configurations may differ"):
        model.motions([[0.3], [0.4]])
    for ask in (model.mass_matrix, model.motions, model.joint_angles):
        with pytest.raises(ValueError, match=r"q: found shape \(2,\), expected \(1,\)"):
            ask([0.3, 0.4])
