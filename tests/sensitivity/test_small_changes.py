"""A start moves with the parameters however little they change: differences at all steps are the derivative."""

from __future__ import annotations

import numpy as np
import pytest

from ccgen.generator import loop
from ccgen.runtime import ensemble, run_function, simulate

from ..support.driven_crank import CRANK
from ..support.workshop import Workshop

STEPS = (1e-3, 1e-5, 1e-7, 1e-9)
"""Shares of a length; the closure misses by as much, from far above what joints may miss to far below."""


@pytest.mark.parametrize(
    ("scene", "path"),
    [
        (loop(6, gravity=True), "link_1.length"),
        (CRANK + '[[drive]]\njoint = "axle"\nangle = "0.7 + t"\n[run]\nuntil = 0.2\n', "rod.points.B.x"),
    ],
    ids=["ring", "driven"],
)
def test_starts_move_without_a_jump(scene: object, path: str, workshop: Workshop) -> None:
    model = workshop.model(scene, derivatives=True)
    function = run_function(model, path, "q", until=0.1)
    x, derivative = function.x0, function.jacobian(function.x0)[:, 0]
    for step in STEPS:
        found = (function(x * (1.0 + step)) - function(x * (1.0 - step))) / (2.0 * step * x)
        assert np.abs(found - derivative).max() <= 10.0 * step**2 + 1e-14 / step, step


def test_so_do_those_of_ensembles(workshop: Workshop) -> None:
    model = workshop.model(loop(6, gravity=True), derivatives=True)
    lengths = 1.0 + np.array(STEPS)
    found = ensemble(model, params={"link_1.length": lengths}, until=0.1, observe=["q"])
    alone = np.array([simulate(model, params={"link_1.length": one}, until=0.1).q[-1] for one in lengths])
    assert np.array_equal(found["q"], alone)
