"""Mechanisms that could go on in two ways at every turn: the branch is kept, and the motion is that of one equation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ccgen.generator import load_scene
from ccgen.runtime import simulate

from ..conftest import Workshop
from .bodies import G
from .conftest import Reach

SCENES = Path(__file__).resolve().parents[2] / "scenes"


@dataclass(frozen=True)
class Branch:
    """The motion on it: kinetic energy inertia(θ) θ̇²/2, potential G moment sin θ; and how far states are off it."""

    inertia: Callable[[Any], Any]
    slope: Callable[[Any], Any]
    moment: float
    off: Callable[[Any], Any]


BRANCHES = {
    "parallelogram": Branch(
        inertia=lambda angle: 2.0 / 3.0 + 1.5 + 0.0 * angle,
        slope=lambda angle: 0.0 * angle,
        moment=0.5 + 0.5 + 1.5,
        off=lambda q: np.maximum(np.abs(q[:, 1]), np.abs(q[:, 0] - q[:, 2])),
    ),
    "equal-length-slider-crank": Branch(
        inertia=lambda angle: 5.0 / 12.0 + 0.25 + 6.0 * np.sin(angle) ** 2,
        slope=lambda angle: 6.0 * np.sin(2.0 * angle),
        moment=1.0,
        off=lambda q: np.maximum(np.abs(q[:, 0] + q[:, 1]), np.abs(q[:, 2] - 2.0 * np.cos(q[:, 0]))),
    ),
}


@pytest.mark.parametrize("name", BRANCHES)
@pytest.mark.parametrize(("end", "rtol", "energy", "angle"), [(10.0, 1e-9, 1e-8, 1e-6), (100.0, 1e-13, 1e-9, 1e-8)])
def test_turn_after_turn_on_its_branch(
    name: str, end: float, rtol: float, energy: float, angle: float, workshop: Workshop, reach: Reach
) -> None:
    branch = BRANCHES[name]
    run = simulate(workshop.model(load_scene(SCENES / f"{name}.toml")), until=end, rtol=rtol)
    assert run.success, run.message
    theta, rate = run.q[:, 0], run.u[:, 0]
    assert np.ptp(theta) > end * np.pi
    total = 0.5 * branch.inertia(theta) * rate**2 + G * branch.moment * np.sin(theta)

    def motion(_: float, y: Any) -> list[float]:
        force = G * branch.moment * np.cos(y[0]) + 0.5 * branch.slope(y[0]) * y[1] ** 2
        return [y[1], -force / branch.inertia(y[0])]

    exact = solve_ivp(motion, (0.0, end), [theta[0], rate[0]], method="DOP853", rtol=3e-14, atol=1e-14).y[0, -1]
    case = f"{name} for {end:g} s, rtol {rtol:g}"
    reach(f"{case}: off its branch", branch.off(run.q).max(), 1e-10)
    reach(f"{case}: energy, relative", np.max(np.abs(total / total[0] - 1)), energy)
    reach(f"{case}: angle, rad", abs(theta[-1] - exact), angle)
