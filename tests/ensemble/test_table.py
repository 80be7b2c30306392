"""What the table of an ensemble holds, rows whatever happened; and what is refused before the first run."""

from __future__ import annotations

import ctypes
import math
import os
import signal
from typing import Any

import numpy as np
import pytest

from ccgen.generator import generate, load_scene
from ccgen.runtime import Model, Reduction, ensemble, load_model, simulate
from ccgen.runtime.ensemble.reduction import SIGNATURE

from ..support.folders import SCENES
from ..support.heeding import heeding_ctrl_c
from ..support.workshop import Workshop


@pytest.fixture(scope="module")
def hexagon(workshop: Workshop) -> Model:
    return workshop.model(load_scene(SCENES / "falling-hexagon.toml"))


PENDULUM = """
name = "pendulum"
[chain]
links = 1
hinged = true
[gravity]
g = 9.81
[run]
until = 2.0
"""


def test_a_row_for_every_run(hexagon: Model) -> None:
    masses = np.array([1.0, -1.0, math.nan, 2.0, 1e308])
    made = ensemble(hexagon, {"link_2.mass": masses}, observe=["impacts"], until=0.2)
    assert list(made.status[:4]) == ["done", "refused", "refused", "done"]
    assert made.reason[1] == "link_2.mass: found -1.0, expected a positive number"
    assert made.reason[2] == "link_2.mass: found nan, expected a finite number"
    assert made.status[4] != "done" and made.reason[4]
    assert len(made) == 5 and np.isnan(made["impacts"][1]) == np.isnan(made["impacts"][2])
    table = made.to_dataframe()
    assert list(table.columns) == ["status", "reason", "t", "steps", "impacts", "link_2.mass"] or "impacts" in table


def test_runs_that_stop_say_why(workshop: Workshop) -> None:
    """A crank driven against a stop; the sentence is that of the run alone."""
    text = """
name = "against"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "crank"
mass = 1
inertia = 0.1
com = [0.5, 0]
points = { O = [0, 0], A = [1, 0] }
[[joint]]
name = "axle"
between = ["ground.O", "crank.O"]
[[drive]]
joint = "axle"
speed = 2.0
[[stop]]
joint = "axle"
highest = 1.0
restitution = 0.5
[run]
until = 2.0
"""
    model = workshop.model(text)
    made = ensemble(model, q0=np.array([[0.0], [0.5]]), observe=["q"])
    for row, start in enumerate(([0.0], [0.5])):
        run = simulate(model, start)
        assert not run.success
        assert (made.status[row], made.reason[row], made.t[row]) == ("stopped", run.message, run.t[-1])


def test_extremes(hexagon: Model, workshop: Workshop) -> None:
    """Over times, by the core; over the rows of the run, and impulses, one by one."""
    at = np.linspace(0.0, 1.0, 101)
    speeds = np.array([0.5, 1.0])
    model = workshop.model(PENDULUM)
    names = ["max(link_0.angle)", "min(link_0.angle)", "link_0.angle"]
    made = ensemble(model, u0=speeds[:, None], observe=names, at=at)
    assert np.array_equal(made["max(link_0.angle)"], made["link_0.angle"].max(axis=1))
    assert np.array_equal(made["min(link_0.angle)"], made["link_0.angle"].min(axis=1))
    rows = ensemble(model, u0=speeds[:, None], observe=["max(link_0.angle)"])
    for row, speed in enumerate(speeds.tolist()):
        assert rows["max(link_0.angle)"][row] == simulate(model, u0=[speed])["link_0.angle"].max()
    one = ensemble(hexagon, {"gravity.g": [9.0, 9.81]}, observe=["max(joint_1.impulse)"], until=1.0)
    run = simulate(hexagon, params={"gravity.g": 9.0}, until=1.0)
    assert one["max(joint_1.impulse)"][0] == run["joint_1.impulse"].max() > 0.0


def test_energy_of_pendulums_is_that_of_their_starts(workshop: Workshop) -> None:
    """Parameters that vary: half the inertia about the hinge, m l^2 / 3, times u^2 lifts the centre by
    l / 2 (1 - cos a)."""
    model = workshop.model(PENDULUM)
    lengths = np.linspace(0.5, 2.0, 7)
    inertia = lengths**2 / 12.0
    params = {
        "link_0.length": lengths,
        "link_0.inertia": inertia,
        "link_0.com.x": lengths / 2.0,
        "link_0.mass": np.ones(7),
    }
    made = ensemble(
        model, params, q0=[-math.pi / 2], u0=[1.0], observe=["max(link_0.angle)"], at=np.linspace(0, 2, 4001)
    )
    swing = np.arccos(1.0 - lengths / (3.0 * 9.81))
    assert made["max(link_0.angle)"] + math.pi / 2 == pytest.approx(swing, abs=2e-6)


def test_a_reduction_in_machine_code(hexagon: Model) -> None:
    """It reads all rows of each run: their number, and the least height of the first joint."""

    @SIGNATURE
    def function(context: Any, t: Any, rows: Any, count: int, width: int, out: Any) -> int:
        out[0], out[1] = count, min(rows[i * width + 1] for i in range(count))
        return 0 if t[count - 1] > 0.5 else 1

    heights = np.array([0.0, 0.2])
    q, _ = hexagon.start()
    qs = np.tile(q, (2, 1))
    qs[:, 1] += heights
    made = ensemble(hexagon, q0=qs, until=1.0, reduction=Reduction(function, 2, "least"))
    for row, one in enumerate(qs):
        run = simulate(hexagon, one, until=1.0)
        assert made["least"][row].tolist() == [run.t.size, run.q[:, 1].min()]
    short = ensemble(hexagon, q0=qs, until=0.1, reduction=Reduction(function, 2))
    assert np.isnan(short["reduced"]).all()
    address = ctypes.cast(function, ctypes.c_void_p).value

    class Numba:
        pass

    Numba.address = address  # type: ignore[attr-defined]
    other = ensemble(hexagon, q0=qs, until=1.0, reduction=Reduction(Numba(), 2, "least"))
    assert np.array_equal(other["least"], made["least"])
    with pytest.raises(TypeError, match=r"reduction: found 3, expected a function of ctypes"):
        ensemble(hexagon, reduction=Reduction(3, 2))


def test_reduce_keeps_no_table(workshop: Workshop) -> None:
    model = workshop.model(PENDULUM)
    speeds = np.linspace(0.0, 1.0, 100_000)[:, None]
    sizes = []

    def most(found: float, table: Any) -> float:
        sizes.append(len(table))
        return max(found, float(table["q"].max()))

    found = ensemble(model, u0=speeds, observe=["q"], until=0.05, reduce=most, initial=-math.inf)
    assert sum(sizes) == 100_000 and len(sizes) > 1
    assert found == simulate(model, u0=[1.0], until=0.05).q[-1, 0]


def test_ctrl_c_keeps_what_is_done(workshop: Workshop) -> None:
    """Two thousand runs take half a minute of two processors; Ctrl-C comes when a few are done."""
    model = workshop.model(PENDULUM)
    speeds = np.linspace(0.0, 3.0, 2_000)[:, None]

    def press(done: int, count: int) -> None:
        if done > 3:
            signal.raise_signal(signal.SIGINT)

    with heeding_ctrl_c():
        made = ensemble(
            model, u0=speeds, observe=["q"], until=5000.0, threads=2, progress=press, keep_interrupted=True, rtol=1e-12
        )
    assert len(made) == 2_000 and "interrupted" in made.status
    done = np.flatnonzero(made.status == "done")
    for row in (done[0], done[-1]):
        assert np.array_equal(made["q"][row], simulate(model, u0=speeds[row], until=5000.0, rtol=1e-12).q[-1])
    assert all(reason for reason, status in zip(made.reason, made.status, strict=True) if status != "done")


def test_ctrl_c_ends_all_runs(workshop: Workshop) -> None:
    """Pressed by the fourth run as it ends, on one of the threads at work: the one that waits for them takes it."""
    model = workshop.model(PENDULUM)
    made: list[int] = []

    @SIGNATURE
    def press(context: Any, t: Any, rows: Any, count: int, width: int, out: Any) -> int:
        made.append(count)
        if len(made) == 4:
            os.kill(os.getpid(), signal.SIGINT)
        return 0

    with heeding_ctrl_c(), pytest.raises(KeyboardInterrupt):
        ensemble(model, u0=np.ones((2_000, 1)), until=5000.0, threads=2, rtol=1e-12, reduction=Reduction(press, 1))
    assert 4 <= len(made) < 2_000


def test_every_fault_at_once(hexagon: Model) -> None:
    with pytest.raises(ValueError) as refusal:
        ensemble(
            hexagon,
            {"link_0.mas": [1.0, 2.0], "gravity.g": [1.0, 2.0, 3.0]},
            u0=np.zeros((4, 8)),
            observe=["link_0.angl"],
            at=[0.0, 9.0],
            threads=0,
        )
    text = str(refusal.value)
    for part in (
        "link_0.mas: found no such parameter",
        "runs: found params: gravity.g of 3, u0 of 4, expected equally many of all",
        "observe: found 'link_0.angl', which nothing is called",
        "at: found 9 s, expected a row of times from 0 to",
        "threads: found 0, expected a number of threads",
    ):
        assert part in text


@pytest.mark.parametrize(
    ("asked", "text"),
    [
        ({"q0": np.zeros((2, 3))}, r"q0: found shape \(2, 3\), expected \(8,\) or \(runs, 8\)"),
        ({"params": {"gravity.g": []}}, "runs: found none in params: gravity.g, expected at least one"),
        ({"params": {"gravity.g": "9.81"}}, "params: gravity.g: found '9.81', expected numbers"),
        ({"observe": ["q", "q"]}, "expected each name once"),
        ({"observe": ["impact_times(0)"]}, "expected a number of times from 1"),
        ({"inputs": {"torque": [1.0]}}, "the model has no inputs"),
        ({"rtol": 2.0}, "rtol: found 2.0"),
    ],
)
def test_wrong_calls(hexagon: Model, asked: dict[str, Any], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        ensemble(hexagon, **asked)


def test_parameters_that_cannot_change(workshop: Workshop) -> None:
    folded = load_model(generate(workshop.scene(PENDULUM), out=workshop.folder / "folded", fold=True))
    with pytest.raises(ValueError, match="parameters are folded into its code"):
        ensemble(folded, {"gravity.g": [1.0, 2.0]})
