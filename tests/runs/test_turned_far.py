"""Runs end where an angle has no digits left, with what was reached kept, and drawn."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.runtime import _core, simulate
from ccgen.runtime.model.tolerances import largest_angle
from ccgen.runtime.precision import core_of

from ..support.command_line import ccgen
from ..support.endings import ending
from ..support.workshop import Workshop

SPUN = """
name = "spun"

[chain]
links = 1
hinged = true

[[motor]]
joint = "joint_0"
torque = 1e10

[run]
until = 10.0
"""
INERTIA = 1.0 / 3.0
LIMIT = 1e-6 / 2.0**-52
"""rad: from here on the last digit of a double is larger than 1e-6."""


@pytest.fixture(scope="module")
def model(workshop: Workshop) -> Any:
    return workshop.model(SPUN)


def test_the_limit_is_that_of_the_numbers() -> None:
    assert largest_angle(_core) == pytest.approx(LIMIT, rel=1e-12)
    assert largest_angle(core_of("float")) == pytest.approx(1e4, rel=0.01)
    assert largest_angle(core_of("wide")) == pytest.approx(1e-6 / float(np.finfo(core_of("wide").REAL).eps), rel=1e-12)


@pytest.mark.parametrize("method", ["gauss", "dop853", "dopri5", "radau"])
def test_a_run_ends_there_with_its_rows(model: Any, method: str) -> None:
    """A rod under a constant torque: its angle is the limit at a time that is known."""
    run = simulate(model, method=method)
    assert ending(run) == "turned_far"
    assert "link_0.angle comes to 4.5e+09 rad" in run.message and "rad/s" in run.message
    assert np.abs(run.q).max() <= LIMIT
    assert run.t[-1] == pytest.approx(np.sqrt(2.0 * LIMIT * INERTIA / 1e10), rel=1e-8)
    q, u = run.at(0.5 * run.t[-1])
    assert model.point("link_0.B", q).shape == (2,) and np.isfinite(u).all()


def test_with_steps_of_fixed_length_it_ends_before(model: Any) -> None:
    run = simulate(model, step=0.1)
    assert ending(run) == "turned_far"
    assert run.t[-1] == pytest.approx(0.5, rel=1e-12) and run.q[-1, 0] <= LIMIT


def test_going_on_from_there_ends_at_once(model: Any) -> None:
    run = simulate(model)
    later = simulate(model, state=run.state, until=11.0)
    assert ending(later) == "turned_far" and later.t[-1] == pytest.approx(run.t[-1], rel=1e-12)


def test_in_floats_and_where_the_motion_is_prescribed(workshop: Workshop) -> None:
    run = simulate(workshop.model(SPUN, precision="float"))
    assert ending(run) == "turned_far" and np.abs(run.q).max() <= largest_angle(core_of("float"))
    driven = SPUN.replace("[[motor]]", "[[drive]]").replace("torque = 1e10", "speed = 1e10")
    run = simulate(workshop.model(driven))
    assert ending(run) == "turned_far" and run.t[-1] == pytest.approx(LIMIT / 1e10, rel=1e-8)


def test_the_command_says_so_and_draws_what_there_is(tmp_path: Path) -> None:
    (tmp_path / "spun.toml").write_text(SPUN)
    done = ccgen("run", "spun.toml", at=tmp_path)
    assert done.returncode == 3
    assert (
        done.stderr.startswith("spun: stopped at t = 0.5479415") and "link_0.angle comes to 4.5e+09 rad" in done.stderr
    )
    assert "Traceback" not in done.stderr
    written = {path.name for path in (tmp_path / "results" / "spun").iterdir()}
    assert written == {".ccgen.json", "result.npz", "plot.png", "player.html", "forces.png"}
