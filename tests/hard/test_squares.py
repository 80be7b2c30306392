"""Squares of equal rods, tossed onto rough ground: every fall folds them through their line, close above the ground.

Nearer to the line than the cube root of rounding no acceleration is known. Elsewhere runs stop there, or rest with a
corner above the ground.
"""

from __future__ import annotations

import numpy as np
import pytest

from ccgen.runtime import simulate

from ..support.reach import Reach
from ..support.tiers import hard, many
from ..support.workshop import Workshop

SQUARE = """name = "square"
[loop]
links = 4
length = 0.5
[start]
height = 0.8
tilt = "20 deg"
velocity = [1.5, 1.0]
angular_velocities = { link_0 = 3.0, link_1 = 2.0 }
[gravity]
[[ground]]
restitution = 0.5
friction = 0.6
"""
END = 5.0


@pytest.mark.parametrize("rtol", [1e-9, hard(1e-11), hard(1e-13)])
@pytest.mark.parametrize("count", [3, hard(many(6, 40))])
def test_tossed_squares_come_to_rest_flat(count: int, rtol: float, workshop: Workshop, reach: Reach) -> None:
    """Energy rises by no more than some tens of passages and falls may miss by the default tolerance, at every rtol.

    Steps take over for the last bounces of a fall: no more than a twentieth of any run, and a hundredth of all.
    """
    model = workshop.model(SQUARE)
    (q, u), rng = model.start(), np.random.default_rng(11)
    rises, depths, shares, heights = [], [], [], []
    for k in range(count):
        thrown = model.project(q, u + 2.0 * rng.normal(size=u.size))[1]
        run = simulate(model, q, thrown, until=END, rtol=rtol)
        assert run.success, (k, run.message)
        energy = np.sum(model.energy(run.q, run.u), axis=0)
        rises.append(float(np.max(energy - np.minimum.accumulate(energy)) / abs(energy[0])))
        depths.append(float(-model.gaps(run.q).min()))
        steps = [phase.end - phase.start for phase in run.phases if phase.kind == "steps"]
        shares.append(sum(steps) / END)
        heights.append(float(model.gaps(run.q[-1]).max()))
    case = f"{count} tossed squares, rtol {rtol:g}"
    reach(f"{case}: energy rises, of that at the start", max(rises), 1e-7)
    reach(f"{case}: penetration, m", max(depths), 1e-10)
    reach(f"{case}: longest share of time by steps", max(shares), 5e-2)
    reach(f"{case}: share of time by steps of all", float(np.mean(shares)), 1e-2)
    reach(f"{case}: squares above the ground at the end", sum(height > 1e-6 for height in heights), 0)
