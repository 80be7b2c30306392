"""A scissor lift of four stages: ``scenes/scissor-lift.toml``, a part placed four times."""

from __future__ import annotations

import math

import pytest

from ccgen.generator import load_scene
from ccgen.runtime import simulate, static_equilibrium

from ..support.folders import ROOT
from ..support.workshop import Workshop

G = 9.81


def test_the_screw_carries_what_virtual_work_says(workshop: Workshop) -> None:
    """F dx = dV for a foot at x, where a stage is h = √(1 − x²) high: of the platform's 50 kg at 4h, and in stage k,
    counted from 0, of two bars of 5 kg at (k + ½)h."""
    model = workshop.model(load_scene(ROOT / "scenes" / "scissor-lift.toml"))
    run = simulate(model)
    screw = model.joints.index("screw")
    for t in (0.0, 0.4, 1.0):
        x = 0.6 + 0.3 * math.cos(math.pi * t)
        lifted = 50.0 * 4.0 + sum(2.0 * 5.0 * (k + 0.5) for k in range(4))
        force = static_equilibrium(model, run.at(t)[0]).reactions[screw, 0]
        assert force == pytest.approx(-lifted * G * x / math.sqrt(1.0 - x**2), rel=1e-12)
