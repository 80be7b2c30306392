"""Periodic motions of closed chains that strike: their multipliers by the derivatives and by other ways."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import find_orbit, simulate

from ..support.folders import SCENES
from ..support.workshop import Workshop

DAMPING, RESTITUTION = 0.3, 0.6
ROCKED = f"""
[[torsion]]
joint = "pivot"
stiffness = 20.0
angle = "112 deg"
[[torsion]]
joint = "motor"
damping = {DAMPING}
[[torque]]
link = "crank"
torque = "4*cos(8*t)"
[[stop]]
joint = "pivot"
highest = "115 deg"
restitution = {RESTITUTION}
[run]
until = 100
rtol = 1e-12
"""
PERIOD = 2 * math.pi / 8


@pytest.fixture(scope="module")
def rocking(workshop: Workshop) -> Any:
    """A four-bar that a torque shakes against a stop: the motion that it comes to."""
    text = (SCENES / "four-bar.toml").read_text()
    text = text[: text.index("[start]")]
    start = '[start]\nangles = { crank = "90 deg", coupler = "30 deg", rocker = "105 deg" }\n'
    model = workshop.model(text + start + ROCKED, derivatives=True)
    run = simulate(model, until=60 * PERIOD, rtol=1e-9)
    assert run.success, run.message
    return find_orbit(model, run.q[-1], run.u[-1], section=PERIOD)


def test_a_four_bar_against_its_stop(rocking: Any) -> None:
    """What a small area of angle and rate of the crank is multiplied by in a period: e^2 at each impact, and what
    damping takes, exp(- integral of c/m), m being the inertia that the crank feels."""
    run, model = rocking.run, rocking.run.model
    assert run.impacts and len(rocking.multipliers) == 2
    marks, taken = [0.0, *(impact.t for impact in run.impacts), rocking.period], 0.0
    nodes, weights = np.polynomial.legendre.leggauss(40)
    for low, high in pairwise(marks):
        times = low + (high - low) * (nodes + 1) / 2
        # of a motion with half a joule: the square of the crank's rate is one by the inertia that it feels
        rates = [model.joint_rates(q, model.motions(q)[:, 0])["motor"] for q in run.at(times)[0]]
        taken += DAMPING * (high - low) / 2 * float(weights @ np.square(rates))
    area = RESTITUTION ** (2 * len(run.impacts)) * math.exp(-taken)
    assert np.prod(rocking.multipliers) == pytest.approx(area, abs=5e-10)  # a run is known to a hundred tolerances
    assert area > 1e-4


ROD = """
[[link]]
name = "rod_{k}"
mass = 0.1
inertia = 0.01
com = [0.1, 0]
points = {{ A = [0, 0], B = [0.2, 0], M = [0.1, 0] }}
"""
PIN = """
[[joint]]
name = "pin_{k}"
between = ["rod_{k}.B", "rod_{after}.A"]
[[torsion]]
joint = "pin_{k}"
stiffness = 100.0
angle = "-60 deg"
damping = 0.3
"""
HEXAGON = f"""
name = "hexagon"
[ground_link]
points = {{ O = [0, 0] }}
[[link]]
name = "table"
mass = 1.0
inertia = 1.0
com = [0, 0]
points = {{ C = [0, 0], L = [-1, 0], R = [1, 0] }}
{"".join(ROD.format(k=k) for k in range(6))}
[[joint]]
name = "shaker"
type = "prismatic"
between = ["ground.O", "table.C"]
axis = [0, 1]
[[drive]]
joint = "shaker"
position = "0.03*sin(10*pi*t + 1)"
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "rod_0.M"]
axis = [0, 1]
{"".join(PIN.format(k=k, after=(k + 1) % 6) for k in range(6))}
[start]
angles = {{ {", ".join(f'rod_{k} = "{-60 * k} deg"' for k in range(6))} }}
slides = {{ shaker = "0.03*sin(1)", guide = 0.45 }}
[[touch]]
name = "bounce"
between = ["rod_2.B", ["table.L", "table.R"]]
radius = 0.01
restitution = 0.4
[gravity]
g = 9.81
[run]
until = 40
rtol = 1e-12
"""
NEARLY = (0.8787, 0.1382, -2.4937, -3.3583, -2.5957, 0.0252, -0.1431), (-0.871, -1.0806, -1.2877, -0.3981, -0.2464)
"""Angles (rad) and places (m) of a hexagon that nears itself after three periods of the table, and its first rates."""


@pytest.mark.hard
def test_a_hexagon_on_a_shaken_table_beside_differences(workshop: Workshop) -> None:
    """A loop of six rods, four degrees of freedom beside the table's, strikes six times in three periods, unstably: the
    matrix of its map beside central differences of runs."""
    model = workshop.model(HEXAGON, derivatives=True)
    own = model.start()
    q = np.array([*NEARLY[0][:5], own[0][5], NEARLY[0][6]])
    found = find_orbit(model, q, [*NEARLY[1], own[1][5], 0.3999], section=0.2, crossings=3)
    assert len(found.run.impacts) == 6 and len(found.multipliers) == 8 and not found.stable
    n, step, columns = len(q), 1e-6, []
    for direction in found.basis.T:
        ends = []
        for sign in (step, -step):
            start = model.project(found.q + sign * direction[:n], found.u + sign * direction[n:])
            run = simulate(model, *start, until=found.period)
            ends.append(np.concatenate([run.q[-1], run.u[-1]]))
        columns.append(np.linalg.lstsq(found.basis, (ends[0] - ends[1]) / (2 * step), rcond=None)[0])
    wanted = np.array(columns).T
    assert found.matrix == pytest.approx(wanted, abs=2e-6 * np.abs(wanted).max())
    largest = sorted(np.linalg.eigvals(wanted), key=abs)[-2:]
    assert np.sort_complex(found.multipliers[:2]) == pytest.approx(np.sort_complex(largest), abs=1e-5)
