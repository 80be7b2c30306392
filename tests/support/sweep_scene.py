"""A hexagon that is dropped by a plan, and a program that sweeps it."""

from __future__ import annotations

from typing import Any

from .folders import SCENES

SCENE = SCENES / "falling-hexagon.toml"
PLAN = """
observe = ["joint_0.y", "impact_times(2)", "max(joint_1.force)"]
times = 3
part = 40
[run]
until = 0.9
[[vary]]
parameter = "ground_0.restitution"
from = 0.0
to = 1.0
count = 11
[[vary]]
start = "link_0.y"
values = [-3.0, 1.5, 1.6]
[[vary]]
parameter = "gravity.g"
values = [5.0, 9.81, 12.0]
"""
"""99 runs in three files; a third of them begin inside the ground, and are refused."""
PROGRAM = """
import sys
from ccgen.runtime import load_model
from ccgen.runtime.sweep.sweep import sweep
model, plan, out = sys.argv[1:]
sweep(load_model(model), plan, out, chunk=3, threads=1)
"""


def content(folder: Any) -> dict[str, bytes]:
    """All files of a sweep."""
    return {file.name: file.read_bytes() for file in folder.iterdir()}
