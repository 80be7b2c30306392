"""A ratchet of one polygon: ``scenes/ratchet.toml``."""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest

from ccgen.generator import load_scene
from ccgen.runtime import simulate

from ..support.folders import ROOT
from ..support.workshop import Workshop

TIP, ROOT_RADIUS, ROUND, ARM, PIVOT = 0.1, 0.08, 0.004, 0.12, -0.10 + 0.13j


def caught() -> float:
    """The wheel's angle, in a tooth (rad), at which the pawl's round tip lies in the corner of a face and a ramp.

    There its centre is as far from both lines as the tip is round: on the line that halves the angle between them.
    """
    corner = complex(ROOT_RADIUS)
    ramp = TIP * cmath.exp(0.25j * math.pi) - corner
    half = cmath.phase(ramp) / 2.0
    centre = corner + ROUND / math.sin(half) * cmath.exp(1j * half)
    away = (abs(centre) ** 2 + abs(PIVOT) ** 2 - ARM**2) / (2.0 * abs(centre) * abs(PIVOT))
    return (cmath.phase(PIVOT) - math.acos(away) - cmath.phase(centre)) % (math.pi / 4.0)


def test_a_ratchet_goes_on_by_whole_teeth(workshop: Workshop) -> None:
    """A torque to and fro turns the wheel by four teeth in each period, from where the pawl catches a tooth."""
    model = workshop.model(load_scene(ROOT / "scenes" / "ratchet.toml"))
    run = simulate(model)
    assert run.success and run.energy_drift < 1e-9
    wheel = model.links.index("wheel")
    angles = model.poses(run.at(np.arange(0.9, 5.0))[0])[:, wheel, 2]
    np.testing.assert_allclose(np.diff(angles), -math.pi, atol=1e-8)
    assert angles[0] % (math.pi / 4.0) == pytest.approx(caught(), abs=1e-8)
