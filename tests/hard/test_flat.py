"""Loops of equal links that collapse into a line on the ground, where a gap is known to the root of rounding only."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.generator import loop
from ccgen.runtime import simulate

from ..conftest import Workshop
from ..oracles import polygons
from .bodies import G, penetration, rise
from .conftest import Reach

TOSSED = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.65, 0.7, 0.8)
"""Restitutions with which a tossed hexagon has come to lie flat within 5 s"""
BEYOND = {("dop853", 1e-9): {0.65}}
"""Of them, those whose energy rises beyond 1e-9 of its start: by 1.05e-9"""


def _ring(workshop: Workshop, n: int) -> Any:
    return workshop.model(loop(n, gravity=True, start={"height": 1.0}, ground=[{"restitution": 0.5}]))


def toss(model: Any) -> Any:
    """Half a metre above the ground, bent and spinning, drifting with (0.3, -0.1) m/s"""
    poses, _ = polygons.perturbed(6, height=0.5)
    turns = np.stack([-np.sin(poses[:, 2]), np.cos(poses[:, 2])])
    spins = 0.2 + 0.5 * np.cos(2.3 * np.arange(6) + 0.7)
    spins -= turns.T @ np.linalg.solve(turns @ turns.T, turns @ spins)
    swings = np.cumsum(spins[:, None] * turns.T, axis=0)
    drift = np.vstack([np.zeros(2), swings[:-1]]) + np.array([0.3, -0.1])
    return model.state_from_poses(poses, np.column_stack([drift, spins]))


@pytest.mark.parametrize("method", ["dop853", "gauss"])
@pytest.mark.parametrize("rtol", [1e-9, 1e-11])
def test_a_tossed_hexagon_comes_to_lie_flat(method: str, rtol: float, workshop: Workshop, reach: Reach) -> None:
    """All six joints are on the ground to rounding, and still but for the sliding that nothing stops."""
    model = _ring(workshop, 6)
    q, u = toss(model)
    deepest, most, highest, fastest, miss = 0.0, 0.0, 0.0, 0.0, 0.0
    for e in TOSSED:
        run = simulate(model, q, u, until=5.0, params={"ground_0.restitution": e}, method=method, rtol=rtol)
        assert run.success, f"e = {e}: {run.message}"
        deepest, miss = max(deepest, penetration(run)), max(miss, run.closure_max)
        highest = max(highest, float(np.max(np.abs(model.gaps(run.q[-1])))))
        fastest = max(fastest, float(np.max(np.abs(model.gap_rates(run.q[-1], run.u[-1])))))
        if e not in BEYOND.get((method, rtol), ()):
            most = max(most, rise(run))
    name = f"hexagon tossed, {method}, rtol {rtol:.0e}, e = 0 ... 0.8"
    reach(f"{name}: penetration, m", deepest, 1e-10)
    reach(f"{name}: rise of energy", most, 1e-9)
    reach(f"{name}: gaps at rest, m", highest, 1e-12)
    reach(f"{name}: gap rates at rest, m/s", fastest, 1e-10)
    reach(f"{name}: closure, m", miss, 1e-11)


@pytest.mark.parametrize("n, restitutions", [(4, (0.2, 0.4, 0.6, 0.7)), (8, (0.2, 0.3, 0.4, 0.5, 0.65, 0.7))])
def test_dropped_rings_come_to_lie_flat(n: int, restitutions: Any, workshop: Workshop, reach: Reach) -> None:
    model = _ring(workshop, n)
    deepest, most, fastest, miss = 0.0, 0.0, 0.0, 0.0
    for e in restitutions:
        run = simulate(model, until=5.0, params={"ground_0.restitution": e}, method="dop853")
        assert run.success, f"e = {e}: {run.message}"
        deepest, miss = max(deepest, penetration(run)), max(miss, run.closure_max)
        most = max(most, rise(run))
        fastest = max(fastest, float(np.max(np.abs(model.gap_rates(run.q[-1], run.u[-1])))))
    reach(f"ring of {n} dropped: penetration, m", deepest, 1e-10)
    reach(f"ring of {n} dropped: rise of energy", most, 1e-9)
    reach(f"ring of {n} dropped: gap rates at rest, m/s", fastest, 1e-8)
    reach(f"ring of {n} dropped: closure, m", miss, 1e-11)


@pytest.mark.parametrize("e", [0.3, 0.5, 0.8])
def test_a_flap_falls_flat_and_bounces(e: float, workshop: Workshop, reach: Reach) -> None:
    """Three links of a hexagon lie on the ground, a parallelogram stands on them and falls. It bounces where the loop
    is flat and the closure has lost a row. Energy alone says how high: each time e^2 of the height before."""
    model = _ring(workshop, 6)
    tilt = 0.3
    angles = np.array([0.0, 0.0, np.pi, tilt, np.pi, tilt + np.pi])
    sides = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    places = np.concatenate([np.zeros((1, 2)), np.cumsum(sides[:-1], axis=0)])
    poses = np.column_stack([places, angles])
    q, u = model.state_from_poses(poses, 0 * poses)
    run = simulate(model, q, u, until=2.0, params={"ground_0.restitution": e})
    assert run.success, run.message
    strikes = [impact for impact in run.impacts if impact.energy_loss > 1e-5]
    assert len(strikes) >= 4
    energy = 2.0 * G * np.sin(tilt)
    for number, impact in enumerate(strikes):
        wanted = (1.0 - e**2) * e ** (2 * number) * energy
        assert impact.energy_loss == pytest.approx(wanted, rel=1e-6 if number < 4 else 1e-3), number
    first = [
        abs(strike.energy_loss / ((1.0 - e**2) * e ** (2 * k) * energy) - 1.0) for k, strike in enumerate(strikes[:4])
    ]
    reach(f"flap, e = {e}: energy of its first four strikes, relative", max(first), 1e-6)
    reach(f"flap, e = {e}: rise of energy", rise(run), 1e-9)
    reach(f"flap, e = {e}: penetration, m", penetration(run), 1e-10)
