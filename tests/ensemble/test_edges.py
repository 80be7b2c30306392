"""Where an ensemble could differ from its runs alone: after another run, at dead points, at times in any order."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import Reduction, ensemble, simulate
from ccgen.runtime.ensemble.reduction import SIGNATURE

from ..support.workshop import Workshop

LINK = """
[[link]]
name = "{0}"
mass = {1}
inertia = 0.1
com = [0.25, 0]
points = {{ A = [0, 0], B = [0.5, 0] }}
"""
JOINT = '[[joint]]\nname = "{0}"\nbetween = ["{1}", "{2}"]\n'


def chain(masses: list[float]) -> str:
    """Links hinged one to the next, the first to the ground and turned by an input."""
    text, before = 'name = "chain"\n[ground_link]\npoints = { O = [0, 0] }\n', "ground.O"
    for number, mass in enumerate(masses):
        text += LINK.format(f"l{number}", mass) + JOINT.format(f"j{number}", before, f"l{number}.A")
        before = f"l{number}.B"
    return text + '[[input]]\nname = "tq"\njoint = "j0"\n[gravity]\ng = 9.81\n[run]\nuntil = 0.3\n'


@pytest.mark.hard
def test_runs_know_nothing_of_the_one_before(workshop: Workshop) -> None:
    """Masses so far apart that digits are lost, which is measured for each run: with no input of another's."""
    model = workshop.model(chain([1.0, 1.0, 1.0, 1.0]))
    apart = {f"l{number}.mass": mass for number, mass in enumerate([1e-3, 1e-3, 1e-3, 1e6])}
    inertia = {f"l{number}.inertia": 0.1 * mass for number, mass in enumerate([1e-3, 1e-3, 1e-3, 1e6])}
    params = {**apart, **inertia, "gravity.g": [9.0, 9.81]}
    assert model.with_parameters({**apart, **inertia}).kernels.refined
    alone = simulate(model, params={**params, "gravity.g": 9.81}, inputs={"tq": 0.0})
    for first in (0.0, 1e308):
        made = ensemble(model, params, inputs={"tq": [first, 0.0]}, observe=["q"], threads=1)
        assert np.array_equal(made["q"][1], alone.q[-1]) and made.steps[1] == alone.t.size - 1


FOUR_BAR = (
    'name = "stuck"\n[ground_link]\npoints = { O = [0, 0], Q = [1.0, 0] }\n'
    + "".join(LINK.format(name, 1.0) for name in ("crank", "rod", "rocker"))
    + JOINT.format("motor", "ground.O", "crank.A")
    + JOINT.format("p", "crank.B", "rod.A")
    + JOINT.format("r", "rod.B", "rocker.B")
    + JOINT.format("s", "ground.Q", "rocker.A")
    + '[[drive]]\njoint = "motor"\nangle = "0.3 + 2*t"\n[start]\n'
    + 'angles = { crank = "17 deg", rod = "20 deg", rocker = "120 deg" }\n[gravity]\ng = 9.81\n[run]\nuntil = 3.0\n'
)


def test_rows_end_at_dead_points(workshop: Workshop) -> None:
    """A crank that cannot go round: the row is that of the run, which is cut off where it stops."""
    model = workshop.model(FOUR_BAR)
    run = simulate(model)
    assert not run.success
    made = ensemble(model, observe=["q", "u", "rocker.angle"], at=[0.1, 2.9])
    assert (made.t[0], made.steps[0], made.reason[0]) == (run.t[-1], run.t.size - 1, run.message)
    assert np.array_equal(made["u"][0], run.u[-1]) and np.array_equal(made["q"][0], run.q[-1])
    assert made["rocker.angle"][0, 0] == run.values("rocker.angle", t=[0.1])["rocker.angle"][0]
    assert np.isnan(made["rocker.angle"][0, 1])


EVENT = """
[[event]]
name = "enough"
when = "t - 0.6"
stop = true
"""
PENDULUM = 'name = "pendulum"\n[chain]\nlinks = 1\nhinged = true\n[gravity]\ng = 9.81\n[run]\nuntil = 1.0\n'


def test_times_in_any_order(workshop: Workshop) -> None:
    at = [1.0, 0.0, 0.5]
    for text, known in ((PENDULUM, [True, True, True]), (PENDULUM + EVENT, [False, True, True])):
        model = workshop.model(text)
        made = ensemble(model, observe=["link_0.angle"], at=at)
        found, run = made["link_0.angle"][0], simulate(model)
        assert list(np.isfinite(found)) == known
        times = np.array(at)[known]
        assert np.array_equal(found[known], run.values("link_0.angle", t=times)["link_0.angle"])


def test_names_that_every_table_has(workshop: Workshop) -> None:
    model = workshop.model(PENDULUM)
    with pytest.raises(ValueError, match="observe: found 't', which is a column of every table"):
        ensemble(model, observe=["t"])
    with pytest.raises(ValueError, match="observe: found 'status', which is a column of every table"):
        ensemble(model, reduction=Reduction(SIGNATURE(lambda *_: 0), 1, "status"))
    with pytest.raises(
        ValueError, match=r"found 'link_0.com.x', which is the column of that parameter, expected another name"
    ):
        ensemble(model, {"link_0.com.x": [0.1, 0.2]}, observe=["link_0.com.x"])
    with pytest.raises(ValueError, match=r"observe: found 'link_0.angle', which is there already"):
        ensemble(model, observe=["link_0.angle"], reduction=Reduction(SIGNATURE(lambda *_: 0), 1, "link_0.angle"))


def test_reductions_read_doubles_alone(workshop: Workshop) -> None:
    model = workshop.model(PENDULUM, precision="wide")

    @SIGNATURE
    def function(context: Any, t: Any, rows: Any, count: int, width: int, out: Any) -> int:
        return 0

    assert ctypes.cast(function, ctypes.c_void_p).value
    with pytest.raises(ValueError, match="found a model in wide numbers, expected one in doubles"):
        ensemble(model, reduction=Reduction(function, 1))


def test_inputs_of_no_run(workshop: Workshop) -> None:
    model = workshop.model(chain([1.0]))
    with pytest.raises(ValueError, match="runs: found none in inputs, expected at least one"):
        ensemble(model, inputs={"tq": []})
    made = ensemble(model, inputs={"tq": [0.0, np.nan]})
    assert list(made.status) == ["done", "refused"]
    assert made.reason[1] == "inputs: found nan, expected finite numbers"
