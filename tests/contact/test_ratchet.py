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


@pytest.mark.hard
def test_no_start_lets_the_pawl_into_a_tooth(workshop: Workshop) -> None:
    """Teeth that come fast jump past a tip within a step: 40 starts, of which half failed where their insides were no
    insides."""
    model = workshop.model(load_scene(ROOT / "scenes" / "ratchet.toml"))
    wheel, pawl = (model.links.index(name) for name in ("wheel", "pawl"))
    corners = [radius * cmath.exp(0.25j * math.pi * k) for k in range(8) for radius in (TIP, ROOT_RADIUS)]
    for start in np.arange(40) * 1e-3:
        q, u = model.start()
        q[wheel] += start
        run = simulate(model, q0=q, u0=u)
        assert run.success and run.energy_drift < 1e-9
        poses = model.poses(run.at(np.linspace(0.0, 5.0, 500))[0])
        tips = (PIVOT + ARM * np.exp(1j * poses[:, pawl, 2])) * np.exp(-1j * poses[:, wheel, 2])
        assert min(distance(tip, corners) for tip in tips) > ROUND - 1e-9
        assert not any(is_around(corners, tip) for tip in tips)


def distance(place: complex, corners: list[complex]) -> float:
    """From a polygon's edges."""
    a, b = np.array(corners), np.roll(corners, -1)
    share = np.clip(((place - a) / (b - a)).real, 0.0, 1.0)
    return float(np.min(np.abs(a + share * (b - a) - place)))


def is_around(corners: list[complex], place: complex) -> bool:
    """Whether a polygon goes round a place: the angles at which its edges are seen sum to a full turn."""
    seen = np.array(corners) - place
    return abs(float(np.sum(np.angle(np.roll(seen, -1) / seen)))) > math.pi
