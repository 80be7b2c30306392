"""The simplest walker (M. Garcia, A. Chatterjee, A. Ruina, M. Coleman, Journal of Biomechanical Engineering 120, 1998):
its gaits by Newton's method with the derivatives of a step, their multipliers, and what the slope changes.

The digits are those of massless feet, by Gauss's method of 10 stages with variational equations in 64-bit mantissas.
Feet here have masses, and what is found is carried to none.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import sensitivities

from ..support.workshop import Workshop

SLOPE = 0.009
FEET = [2e-3 / 2**k for k in range(6)]
TO_ROUNDING, ROUNDED = 4, 6
"""Steps of Newton's method, which are as many as it needs, and as many again that differ by rounding alone."""
PASSED = 3.0
"""When the foot that swings is through and above the ground again (s); until then it has none."""

STABLE, UNSTABLE = (
    (0.200310900544247089, -0.199832473004952355, 3.88246375285137414),
    (0.193937369810181809, -0.203866927442006927, 3.09610586807816370),
)
"""Angle of the stance leg behind a strike (rad), its rate (rad/s), and the time of a step (s)."""

SCENE = """
name = "walker"
[[link]]
name = "stance"
points = { foot = [0, 0], hip = [1, 0] }
point_mass = [{ at = [0, 0], mass = "foot" }, { at = [1, 0], mass = 1 }]
[[link]]
name = "swing"
points = { foot = [0, 0], hip = [1, 0] }
point_mass = { at = [0, 0], mass = "foot" }
[[joint]]
name = "hip"
between = ["stance.hip", "swing.hip"]
[start]
position = [0, 0]
velocity = [0, 0]
angles = { stance = "pi/2 + 0.2", swing = "pi/2 - 0.2" }
angular_velocities = { stance = -0.2, swing = -0.19 }
[gravity]
g = 1
direction = [0.009, -1]
"""
GROUND = '[[ground]]\nrestitution = 0\nfriction = 1\ncontacts = ["{}.foot"]\n'


class Walker:
    """A walker whose feet have a mass: one step, and what it moves by."""

    def __init__(self, workshop: Workshop, foot: float) -> None:
        one, both = (
            workshop.model(SCENE.replace("[[link]]", LET + "[[link]]", 1) + text, derivatives=True)
            for text in (GROUND.format("stance"), GROUND.format("stance") + GROUND.format("swing"))
        )
        pull = {"gravity.direction.x": np.sin(SLOPE), "gravity.direction.y": -np.cos(SLOPE)}
        stance = {"stance.mass": 1 + foot, "stance.com.x": 1 / (1 + foot), "stance.inertia": foot / (1 + foot)}
        values = pull | stance | {"swing.mass": foot}
        self.models = one.with_parameters(values), both.with_parameters(values)

    def step(self, theta: float, rate: float, until: float) -> tuple[Any, Any]:
        """Angle and rate behind the next strike, its time (3,), and by what these move with angle, rate and slope."""
        swing, turned = np.cos(2 * theta) * rate, np.array([-2 * np.sin(2 * theta) * rate, np.cos(2 * theta), 0.0])
        q, u = np.array([0, 0, np.pi / 2 + theta, np.pi / 2 - theta]), np.array([0, 0, rate, swing])
        by = {
            "q0": np.array([[0, 0, 0], [0, 0, 0], [1, 0, 0], [-1, 0, 0]]),
            "u0": np.array([[0, 0, 0], [0, 0, 0], [0, 1, 0], turned]),
            "gravity.direction.x": [0, 0, np.cos(SLOPE)],
            "gravity.direction.y": [0, 0, np.sin(SLOPE)],
        }
        options = {"rtol": 1e-14, "method": "gauss"}
        through = sensitivities(
            self.models[0], by, q0=q, u0=u, until=PASSED if until > PASSED + 0.3 else 2.4, **options
        )
        start = through.run.t[-1]
        q, u = through.run.q[-1], through.run.u[-1]
        then = by | {"q0": through["q"], "u0": through["u"]}
        struck = sensitivities(self.models[1], then, q0=q, u0=u, until=until - start, **options)
        (impact,), (passed,) = struck.run.impacts, struck.passed[:1]
        row = int(np.searchsorted(struck.run.t, impact.t))
        found = np.array([struck.run.q[row, 3] - np.pi / 2, impact.u_plus[3], start + impact.t])
        return found, np.array([passed.behind[3], passed.behind[7], passed.dt])

    def gait(self, guess: tuple[float, float, float]) -> tuple[Any, Any]:
        """Angle, rate and time of the gait (3,), and the derivatives of its step (3, 3): means of steps that are at
        rounding, which light feet make large."""
        state, found = np.array(guess), list[tuple[Any, Any]]()
        for _ in range(TO_ROUNDING + ROUNDED):
            after, by = self.step(state[0], state[1], state[2] + 0.1)
            change = np.linalg.solve(np.eye(2) - by[:2, :2], after[:2] - state[:2])
            state = np.append(state[:2] + change, after[2] + by[2, :2] @ change)
            found.append((state, by))
        states, moves = zip(*found[TO_ROUNDING:], strict=True)
        return np.mean(states, axis=0), np.mean(moves, axis=0)


LET = "[let]\nfoot = 1e-3\n"


def vanishing(values: list[Any]) -> Any:
    """The limit of values, each of half the mass of the one before (L. F. Richardson)."""
    for order in range(1, len(values)):
        values = [(2**order * fine - coarse) / (2**order - 1) for coarse, fine in pairwise(values)]
    return values[0]


@pytest.fixture(scope="module")
def walkers(workshop: Workshop) -> list[Walker]:
    return [Walker(workshop, foot) for foot in FEET]


def test_the_stable_gait(walkers: list[Walker]) -> None:
    found = [walker.gait(STABLE) for walker in walkers]
    assert vanishing([state for state, _ in found]) == pytest.approx(STABLE, abs=2e-11)
    by = vanishing([by for _, by in found])
    assert np.sort_complex(np.linalg.eigvals(by[:2, :2])) == pytest.approx(
        np.array([-0.1900998410658881 - 0.5575987766820683j, -0.1900998410658881 + 0.5575987766820683j]), abs=1e-9
    )
    state = np.linalg.solve(np.eye(2) - by[:2, :2], by[:2, 2])
    assert state == pytest.approx([7.2978202116226420, -6.5709274333289765], rel=1e-9)
    assert by[2, 2] + by[2, :2] @ state == pytest.approx(5.346788245468937, rel=1e-8)


@pytest.mark.hard
def test_the_unstable_gait(walkers: list[Walker]) -> None:
    found = [walker.gait(UNSTABLE) for walker in walkers]
    assert vanishing([state for state, _ in found]) == pytest.approx(UNSTABLE, abs=2e-11)
    by = vanishing([by for _, by in found])
    assert np.sort(np.linalg.eigvals(by[:2, :2])) == pytest.approx([0.4595895897976716, 4.0038643589297072], abs=1e-8)
