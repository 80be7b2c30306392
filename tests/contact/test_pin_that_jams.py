"""A driven loop with one loose rough pin: it jams as it slides, its force growing as one over the time left."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.runtime import simulate

from ..support.workshop import Workshop

CLEARANCE = 1.948438541895064e-05

LOOP = """
name = "loose"
[run]
law = "poisson"
until = 1
[ground_link]
points = { O = [1.4, 0.8], Q = [2.0, 0.872669705027969] }
[start]
angles = { crank = 4.19867643185205, bar = 1.0808795582255297, rocker = 2.6444689483752137 }
angular_velocities = { crank = 11.791569398568946, bar = 3.622866493589347, rocker = -13.066347793766141 }
[[link]]
name = "crank"
points = { A = [0, 0], B = [0.2, 0] }
mass = 0.21742109316020475
inertia = 0.0007247369772006826
com = [0.1, 0]
[[link]]
name = "bar"
points = { A = [0, 0], B = [0.55, 0] }
mass = 3.116354695543749
inertia = 0.07855810795016537
com = [0.275, 0]
[[link]]
name = "rocker"
points = { A = [0, 0], B = [0.5, 0] }
mass = 0.1650412174817643
inertia = 0.0034383586975367565
com = [0.25, 0]
[[joint]]
between = ["ground.O", "crank.A"]
name = "drive"
[[joint]]
between = ["crank.B", "bar.A"]
[[joint]]
between = ["ground.Q", "rocker.A"]
[[journal]]
name = "pin"
between = ["bar.B", "rocker.B"]
radius = 0.01
clearance = 1.948438541895064e-05
restitution = 0.6510588587811941
friction = 3.0
[[drive]]
joint = "drive"
speed = 11.791569398568946
"""


@pytest.fixture(scope="module")
def loop(workshop: Workshop) -> Any:
    return workshop.model(LOOP)


@pytest.mark.parametrize("method", ["gauss", "dop853", "radau"])
def test_the_pin_is_stopped_by_an_impact_without_collision(loop: Any, method: str) -> None:
    """Where it jams it has been sliding, held: the impulse has no approach before it, and no sliding after it."""
    run = simulate(loop, until=0.18, method=method)
    assert run.success, run.message
    impact = min((i for i in run.impacts if i.t > 0.17405), key=lambda i: i.t)
    assert impact.t == pytest.approx(0.174203, abs=2e-6)
    q = run.at(impact.t)[0]
    before, after = (pin_speed(q, u) for u in (impact.u_minus, impact.u_plus))
    assert abs(before[0]) < 1e-8 and abs(before[1]) > 1e-4
    assert abs(after[0]) < 1e-7 and abs(after[1]) < 1e-7
    assert impact.u_plus[0] == pytest.approx(11.791569398568946, rel=1e-12)
    assert abs(impact.friction[0]) < 3.0 * impact.impulses[0]


def pin_speed(q: Any, u: Any) -> tuple[float, float]:
    """How fast the pin of the bar goes in its hole (m/s): along the line of the centres, and the rubbing along it."""
    turn = np.exp(1j * q)
    bar = 1.4 + 0.8j + 0.2 * turn[0] + 0.55 * turn[1]
    rocker = 2.0 + 0.872669705027969j + 0.5 * turn[2]
    moving = 1j * (0.2 * u[0] * turn[0] + 0.55 * u[1] * turn[1] - 0.5 * u[2] * turn[2])
    line = (bar - rocker) / abs(bar - rocker)
    own = moving * np.conj(line)
    return float(own.real), float(own.imag + u[1] * 0.01 - u[2] * (0.01 + CLEARANCE))
