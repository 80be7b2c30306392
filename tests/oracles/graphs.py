"""Mechanisms from graphs: links are nodes, joints are edges, and the drawing is a closed configuration anywhere.

Every function gives edges (link, link); ``mechanism`` draws them with random joint positions and, if asked, numbers the
links at random.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from .maximal import GROUND
from .mechanisms import Drawing, draw

Edges = list[tuple[int, int]]


def mechanism(name: str, edges: Edges, seed: int = 1, permuted: bool = False, gravity: float = 9.81) -> Drawing:
    """A mechanism whose joint k joins the two links of edge k."""
    n = 1 + max(link for edge in edges for link in edge)
    rng = np.random.default_rng([seed, n, len(edges)])
    if permuted:
        number = rng.permutation(n)
        edges = [(int(number[a]) if a >= 0 else a, int(number[b]) if b >= 0 else b) for a, b in edges]
        edges = [edges[k] for k in rng.permutation(len(edges))]
    bodies: list[list[int]] = [[] for _ in range(n)]
    for joint, edge in enumerate(edges):
        for link in edge:
            if link != GROUND:
                bodies[link].append(joint)
    places = [rng.uniform(-0.8, 0.8, 2) for _ in edges]
    for body in bodies:
        if len(body) < 2:
            body.append(len(places))
            places.append(rng.uniform(-0.8, 0.8, 2))
    return draw(name, np.array(places), bodies, [(k, a, b) for k, (a, b) in enumerate(edges)], rng, gravity)


def _run(first: int, start: int, count: int, last: int | None = None) -> Edges:
    """New links ``start`` … in a row from link ``first``, and on to ``last``."""
    links = [first, *range(start, start + count), *([] if last is None else [last])]
    return list(pairwise(links))


def theta(lengths: Sequence[int], grounded: bool = False) -> Edges:
    """Runs of these many links side by side between link 0 and link 1 (or the ground and link 0)."""
    first, last, free = (GROUND, 0, 1) if grounded else (0, 1, 2)
    edges: Edges = []
    for length in lengths:
        edges += _run(first, free, length, last)
        free += length
    return edges


def ring(n: int, grounded: bool = False) -> Edges:
    """A loop of n links; grounded hangs link 0 up as well."""
    return [*([(GROUND, 0)] if grounded else []), *((k, (k + 1) % n) for k in range(n))]


def nested(outer: int, inner: int, one: int, other: int, grounded: bool = False) -> Edges:
    """A ring, and a run of ``inner`` links that joins its links ``one`` and ``other``."""
    return ring(outer, grounded) + _run(one, outer, inner, other)


def ladder(rungs: int, grounded: bool = False) -> Edges:
    """Uprights 0 … ``rungs``, neighbours joined by two links at the top and two at the bottom (or the ground)."""
    edges: Edges = [(GROUND, k) for k in range(rungs + 1)] if grounded else []
    free = rungs + 1
    for k in range(rungs):
        for _ in range(1 if grounded else 2):
            edges += _run(k, free, 2, k + 1)
            free += 2
    return edges


def comb(spine: int, teeth: int, grounded: bool = False) -> Edges:
    """A row of ``spine`` links with a row of ``teeth`` links hanging from each."""
    edges: Edges = [*([(GROUND, 0)] if grounded else []), *pairwise(range(spine))]
    for k in range(spine):
        edges += _run(k, spine + teeth * k, teeth)
    return edges


def tree(n: int, arity: int) -> Edges:
    """Link k hangs from link (k - 1) / arity."""
    return [((k - 1) // arity, k) for k in range(1, n)]


def ears(grounded: bool, parts: Sequence[tuple[int, int | None, int]]) -> Edges:
    """Link 0 and runs (from, to, length) grown one after the other from any links to any links that are there.

    A closed run has at least three links more than the two ends: each one adds a degree of freedom at least, so that no
    joint is redundant.
    """
    ends, edges = [0], []
    if grounded:
        ends, edges = [GROUND, 0], [(GROUND, 0)]
    for first, last, length in parts:
        free = max(ends) + 1
        goal = None if last is None else ends[last % len(ends)]
        edges += _run(ends[first % len(ends)], free, length if goal is None else max(length, 3), goal)
        ends += range(free, max(link for edge in edges for link in edge) + 1)
    return edges
