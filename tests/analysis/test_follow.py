"""Inverse kinematics along paths, and the forces of the motion: closed forms of each leg, and the balance of power."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import OutOfReach, follow, inverse_dynamics, reach

from ..oracles.maximal import Array
from ..support.folders import SCENES
from ..support.platforms import ARM, BASE, CRANK, FEET, FIVE_BAR, FORE, LEG, RIM, STOPPED, UPPER, three_legs
from ..support.workshop import Workshop

DIFFERENCE = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
"""First derivative in the middle of nine values, to the eighth power of the time between them."""


def platform_path(t: Array) -> tuple[Array, Array]:
    """Places (3, n, 2) and angles (3, n) of a platform, each with its first and second derivatives."""
    w = 2.0 * np.pi
    s, c = np.sin(w * t), np.cos(w * t)
    places = [[0.05 * s, 0.03 * (1.0 - c)], [0.05 * w * c, 0.03 * w * s], [-0.05 * w**2 * s, 0.03 * w**2 * c]]
    return np.array(places).transpose(0, 2, 1), 0.2 * np.array([s, w * c, -(w**2) * s])


def crank_angle(k: int, t: Array, elbow: float) -> Array:
    """The angle of crank k by the cosine rule, on the side ``elbow`` of the way from its foot to the platform."""
    places, angles = platform_path(t)
    foot = BASE * np.exp(1j * FEET[k])
    way = places[0] @ [1.0, 1j] + RIM * np.exp(1j * (FEET[k] + angles[0])) - foot
    bend = np.arccos((CRANK**2 + np.abs(way) ** 2 - LEG**2) / (2.0 * CRANK * np.abs(way)))
    return np.asarray(np.angle(way) + elbow * bend)


@pytest.fixture(scope="module")
def platform(workshop: Workshop) -> Any:
    return workshop.model(three_legs())


def test_three_legs_carry_a_platform(platform: Any) -> None:
    q, _ = platform.start()
    t = np.linspace(0.0, 1.0, 41)
    places, angles = platform_path(t)
    found = follow(platform, q, {"platform.C": places}, {"platform": angles})
    assert np.max(np.abs(platform.closure(found.q))) <= 1e-14
    h, middle = 1e-3, np.arange(-4, 5)
    for k in range(3):
        crank = platform.q_names.index(f"theta_{platform.links.index(f'arm{k}')}")
        side = min((1.0, -1.0), key=lambda elbow: abs(np.sin((crank_angle(k, t[:1], elbow)[0] - q[crank]) / 2)))
        miss = found.q[:, crank] - crank_angle(k, t, side)
        assert np.max(np.abs(np.remainder(miss + np.pi, 2 * np.pi) - np.pi)) <= 1e-12
        assert found.u is not None and found.u_dot is not None
        around = np.unwrap([crank_angle(k, t + h * step, side) for step in middle], axis=0)
        assert found.u[:, crank] == pytest.approx(DIFFERENCE @ around / h, abs=1e-9)
        wide, far = 4e-3, np.arange(-8, 9)
        values = np.unwrap([crank_angle(k, t + wide * step, side) for step in far], axis=0)
        slopes = np.array([DIFFERENCE @ values[first : first + 9] / wide for first in range(9)])
        assert found.u_dot[:, crank] == pytest.approx(DIFFERENCE @ slopes / wide, abs=1e-6)


def test_torques_of_three_motors(platform: Any) -> None:
    """What they do in time is the change of the energy."""
    h = 1e-3
    t = 0.3 + h * np.arange(-4, 5)
    places, angles = platform_path(t)
    found = follow(platform, platform.start()[0], {"platform.C": places}, {"platform": angles})
    motors = [f"motor{k}" for k in range(3)]
    torques = inverse_dynamics(platform, found.q, found.u, found.u_dot, motors)
    rates = platform.joint_rates(found.q, found.u)
    power = sum(torques[4, k] * rates[motor][4] for k, motor in enumerate(motors))
    energy = np.sum(platform.energy(found.q, found.u), axis=0)
    assert power == pytest.approx(DIFFERENCE @ energy / h, abs=1e-9)


def test_accelerations_of_sliding_lengths(workshop: Workshop) -> None:
    """A slot that is cut, and a guide of the tree: the rates that follow from wanted lengths give these back."""
    for scene, joint in (("quick-return", "slot"), ("quick-return", "guide"), ("slider-crank", "guide")):
        model = workshop.model(load_scene(SCENES / f"{scene}.toml"))
        q = reach(model, model.start()[0], angles={"crank": 0.7})
        now = float(model.slides(q)[joint])
        found = follow(model, q, slides={joint: [[now], [0.3], [-0.7]]})
        assert found.u is not None and found.u_dot is not None
        assert model.slide_rates(found.q, found.u)[joint] == pytest.approx([0.3], rel=1e-12)
        h = 1e-3
        t = h * np.arange(-4, 5)[:, None]
        path = model.assemble(found.q + found.u * t + found.u_dot * t**2 / 2)  # differs from it by t³
        lengths = model.slides(path)[joint]
        assert (lengths[5] - 2.0 * lengths[4] + lengths[3]) / h**2 == pytest.approx(-0.7, abs=2e-4)


def test_a_path_without_rates_and_with_freedoms_left(workshop: Workshop) -> None:
    arm = workshop.model(ARM)
    way = np.linspace(0.0, 2.0 * np.pi, 60)
    circle = np.column_stack([0.6 + 0.2 * np.cos(way), 0.2 * np.sin(way)])
    found = follow(arm, [0.3, 0.9], {"fore.T": circle})
    assert found.u is None and found.u_dot is None
    assert arm.point("fore.T", found.q) == pytest.approx(circle, abs=1e-12)
    assert found.q[-1] == pytest.approx(found.q[0], abs=1e-11)
    heights = np.array([np.linspace(0.4, 0.6, 5), np.full(5, 0.2), np.zeros(5)])
    turned = follow(arm, [0.3, 0.9], angles={"elbow": heights})
    assert turned.u is not None and turned.u_dot is not None
    assert turned.u[:, 1] - turned.u[:, 0] == pytest.approx(np.full(5, 0.2), rel=1e-13)
    assert turned.u[:, 0] == pytest.approx(np.zeros(5), abs=1e-13)  # no more than what is wanted moves
    first = reach(arm, [0.3, 0.9], {"fore.T": tuple(circle[0])})
    assert np.array_equal(first, found.q[0])


def test_a_height_alone_is_followed(workshop: Workshop) -> None:
    """One coordinate is left open as in ``reach``: all joints move as little as they can, by Lagrange's condition."""
    arm = workshop.model(ARM)
    heights = np.linspace(0.3, 0.6, 7)
    found = follow(arm, [0.3, 0.9], {"fore.T": [(None, height) for height in heights]})
    assert arm.point("fore.T", found.q)[:, 1] == pytest.approx(heights, abs=1e-12)
    q = np.array([0.3, 0.9])
    for number, height in enumerate(heights):
        q = reach(arm, q, {"fore.T": (None, height)})
        assert found.q[number] == pytest.approx(q, abs=1e-12)
    sides = follow(arm, [0.3, 0.9], {"fore.T": [(0.6, None), (0.5, 0.4), (None, 0.5)]})
    places = arm.point("fore.T", sides.q)
    assert (places[0, 0], *places[1], places[2, 1]) == pytest.approx((0.6, 0.5, 0.4, 0.5), abs=1e-12)


def test_rates_of_a_height_alone(workshop: Workshop) -> None:
    """The other coordinate's rate is what the least joint rates make of it: J⁺ by the right inverse of one row."""
    arm = workshop.model(ARM)
    n = 4
    open_ = [None] * n
    path = [list(zip(open_, row, strict=True)) for row in ([0.4] * n, [0.2] * n, [0.0] * n)]
    found = follow(arm, [0.3, 0.9], {"fore.T": path})
    assert found.u is not None and found.u_dot is not None
    q1, q2 = found.q[0]
    row = np.array([UPPER * np.cos(q1), FORE * np.cos(q2)])  # of y by absolute angles
    metric = np.array([[2.0, -1.0], [-1.0, 1.0]])  # q₁² + (q₂ − q₁)²
    inverse = np.linalg.solve(metric, row)
    assert found.u[0] == pytest.approx(0.2 * inverse / (row @ inverse), rel=1e-12)
    v = arm.point_velocity("fore.T", found.q, found.u)
    assert v[:, 1] == pytest.approx(np.full(n, 0.2), rel=1e-12) and np.ptp(found.q[:, 0]) < 1e-12
    a = arm.point_acceleration("fore.T", found.q, found.u, u_dot=found.u_dot)
    assert a[:, 1] == pytest.approx(np.zeros(n), abs=1e-12)


@pytest.mark.parametrize(
    ("path", "what"),
    [
        ([(None, None)], r"points: fore\.T: found \(None, None\) at place 0, expected \(x, y\) in m, of which one may"),
        ([(0.5, 0.3), (None, None)], r"points: fore\.T: found \(None, None\) at place 1"),
        (
            [[(None, 0.3)], [(0.1, 0.0)], [(0.0, 0.0)]],
            "found None for a coordinate or a derivative of it alone at place 0",
        ),
        ([(float("nan"), 0.3)], "expected finite numbers"),
        ([None, (0.5, 0.3)], "points: fore"),
    ],
)
def test_what_cannot_be_left_open(path: Any, what: str, workshop: Workshop) -> None:
    with pytest.raises(ValueError, match=what):
        follow(workshop.model(ARM), [0.3, 0.9], {"fore.T": path})


def test_turning_right_round(workshop: Workshop) -> None:
    """Few places, each a sixth of a turn on: turns are counted, joints brought along in parts."""
    model = workshop.model(load_scene(SCENES / "four-bar.toml"))
    q, _ = model.start()
    turns = q[0] + np.pi / 3 * np.arange(13)
    found = follow(model, q, angles={"crank": turns})
    assert found.q[:, 0] == pytest.approx(turns, abs=1e-12)
    assert found.q[6, 1:] == pytest.approx(found.q[0, 1:], abs=1e-11)
    assert np.max(np.abs(model.closure(found.q))) <= 1e-14


def test_paths_that_leave_the_reach(workshop: Workshop) -> None:
    arm, rows = workshop.model(ARM), np.array([[0.6, 0.3], [0.9, 0.3], [1.2, 0.3]])
    with pytest.raises(OutOfReach, match=r"place 2: arm: points: fore\.T: found \(1\.2, 0\.3\) m") as caught:
        follow(arm, [0.3, 0.9], {"fore.T": rows})
    assert caught.value.misses["fore.T"] == pytest.approx(np.hypot(1.2, 0.3) - UPPER - FORE, abs=1e-12)
    with pytest.raises(OutOfReach, match="place 0: "):
        follow(arm, [0.3, 0.9], {"fore.T": rows[::-1]})


def test_a_stop_that_bars_the_way(workshop: Workshop) -> None:
    """Inwards the elbow bends past its stop at 60°; bent back it would reach the place."""
    arm = workshop.model(STOPPED)
    start = np.array([0.3, 0.3 + np.radians(50.0)])
    ways = [np.hypot(UPPER + FORE * np.cos(bend), FORE * np.sin(bend)) for bend in np.radians([50.0, 80.0])]
    with pytest.raises(ValueError, match=r"arm: place 1 is reached on another branch only, .* go another way"):
        follow(arm, start, {"fore.T": [[way, 0.0] for way in ways]})


def test_speeds_that_cannot_be_had(workshop: Workshop) -> None:
    """The five-bar's two cranks give its tip any velocity; its rods' angles as well would be too much."""
    model = workshop.model(FIVE_BAR)
    q, _ = model.start()
    tip, rise = model.point("tip", q), model.poses(q)[model.links.index("rise"), 2]
    moving = np.array([tip, [0.1, 0.0], [0.0, 0.0]])[:, None]
    with pytest.raises(ValueError, match="no velocities at place 0 give the wanted ones, which are off by"):
        follow(model, q, {"tip": moving}, {"rise": [[rise], [5.0], [0.0]]})


def test_wrong_paths_are_refused(workshop: Workshop) -> None:
    arm = workshop.model(ARM)
    with pytest.raises(ValueError) as caught:
        follow(arm, [0.3, 0.9], {"fore.T": [0.5, 0.6], "wrist": [[0, 0]]}, {"fore": [[0.1], [0.2]]})
    assert str(caught.value).splitlines() == [
        "points: name: found point 'wrist', expected one of: shoulder, elbow, upper.A, upper.B, fore.A, fore.T",
        "points: fore.T: found shape (2,), expected finite numbers (n, 2), or (3, n, 2) with first and second "
        "derivatives in time",
        "angles: fore: found shape (2, 1), expected finite numbers (n,), or (3, n) with first and second derivatives "
        "in time",
    ]
    with pytest.raises(ValueError, match=r"found fore\.T \(2,\), upper \(3,\), expected equally many places"):
        follow(arm, [0.3, 0.9], {"fore.T": [[0.5, 0.6], [0.5, 0.5]]}, {"upper": [0.1, 0.2, 0.3]})
    with pytest.raises(ValueError, match="found nothing wanted"):
        follow(arm, [0.3, 0.9])
