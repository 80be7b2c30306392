"""The unit step in equations: its value and slope, in listings, in C, over lanes, and with folded parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
import sympy as sp

from ccgen.generator.derive.motion import Couple, Motion
from ccgen.generator.documents.latex import expression_tex
from ccgen.generator.effect_base.effect import Effect
from ccgen.generator.equations.step import step
from ccgen.generator.pipeline import listing
from ccgen.generator.program.dialects import LISTING, C, write
from ccgen.generator.program.reading import read_listing

from ..support.workshop import Workshop

X = sp.Symbol("x")


@dataclass(frozen=True)
class Latch(Effect):
    """A moment of 3 N m on the first link where the cosine of its angle is positive."""

    name: str = "latch"

    def loads(self, motion: Motion) -> Sequence[Couple]:
        return (Couple(0, 3 * motion.let("step_latch", step(sp.cos(motion.angle(0))))),)


def test_value_and_slope() -> None:
    assert [step(sp.Float(x)) for x in (-1.0, 0.0, 1e-300)] == [0, 0, 1]
    assert sp.diff(X**2 * step(X), X) == 2 * X * step(X)
    assert write(2 * step(X), LISTING) == "2*step(x)" and write(step(X), C) == "unit_step(x)"
    assert expression_tex(step(X)) == r"\mathrm{step}\left(x\right)"


@pytest.mark.sample(1)
@pytest.mark.parametrize("precision", ["double", "wide", "float"])
def test_in_models(precision: str, workshop: Workshop) -> None:
    """The acceleration of a rod with and without the moment, one state at a time, in lanes and from the listing."""
    bare = workshop.scene("[chain]\nlinks = 1\nhinged = true\n[gravity]\n")
    scene = replace(bare, effects=(*bare.effects, Latch()))
    model: Any = workshop.model(scene, precision)
    angles = np.linspace(-4.0, 4.0, 33)[:, None]
    wanted = 3 * (-9.81 * np.cos(angles) / 2 + 3 * (np.cos(angles) > 0))
    found = np.array([model.acceleration(q, 0 * q) for q in angles], dtype=float)
    assert found == pytest.approx(wanted, abs=1e-5 if precision == "float" else 1e-13)
    if precision == "double":
        lanes, _ = model.kernels.acceleration_lanes(angles, 0 * angles, np.zeros(33))
        assert lanes == pytest.approx(wanted, abs=1e-13)
        for fold in (False, True):
            given = {"q": angles.T, "u": 0 * angles.T}
            listed = read_listing(listing(scene, fold=fold)).evaluate("acceleration", given)["u_dot"].T
            assert np.max(np.abs(listed - wanted)) <= 1e-13
