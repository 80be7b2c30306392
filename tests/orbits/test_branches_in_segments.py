"""Branches by multiple shooting, at closed forms: motions that one run from a start loses, and periods that change."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from ccgen.runtime import continue_orbit, double_period, find_orbit
from ccgen.runtime.orbits.section import read_map
from ccgen.runtime.orbits.shooting import PLACES, Chain, _ends, _timed, multipliers_of, spread, whole

from ..oracles.bouncing_table import BouncingTable
from ..support.shaken_table import RADIUS, SHAKEN, TABLE, G
from ..support.simplest_walker import SEARCH, STONES, with_feet
from ..support.workshop import Workshop

RESTITUTION = "bounce.restitution"
PHASE = 1.0
TURNS = 20
"""Periods in which neighbours of the unstable orbit leave by a factor of two thousand million: 2.93^20 = 2.1e9."""


@pytest.mark.hard
def test_a_branch_that_one_run_loses(workshop: Workshop) -> None:
    """The unstable orbit on the shaken table, as one of twenty periods, through the fold at which it becomes the stable
    one: heights and both multipliers by hand at all points. By single shooting not one step is made."""
    text = SHAKEN.replace("*t)", f"*t + {PHASE})").replace(
        "shaker = 0.0", f"shaker = {TABLE.amplitude * math.sin(PHASE)!r}"
    )
    model = workshop.model(text + "rtol = 1e-12\n", derivatives=True)
    guess = [TABLE.amplitude * math.sin(PHASE), 0.040], [TABLE.amplitude * TABLE.frequency * math.cos(PHASE), 0.45]
    nodes = [np.tile(part, (TURNS, 1)) for part in guess]
    orbit = find_orbit(model, *nodes, section=TABLE.period, crossings=TURNS, segments=TURNS)
    assert abs(orbit.multipliers[0]) > 2e9
    single = dataclasses.replace(orbit, chain=whole(orbit.return_map), nodes=orbit.nodes[:1])
    lost = continue_orbit(single, RESTITUTION, (0.35, 0.55))
    assert len(lost.values) == 1 and all("does not converge" in end for end in lost.ends)
    branch = continue_orbit(orbit, RESTITUTION, (0.35, 0.55), step=0.1)
    assert branch.ends == ("bounce.restitution reached 0.55", "bounce.restitution reached 0.55")
    (fold,) = branch.bifurcations
    assert fold.kind == "fold"
    assert fold.value == pytest.approx((math.pi - TABLE.strength) / (math.pi + TABLE.strength), abs=1e-12)
    unstable = np.abs([one.multipliers[0] for one in branch.orbits]) > 1.0
    assert unstable[0] != unstable[-1]
    for e, one, way in zip(branch.values.tolist(), branch.orbits, np.where(unstable, -1.0, 1.0), strict=True):
        own = BouncingTable(G, TABLE.amplitude, TABLE.frequency, e)
        phase = way * own.phase
        trace = 1 + e**2 - (1 + e) ** 2 * own.strength * math.sin(phase)
        expected = np.roots([1.0, -trace, e**2]) ** TURNS
        assert np.sort(np.abs(one.multipliers)) == pytest.approx(np.sort(np.abs(expected)), rel=1e-6)
        speed, since = G * own.period / 2, own.period - (phase - PHASE) % (2 * math.pi) / own.frequency
        height = own.amplitude * math.sin(phase) + speed * since - G * since**2 / 2
        assert one.states.shape == (TURNS, 4) and one.states[:, 1] == pytest.approx(height + RADIUS, abs=1e-9)


@pytest.mark.hard
def test_segments_follow_the_period(workshop: Workshop) -> None:
    """The simplest walker where gravity becomes four times as strong: the same gait in half the time, in three segments
    that end after times, the last where its foot strikes. Two thirds of the first period are longer than the last one:
    the times have to follow it."""
    model = with_feet(workshop.model(STONES, derivatives=True), 1e-4)
    orbit = find_orbit(model, **SEARCH, segments=3)
    alone = find_orbit(model, **SEARCH)
    assert orbit.period == pytest.approx(alone.period, abs=1e-8) and orbit.nodes.shape == (3, 8)
    assert orbit.multipliers[:2] == pytest.approx(alone.multipliers[:2], abs=1e-7)
    first = sum(one.section for one in orbit.chain.maps[:2])
    branch = continue_orbit(orbit, "gravity.g", (1.0, 4.0), way="up")
    assert branch.ends[1] == "gravity.g reached 4" and not branch.bifurcations
    for g, one in zip(branch.values.tolist(), branch.orbits, strict=True):
        assert one.period == pytest.approx(alone.period / math.sqrt(g), abs=1e-8)
        assert one.q == pytest.approx(alone.q, abs=1e-8)
        assert one.u / math.sqrt(g) == pytest.approx(alone.u, abs=1e-8)
        assert one.multipliers[:2] == pytest.approx(alone.multipliers[:2], abs=1e-7)
        assert len(one.run.impacts) == len(alone.run.impacts)
    assert branch.orbits[-1].period < first


@pytest.mark.parametrize("impacts", [[], [1.0], [0.99, 1.04], [2.5], [1.0, 2.0]])
def test_segments_end_away_from_impacts(impacts: Any) -> None:
    """Of three in three seconds: at most a quarter from where equal ones end, a sixteenth from impacts."""
    ends = _ends(3.0, 3, impacts)
    assert all(abs(t - k) <= 0.25 + 1e-15 for k, t in enumerate(ends, 1))
    assert all(abs(t - one) >= 1.0 / PLACES - 1e-15 for t in ends for one in impacts)
    if not impacts:
        assert ends == [1.0, 2.0]


def test_doubling_in_segments(workshop: Workshop) -> None:
    """The stable orbit as one of three periods in three segments: its flip where the closed form has it, and behind it
    the motion of six periods is that of two, by single shooting, three times."""
    model = workshop.model(SHAKEN + "rtol = 1e-12\n", derivatives=True)
    since = -TABLE.phase % (2 * math.pi) / TABLE.frequency
    speed = G * TABLE.period / 2
    height = TABLE.amplitude * math.sin(TABLE.phase) + speed * since - G * since**2 / 2 + RADIUS
    guess = [0.0, height], [TABLE.amplitude * TABLE.frequency, speed - G * since + 0.001]
    orbit = find_orbit(model, *guess, section=TABLE.period, crossings=3, segments=3)
    branch = continue_orbit(orbit, RESTITUTION, (0.5, 0.7), way="up")
    (flip,) = (one for one in branch.bifurcations if one.kind == "flip")

    def beyond(e: float) -> float:
        return BouncingTable(G, TABLE.amplitude, TABLE.frequency, e).stable_until - TABLE.strength

    assert flip.value == pytest.approx(brentq(beyond, 0.5, 0.7, xtol=1e-15), abs=1e-12)
    doubled = double_period(flip)
    assert doubled.period == pytest.approx(6 * TABLE.period) and doubled.nodes.shape == (6, 4)
    first, second = doubled.states[0], doubled.states[1]
    assert abs(first[1] - second[1]) > 1e-4
    assert doubled.states == pytest.approx(np.tile([first, second], (3, 1)), abs=1e-9)
    again = find_orbit(doubled.return_map.model, first[:2], first[2:], section=TABLE.period, crossings=2)
    assert np.append(again.q, again.u) == pytest.approx(first, abs=1e-9)
    assert np.sort_complex(again.multipliers**3) == pytest.approx(np.sort_complex(doubled.multipliers), abs=1e-8)


@pytest.mark.hard
def test_segments_of_a_doubled_motion_follow_its_period(workshop: Workshop) -> None:
    """The simplest walker's gait of a long and a short step, where gravity becomes three times as strong: in steps of
    three segments, two of which take longer at first than a whole step at last. One run for each step comes back too,
    with the same multipliers."""
    pull, slope = "gravity.direction.x", 0.015
    model = with_feet(workshop.model(STONES, derivatives=True), 1e-4).with_parameters({pull: slope})
    theta, rate = 0.2003 * (slope / 0.009) ** (1 / 3), -0.1998 * (slope / 0.009) ** (1 / 3)  # as in test_walker_gaits
    guess = [0.0, 0.0, math.pi / 2 + theta, math.pi / 2 - theta], [0.0, 0.0, rate, math.cos(2 * theta) * rate]
    orbit = find_orbit(model, *guess, **SEARCH, segments=3)
    (flip,) = continue_orbit(orbit, pull, (slope, slope + 3e-4), way="up", step=0.3).bifurcations
    doubled = double_period(flip)
    assert doubled.nodes.shape == (6, 8) and abs(doubled.states[0, 2] - doubled.states[1, 2]) > 1e-3
    first = sum(one.section for one in doubled.chain.maps[:2])
    branch = continue_orbit(doubled, "gravity.g", (1.0, 3.0), way="up", step=0.2)
    assert branch.ends[1] == "gravity.g reached 3" and not branch.bifurcations
    for g, one in zip(branch.values.tolist(), branch.orbits, strict=True):
        assert one.period == pytest.approx(doubled.period / math.sqrt(g), abs=1e-8)
        assert one.states[:, :4] == pytest.approx(doubled.states[:, :4], abs=1e-8)
        assert one.states[:, 4:] / math.sqrt(g) == pytest.approx(doubled.states[:, 4:], abs=1e-8)
    last = branch.orbits[-1]
    assert last.nodes.shape == (6, 8) and last.period / 2 < first
    alone = whole(last.return_map)
    found = alone.at([(last.q, last.u)])
    assert np.abs(alone.system(found)[0]).max() <= 1e-8 and len(found[0].runs) == 2
    assert multipliers_of(alone.blocks(found))[:2] == pytest.approx(last.multipliers[:2], abs=1e-7)


BALL = """
name = "ball"
[[link]]
name = "ball"
mass = 1
inertia = 1
com = [0, 0]
points = { C = [0, 0] }
[start]
velocity = [1, 2]
[gravity]
g = 10
[[ground]]
restitution = 1
contacts = ["ball.C"]
[run]
until = 1.0
rtol = 1e-12
"""


def test_what_advances_begins_where_it_has_got_to(workshop: Workshop) -> None:
    """A ball that bounces on to the side, two bounces in two segments whose rough starts do not fit: the second one is
    moved along too, to where the first ends, 1 m/s by 2 v / g."""
    model = workshop.model(BALL, derivatives=True)
    q, u = np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0]]), np.array([[1.0, 2.0, 0.0], [1.0, 2.2, 0.0]])
    section = model.contacts[0]
    orbit = find_orbit(model, q, u, section=section, crossings=2, segments=2, advances=["ball.x"])
    assert orbit.missed <= 1e-10
    assert orbit.nodes[0, 4] == pytest.approx(orbit.nodes[1, 4], abs=1e-10)
    apart = float(orbit.nodes[1, 0] - orbit.nodes[0, 0])
    assert apart == pytest.approx(2 * orbit.u[1] / 10 * orbit.u[0], abs=1e-10)
    assert orbit.period == pytest.approx(4 * orbit.u[1] / 10, abs=1e-10)


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


def bounced(t: float) -> tuple[float, float]:
    """Place and rate of a mass of 2 kg on a spring of 8 N/m that rebounds at its place of rest, 0.1 m, from -0.2 m with
    0.8 m/s: halves of swings of 0.5 m, the first impact after arcsin(0.6)/2."""
    angle = 2 * t - math.asin(0.6)
    half = math.floor(angle / math.pi) + 1
    angle -= half * math.pi
    return 0.1 + 0.5 * math.sin(angle), math.cos(angle)


@pytest.mark.parametrize("times", [[0.321, 0.4], [0.1, 0.15], [0.75, 0.77]], ids=["impact", "last long", "last short"])
def test_segments_that_no_longer_fit_are_chosen_anew(times: Any, workshop: Workshop) -> None:
    """An impact 0.7 ms behind the end of one, and a last one that is far too long or too short: new ones begin on the
    same motion, at its closed form, about as long as each other and away from the impact."""
    model = workshop.model(BOUNCES, derivatives=True)
    a_map = read_map(model, ("guide.slide", -0.2), 1, None, None, (), {"rtol": None, "method": None})
    starts = [0.0, *np.cumsum(times)]
    chain = _timed(a_map, [*times, math.pi / 2 - starts[-1]])
    found = chain.at([tuple(np.array([one]) for one in bounced(t)) for t in starts])
    other, nodes = spread(chain, found) or pytest.fail("they were kept")
    begins = [0.0, *np.cumsum([one.section for one in other.maps[:-1]])]
    assert max(abs(t - k * math.pi / 6) for k, t in enumerate(begins)) <= math.pi / 24 + 1e-9
    assert min(abs(t - math.asin(0.6) / 2) for t in begins[1:]) >= math.pi / 96 - 1e-9
    for t, node in zip(begins, nodes, strict=True):
        assert np.concatenate(node) == pytest.approx(bounced(t), abs=1e-9)
    again = other.at(nodes)
    assert np.abs(other.system(again)[0]).max() <= 1e-9 and spread(other, again) is None


def test_of_a_doubled_motion_the_turn_that_no_longer_fits_is_parted_anew(workshop: Workshop) -> None:
    """The same motion twice: its first turn has a last segment that is far too long, the second one is as it should
    be and keeps its times."""
    model = workshop.model(BOUNCES, derivatives=True)
    a_map = read_map(model, ("guide.slide", -0.2), 1, None, None, (), {"rtol": None, "method": None})
    parts = [np.array([0.1, 0.15, math.pi / 2 - 0.25]), np.array([0.5, 0.5, math.pi / 2 - 1.0])]
    first, second = (_timed(a_map, part.tolist()) for part in parts)
    chain = Chain(a_map.doubled(), first.maps + second.maps, first.crosses + second.crosses)
    starts = [float(t) for part in parts for t in np.cumsum([0.0, *part[:-1]])]
    found = chain.at([tuple(np.array([one]) for one in bounced(t)) for t in starts])
    other, nodes = spread(chain, found) or pytest.fail("they were kept")
    assert other.map is chain.map and other.crosses == chain.crosses and other.maps[3:] == chain.maps[3:]
    for t, node in zip(np.cumsum([0.0, *(one.section for one in other.maps[:2])]).tolist(), nodes[:3], strict=True):
        assert np.concatenate(node) == pytest.approx(bounced(t), abs=1e-9)
    for t, node in zip(starts[3:], nodes[3:], strict=True):
        assert np.concatenate(node) == pytest.approx(bounced(t), abs=1e-9)
    again = other.at(nodes)
    assert np.abs(other.system(again)[0]).max() <= 1e-9 and spread(other, again) is None
    assert sum(one.time for one in again) == pytest.approx(math.pi, abs=1e-9)
