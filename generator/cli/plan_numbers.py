"""Numbers of a sweep's plan and of ``--set`` as scenes write them: ``"20 deg"``, ``"5 N/mm"``, ``"2*pi"``."""

from __future__ import annotations

from ..effect_base.arithmetic import NO_NAMES, ExpressionError, Written, calculate
from ..effect_base.written_numbers import read_number, read_quantity
from ..scene import Scene
from ..scene.measures import units_of


def written(text: str, unit: str | None, parameter: str | None = None, scene: Scene | None = None) -> float:
    """The number (SI) that a text stands for, which measures what ``unit`` does, or the ``parameter`` of the ``scene``
    of this path, or anything where neither is known.

    Raises ``ValueError`` with a sentence that says what to write instead."""
    units = units_of(scene, parameter) if scene is not None and parameter is not None else ()
    try:
        if unit is not None or units:
            return float(read_number(text, units if unit is None else [unit]))
        return float(read_any(text))
    except ExpressionError as error:
        raise ValueError(str(error)) from error


def read_any(text: str) -> Written:
    """The number (SI) that a text stands for, which knows what it measures where that says so.

    Raises ``ExpressionError`` with a sentence."""
    found = read_quantity(text, None)
    return calculate(text, NO_NAMES) if found is None else found
