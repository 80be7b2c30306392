"""Other units of length and mass change no orbit, no branch and no rank."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import continue_orbit, find_orbit
from ccgen.runtime.orbits.kept import Kept, rows_of
from ccgen.runtime.orbits.rank import least_change, rank_of, unmoved

from ..support.workshop import Workshop

PERIOD = 2 * math.pi / 3


def shaken(length: float, mass: float) -> str:
    """A mass of 2 kg, 1 m high, on a spring of 8 N/m, shaken by 5 N, that comes near a wall; in units of which a metre
    has ``length`` and a kilogramme ``mass``."""
    return f"""
name = "shaken"
[ground_link]
points = {{ O = [0, 0], W = [{-length!r}, 0] }}
[[link]]
name = "mass"
mass = {2 * mass!r}
inertia = {mass * length**2!r}
com = [0, 0]
points = {{ C = [0, 0], D = [0, {-length!r}] }}
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "mass.C"]
axis = [1, 0]
[[spring]]
between = ["ground.W", "mass.C"]
stiffness = {8 * mass!r}
length = {length!r}
[[damper]]
between = ["ground.W", "mass.C"]
damping = {1.2 * mass!r}
[[force]]
point = "mass.C"
vector = ["{5 * mass * length!r}*cos(3*t + 1)", 0]
[[ground]]
point = [{0.5 * length!r}, 0]
normal = [-1, 0]
restitution = 0.6
contacts = ["mass.C"]
[run]
until = 200.0
rtol = 1e-12
"""


@pytest.mark.parametrize(("length", "mass"), [(1e3, 1.0), (1e3, 1e12), (1e-3, 1e-9)], ids=["mm", "mm, ng", "km, kt"])
def test_a_branch_in_other_units(length: float, mass: float, workshop: Workshop) -> None:
    """Point by point the same motions, to the grazing of the closed form: with a stiffness of 8e12 g/s^2 the derivative
    by it is 1e-13 of what derivatives by the state are, and counts all the same."""
    found = []
    for a, b in ((1.0, 1.0), (length, mass)):
        orbit = find_orbit(workshop.model(shaken(a, b), derivatives=True), [0.1 * a], [0.0], section=PERIOD)
        found.append(continue_orbit(orbit, "spring_0.stiffness", (7 * b, 14 * b)))
    here, there = found
    assert there.values / mass == pytest.approx(here.values, rel=1e-9)
    for one, other in zip(here.orbits, there.orbits, strict=True):
        assert other.multipliers == pytest.approx(one.multipliers, abs=1e-10)
        assert np.append(other.q, other.u) / length == pytest.approx(np.append(one.q, one.u), abs=1e-9)
    (grazing,) = there.bifurcations
    assert grazing.value / mass == pytest.approx(18 - math.sqrt((5 / 0.5) ** 2 - 3.6**2), abs=1e-9)


def crank(length: float) -> str:
    """A driven slider-crank with a wall before its slider and a stop of its crank."""
    return f"""
name = "driven"
[ground_link]
points = {{ O = [0, 0] }}
[[link]]
name = "crank"
points = {{ A = [0, 0], B = [{0.4 * length!r}, 0] }}
point_mass = {{ at = [{0.2 * length!r}, 0], mass = 1 }}
[[link]]
name = "rod"
points = {{ A = [0, 0], B = [{1.1 * length!r}, 0] }}
point_mass = {{ at = [{0.5 * length!r}, 0], mass = 1 }}
[[link]]
name = "slider"
mass = 1.5
inertia = 0.2
com = [0, 0]
points = {{ P = [0, 0] }}
[[joint]]
name = "axle"
between = ["ground.O", "crank.A"]
[[joint]]
name = "pin"
between = ["crank.B", "rod.A"]
[[joint]]
name = "wrist"
between = ["rod.B", "slider.P"]
[[joint]]
name = "guide"
type = "prismatic"
axis = [1, 0]
between = ["ground.O", "slider.P"]
[[drive]]
joint = "axle"
speed = 2.0
[[stop]]
joint = "axle"
highest = 0.9
restitution = 0
[[ground]]
point = [{1.4 * length!r}, 0]
normal = [-1, 0]
restitution = 0
contacts = ["slider.P"]
[start]
angles = {{ crank = 0.7, rod = -0.24 }}
"""


def test_rows_of_what_is_shut_have_no_units(workshop: Workshop) -> None:
    """Loops, the driven axle, a stop (rad) and a wall (m): entries are the same in metres and millimetres, and of the
    size of one, so that no row counts more than another."""
    found = []
    for length in (1.0, 1e3):
        model = workshop.model(crank(length), derivatives=True)
        assert model.length == pytest.approx(1.1 * length)
        q, u = model.start()
        units = np.concatenate([model.coordinate_units, 2.0 * model.coordinate_units])  # half a second
        both = tuple(range(len(model.contacts)))
        (drive,) = (name for name in model.parameters if name.endswith("speed"))
        found.append(rows_of(model, q, u, Kept(both, both, ()), units, drive))
    (rows, by), (others, others_by) = found
    assert others == pytest.approx(rows, abs=1e-12) and others_by == pytest.approx(by, abs=1e-12)
    sizes = np.linalg.norm(rows, axis=1)
    assert len(rows) >= 8 and sizes.min() > 0.1 and sizes.max() < 10.0
    assert -0.5 in by  # the speed of the axle, 1 rad/s, of 2 rad/s


def test_what_counts_as_independent() -> None:
    """Singular values by hand: of rows that all are rounding nothing is known."""
    assert rank_of(np.array([1.0, 1e-9, 1e-11])) == 2
    assert rank_of(np.array([1e-12, 1e-13])) == 2 and rank_of(np.array([1e-12]), 1.0) == 0
    assert rank_of(np.zeros(0)) == 0
    rows = np.array([[1.0, 1.0, 0.0], [2.0, 2.0, 0.0]])
    assert least_change(rows, np.array([1.0, 2.0])) == pytest.approx([0.5, 0.5, 0.0])
    assert least_change(1e-12 * rows, np.array([1.0, 2.0]), 1.0) == pytest.approx(np.zeros(3))
    left = unmoved(rows)
    assert left.shape == (3, 2) and np.abs(rows @ left).max() <= 1e-15
    assert left.T @ left == pytest.approx(np.eye(2)) and unmoved(np.zeros((0, 2))) == pytest.approx(np.eye(2))
    none: Any = least_change(np.zeros((0, 2)), np.zeros(0))
    assert none == pytest.approx(np.zeros(2))
