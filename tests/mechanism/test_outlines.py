"""Convex pieces of polygons: what is cut where, and that nothing is left out."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from ccgen.generator.mechanism.outlines import convex_corners, convex_pieces, is_inside, turns
from ccgen.generator.mechanism.uniform_bodies import crossing_edges

SQUARE = [0j, 1 + 0j, 1 + 1j, 1j]
L_SHAPE = [0j, 2 + 0j, 2 + 1j, 1 + 1j, 1 + 2j, 2j]
CLAMP = [0j, 4 + 0j, 4 + 3j, 2.2 + 3j, 2.2 + 2j, 3 + 2j, 3 + 1j, 1 + 1j, 1 + 2j, 1.8 + 2j, 1.8 + 3j, 3j]
"""A ring with a slit: its outside turns by more than a full turn between concave corners."""


def drawn(seed: int) -> list[complex]:
    """A polygon round the origin with random radii, convex here and concave there."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(4, 14))
    angles = np.sort(rng.uniform(0, 2 * math.pi, count)) + np.arange(count) * 0.02
    corners = [complex(z) for z in rng.uniform(0.4, 1.0, count) * np.exp(1j * angles * 2 * math.pi / 6.6)]
    return corners if rng.integers(2) else corners[::-1]


def polygons() -> list[list[complex]]:
    found = [SQUARE, SQUARE[::-1], L_SHAPE, CLAMP, CLAMP[::-1], *map(drawn, range(12))]
    return [corners for corners in found if crossing_edges(corners) is None]


@pytest.mark.parametrize("corners", polygons())
def test_pieces_are_convex_and_cover_all_edges(corners: list[complex]) -> None:
    angles, count, pieces = turns(corners), len(corners), convex_pieces(corners)
    assert sum(angles) == pytest.approx(2 * math.pi)
    covered = [(a, b) for piece in pieces for a, b in pairwise(piece)]
    assert sorted(covered) == sorted((k, (k + 1) % count) for k in range(count))
    for piece in pieces:
        inner = [angles[k] for k in piece[1:-1]]
        assert all(angle > -1e-9 for angle in inner)
        if len(pieces) > 1:
            assert sum(inner) <= math.pi + 1e-9
    assert set(convex_corners(corners)) == {k for k, angle in enumerate(angles) if angle > -1e-9}


def test_how_many_pieces() -> None:
    assert convex_pieces(SQUARE) == [(0, 1, 2, 3, 0)]
    assert convex_pieces(L_SHAPE) == [(3, 4, 5, 0), (0, 1, 2, 3)]
    assert convex_corners(L_SHAPE) == [0, 1, 2, 4, 5]


@pytest.mark.sample(8)
@pytest.mark.parametrize("corners", polygons())
def test_a_disc_outside_touches_a_piece_in_one_place(corners: list[complex]) -> None:
    """Of the places of an outline that are as near as any round them and are seen from outside, a piece has one."""
    rng, pieces, looked = np.random.default_rng(1), convex_pieces(corners), 0
    for _ in range(25):
        x, y = rng.uniform(-1.5, 4.5, 2) if abs(corners[1]) > 1 else rng.uniform(-1.5, 1.5, 2)
        place = complex(x, y)
        if is_inside(place, corners):
            continue
        for piece in pieces:
            feet: list[complex] = []
            for a, b in pairwise(piece):
                edge = corners[b] - corners[a]
                share = float(np.clip(((place - corners[a]) / edge).real, 0, 1))
                foot = corners[a] + share * edge
                seen = not any(is_inside(foot + s * (place - foot), corners) for s in np.linspace(1e-6, 1, 60))
                least = all(
                    abs(foot + h * (corners[d] - corners[c]) * s - place) >= abs(foot - place) - 1e-12
                    for c, d in ((k, (k + 1) % len(corners)) for k in range(len(corners)))
                    for h, s in ((1e-4, 1), (1e-4, -1))
                    if min(abs(foot - corners[c]), abs(foot - corners[d])) < 1e-12
                    and ((s > 0) == (abs(foot - corners[c]) < 1e-12))
                )
                if seen and least and all(abs(foot - other) > 1e-9 for other in feet):
                    feet.append(foot)
            assert len(feet) <= 1, (place, piece, feet)
            looked += len(feet)
    assert looked > 5


def test_inside() -> None:
    assert is_inside(0.5 + 0.5j, SQUARE) and is_inside(0.5 + 0.5j, SQUARE[::-1])
    assert not is_inside(1.5 + 1.5j, L_SHAPE) and not is_inside(2 + 1.5j, CLAMP)


def test_open_lines_do_not_close() -> None:
    """Only the edge from the last corner to the first makes these cross."""
    line = [0j, 1 + 0j, 1 + 1j, 0.5 - 1j]
    assert crossing_edges([*line[:3], 2 + 1j, 2 - 1j, 0.5 - 2j], False) is None
    assert crossing_edges(line, False) == (0, 2)
    assert crossing_edges([0j, 1 + 0j, 0.5 + 0j], False) == (0, 1)
