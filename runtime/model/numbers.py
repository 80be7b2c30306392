"""Numbers as people give them: what is none is refused by the name of its argument."""

from __future__ import annotations

from collections.abc import Iterable
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
    raise ValueError(f"{what}: found {told(wrong)}, expected {'real ' * isinstance(wrong, complex)}numbers")


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


def told(value: object) -> str:
    """A value in a sentence: the beginning of how Python writes it."""
    try:
        text = repr(value)
    except ValueError:  # a whole number of more digits than Python writes
        text = f"a {type(value).__name__} that is too long"
    return text if len(text) < 60 else f"{text[:56]}..."


def read_name(given: object, what: str, of: str) -> str:
    """The argument ``what``, which is a name ``of`` something. Raises ``TypeError`` for what is no text."""
    if not isinstance(given, str):
        raise TypeError(f"{what}: found {told(given)}, expected the name of {of}")
    return given


def read_names(given: object, what: str, of: str) -> list[str]:
    """The argument ``what``, several names ``of`` something. Raises ``TypeError`` for what are no texts."""
    if (
        isinstance(given, str | bytes)
        or not isinstance(given, Iterable)
        or (isinstance(given, np.ndarray) and not given.ndim)
    ):
        raise TypeError(f"{what}: found {told(given)}, expected several names of {of}, as a list")
    return [read_name(one, what, of) for one in given]


def read_row_of_times(given: object, kind: DTypeLike) -> NDArray[Any]:
    """The argument ``t``: times (n,), of a single one (1,). Raises ``ValueError`` for what are none."""
    times = np.atleast_1d(read_numbers(given, "t", kind))
    if times.ndim > 1:
        raise ValueError(f"t: found shape {times.shape}, expected a number or a row of them")
    return times
