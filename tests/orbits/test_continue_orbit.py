"""Branches of periodic motions: their folds, flips, Neimark-Sacker bifurcations and grazing at closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from ccgen.runtime import Branch, continue_orbit, double_period, find_orbit
from ccgen.runtime.orbits.diagram import draw_branches

from ..oracles.bouncing_table import BouncingTable
from ..support.shaken_table import RADIUS, SHAKEN, TABLE, G
from ..support.workshop import Workshop

PHASE = 1.0
"""The table's phase at t = 0, at which none of the motions strikes."""
RESTITUTION = "bounce.restitution"


def table(restitution: float) -> BouncingTable:
    return BouncingTable(G, TABLE.amplitude, TABLE.frequency, restitution)


@pytest.fixture(scope="module")
def shaken(workshop: Workshop) -> Any:
    text = SHAKEN.replace("*t)", f"*t + {PHASE})").replace(
        "shaker = 0.0", f"shaker = {TABLE.amplitude * math.sin(PHASE)!r}"
    )
    return workshop.model(text + "rtol = 1e-12\n", derivatives=True)


@pytest.fixture(scope="module")
def bouncing(shaken: Any) -> Any:
    """The orbit with one impact a period, begun near its closed form."""
    since = TABLE.period - (TABLE.phase - PHASE) % (2 * math.pi) / TABLE.frequency
    speed = G * TABLE.period / 2
    height = TABLE.amplitude * math.sin(TABLE.phase) + speed * since - G * since**2 / 2
    q = [TABLE.amplitude * math.sin(PHASE), height + RADIUS]
    u = [TABLE.amplitude * TABLE.frequency * math.cos(PHASE), speed - G * since + 0.01]
    return find_orbit(shaken, q, u, section=TABLE.period)


@pytest.fixture(scope="module")
def branch(bouncing: Any) -> Branch:
    return continue_orbit(bouncing, RESTITUTION, (0.2, 0.8))


def test_a_fold_and_a_flip_at_their_closed_forms(branch: Branch) -> None:
    """The branch begins where the table is just fast enough, and is stable up to where its multipliers pass -1."""
    fold, flip = branch.bifurcations
    assert (fold.kind, flip.kind) == ("fold", "flip")
    strength = TABLE.strength
    assert fold.value == pytest.approx((math.pi - strength) / (math.pi + strength), abs=1e-13)
    assert flip.value == pytest.approx(
        brentq(lambda e: table(e).stable_until - strength, 0.5, 0.7, xtol=1e-15), abs=1e-13
    )
    assert np.abs(fold.orbit.multipliers - 1.0).min() <= 1e-6
    assert np.abs(flip.orbit.multipliers + 1.0).min() <= 1e-10


def test_all_points_of_a_branch(branch: Branch) -> None:
    """Both halves: phases, and multipliers by hand; the unstable half is the mirrored phase."""
    fold = branch.bifurcations[0].place
    for k, (value, orbit) in enumerate(zip(branch.values.tolist(), branch.orbits, strict=True)):
        own, (impact,) = table(value), orbit.run.impacts
        phase = own.phase if k > fold else -own.phase
        struck = (phase - PHASE) % (2 * math.pi) / own.frequency
        assert impact.t == pytest.approx(struck, abs=1e-9)
        trace = 1 + value**2 - (1 + value) ** 2 * own.strength * math.sin(phase)
        assert np.poly(orbit.multipliers) == pytest.approx([1.0, -trace, value**2], abs=1e-8)
    lower, upper = (next(one.value for one in branch.bifurcations if one.kind == kind) for kind in ("fold", "flip"))
    inside = (branch.values > lower) & (branch.values < upper) & (np.arange(len(branch.values)) > fold)
    assert np.array_equal(branch.stable, inside)


def test_why_a_branch_ends(branch: Branch) -> None:
    assert branch.ends[0] == "bounce.restitution reached 0.8"
    assert "an impact comes to the instant of the section: begin at another phase" in branch.ends[1]
    # the phase of the stable orbit comes to that at which the run begins
    at_start = brentq(lambda e: table(e).phase - PHASE, 0.5, 0.7, xtol=1e-15)
    assert branch.values[-1] == pytest.approx(at_start, abs=1e-5)


@pytest.mark.parametrize("columns", [2, 100])
def test_dots_of_settled_runs_show_beside_the_lines(columns: int, branch: Branch) -> None:
    """On a branch that is stable they lie under its line, and have to be wider."""
    dots = np.linspace(0.3, 0.8, columns), np.full(columns, 0.9)
    axes = draw_branches([branch], settled=dots).axes[0]
    drawn = next(line for line in axes.lines if len(line.get_xdata()) == columns and line.get_linestyle() == "None")
    assert drawn.get_markersize() > 2.0 * max(
        line.get_linewidth() for line in axes.lines if line.get_marker() == "None"
    )
    assert axes.get_xlabel() == f"{RESTITUTION} [SI units]"
    for unit, said in (("", RESTITUTION), ("kg", f"{RESTITUTION} [kg]")):
        assert draw_branches([branch], unit=unit).axes[0].get_xlabel() == said


def test_the_doubled_branch(branch: Branch) -> None:
    """Behind the flip two impacts in two periods, by the exact map of the table: they come back to their phases."""
    (flip,) = (one for one in branch.bifurcations if one.kind == "flip")
    doubled = double_period(flip)
    value = doubled.return_map.model.parameters[RESTITUTION]
    assert value > flip.value and doubled.stable and doubled.period == 2 * TABLE.period
    found = continue_orbit(doubled, RESTITUTION, (0.5, 0.8), way="up")
    assert found.values[-1] > value
    assert found.ends[0] == "not followed, as the way asked for was 'up'"
    for e, orbit in ((value, doubled), (found.values[-1], found.orbits[-1])):
        first, second = orbit.run.impacts
        phase = (first.t * TABLE.frequency + PHASE) / TABLE.frequency
        height = np.array([TABLE.amplitude * math.sin(phase * TABLE.frequency)])
        leaving = np.array([first.u_plus[1]])
        t, v = np.array([phase]), leaving
        times = []
        for _ in range(2):
            own = table(e)
            after = own.next_impact(t, height, v)
            falling, moving = v - G * (after - t), own.table_speed(after)
            t, height, v = after, own.table(after), moving + e * (moving - falling)
            times.append(float(t[0]))
        assert times[0] - phase == pytest.approx(second.t - first.t, abs=1e-8)
        assert times[1] - phase == pytest.approx(2 * TABLE.period, abs=1e-8)
        assert float(v[0]) == pytest.approx(float(leaving[0]), abs=1e-7)
        assert abs(second.t - first.t - TABLE.period) > 1e-3


SPRING = """
name = "shaken"
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
length = 1.0
[[damper]]
between = ["ground.W", "mass.C"]
damping = 1.2
[[force]]
point = "mass.C"
vector = ["5*cos(3*t + 1)", 0]
[[ground]]
point = [0.5, 0]
normal = [-1, 0]
restitution = 0.6
contacts = ["mass.C"]
[run]
until = 200.0
rtol = 1e-12
"""
SWINGS = 2 * math.pi / 3


def test_grazing_of_a_motion_that_does_not_strike(workshop: Workshop) -> None:
    """A shaken mass comes to a wall as its spring becomes stiffer: where its response is as large as the way there."""
    model = workshop.model(SPRING, derivatives=True)
    orbit = find_orbit(model, [0.1], [0.0], section=SWINGS)
    branch = continue_orbit(orbit, "spring_0.stiffness", (7.0, 14.0))
    (grazing,) = branch.bifurcations
    assert grazing.kind == "grazing" and grazing.contact == ("mass.C", "ground_0")
    assert grazing.value == pytest.approx(18 - math.sqrt((5 / 0.5) ** 2 - 3.6**2), abs=1e-9)
    assert branch.values[0] == 7.0 and branch.ends == (
        "spring_0.stiffness reached 7",
        f"mass.C on ground_0 grazes at {grazing.value:.9g}",
    )


def struck_once(speed: float, e: float) -> tuple[float, float]:
    """Where the wall has to be for the mass to strike it once a period with this speed, and at which phase of the force
    it does: what is free of its swing repeats but for the jump (S. W. Shaw, P. J. Holmes, Journal of Sound and
    Vibration 90, 1983)."""
    A = np.array([[0.0, 1.0], [-4.0, -0.6]])
    values, vectors = np.linalg.eig(A)
    E = (vectors @ np.diag(np.exp(values * SWINGS)) @ np.linalg.inv(vectors)).real
    free = np.linalg.solve(E - np.eye(2), [0.0, (1 + e) * speed])
    response = 5 / (8 - 18 + 3.6j)
    # -3 |response| sin(angle) is the rate of the forced swing at the impact
    angle = math.asin((free[1] + e * speed) / (3 * abs(response)))
    return free[0] + abs(response) * math.cos(angle), angle - float(np.angle(response))


def swing_after(place: float, phase: float, rate: float, time: float) -> Any:
    """Place and rate of the mass so long after an impact, which it leaves with this rate."""
    A = np.array([[0.0, 1.0], [-4.0, -0.6]])
    values, vectors = np.linalg.eig(A)
    response = 5 / (8 - 18 + 3.6j)

    def forced(angle: float) -> Any:
        return np.array([(response * np.exp(1j * angle)).real, (3j * response * np.exp(1j * angle)).real])

    free = np.array([place, rate]) - forced(phase)
    return (vectors @ np.diag(np.exp(values * time)) @ np.linalg.inv(vectors) @ free).real + forced(phase + 3 * time)


def test_grazing_of_a_motion_that_strikes(workshop: Workshop) -> None:
    """The same grazing from the other side: as the wall is where the mass turns, it closes with no speed; all of the
    branch beside its closed form."""
    e = 0.6
    place, phase = struck_once(0.3, e)
    model = workshop.model(SPRING, derivatives=True).with_parameters({"ground_0.point.x": place})
    struck = (phase - 1.0) % (2 * math.pi) / 3
    x, v = swing_after(place, phase, -e * 0.3, SWINGS - struck)
    orbit = find_orbit(model, [x], [v], section=SWINGS)
    assert orbit.run.impacts[0].t == pytest.approx(struck, abs=1e-9)
    branch = continue_orbit(orbit, "ground_0.point.x", (0.3, 0.6), way="down")
    for value, one in zip(branch.values.tolist(), branch.orbits, strict=True):
        (impact,) = one.run.impacts
        assert value == pytest.approx(struck_once(float(impact.u_minus[0]), e)[0], abs=1e-9)
    grazing = next(one for one in branch.bifurcations if one.kind == "grazing")
    assert grazing.value == pytest.approx(abs(5 / (8 - 18 + 3.6j)), abs=1e-9)


COLUMN = """
name = "column"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "lower"
points = { O = [0, 0], A = [1, 0] }
point_mass = { at = [1, 0], mass = 2 }
[[link]]
name = "upper"
points = { A = [0, 0], B = [1, 0] }
point_mass = { at = [1, 0], mass = 1 }
[[joint]]
name = "base"
between = ["ground.O", "lower.O"]
[[joint]]
name = "knee"
between = ["lower.A", "upper.A"]
[[torsion]]
joint = "base"
stiffness = 1.0
damping = 0.1
[[torsion]]
joint = "knee"
stiffness = 1.0
damping = 0.2
[[force]]
point = "upper.B"
vector = [-1.0, 0]
frame = "link"
[run]
until = 10
rtol = 1e-12
"""


def test_flutter_of_a_column_under_a_follower_force(workshop: Workshop) -> None:
    """H. Ziegler's column (Ingenieur-Archiv 20, 1952): straight, it is a periodic motion of any period, and a pair of
    its multipliers passes the unit circle where a pair of eigenvalues passes the imaginary axis."""
    model = workshop.model(COLUMN, derivatives=True)
    orbit = find_orbit(model, section=1.0)
    assert orbit.missed == 0.0

    def eigenvalues(P: float) -> Any:
        M, C = np.array([[3.0, 1.0], [1.0, 1.0]]), np.array([[0.3, -0.2], [-0.2, 0.2]])
        K = np.array([[2.0 - P, P - 1.0], [-1.0, 1.0]])
        A = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
        return np.linalg.eigvals(A)

    assert np.sort(np.abs(orbit.multipliers)) == pytest.approx(np.sort(np.exp(eigenvalues(1.0).real)), abs=1e-10)
    branch = continue_orbit(orbit, "force_0.vector.x", (-4.0, -0.5))
    (found,) = branch.bifurcations
    critical = brentq(lambda P: eigenvalues(P).real.max(), 0.5, 3.0, xtol=1e-14)
    assert found.kind == "Neimark-Sacker" and found.value == pytest.approx(-critical, abs=1e-11)
    assert found.orbit.multipliers[0].imag != 0.0


def test_all_that_is_wrong_is_told_at_once(bouncing: Any, branch: Branch) -> None:
    with pytest.raises(ValueError) as caught:
        continue_orbit(bouncing, "bounce.bounciness", (1.0, 0.0), way="left", step=2.0, most=0)  # type: ignore[arg-type]
    for part in ("bounce.bounciness", "the lower one first", "way: found 'left'", "step: found 2.0", "most: found 0"):
        assert part in str(caught.value), str(caught.value)
    with pytest.raises(ValueError, match=r"found 0\.6 to 0\.8, expected a range around 0\.5, the value of bounce"):
        continue_orbit(bouncing, RESTITUTION, (0.6, 0.8))
    with pytest.raises(TypeError, match="orbit: found str, expected an Orbit"):
        continue_orbit("ball", RESTITUTION, (0.6, 0.8))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="flip: found fold, expected a flip"):
        double_period(branch.bifurcations[0])
