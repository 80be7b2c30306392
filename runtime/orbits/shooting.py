"""Multiple shooting: a periodic motion in segments, each begun anew, so that none lets small differences grow far.

J. Stoer, R. Bulirsch, Introduction to Numerical Analysis, 2002, section 7.3.5 (docs/theory.md, eq. 12.5).
"""

from __future__ import annotations

import copy
from collections.abc import Sequence

import numpy as np

from ..arrays import ComplexArray, FloatArray
from ..run import Run
from ..simulate import simulate
from .orbit import Orbit
from .section import RANK, Crossed, Map, depends_on_time
from .tolerance import LESS, tolerance_of
from .trial import trying

State = tuple[FloatArray, FloatArray]

BETWEEN = (-1, False)
"""Where a segment begins nothing is closed but what is held there."""


def shoot(a_map: Map, starts: Sequence[State], segments: int, most: int) -> Orbit:
    """The periodic motion near ``starts``: one state, from which a run gives the others, or one for each segment.

    Raises ``ValueError`` where the segments cannot be parted so, and where Newton's method does not converge.
    """
    maps, nodes = _parted(a_map, starts, segments)
    best: tuple[float, list[Crossed]] | None = None
    tolerance = tolerance_of(a_map)
    guess = nodes[0]
    for step in range(most):
        found = []
        for one, node in zip(maps, nodes, strict=True):
            with trying(a_map.model, step, guess, node):
                found.append(one.at(*node))
        rest, rows = _system(a_map, found)
        missed = float(np.max(np.abs(rest)))
        if best is not None and best[0] <= tolerance and not missed < best[0] / LESS:
            break
        if best is None or missed < best[0]:
            best = missed, found
        if missed == 0.0:
            break
        steps = np.linalg.lstsq(rows, -rest, rcond=RANK)[0]
        ends = np.cumsum([0, *(one.basis.shape[1] for one in found)])
        nodes = []
        for part, crossed, first, last in zip(maps, found, ends, ends[1:], strict=False):
            change = crossed.basis @ steps[first:last]
            n = len(crossed.q)
            with trying(a_map.model, step + 1, guess, (crossed.q + change[:n], crossed.u + change[n:])):
                nodes.append(part.moved(crossed, change))
    assert best is not None
    missed, found = best
    if missed > tolerance:
        raise ValueError(
            f"{a_map.model.name}: found no periodic motion in {most} steps of Newton's method in {segments} segments, "
            f"the nearest misses by {missed:.2g} of its size; begin nearer, or ask for more segments or steps"
        )
    return _orbit(a_map, found, missed)


def _parted(a_map: Map, starts: Sequence[State], segments: int) -> tuple[list[Map], list[State]]:
    """The map of each segment, and the states in which they begin. Where time tells the phase they end at crossings of
    the section, else after equal times, and the last at the section."""
    if a_map.crossings % segments == 0:
        return _by_crossings(a_map, starts, segments)
    if a_map.crossings > 1 or depends_on_time(a_map.model):
        raise ValueError(
            f"segments: found {segments} of {a_map.crossings} crossings in a model that "
            f"{'crosses its section on the way' if a_map.crossings > 1 else 'depends on time'}, expected a part of the "
            "number of crossings: segments begin at the phase of the first"
        )
    return _by_time(a_map, starts, segments)


def _by_crossings(a_map: Map, starts: Sequence[State], segments: int) -> tuple[list[Map], list[State]]:
    part = copy.copy(a_map)
    part.crossings, part.relabel = a_map.crossings // segments, None
    last = copy.copy(part)
    last.relabel = a_map.relabel
    nodes = list(starts)
    if len(nodes) == 1:
        nodes = [part.first(*nodes[0])]
        while len(nodes) < segments:
            nodes.append(part.after(*nodes[-1]))
    return [*[part] * (segments - 1), last], nodes


def _by_time(a_map: Map, starts: Sequence[State], segments: int) -> tuple[list[Map], list[State]]:
    nodes = list(starts)
    if len(nodes) == 1:
        nodes = [a_map.first(*nodes[0])]
        time = a_map.time_of(*nodes[0])
        run = simulate(a_map.model, *nodes[0], until=time, **a_map.options)
        assert isinstance(run, Run)
        nodes += [run.at(time * k / segments) for k in range(1, segments)]
    else:
        timed = isinstance(a_map.section, float)
        time = a_map.time_of(*nodes[-1]) * (1 if timed else segments)
    inner = copy.copy(a_map)
    inner.section, inner.relabel, inner.free, inner.closed = time / segments, None, a_map.free[:0], BETWEEN
    inner.compared = np.arange(len(a_map.units))
    first, last = copy.copy(inner), copy.copy(inner)
    inner.fixed = last.fixed = inner.free
    first.free, first.closed = a_map.free, a_map.closed
    last.section = last.section if isinstance(a_map.section, float) else a_map.section
    last.relabel = a_map.relabel
    return [first, *[inner] * (segments - 2), last], nodes


def _system(a_map: Map, found: Sequence[Crossed]) -> tuple[FloatArray, FloatArray]:
    """By what the segments miss those that follow, in units of the mechanism, and the rows, block by block, by the
    directions of all their starts."""
    ends = np.cumsum([0, *(one.basis.shape[1] for one in found)])
    rests, rows = [], []
    for k, one in enumerate(found):
        after = (k + 1) % len(found)
        kept = a_map.compared if after == 0 else np.arange(len(one.end))
        units = a_map.units[kept]
        rests.append((one.end - found[after].states[0])[kept] / units)
        row = np.zeros((len(kept), ends[-1]))
        row[:, ends[k] : ends[k + 1]] += one.ends[kept] / units[:, None]
        row[:, ends[after] : ends[after + 1]] -= found[after].basis[kept] / units[:, None]
        rows.append(row)
    return np.concatenate(rests), np.vstack(rows)


def _orbit(a_map: Map, found: Sequence[Crossed], missed: float) -> Orbit:
    """The whole motion: multipliers by the segments, and one run through all of it."""
    parts = []
    for k, one in enumerate(found):
        onto = found[(k + 1) % len(found)].basis
        free = np.eye(len(one.end))[:, a_map.free]
        both = np.hstack([onto, free]) if k + 1 == len(found) else onto
        solved = np.linalg.lstsq(both / a_map.units[:, None], one.ends / a_map.units[:, None], rcond=RANK)[0]
        parts.append(solved[: onto.shape[1]])
    matrix = np.linalg.multi_dot(parts[::-1]) if len(parts) > 1 else parts[0]
    first, time = found[0], float(sum(one.time for one in found))
    run = simulate(a_map.model, first.q, first.u, until=time, **a_map.options)
    assert isinstance(run, Run)
    timed = not isinstance(a_map.section, float) and len(found) > 1 and a_map.crossings % len(found) != 0
    states = found[0].states if timed or a_map.crossings == 1 else np.vstack([one.states for one in found])
    multipliers = multipliers_of(parts)
    return Orbit(first.q, first.u, time, multipliers, matrix, first.basis, missed, a_map.count, run, states, a_map)


def multipliers_of(parts: Sequence[FloatArray]) -> ComplexArray:
    """Eigenvalues (m,), largest first, of the product of matrices, the first on the right, small ones beside large too.

    Those of the cyclic matrix that has the parts as blocks are their roots of order N, whose sizes are much nearer to
    each other (D. S. Watkins, Product eigenvalue problems, SIAM Review 47, 2005); each comes N times.
    """
    count, sizes = len(parts), [part.shape[1] for part in parts]
    ends = np.cumsum([0, *sizes])
    cyclic = np.zeros((ends[-1], ends[-1]))
    for k, part in enumerate(parts):
        after = (k + 1) % count
        cyclic[ends[after] : ends[after + 1], ends[k] : ends[k + 1]] += part
    left = list(np.linalg.eigvals(cyclic).astype(complex) ** count)
    found = []
    for _ in range(sizes[0]):
        largest = max(left, key=abs)
        left.sort(key=lambda one: abs(one - largest))
        found.append(complex(np.mean(left[:count])))
        left = left[count:] if len(left) > count else [0j]
    return np.array(sorted(found, key=lambda one: (-abs(one), one.imag)))
