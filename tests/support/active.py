"""Small scenes that tests of active effects begin with, and how a wrong table is refused."""

from __future__ import annotations

import pytest

from ccgen.generator.scene import SceneError

from .workshop import Workshop

ROD = 'name = "rod"\n[chain]\nlinks = 1\nhinged = true\nmass = 3.0\nlength = 2.0\n'
SWING = 3.0 * 2.0**2 / 3
"""Inertia of the rod about its hinge."""
LEFT = '[[joint]]\nname = "hub"\nbetween = ["wheel.C", "ground.O"]\n'
WHEEL = (
    'name = "wheel"\n[ground_link]\npoints = { O = [0, 0] }\n[[link]]\nname = "wheel"\nmass = 1.0\ninertia = 4.0\n'
    "com = [0, 0]\npoints = { C = [0, 0] }\n"
)
SINGLE = (
    'name = "body"\n[[link]]\nname = "body"\nmass = 2.0\ninertia = 0.5\ncom = [0, 0]\n'
    "points = { C = [0, 0], P = [0.3, 0] }\n"
)

ARM = 'name = "arm"\n[chain]\nlinks = 3\nhinged = true\n[start]\nangles = [-0.5, 0.4, 1.0]\n[gravity]\n'

Wrong = tuple[str, int, str, str]
"""A wrong table, the line (from its own first) and the key at fault, and what the message says."""


def check_refusal(case: Wrong, workshop: Workshop) -> None:
    """The table is the one fault of its scene, at its place and in these words."""
    text, line, key, words = case
    with pytest.raises(SceneError) as caught:
        workshop.scene(ROD + text + "\n")
    assert len(caught.value.faults) == 1, str(caught.value)
    fault = caught.value.faults[0]
    assert (fault.line, fault.key) == (line + ROD.count("\n"), key)
    assert words in fault.message
