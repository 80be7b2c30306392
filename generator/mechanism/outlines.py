"""Outlines of links that touch others: lines from point to point, open or closed, and the convex pieces of polygons."""

from __future__ import annotations

import math
from collections.abc import Sequence

from .totals import total

STRAIGHT = 1e-9
"""Corners that turn by less (rad) are straight, and pieces that turn by half a turn may do so by this more: coordinates
are written with finitely many digits."""


def edges(count: int, closed: bool) -> list[tuple[int, int]]:
    """The edges of an outline with ``count`` corners, by the numbers of the corners at their ends."""
    return [(k, (k + 1) % count) for k in range(count if closed else count - 1)]


def turns(corners: Sequence[complex]) -> list[float]:
    """How far the outline of a polygon turns at each corner (rad), positive where that is convex: all sum to 2π.

    The polygon does not cross itself; its corners are in order round it, either way.
    """
    sides = [corners[b] - corners[a] for a, b in edges(len(corners), True)]
    turned = [_angle(sides[k - 1], side) for k, side in enumerate(sides)]
    way = 1.0 if total(turned) > 0.0 else -1.0
    return [way * angle for angle in turned]


def convex_pieces(corners: Sequence[complex]) -> list[tuple[int, ...]]:
    """A polygon's outline in pieces that a disc outside touches in one place at most: numbers of their corners.

    A convex polygon is one piece that ends where it begins. Any other is cut at its concave corners, and where a piece
    would turn by more than half a turn. So a piece is part of the outline of a convex set; a place outside of that has
    one nearest point there, and one inside of it sees the piece from within only (theory, section 5.9).
    """
    angles, count = turns(corners), len(corners)
    concave = [k for k, angle in enumerate(angles) if angle < -STRAIGHT]
    if not concave:
        return [(*range(count), 0)]
    pieces, piece, turned = [], [concave[0]], 0.0
    for step in range(1, count + 1):
        k = (concave[0] + step) % count
        piece.append(k)
        turned += angles[k]
        if k in concave or turned > math.pi + STRAIGHT or step == count:
            pieces.append(tuple(piece))
            piece, turned = [k], 0.0
    return pieces


def convex_corners(corners: Sequence[complex]) -> list[int]:
    """The corners of a polygon by which it can touch what is outside, by their numbers: those that are not concave."""
    return [k for k, angle in enumerate(turns(corners)) if angle > -STRAIGHT]


def is_inside(place: complex, corners: Sequence[complex]) -> bool:
    """Whether a place is inside a polygon: the angles at which its edges are seen sum to a full turn."""
    seen = [corner - place for corner in corners]
    if not all(seen):
        return False
    return abs(total(_angle(seen[k - 1], one) for k, one in enumerate(seen))) > math.pi


def _angle(one: complex, other: complex) -> float:
    """From one direction to another, between −π and π."""
    turned = one.conjugate() * other
    return math.atan2(turned.imag, turned.real)
