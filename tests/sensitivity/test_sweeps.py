"""Few differences that sweeps carry through steps: a closed form, and matrices of the same steps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ccgen.runtime import sensitivities
from ccgen.runtime._core import Carried
from ccgen.runtime.sensitivity import swept
from ccgen.runtime.sensitivity.steps import gauss

from ..hard import fuzz
from ..support.run_differences import RTOL, relative
from ..support.thrown_loops import throws
from ..support.workshop import Workshop

STIFFNESS = 4.0
"""1/s^2, of the oscillator whose differences obey u' = p - STIFFNESS q."""


class Stuck:
    """Steps through which sweeps do not go."""

    def __init__(self, *_: Any) -> None:
        pass

    def through(self, *_: Any) -> None:
        return None


def oscillator(h: float, back: list[Any]) -> Carried:
    """A step of length h, s: one coordinate, one rate, and p."""
    g = gauss()
    J = np.tile(np.array([-STIFFNESS, 0.0, 1.0])[:, None], (1, 1, 1, len(g.c)))
    return Carried(np.array([h]), (g.c, g.b, g.twice_b, g.A, g.twice), J, back)


def expected(h: float) -> Any:
    """The matrix (2, 3) of the same step."""
    w = np.sqrt(STIFFNESS)
    c, s = np.cos(w * h), np.sin(w * h)
    return np.array([[c, s / w, (1.0 - c) / w**2], [-w * s, c, s / w]])


@pytest.mark.parametrize("columns", [1, 2, 4, 7, 8, 13])
def test_a_step_is_that_of_an_oscillator(columns: int) -> None:
    whole = np.random.default_rng(columns).normal(size=(3, columns))
    found = oscillator(0.4, []).through(0, whole)
    assert found is not None
    assert np.abs(found - expected(0.4) @ whole).max() < 1e-14


@pytest.mark.parametrize("columns", [1, 4])
def test_steps_one_after_the_other(columns: int) -> None:
    """The second and the third of three; what puts their ends back makes none of it."""
    g, h = gauss(), np.array([0.7, 0.4, 0.1])
    J = np.tile(np.array([-STIFFNESS, 0.0, 1.0])[:, None], (3, 1, 1, len(g.c)))
    still = np.zeros((3, 1, 1)), np.zeros((3, 1, 3))
    steps = Carried(h, (g.c, g.b, g.twice_b, g.A, g.twice), J, [(0, *still), (1, *still)])
    whole = np.random.default_rng(columns).normal(size=(3, columns))
    found = steps.through(1, whole, 2)
    assert found is not None
    assert np.abs(found - expected(0.5) @ whole).max() < 1e-14


@pytest.mark.parametrize("columns", [1, 3, 8])
@pytest.mark.parametrize("first", [0, 1])
def test_what_feeds_nothing_back(first: int, columns: int) -> None:
    """The oscillator y beside z, u' = y, that nothing depends on: the double integral of y is that of p - u' / k."""
    g, h, y, z = gauss(), 0.4, first, 1 - first
    J = np.zeros((1, 2, 5, len(g.c)))
    J[:, y, y], J[:, y, 4], J[:, z, y] = -STIFFNESS, 1.0, 1.0
    step = Carried(np.array([h]), (g.c, g.b, g.twice_b, g.A, g.twice), J, [])
    whole = np.random.default_rng(columns).normal(size=(5, columns))
    found = step.through(0, whole)
    moved = expected(h) @ whole[[y, 2 + y, 4]]
    rate = whole[2 + z] + (h * whole[4] - moved[1] + whole[2 + y]) / STIFFNESS
    place = whole[z] + h * whole[2 + z] + (h**2 / 2 * whole[4] - moved[0] + whole[y] + h * whole[2 + y]) / STIFFNESS
    assert found is not None
    wanted = np.array([moved[0], place, moved[1], rate] if y == 0 else [place, moved[0], rate, moved[1]])
    assert np.abs(found - wanted).max() < 1e-14


@pytest.mark.parametrize("columns", [1, 5])
def test_impacts_between_steps(columns: int) -> None:
    """Of an oscillator that bounces: its rate turns before the first step and before the third of three, by the same
    closed form."""
    g, h = gauss(), np.array([0.7, 0.4, 0.1])
    J = np.tile(np.array([-STIFFNESS, 0.0, 1.0])[:, None], (3, 1, 1, len(g.c)))
    steps = Carried(h, (g.c, g.b, g.twice_b, g.A, g.twice), J, [])
    rng = np.random.default_rng(columns)
    whole, bounce = rng.normal(size=(3, columns)), np.array([[1.0, 0.0, 0.0], [0.3, -0.6, 0.2]])
    seen = np.empty((2, 3, columns))
    found = steps.through(0, whole, 3, np.array([0, 2]), np.array([bounce, bounce]), seen)
    assert found is not None
    first = np.vstack([bounce @ whole, whole[2:]])  # some numbers up to ten: ten times the rounding of single steps
    then = np.vstack([expected(0.7 + 0.4) @ first, whole[2:]])
    assert np.array_equal(seen[0], whole)
    assert np.abs(seen[1] - then).max() < 1e-13
    assert np.abs(found - expected(0.1) @ np.vstack([bounce @ then, whole[2:]])).max() < 1e-13


@pytest.mark.parametrize("columns", [1, 5])
def test_ends_are_put_back(columns: int) -> None:
    """The place is set to p, and then the rate to twice the place."""
    whole = np.random.default_rng(columns).normal(size=(3, columns))
    one = np.ones((1, 1, 1))
    back = [(0, one, np.array([[[1.0, 0.0, -1.0]]])), (1, one, np.array([[[-2.0, 1.0, 0.0]]]))]
    found = oscillator(0.4, back).through(0, whole)
    assert found is not None
    assert np.abs(found - np.array([1.0, 2.0])[:, None] * whole[2]).max() < 1e-14


@pytest.mark.parametrize("columns", [1, 4])
def test_steps_on_which_sweeps_do_not_contract_are_told(columns: int) -> None:
    assert oscillator(20.0, []).through(0, np.ones((3, columns))) is None


@pytest.mark.parametrize(("rough", "columns"), [(False, 1), (True, 1), (True, 4)])
def test_runs_have_the_same_derivatives_by_sweeps_and_by_matrices(
    rough: bool, columns: int, workshop: Workshop, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Through impacts, and behind sliding, of loops of six rods; and by the matrices of all steps through which sweeps
    do not go."""
    models = (workshop.model(fuzz.scene(6, rough), derivatives=True),) * 2
    calls, through = [0], swept.Swept.through

    def counted(self: swept.Swept, whole: Any, parts: Any = ()) -> Any:
        calls[0] += 1
        return through(self, whole, parts)

    monkeypatch.setattr(swept.Swept, "through", counted)
    for model, _, q, u, end, rng in throws(models, 6, rough, 5, 3):
        wrt = {"q0": rng.normal(size=(len(q), columns)), "u0": rng.normal(size=(len(q), columns))}
        found = []
        for few in (0.0, swept.FEW):
            before = calls[0]
            with monkeypatch.context() as patch:
                patch.setattr(swept, "FEW", few)
                found.append(sensitivities(model, wrt, ["q", "u"], q0=q, u0=u, until=end, rtol=RTOL).jacobian)
            assert (calls[0] > before) == (few > 0.0)
        assert relative(found[1], found[0]) < 1e-10
        with monkeypatch.context() as patch:
            patch.setattr(swept, "Carried", Stuck)
            found.append(sensitivities(model, wrt, ["q", "u"], q0=q, u0=u, until=end, rtol=RTOL).jacobian)
        assert relative(found[2], found[0]) < 1e-10
