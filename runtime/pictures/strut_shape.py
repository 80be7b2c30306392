"""How springs and dampers look: lines along the way between their ends, to be drawn at any length."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..arrays import FloatArray

COILS = 6
LEAD, BOX = 0.14, 0.32
"""Parts of the length: of a straight end, and from the first end to a damper's bottom."""
WIDTH = 0.035
"""Half the width, of the mechanism's size."""


def _spring() -> list[list[tuple[float, float]]]:
    zigzag = [(LEAD + (1 - 2 * LEAD) * (k + 0.5) / (2 * COILS), (-1.0) ** k) for k in range(2 * COILS)]
    return [[(0.0, 0.0), (LEAD, 0.0), *zigzag, (1.0 - LEAD, 0.0), (1.0, 0.0)]]


def _damper() -> list[list[tuple[float, float]]]:
    """A cup on a rod, and a piston on another."""
    cup = [(1.0 - BOX, 1.0), (BOX, 1.0), (BOX, -1.0), (1.0 - BOX, -1.0)]
    return [[(0.0, 0.0), (BOX, 0.0)], cup, [(0.5, 0.7), (0.5, -0.7)], [(0.5, 0.0), (1.0, 0.0)]]


SHAPES: Mapping[str, Sequence[Sequence[tuple[float, float]]]] = {"spring": _spring(), "damper": _damper()}
"""For each kind its lines: points by the part of the way from end to end, and across it in half widths."""


def shape(kind: str, ends: FloatArray, width: float) -> FloatArray:
    """The lines of a spring or a damper between two ``ends`` (2, 2), of half a ``width`` (m): points (m, 2), with one
    that is no number between two lines."""
    way = ends[1] - ends[0]
    length = float(np.hypot(*way))
    across = np.array([-way[1], way[0]]) / length if length else np.zeros(2)
    rows: list[FloatArray] = []
    for line in SHAPES[kind]:
        rows += [ends[0] + along * way + width * aside * across for along, aside in line]
        rows.append(np.full(2, np.nan))
    return np.array(rows[:-1])
