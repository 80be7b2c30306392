"""Numbers as people give them: what is none is refused by the name of its argument."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

PLAIN = "biuf"
"""Kinds of NumPy's types that are real numbers."""


def read_numbers(given: object, what: str, kind: DTypeLike = float) -> NDArray[Any]:
    """The argument ``what`` as an array of real numbers of that ``kind``, the very one where it is one already.

    Raises ``ValueError`` for texts, complex numbers, whose imaginary part would be dropped, and rows of unequal length.
    """
    try:
        found = np.asarray(given)
        if found.dtype.kind in PLAIN:
            return np.asarray(found, dtype=kind)
        if found.dtype.kind == "O" and not any(isinstance(one, complex | str | bytes) for one in found.ravel()):
            return np.asarray(found.astype(float), dtype=kind)  # as fractions
    except (OverflowError, TypeError, ValueError):
        pass
    wrong = _wrong(given)
    raise ValueError(f"{what}: found {_cut(wrong)}, expected {'real ' * isinstance(wrong, complex)}numbers")


def dimensions(given: object) -> int:
    """How many indices an array has; 0 of rows of unequal length, which are none."""
    try:
        return np.ndim(given)  # type: ignore[arg-type]
    except ValueError:
        return 0


def _wrong(given: object) -> object:
    """The first entry that is no number, where that can be told; else all that was given."""
    try:
        entries = np.asarray(given, dtype=object).ravel().tolist()
    except ValueError:  # rows of unequal length
        return given
    return next((one for one in entries if isinstance(one, complex | str | bytes)), given)


def _cut(value: object) -> str:
    text = repr(value)
    return text if len(text) < 60 else f"{text[:56]}..."
