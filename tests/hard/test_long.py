"""Long runs and singular configurations."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

from ccgen.generator import loop
from ccgen.runtime import simulate

from ..oracles import polygons
from ..support.reach import Reach
from ..support.tiers import hard
from ..support.workshop import Workshop

G = 9.81


def row(count: int) -> str:
    return f"[four_bars]\ncount = {count}\n[gravity]\ng = {G}\n"


def swing(count: int, t: float) -> float:
    """Angle from upright of a row of four-bars, head at 1 m/s: all its uprights stay parallel."""
    inertia, weight = (count + 1) / 3 + count, G * ((count + 1) / 2 + count)
    n = 4 * weight / inertia
    m, c = n / (1 + n), 0.5 * np.sqrt(1 + n)
    return float(2 * np.arcsin(ellipj(ellipk(m) - c * t, m)[1]))


@pytest.mark.parametrize(("count", "end", "bound"), [(2, 1000.0, 1e-6), hard(40, 20.0, 1e-8)])
def test_a_row_of_four_bars(count: int, end: float, bound: float, workshop: Workshop, reach: Reach) -> None:
    """Flat twice a turn, where it could go count + 1 ways: it keeps its branch, against elliptic functions."""
    model = workshop.model(row(count))
    run = simulate(model, until=end, rtol=1e-13)
    assert run.success, run.message
    upright = model.links.index(model.links[0])
    angle = float(model.poses(run.q[-1])[upright, 2]) - np.pi / 2
    error = abs(np.sin(0.5 * (angle + swing(count, end))))
    name = f"{count} four-bars for {end:g} s"
    energy = np.sum(model.energy(run.q, run.u), axis=0)
    reach(f"{name}: energy, relative", np.max(np.abs(energy / energy[0] - 1)), 1e-8)
    reach(f"{name}: closure, m", run.closure_max, 1e-11)
    reach(f"{name}: half the angle, rad", min(error, abs(np.sin(0.5 * (angle - swing(count, end))))), bound)


@pytest.mark.hard
def test_a_free_hexagon_for_ten_thousand_seconds(workshop: Workshop, reach: Reach) -> None:
    model = workshop.model(loop(6))
    q, u = model.state_from_poses(*polygons.perturbed(6))
    run = simulate(model, q, u, until=10_000.0, rtol=1e-13)
    assert run.success, run.message
    energy = model.energy(run.q, run.u)[0]
    reach("free hexagon for 10,000 s: closure, m", run.closure_max, 1e-11)
    reach("free hexagon for 10,000 s: energy, relative", np.max(np.abs(energy / energy[0] - 1)), 1e-9)


def test_a_hexagon_started_with_all_links_in_line(workshop: Workshop, reach: Reach) -> None:
    model: Any = workshop.model(loop(6, gravity=True))
    q, u = model.start()
    q[2:] = [0.0, 0.0, 0.0, np.pi, np.pi, np.pi]
    spins = [1.0, 0.4, -0.3]  # in pairs, so that the line opens on a branch: the sum of +-spin^2 vanishes too
    q, u = model.project(q, np.array([0.0, 0.0, *spins, *spins]))
    run = simulate(model, q, u, until=5.0, rtol=1e-11)
    assert run.success, run.message
    energy = np.sum(model.energy(run.q, run.u), axis=0)
    kinetic = np.max(model.energy(run.q, run.u)[0])
    reach("hexagon from a line: energy, relative to the kinetic", np.max(np.abs(energy - energy[0])) / kinetic, 1e-8)
    reach("hexagon from a line: closure, m", run.closure_max, 1e-11)


def test_starts_that_are_not_closed(workshop: Workshop, reach: Reach) -> None:
    """Slightly: repaired on the way of the mass matrix. Grossly: refused."""
    model = workshop.model(loop(6))
    q, u = model.start()
    q[3] += 1e-4
    run = simulate(model, q, u, until=0.1)
    reach("a start open by 1e-4 rad, repaired: closure, m", run.closure_max, 1e-11)
    with pytest.raises(ValueError, match="closed"):
        simulate(model, 0.0 * q, u, until=0.1)
