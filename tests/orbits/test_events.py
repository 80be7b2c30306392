"""Periodic motions through events that set parameters and switch effects: closed forms, published digits, refusals."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import continue_orbit, find_orbit

from ..support.folders import ROOT
from ..support.simplest_walker import EXCHANGED
from ..support.workshop import Workshop

STIFFNESS, DAMPING, TORQUE = 4.0, 0.3, 0.5

RELAY = f"""
name = "relay"
[ground_link]
points = {{ O = [0, 0] }}
[[link]]
name = "wheel"
mass = 1
inertia = 1
com = [0, 0]
points = {{ C = [0, 0] }}
[[joint]]
name = "axle"
between = ["ground.O", "wheel.C"]
[[torsion]]
name = "coil"
joint = "axle"
stiffness = {STIFFNESS}
damping = {DAMPING}
[[motor]]
name = "relay"
joint = "axle"
torque = {TORQUE}
[[event]]
name = "back"
when = "rate(angle(axle))"
direction = "falling"
set = {{ "relay.torque" = {-TORQUE} }}
[[event]]
name = "forth"
when = "rate(angle(axle))"
direction = "rising"
set = {{ "relay.torque" = {TORQUE} }}
[start]
angles = {{ wheel = 0 }}
angular_velocities = {{ wheel = 1.0 }}
[run]
until = 20
"""
SECTION = ("wheel.angle", 0.0)


@pytest.fixture(scope="module")
def relay(workshop: Workshop) -> Any:
    return workshop.model(RELAY, derivatives=True)


def swing(damping: float) -> tuple[float, float, float]:
    """How far the wheel swings, its period, and by what differences grow in one: of the torque T in the direction of
    the motion, a half swing from -A ends at T/k + r (A + T/k), r being what damping leaves of a swing about T/k."""
    half = math.pi / math.sqrt(STIFFNESS - damping**2 / 4)
    r = math.exp(-damping / 2 * half)
    return TORQUE / STIFFNESS * (1 + r) / (1 - r), 2 * half, r**2


def test_a_wheel_whose_torque_is_turned_round_where_it_stands(relay: Any) -> None:
    orbit = find_orbit(relay, section=SECTION, rtol=1e-12)
    far, period, multiplier = swing(DAMPING)
    assert orbit.period == pytest.approx(period, abs=1e-10)
    assert orbit.multipliers == pytest.approx([multiplier], abs=1e-10)
    assert [event.name for event in orbit.run.events] == ["back", "forth"]
    assert [event.q[0] for event in orbit.run.events] == pytest.approx([far, -far], abs=1e-9)


def test_its_branch_along_the_damping(relay: Any) -> None:
    branch = continue_orbit(
        find_orbit(relay, section=SECTION, rtol=1e-11), "coil.damping", (0.3, 0.6), way="up", step=0.3
    )
    assert branch.values[-1] == pytest.approx(0.6)
    for value, orbit in zip(branch.values, branch.orbits, strict=True):
        assert orbit.period == pytest.approx(swing(value)[1], abs=1e-9)
        assert orbit.multipliers == pytest.approx([swing(value)[2]], abs=1e-9)


def test_parameters_have_to_come_back(relay: Any) -> None:
    said = r"found relay\.torque at 0\.5 at the end of a way from the section back to it, t = .*, set by forth"
    with pytest.raises(ValueError, match=said):
        find_orbit(relay, section=SECTION, params={"relay.torque": 0.4})
    with pytest.raises(ValueError, match=r"found relay\.torque at -0\.5 at the end"):
        find_orbit(relay, section=SECTION, segments=3)


def test_events_by_the_time_have_to_come_again(workshop: Workshop) -> None:
    by_time = workshop.model(
        RELAY.replace('when = "rate(angle(axle))"\ndirection', 'when = "sin(pi*(t - 0.3))"\ndirection'),
        derivatives=True,
    )
    with pytest.raises(ValueError, match="found back, an event that does something by the time, expected events by"):
        find_orbit(by_time, section=SECTION)
    with pytest.raises(ValueError, match="after which back, an event that does something by the time, is not what it"):
        find_orbit(by_time, section=1.0)
    # a torque of period 2, -T until 0.3: what each half of it leaves at its end is turned round
    orbit = find_orbit(by_time, section=2.0, rtol=1e-12, params={"relay.torque": -TORQUE})
    rest = np.array([TORQUE / STIFFNESS, 0.0])
    at_forth = np.linalg.solve(free(1.0) + np.eye(2), free(1.0) @ rest - rest)
    assert [orbit.q[0], orbit.u[0]] == pytest.approx(free(0.7) @ (rest - at_forth) - rest, abs=1e-10)
    wanted = np.linalg.eigvals(free(2.0))
    assert np.sort_complex(orbit.multipliers) == pytest.approx(np.sort_complex(wanted), abs=1e-10)


def free(time: float) -> Any:
    """What a time (s) without torque makes of the state, (2, 2)."""
    c = DAMPING / 2
    w = math.sqrt(STIFFNESS - c**2)
    far, near = math.sin(w * time) / w, math.cos(w * time)
    return math.exp(-c * time) * np.array([[near + c * far, far], [-STIFFNESS * far, near - c * far]])


def test_the_simplest_walker_whose_feet_are_let_through(workshop: Workshop) -> None:
    """Its gait of long steps at the slope 0.009, by its own events: angle, rate and multipliers of feet without mass as
    they are published after M. Garcia and others (1998), the multipliers to six digits."""
    scene = (ROOT / "scenes" / "simplest-walker.toml").read_text()
    options: dict[str, Any] = {"section": ("right.foot", "ground_1"), "relabel": (EXCHANGED, np.zeros(8))}
    found = []
    for foot in ("2e-5", "1e-5"):
        model = workshop.model(scene.replace("foot = 1e-5", f"foot = {foot}"), derivatives=True)
        found.append(find_orbit(model, advances=["left.x"], rtol=1e-11, method="dop853", **options))
    coarse, fine = found
    assert fine.stable and {"right_through", "right_ahead"} <= {event.name for event in fine.run.events}
    state = [2 * (fine.q[2] - math.pi / 2) - (coarse.q[2] - math.pi / 2), 2 * fine.u[2] - coarse.u[2]]
    assert state == pytest.approx([0.200310900544287, -0.199832473004977], abs=1e-9)
    largest = [orbit.multipliers[np.argmax(orbit.multipliers.imag)] for orbit in (coarse, fine)]
    vanishing = 2 * largest[1] - largest[0]
    assert vanishing == pytest.approx(-0.190099639402167 + 0.557599274284362j, abs=1e-6)
    # those of variational equations in 64-bit mantissas, as in tests/sensitivity/test_simplest_walker.py
    assert vanishing == pytest.approx(-0.1900998410658881 + 0.5575987766820683j, abs=1e-7)
    # two steps, first on the one leg and then on the other
    model = workshop.model(scene, derivatives=True)
    stride = find_orbit(
        model, section=options["section"], crossings=2, advances=["left.x"], rtol=1e-11, method="dop853"
    )
    assert stride.period == pytest.approx(2 * fine.period, abs=1e-8)
    assert stride.multipliers[:2].real == pytest.approx((largest[1] ** 2).real, abs=1e-7)
