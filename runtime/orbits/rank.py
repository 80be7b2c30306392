"""Linear systems of a search for periodic motions: which rows and directions count as independent, decided here alone.

Rows and columns are in units of the mechanism (lengths of it, and its characteristic time; a parameter in the range it
is followed over), so that other units of length and time change no singular value.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray

RANK = 1e-10
"""Rows and directions below this part of the largest depend on others: entries are known to a tolerance of a run, 1e-12
of a unit where it is tight, and a hundred times that is what they may add up to."""


def rank_of(values: FloatArray, least: float = 0.0) -> int:
    """How many singular values (k,), largest first, are no rounding: of what is ``least`` in size at least."""
    return int(np.sum(values > RANK * max(float(values.max(initial=0.0)), least)))


def unmoved(rows: FloatArray) -> FloatArray:
    """Directions (columns, m), orthonormal, that ``rows`` (k, columns) leave as they are."""
    if not len(rows):
        return np.eye(rows.shape[1])
    _, values, directions = np.linalg.svd(rows)
    return np.asarray(directions[rank_of(values) :].T)


def least_change(rows: FloatArray, wanted: FloatArray, least: float = 0.0) -> FloatArray:
    """The smallest x (columns,) or (columns, m) with which ``rows`` x is nearest to ``wanted`` (k,) or (k, m).

    Where all that rows move is rounding of something of size ``least`` nothing is known, and x is zero.
    """
    left, values, right = np.linalg.svd(rows, full_matrices=False)
    rank = rank_of(values, least)
    within = left[:, :rank].T @ wanted
    return np.asarray(right[:rank].T @ (within.T / values[:rank]).T)
