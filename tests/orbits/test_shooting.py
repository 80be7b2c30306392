"""Multiple shooting: motions that single shooting cannot find, and their multipliers, at closed forms."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import find_orbit

from ..oracles.bouncing_table import BouncingTable
from ..support.shaken_table import RADIUS, SHAKEN, TABLE, G
from ..support.workshop import Workshop

PHASE = 1.0
TURNS = 13
"""Periods in which the unstable orbit on the table leaves by a factor of a million: 2.93^13 = 1.2e6."""


@pytest.fixture(scope="module")
def shaken(workshop: Workshop) -> Any:
    text = SHAKEN.replace("*t)", f"*t + {PHASE})").replace(
        "shaker = 0.0", f"shaker = {TABLE.amplitude * math.sin(PHASE)!r}"
    )
    return workshop.model(text + "rtol = 1e-12\n", derivatives=True)


def test_an_orbit_whose_neighbours_leave_by_a_million(shaken: Any) -> None:
    """The unstable orbit with one impact a period, as one of thirteen periods: from the same rough state at each."""
    moving = TABLE.amplitude * TABLE.frequency * math.cos(PHASE)
    guess = np.array([TABLE.amplitude * math.sin(PHASE), 0.040]), np.array([moving, 0.45])
    with pytest.raises(ValueError, match=r"found no solution|found no periodic motion|has no derivative"):
        find_orbit(shaken, *guess, section=TABLE.period, crossings=TURNS)
    nodes = [np.tile(part, (TURNS, 1)) for part in guess]
    found = find_orbit(shaken, *nodes, section=TABLE.period, crossings=TURNS, segments=TURNS)
    phase = -TABLE.phase
    trace = 1 + 0.5**2 - 1.5**2 * TABLE.strength * math.sin(phase)
    expected = np.roots([1.0, -trace, 0.5**2]) ** TURNS
    assert found.multipliers == pytest.approx(expected, rel=1e-7)
    assert abs(found.multipliers[0]) > 1e6 and abs(found.multipliers[1]) < 1e-13
    assert found.period == pytest.approx(TURNS * TABLE.period) and not found.stable
    assert found.runs <= 8 * TURNS  # Newton's method squares what is missed, from 0.01 to rounding
    since = TABLE.period - (phase - PHASE) % (2 * math.pi) / TABLE.frequency
    speed = G * TABLE.period / 2
    height = TABLE.amplitude * math.sin(phase) + speed * since - G * since**2 / 2
    assert found.states[:, 1] == pytest.approx(height + RADIUS, abs=1e-10)
    assert found.states[:, 3] == pytest.approx(speed - G * since, abs=1e-9)


PENDULUM = """
name = "upright"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "lower"
points = { O = [0, 0], A = [0, 1] }
point_mass = { at = [0, 1], mass = 1 }
[[link]]
name = "upper"
points = { A = [0, 0], B = [0, 1] }
point_mass = { at = [0, 1], mass = 1 }
[[joint]]
name = "base"
between = ["ground.O", "lower.O"]
[[joint]]
name = "knee"
between = ["lower.A", "upper.A"]
[gravity]
g = 10
[run]
until = 10
rtol = 1e-12
"""


def test_a_double_pendulum_upright(workshop: Workshop) -> None:
    """It stands for a time in which it would fall by a factor of a million, begun beside that: all four multipliers,
    from 1e6 to 1e-6, by M x'' = G x."""
    model = workshop.model(PENDULUM, derivatives=True)
    rates = np.linalg.eigvals(np.linalg.solve([[2.0, 1.0], [1.0, 1.0]], [[20.0, 0.0], [0.0, 10.0]]))
    time = math.log(1e6) / math.sqrt(rates.max())
    guess = np.array([0.01, -0.02]), np.array([0.03, 0.0])
    nodes = [np.tile(part, (6, 1)) for part in guess]
    found = find_orbit(model, *nodes, section=time, segments=6)
    assert np.abs(np.concatenate([found.q, found.u])).max() <= 1e-10
    roots = np.sqrt(rates)
    expected = np.sort(np.exp(np.concatenate([roots, -roots]) * time))[::-1]
    assert found.multipliers == pytest.approx(expected, rel=1e-8)


BOUNCES = """
name = "bounces"
[ground_link]
points = { O = [0, 0], W = [-1, 0] }
[[link]]
name = "mass"
mass = 2.0
inertia = 1.0
com = [0, 0]
points = { C = [0, 0] }
[[joint]]
name = "guide"
type = "prismatic"
between = ["ground.O", "mass.C"]
axis = [1, 0]
[[spring]]
between = ["ground.W", "mass.C"]
stiffness = 8.0
length = 1.1
[[ground]]
point = [0.1, 0]
normal = [-1, 0]
restitution = 1
contacts = ["mass.C"]
[run]
until = 20.0
rtol = 1e-12
"""


def test_segments_between_impacts(workshop: Workshop) -> None:
    """A mass on a spring that bounces off a wall: half a swing, the last segment ending where it strikes."""
    model = workshop.model(BOUNCES, derivatives=True)
    one, several = (find_orbit(model, [-0.4], [0.1], section=model.contacts[0], segments=k) for k in (1, 3))
    assert several.period == pytest.approx(math.pi / 2, abs=1e-10) == one.period
    assert several.multipliers == pytest.approx([1.0], abs=1e-9)
    assert abs(several.u[0]) == pytest.approx(2 * math.hypot(0.5, 0.05), abs=1e-9)


def test_segments_that_do_not_fit(shaken: Any) -> None:
    rule = (
        "in a model that depends on time, or with several crossings, the number of segments has to divide the number "
        "of crossings; ask for "
    )
    said = f"segments: found 2 with 1 crossing, expected a divisor of 1: {rule}2 crossings (--crossings 2, or "
    with pytest.raises(ValueError, match=re.escape(f"{said}crossings=2 from Python)")):
        find_orbit(shaken, section=TABLE.period, segments=2)
    said = f"segments: found 3 with 4 crossings, expected a divisor of 4: {rule}12 crossings (--crossings 12"
    with pytest.raises(ValueError, match=re.escape(said)):
        find_orbit(shaken, section=TABLE.period, crossings=4, segments=3)
    with pytest.raises(ValueError, match="segments: found 0, expected a number, at least 1"):
        find_orbit(shaken, section=TABLE.period, segments=0)
    with pytest.raises(ValueError, match=r"found shapes \(3, 2\) and \(2,\), expected one state, \(2,\), or one for"):
        find_orbit(shaken, np.zeros((3, 2)), [0.0, 0.0], section=TABLE.period, crossings=3, segments=3)


NEARLY = (
    (0.0250, 0.2073),
    (0.0226, 0.1987),
    (0.0214, 0.2467),
    (0.0215, 0.3005),
    (0.0248, 0.1877),
    (0.0221, 0.2289),
    (0.0225, 0.2690),
    (0.0225, 0.3639),
    (0.0250, 0.5133),
    (0.0517, 0.5780),
    (0.0552, 1.2672),
    (0.1124, -0.6948),
    (0.0336, -0.1836),
)
"""Heights (m) and speeds (m/s) of a ball that does not settle, a period apart, as it nears itself after thirteen."""


def test_an_orbit_of_a_ball_that_does_not_settle(shaken: Any) -> None:
    """Beside a run that came near itself there is an orbit, which its neighbours leave by six thousand million: by the
    table's exact map, and each of its impacts takes e^2 of a small area."""
    e = 0.79
    model, own = (
        shaken.with_parameters({"bounce.restitution": e}),
        BouncingTable(G, TABLE.amplitude, TABLE.frequency, e),
    )
    nodes = np.array(NEARLY)
    table = TABLE.amplitude * math.sin(PHASE), TABLE.amplitude * TABLE.frequency * math.cos(PHASE)
    q, u = (np.column_stack([np.full(len(nodes), table[k]), nodes[:, k]]) for k in (0, 1))
    found = find_orbit(model, q, u, section=TABLE.period, crossings=len(nodes), segments=len(nodes))
    after, count = after_a_period(own, found.states[:, 1] - RADIUS, found.states[:, 3])
    assert after == pytest.approx(np.roll(found.states[:, [1, 3]] - [RADIUS, 0.0], -1, axis=0), abs=1e-9)
    assert abs(found.multipliers[0]) > 1e9
    assert np.prod(found.multipliers) == pytest.approx(e ** (2 * count), rel=1e-6)


def after_a_period(own: BouncingTable, heights: Any, speeds: Any) -> tuple[Any, int]:
    """Heights and speeds (balls, 2) behind a period, and how often all balls strike together."""
    found, count, begin = [], 0, PHASE / own.frequency
    for first, leaving in zip(heights[:, None], speeds[:, None], strict=True):
        t, height, speed = np.array([begin]), first, leaving
        while (struck := own.next_impact(t, height, speed))[0] < begin + own.period:
            falling, moving = speed - own.gravity * (struck - t), own.table_speed(struck)
            t, height, speed, count = (
                struck,
                own.table(struck),
                moving + own.restitution * (moving - falling),
                count + 1,
            )
        left = begin + own.period - t
        found.append([*(height + speed * left - own.gravity * left**2 / 2), *(speed - own.gravity * left)])
    return np.array(found), count
