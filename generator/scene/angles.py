"""Angles as scenes write them: what is taken as radians although degrees may be meant, and what has lost its digits."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Mapping

from pydantic_core import PydanticCustomError

from ..effect_base.angle import read_angle
from .errors import Path, Report

ANGLES = ("tilt", "angles", "angle", "axis", "lowest", "highest", "poses")
"""Keys of all tables whose values are angles, or hold some."""

KNOWN = 1e-6
"""Angles are states if they are known to this (rad); joints of a state may miss by as much (m)."""
LARGEST = KNOWN / sys.float_info.epsilon
"""The largest such angle (rad): the last place of one beyond it is larger than that."""


def judge_angles(raw: Mapping[str, object], path: Path, report: Report) -> bool:
    """Note angles in the table ``raw`` that are too large to have digits, and remark on those that have no unit and
    are larger than a full turn. Whether none is too large; what is no finite number is told with the others of a table.
    """
    fine = True
    for key in ANGLES:
        for where, given in _angles_in(key, raw.get(key)):
            try:
                angle = read_angle(given)
            except PydanticCustomError:
                continue
            if isinstance(angle, bool) or not isinstance(angle, int | float) or not _finite(angle):
                continue
            if abs(angle) > LARGEST:
                message = f"expected at most {LARGEST:.2g} rad, beyond which no digits are left of where links point"
                report.add((*path, *where), f"found an angle of {angle:.3g} rad, {message}; leave out full turns")
                fine = False
            elif angle is given and abs(angle) > 2.0 * math.pi:
                turns = f"{abs(angle) / (2.0 * math.pi):.3g} turns"
                report.remark((*path, *where), f'{given:g} is taken as rad, {turns}; write "{given:g} deg" for degrees')
    return fine


def _finite(number: float) -> bool:
    return abs(number) <= sys.float_info.max


def _angles_in(key: str, value: object) -> Iterator[tuple[Path, object]]:
    """The angles in the value of a key, and where they stand; of a list of a place and an angle the angle alone."""
    if isinstance(value, Mapping):
        for name, one in value.items():
            if key == "angles":
                yield (key, str(name)), one
            elif key == "poses" and isinstance(one, list) and len(one) == 3:
                yield (key, str(name), 2), one[2]
    elif isinstance(value, list):
        yield from (((key, index), one) for index, one in enumerate(value) if key == "angles")
    elif value is not None:
        yield (key,), value
