"""How large angles may be, and how far joints may miss."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np

from .._core import TOLERANCES
from ..arrays import FloatArray

JOINT_MISS = 1e-6
"""Poses whose joints miss by more than this, times the mechanism's length, are not a state of it."""

START_MISS = 1e-12
"""Loops of the scene's start, and its driven joints, that miss by more than this, times the mechanism's length, are put
right: parameters have changed. It is some thousand times the rounding of what adds up to a closure, so that nothing
moves by rounding, and no more, so that the start moves with parameters however little they change."""

ANGLE_KNOWN = TOLERANCES["ANGLE_KNOWN"].value
"""Angles are states if they are known to this (rad): points at the mechanism's length are then known to JOINT_MISS.
Floats have a limit of their own."""


@cache
def largest_angle(core: ModuleType) -> float:
    """Size (rad) beyond which no digits are left of where links point, in the numbers of that core. Its runs end there.

    The last place is larger than 1e-6 rad beyond 4.5e9 rad (in floats, which carry 7 digits: than 1e-3, beyond 1e4).
    """
    return float(core.TOLERANCES["ANGLE_KNOWN"].value) / float(np.finfo(core.REAL).eps)


def check_angles(what: str, angles: FloatArray, names: Sequence[str], core: ModuleType) -> None:
    """None of the ``angles`` (b, n) of these ``names`` in the argument ``what``, in the numbers of that core, is
    larger, else ``ValueError``."""
    sizes, largest = np.abs(angles), largest_angle(core)
    if sizes.size and sizes.max() > largest:
        row, column = np.unravel_index(int(np.argmax(sizes)), sizes.shape)
        name, found = names[int(column)], float(angles[row, column])
        raise ValueError(
            f"{what}: found {name} = {found:.3g} rad, expected at most {largest:.2g} rad, "
            "beyond which no digits are left of where links point; leave out full turns"
        )


def joint_miss(kind: np.dtype[Any], length: float) -> float:
    """How far joints of a mechanism of this ``length`` (m) may miss in numbers of that type: floats miss by more than
    JOINT_MISS already by rounding."""
    return max(JOINT_MISS, 1e3 * float(np.finfo(kind).eps)) * length


def start_miss(kind: np.dtype[Any], length: float) -> float:
    """How far loops and driven joints of the start of a mechanism of this ``length`` (m) may miss in numbers of that
    type."""
    return max(START_MISS, 1e3 * float(np.finfo(kind).eps)) * length
