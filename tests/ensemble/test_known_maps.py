"""Maps over two numbers whose every cell is known: a rocking block that falls over or not, a ball on a table that goes
up and down, and the stride and the torque of Jansen's leg with other lengths."""

from __future__ import annotations

import math
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from ccgen.generator import load_scene
from ccgen.runtime import ensemble, simulate

from ..oracles.maximal import Array
from ..support.folders import SCENES
from ..support.jansen_foot import foot, torque
from ..support.shaken_table import RADIUS, SHAKEN, TABLE
from ..support.workshop import Workshop

WIDTH, HEIGHT, MASS, G = 0.5, 1.5, 60.0, 9.81
BLOCK = f"""
name = "rocking-block"
[[link]]
name = "block"
mass = {MASS}
inertia = {MASS * (WIDTH**2 + HEIGHT**2) / 12.0}
com = [{WIDTH / 2}, {HEIGHT / 2}]
points = {{ A = [0, 0], B = [{WIDTH}, 0], C = [{WIDTH}, {HEIGHT}], D = [0, {HEIGHT}] }}
[[ground]]
restitution = 0.0
friction = 2.0
contacts = ["block.A", "block.B", "block.C", "block.D"]
[gravity]
g = {G}
[run]
until = 6.0
"""


def falls(tilt: Array, rate: Array) -> Array:
    """1 to the left, on whose corner A it stands, -1 to the right, 0 neither (Housner 1963).

    Over a corner it gets with an energy above m g R. When it comes down flat the other corner takes over, and angular
    momentum about that one is kept: the rate is multiplied by 1 - 3/2 sin² of the angle of the diagonal.
    """
    alpha, far = math.atan2(WIDTH, HEIGHT), math.hypot(WIDTH, HEIGHT) / 2.0
    inertia = MASS * (WIDTH**2 + HEIGHT**2) / 3.0
    energy = inertia / 2.0 * rate**2 + MASS * G * far * np.cos(alpha - tilt)
    top, flat = MASS * G * far, MASS * G * far * math.cos(alpha)
    left = (rate > 0.0) & (energy > top)
    right = ~left & ((energy - flat) * (1.0 - 1.5 * math.sin(alpha) ** 2) ** 2 + flat > top)
    return left.astype(float) - right


def test_a_rocking_block_falls_where_it_must(workshop: Workshop) -> None:
    """All cells but those whose verdict other rates within 1 % would change."""
    model = workshop.model(BLOCK)
    tilt, rate = (x.ravel() for x in np.meshgrid(np.linspace(0.01, 0.31, 21), np.linspace(-2.0, 2.0, 41)))
    q0, u0 = np.zeros((2, tilt.size, 3))
    q0[:, 2], u0[:, 2] = tilt, rate
    made = ensemble(model, q0=q0, u0=u0, observe=["block.angle", "block.A.x"])
    assert set(made.status) == {"done"}
    angle = made["block.angle"]
    found = np.where(np.abs(angle) > 0.5, np.sign(angle), 0.0)
    wanted = falls(tilt, rate)
    sure = (falls(tilt, 0.99 * rate) == wanted) & (falls(tilt, 1.01 * rate) == wanted)
    assert np.count_nonzero(sure) > 0.97 * tilt.size and min(np.count_nonzero(wanted == x) for x in (-1, 0, 1)) > 100
    assert np.array_equal(found[sure], wanted[sure])
    lies = found != 0.0
    assert np.abs(np.abs(angle[lies]) - math.pi / 2.0).max() < 1e-9  # on its side


def balls(gap: Array, speed: Array) -> dict[str, Array]:
    """Starts with balls at gaps above the table, which goes up through its middle."""
    q0, u0 = np.zeros((2, gap.size, 2))
    q0[:, 1], u0[:, 1] = RADIUS + gap, speed
    u0[:, 0] = TABLE.amplitude * TABLE.frequency
    return {"q0": q0, "u0": u0}


@pytest.mark.hard
def test_a_ball_on_a_shaken_table_bounces_or_rests(workshop: Workshop) -> None:
    """From each start the ball comes to bounce once a period, or comes to rest again and again: by the exact map which.

    What bounces is drawn to its orbit by the factor e, 0.5, an impact; where it rests while the table goes up through
    its middle the gap is none. Each cell is that of all starts within 1e-6 of its gap and speed too; and the first
    impacts are at the instants of the map, whose rounding grows by no more than its derivative from one to the next.
    """
    model = workshop.model(SHAKEN)
    gap, speed = (x.ravel() for x in np.meshgrid(np.linspace(0.002, 0.122, 21), np.linspace(-1.0, 1.0, 21)))
    times, rests = TABLE.impacts(gap.copy(), speed.copy(), 60)
    for share in (1.0 - 1e-6, 1.0 + 1e-6):
        assert np.array_equal(TABLE.impacts(share * gap, share * speed, 60)[1], rests)
    phase = TABLE.frequency * times[~rests, -1] % (2.0 * math.pi)
    assert np.abs(phase - TABLE.phase).max() < 1e-12 and np.abs(TABLE.multipliers) == pytest.approx(0.5)
    assert 150 < np.count_nonzero(rests) < gap.size - 150
    made = ensemble(model, **balls(gap, speed), observe=["q", "impact_times(6)"])
    assert set(made.status) == {"done"}
    orbit, _ = TABLE.orbit_at_middle()
    found = made["q"][:, 1] - RADIUS
    assert np.array_equal(found < orbit / 2.0, rests)
    assert np.abs(found[rests]).max() < 1e-9 and np.abs(found[~rests] - orbit).max() < 1e-5
    assert np.abs(made["impact_times(6)"] - times[:, :6]).max() < 1e-11


def test_bouncing_once_a_period_is_stable_where_it_must_be(workshop: Workshop) -> None:
    """Restitutions from 0.35 to 0.75, each ball 1e-5 m above its own orbit: after 200 periods it is on it again just
    where the orbit is there and its multipliers are less than one.

    Left out are those whose multipliers are so near to 1 that 200 impacts make less of a factor than 1e3."""
    model = workshop.model(SHAKEN)
    tables = [replace(TABLE, restitution=e) for e in np.linspace(0.35, 0.75, 41).tolist()]
    there = np.array([one.strength > one.least_strength for one in tables])
    known = [one.orbit_at_middle() if ok else (0.02, 0.0) for one, ok in zip(tables, there, strict=True)]
    largest = np.array([np.abs(one.multipliers).max() if ok else 2.0 for one, ok in zip(tables, there, strict=True)])
    sure = np.abs(np.log(largest)) * 200 > math.log(1e3)
    stable = there & (largest < 1.0)
    assert np.array_equal(stable, [one.least_strength < one.strength < one.stable_until for one in tables])
    gap, speed = np.array(known).T
    restitutions = {"bounce.restitution": [one.restitution for one in tables]}
    made = ensemble(model, restitutions, **balls(gap + 1e-5, speed), observe=["q"], until=200 * TABLE.period)
    assert set(made.status) == {"done"}
    back = np.abs(made["q"][:, 1] - RADIUS - gap) < 1e-7
    assert np.count_nonzero(sure) >= 38 and 10 < np.count_nonzero(stable[sure]) < np.count_nonzero(sure) - 10
    assert np.array_equal(back[sure], stable[sure])


FINE = 4
"""Times as many angles as there are instants at which the closed form of the torque is looked at."""


def turn_at_which_the_foot_stops(cranks: Array, struts: Array, first: Array) -> NDArray[np.float64]:
    """From ``first`` on, how far the crank can turn until shin and tie are in line, by halving; infinite where it goes
    all round."""
    steps = np.linspace(0.0, 2.0 * math.pi, 2001)
    with np.errstate(invalid="ignore"):
        shut = np.isnan(foot(first[:, None] + steps, m=cranks[:, None], c=struts[:, None]))
        low = steps[np.maximum(shut.argmax(axis=1), 1) - 1]
        high = low + steps[1]
        for _ in range(50):
            middle = (low + high) / 2.0
            beyond = np.isnan(foot(first + middle, m=cranks, c=struts))
            low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    return np.where(shut.any(axis=1), low, math.inf)


def test_strides_of_legs_with_other_lengths(workshop: Workshop) -> None:
    """Cranks of 12 to 17 and struts of 38 to 41: the foot at every instant, the stride, and legs that cannot go round.

    A leg stops where its motion ends as a square root does. A step takes a share of what is left before it, by rounding
    one in some is refused and takes half of that share: less is left than the last four have taken, which holds while a
    step takes a sixth of it or more, (5/6)⁴ < 1/2.

    Each extreme is read at times whose crank angles are ``apart``; between them it lies at most half of that away, and
    is missed by a (apart / 2)² / 2 at most, a being the largest second derivative of the foot's place by the angle.
    """
    model = workshop.model(load_scene(SCENES / "jansen-driven.toml"))
    cranks, struts = (x.ravel() for x in np.meshgrid(np.linspace(12.0, 17.0, 6), np.linspace(38.0, 41.0, 4)))
    at = np.linspace(0.0, 1.0, 1001)
    names = ["max(shin.F.x)", "min(shin.F.x)", "shin.F.x", "crank.angle"]
    made = ensemble(model, {"crank.points.A.x": cranks, "strut.points.C.x": struts}, observe=names, at=at)
    angles, first = made["crank.angle"], made["crank.angle"][:, 0]
    limit = turn_at_which_the_foot_stops(cranks, struts, first)
    whole = np.isinf(limit)
    assert np.array_equal(made.status == "done", whole) and 0 < np.count_nonzero(~whole) < whole.size
    for row in np.flatnonzero(~whole).tolist():
        alone = simulate(model, params={"crank.points.A.x": cranks[row], "strut.points.C.x": struts[row]})
        assert alone.t[-1] == made.t[row]
        left = limit[row] / (2.0 * math.pi) - made.t[row]
        assert 0.0 < left < made.t[row] - alone.t[-5]
    assert all("tie and shin are in line there" in made.reason[row] for row in np.flatnonzero(~whole))
    places = foot(angles[whole], m=cranks[whole, None], c=struts[whole, None]).real
    assert np.abs(made["shin.F.x"][whole] - places).max() < 1e-10  # lengths to 66, joints shut to rounding
    turn = np.linspace(0.0, 2.0 * math.pi, 100_001)
    fine = foot(turn, m=cranks[whole, None], c=struts[whole, None]).real
    apart = 2.0 * math.pi * at[1]
    bend = np.abs(np.diff(fine, 2, axis=1)).max(axis=1) / turn[1] ** 2
    missed = np.ptp(fine, axis=1) - (made["max(shin.F.x)"] - made["min(shin.F.x)"])[whole]
    own = bend * (turn[1] / 2.0) ** 2  # what the closed form's own grid misses
    assert np.all(missed >= -own - 1e-10) and np.all(missed <= bend * (apart / 2.0) ** 2 + 1e-10)
    assert bend.max() * (apart / 2.0) ** 2 < 2e-3  # of strides of 53 to 79


def test_peak_torque_of_legs_with_other_lengths(workshop: Workshop) -> None:
    """The torque that drives the crank at every instant, and its extremes over a turn, over twelve pairs of lengths.

    The closed form is the derivative of the leg's energy by series, over ``FINE`` times as many angles as there are
    times. That these are enough is seen from half as many. Two derivatives multiply what is rounded by the square of
    the highest order. Extremes are read at the times, as those of strides are."""
    file = SCENES / "jansen-driven.toml"
    scene = tomllib.loads(file.read_text())
    model = workshop.model(load_scene(file))
    cranks, struts = (x.ravel() for x in np.meshgrid(np.linspace(12.0, 15.0, 4), np.linspace(38.5, 40.5, 3)))
    at = np.linspace(0.0, 1.0, 1001)
    names = ["max(axle.moment)", "min(axle.moment)", "axle.moment", "crank.angle"]
    made = ensemble(model, {"crank.points.A.x": cranks, "strut.points.C.x": struts}, observe=names, at=at)
    assert set(made.status) == {"done"}

    def wanted(fine: int) -> Array:
        turn = made["crank.angle"][:, :1] + np.arange(1000 * fine) * (2.0 * math.pi / (1000 * fine))
        lengths = {"m": cranks[:, None], "c": struts[:, None]}
        return torque(turn, scene["link"], 2.0 * math.pi, scene["gravity"]["g"], **lengths)

    fine = wanted(FINE)
    peak = np.abs(fine).max(axis=1)
    cut = np.abs(fine[:, ::2] - wanted(FINE // 2)).max(axis=1)
    rounded = 16.0 * float(np.finfo(float).eps) * (1000 * FINE / 2) ** 2 * peak  # 1.4e-8 of the peak
    assert np.all(cut < rounded)
    off = np.abs(made["axle.moment"][:, :1000] - fine[:, ::FINE]).max(axis=1)
    assert np.all(off < rounded)
    apart = 2.0 * math.pi * at[1]
    bend = np.abs(np.diff(fine, 2, axis=1)).max(axis=1) / (apart / FINE) ** 2
    for found, best in ((made["max(axle.moment)"], fine.max(axis=1)), (-made["min(axle.moment)"], -fine.min(axis=1))):
        own = bend * (apart / FINE / 2.0) ** 2 / 2.0 + rounded
        assert np.all(best - found >= -own) and np.all(best - found <= bend * (apart / 2.0) ** 2 / 2.0 + own)
    assert peak.max() > 20.0 * peak.min()  # from legs that turn easily to one that hardly gets round
