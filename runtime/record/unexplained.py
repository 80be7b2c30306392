"""What of a run's energy nothing that it records accounts for, row by row."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray


def largest(unexplained: FloatArray) -> float:
    """The largest size (J) of ``unexplained`` (nt,); 0 of no rows. One that is no number stays none."""
    return float(np.max(np.abs(unexplained), initial=0.0))


def in_a_row(parts: Sequence[FloatArray], jumps: Sequence[float]) -> FloatArray:
    """That of a run put together from ``parts``, each of which counts from its own first row, (nt,).

    ``jumps`` are what the energy (J) changes by unexplained where each of the parts begins. Empty where one part has
    none.
    """
    found, so_far = [], 0.0
    for part, jump in zip(parts, jumps, strict=True):
        if not part.size:
            return part
        found.append(part + (so_far + jump))
        so_far = float(found[-1][-1])
    return np.concatenate(found)
