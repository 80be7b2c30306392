"""What a run says of its energy is what its rows, its recorded losses and the works of its loads say, summed up by
other code (``tests/oracles/balance.py``); ``CCGEN_AUDITS`` says how many random runs a kind ``make hard`` does: 25
unless given, and 250 with ``CCGEN_LARGE=1``."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.generator.cli.report import print_audit, print_warnings
from ccgen.runtime import Run, load_run, simulate

from ..hard import driven, fuzz
from ..oracles.balance import energy, left
from ..support.folders import ROOT
from ..support.tiers import hard, many
from ..support.workshop import Workshop

MANY = int(os.environ.get("CCGEN_AUDITS", many(15, 250)))
MISSED = 1e-6
"""Of the energy that moves: friction changes within steps by kinks that a quadrature does not see."""

RINGS = """
[loop]
links = 4
length = [1.0, 0.5, 0.8, 0.7]
[start]
angles = [0.0, 1.0, 3.1, 4.2]
tilt = 0.2
height = 0.05
[gravity]
[[ground]]
restitution = 0.6
friction = 0.8
[run]
until = 1.5
law = "stronge"
"""
"""A ring with a + b = c + d that falls flat on rough ground."""

DROPPED = """
[[link]]
name = "ball"
mass = 1.0
inertia = 0.1
com = [0, 0]
free = true
points = { A = [0, 0] }
[gravity]
g = 9.81
[[ground]]
restitution = 0.0
contacts = ["ball.A"]
[start]
position = [0, 1]
"""

HEXAGON = """
[loop]
links = 6
length = 0.5
[gravity]
g = 9.81
[start]
height = 0.0
tilt = "30 deg"
[[ground]]
restitution = 0.3
friction = 0.4
law = "poisson"
[run]
until = 0.45
"""
"""It falls flat from an edge: all rods reach their line at one instant, above the ground."""

FALLS_INTO_MUD = """
[[link]]
name = "stick"
mass = 2.0
inertia = 0.1
com = [0, 0]
points = { C = [0, 0], T = [0.5, 0] }
[gravity]
[[drag]]
point = "stick.C"
linear = 0.5
[[event]]
name = "mud"
when = "y(stick.C) - 0.2"
set = { "drag_0.linear" = 9.0, "gravity.g" = 5.0 }
[start]
position = [0, 1]
[run]
until = 1.0
"""


def outside_of_steps(run: Run) -> Any:
    """Rows that are not within a stretch of time stepping: how its losses come about there is not recorded."""
    within = np.zeros(len(run.t), dtype=bool)
    for phase in run.phases:
        if phase.kind == "steps":
            within |= (run.t > phase.start) & (run.t < phase.end)
    return ~within


def check(scene: Any, run: Run, missed: float = MISSED) -> None:
    """Every row says what the balance does, and the audit the largest of them."""
    own, rows = left(scene, run), outside_of_steps(run)
    known = np.isfinite(own)
    assert known.all() or not run.success, run  # where a loop lies in a line, and a run stops, forces are no numbers
    moved = float(np.ptp(energy(run.model, run.q, run.u)) + np.max(np.abs(own[known])))
    height = float(np.max(np.sum(np.abs(run.model.energy(run.q, run.u)), axis=0)))  # of which rounding is a part
    off = np.abs(own - run.unexplained)[rows & known]
    assert off.max() <= missed * moved + 1e-13 * (height + run.t.size * 1e-3), (run, off.max(), moved)
    assert run.energy_drift == np.max(np.abs(run.unexplained))


SHIPPED = sorted({*(ROOT / "scenes").glob("*.toml"), *(ROOT / "scenes" / "gallery").glob("*.toml")})
STEPS_BY = 1.0
"""When (s) the ring has gone by time stepping for a while, and falls flat on the ground no more often than once."""
LONGEST = 2.0
"""Seconds: of an escapement that is two beats."""
LATER = ("trebuchet", "jack-in-a-box", "simplest-walker")
"""Runs put together from pieces, each of which is a run of its own."""
ROUGH = ("cam-follower", "loose-slider-crank", "strandbeest-walking")
"""Whose friction is that of cams, journals or links on links: where it acts this balance does not know."""


@pytest.mark.parametrize(
    "file",
    [
        pytest.param(file, id=file.stem, marks=[] if file.stem in ("four-bar", "planetary") else pytest.mark.hard)
        for file in SHIPPED
        if file.stem not in LATER + ROUGH
    ],
)
@pytest.mark.parametrize("method", ["gauss", pytest.param("dop853", marks=pytest.mark.hard)])
def test_shipped_scenes(file: Path, method: str, workshop: Workshop) -> None:
    scene = load_scene(file)
    model = workshop.model(scene)
    run = simulate(model, method=method, until=min(0.2 * model.duration, LONGEST))
    check(scene, run)


@pytest.mark.parametrize(
    ("text", "method"),
    [(RINGS, "dop853"), (RINGS, "moreau"), hard(HEXAGON, "gauss"), (HEXAGON, "moreau")],
    ids=["ring-dop853", "ring-moreau", "hexagon-gauss", "hexagon-moreau"],
)
def test_what_contacts_take_in_steps_counts_once(text: str, method: str, workshop: Workshop) -> None:
    """It went into the works of runs with friction, and was taken off once more: 23.1 J of 25.5 J of the hexagon."""
    scene = workshop.scene(text)
    run = simulate(workshop.model(text), until=STEPS_BY, method=method, step=1e-3 if method == "moreau" else None)
    check(scene, run)
    for phase in run.phases:
        assert phase.kind == "steps" or phase.taken == 0.0
        if phase.kind == "steps":  # no more than what has gone
            before, after = (
                np.searchsorted(run.t, t, side=s) for t, s in ((phase.start, "right"), (phase.end, "left"))
            )
            gone = -np.diff(energy(run.model, run.q[[before - 1, after]], run.u[[before - 1, after]]))[0]
            assert -1e-12 <= phase.taken <= gone + 1e-12


def test_energy_that_goes_in_steps_is_told(workshop: Workshop, tmp_path: Path) -> None:
    """Whatever a run loses beside what impacts record is either drift or taken in steps."""
    model = workshop.model(RINGS)
    run = simulate(model, until=0.3, method="moreau", step=1e-4)
    rows = energy(model, run.q, run.u)
    lost = rows[0] - rows[-1] - sum(impact.energy_loss for impact in run.impacts)
    taken = sum(phase.taken for phase in run.phases if phase.kind == "steps")
    assert lost > 0.1 and abs(lost - taken) <= run.energy_drift + 0.02 * float(np.ptp(rows))  # of sliding
    read = load_run(run.save(tmp_path / "run.npz"), model)
    assert np.array_equal(read.unexplained, run.unexplained) and read.phases == run.phases


def test_much_energy_that_goes_in_steps_is_warned_of(workshop: Workshop, capsys: pytest.CaptureFixture[str]) -> None:
    """As of a run that went by steps where it should have gone from event to event: a ball that falls by a metre and
    does not bounce loses its 9.81 J there."""
    model = workshop.model(DROPPED)
    run = replace(simulate(model, until=1.0, method="moreau", step=1e-3), method="gauss")
    print_audit(run)
    print_warnings(run)
    printed = capsys.readouterr()
    assert "warning: contacts took 9.81 J, 1e+02 % of the energy that moves" in printed.err
    assert "in no impact that is recorded" in printed.err
    assert "beside 9.81 J that contacts took in steps" in printed.out


def test_a_cut_run_tells_of_its_own_rows(workshop: Workshop) -> None:
    """Parameters are set on the way: the two pieces have each its loads, and the jump between them is the event's."""
    model = workshop.model(FALLS_INTO_MUD)
    run = simulate(model)
    (event,) = run.events
    assert run.success and event.energy == pytest.approx(2.0 * (5.0 - 9.81) * 0.2, rel=1e-9)
    total = np.concatenate([sum(piece.run.model.energy(piece.run.q, piece.run.u)) for piece in run.advance.pieces])
    assert abs(total[-1] - total[0] - event.energy) > 1.0  # drag takes that
    for piece in run.advance.pieces:
        check(workshop.scene(FALLS_INTO_MUD), piece.run)
    assert run.unexplained.shape == run.t.shape
    assert run.energy_drift == np.max(np.abs(run.unexplained)) < 1e-9


def _random(kind: str, count: int, workshop: Workshop) -> None:
    if kind == "driven":
        for one in driven.driven(count, 7):
            run = driven.run(workshop.model, one)
            if not any(phase.kind == "steps" for phase in run.phases):  # drives' work is not told apart there
                check(workshop.scene(driven.scene(one.kind, one.links)), run, 1e-5)
        return
    for toss in fuzz.tosses(count, 3):
        scene = fuzz.scene(toss.n, toss.rough)
        check(scene, fuzz.run(workshop.model(scene), toss, until=2.0, rtol=1e-9), 1e-5)


@pytest.mark.hard
@pytest.mark.parametrize("kind", ["tossed", "driven"])
def test_random_runs(kind: str, workshop: Workshop) -> None:
    _random(kind, MANY, workshop)


def test_a_few_random_tosses(workshop: Workshop) -> None:
    tosses = [toss for toss in fuzz.tosses(60, 3) if toss.n == 6][:4]
    for toss in tosses:
        scene = fuzz.scene(toss.n, toss.rough)
        check(scene, fuzz.run(workshop.model(scene), toss, until=1.5, rtol=1e-9), 1e-5)
