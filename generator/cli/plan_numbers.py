"""Numbers of a sweep's plan and of ``--set`` as scenes write them: ``"20 deg"``, ``"5 N/mm"``, ``"2*pi"``."""

from __future__ import annotations

from ..effect_base.arithmetic import NO_NAMES, ExpressionError, Written, calculate
from ..effect_base.written_numbers import read_number, read_quantity


def written(text: str, unit: str | None) -> float:
    """The number (SI) that a text stands for, which measures what ``unit`` does, or anything where that is None.

    Raises ``ValueError`` with a sentence that says what to write instead."""
    try:
        if unit is not None:
            return float(read_number(text, [unit]))
        return float(read_any(text))
    except ExpressionError as error:
        raise ValueError(str(error)) from error


def read_any(text: str) -> Written:
    """The number (SI) that a text stands for, which knows what it measures where that says so.

    Raises ``ExpressionError`` with a sentence."""
    found = read_quantity(text, None)
    return calculate(text, NO_NAMES) if found is None else found
