"""Runs that get on so slowly that no number of steps would take them to their end."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np
import pytest

from ccgen.generator import chain
from ccgen.runtime import ensemble, simulate

from ..support.workshop import Workshop

FAST = """
name = "fast"
[pinned]
links = 3
[start]
angles = [1.2, 0.1, -1.3]
[gravity]
g = 1e300
[run]
until = 0.1
"""
STRETCH = 500_000


@pytest.fixture(scope="module")
def fast(workshop: Workshop) -> Any:
    return workshop.model(workshop.scene(FAST))


def test_it_is_told_after_a_stretch_of_steps(fast: Any) -> None:
    """The same of a run alone and of one of many; what was reached is kept."""
    run = simulate(fast)
    assert not run.success and run.t[-1] > 0.0 and len(run.t) <= STRETCH + 1
    assert "at the pace of its last steps it would take more than 1e+10 of them" in run.message
    table = ensemble(fast, {"gravity.g": np.array([1e300])})
    assert table.reason[0] == run.message


@pytest.mark.slow
def test_slow_runs_keep_their_budget(workshop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    """A pendulum has one pace: with a budget of 600,000 steps what takes 3 * 10**8 of them spends it, and what
    takes 2 * 10**9, more than a thousand budgets, does not."""
    model = workshop.model(chain(1, hinged=True, gravity=True))
    short = simulate(model, [0.0], [1.0], until=100.0)
    pace = 100.0 / (len(short.t) - 1)
    for module in ("one_run", "ending"):
        monkeypatch.setattr(import_module(f"ccgen.runtime.simulation.{module}"), "STEP_BUDGET", 600_000)
    spent = simulate(model, [0.0], [1.0], until=3e8 * pace)
    assert "600000 steps are spent" in spent.message
    endless = simulate(model, [0.0], [1.0], until=2e9 * pace)
    assert "more than 6e+08 of them" in endless.message and len(endless.t) <= STRETCH + 1
