"""A periodic motion in segments, each begun anew, so that none lets small differences grow far; one may be all of it.

Multiple shooting: J. Stoer, R. Bulirsch, Introduction to Numerical Analysis, 2002, section 7.3.5 (docs/theory.md, eq.
12.5).
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise

import numpy as np

from ..arrays import ComplexArray, FloatArray
from ..model.model import Model
from ..run import Run
from ..simulate import simulate
from .rank import least_change
from .section import Crossed, Map, depends_on_time

State = tuple[FloatArray, FloatArray]

BETWEEN = (-1, False)
"""Where a segment begins nothing is closed but what is held there."""

PLACES = 16
"""Segments may end at sixteenths of an equal one, up to a quarter of it to either side, and away from impacts by one
sixteenth where they can: an impact that comes to the end of a segment would make its start jump."""

SHORT, LONG = 0.25, 1.75
"""A segment is as long as it should be, in equal ones, up to here: a quarter more than where ends may lie."""


class Chain:
    """The ``maps`` from the start of each segment to that of the next, and of the last to the section of ``map``, which
    they make together. ``crosses`` says which segments begin on the section. A motion has nodes: the state in which
    each segment begins."""

    def __init__(self, a_map: Map, maps: Iterable[Map], crosses: Sequence[bool]) -> None:
        self.map, self.maps, self.crosses = a_map, tuple(maps), tuple(crosses)

    @property
    def timed(self) -> bool:
        """Whether segments end after times of their own, which have to follow the period."""
        return not all(self.crosses)

    def turns(self) -> list[slice]:
        """The segments of each way from the section back to it: several where the motion was doubled."""
        begins = [k for k, crosses in enumerate(self.crosses) if crosses]
        return [slice(*ends) for ends in pairwise([*begins, len(self.maps)])]

    def of(self, model: Model) -> Chain:
        """The same segments of the model with other values of its parameters."""
        return Chain(self.map.of(model), [one.of(model) for one in self.maps], self.crosses)

    def doubled(self) -> Chain:
        """All segments twice; what is one segment becomes one run of two periods."""
        double = self.map.doubled()
        return Chain(double, self.maps * 2, self.crosses * 2) if len(self.maps) > 1 else whole(double)

    def at(self, nodes: Sequence[State], parameter: str | None = None) -> list[Crossed]:
        """What comes of each node."""
        return [one.at(*node, parameter) for one, node in zip(self.maps, nodes, strict=True)]

    def system(self, found: Sequence[Crossed], unit: float = 1.0) -> tuple[FloatArray, FloatArray]:
        """By what the segments miss those that follow (k,), in units of the mechanism, and rows (k, m + 1): what that
        moves by along the directions of all their starts, and with a parameter in its ``unit``."""
        ends, last = self.columns(found), len(found) - 1
        rests, rows = [], []
        for k, (a_map, one) in enumerate(zip(self.maps, found, strict=True)):
            after = found[k + 1 if k < last else 0]
            to = ends[k + 1 if k < last else 0]
            kept, units = a_map.compared, a_map.units[a_map.compared]
            rests.append((one.end - after.states[0])[kept] / units)
            row = np.zeros((len(kept), ends[-1] + 1))
            row[:, ends[k] : ends[k + 1]] += one.ends[kept] / units[:, None]
            row[:, to : to + after.basis.shape[1]] -= after.basis[kept] / units[:, None]
            row[:, -1] = (one.pushed - after.lift)[kept] / units * unit
            rows.append(row)
        return np.concatenate(rests), np.vstack(rows)

    @staticmethod
    def columns(found: Sequence[Crossed]) -> list[int]:
        """Where the directions of each segment begin among all of them, and at last how many they are."""
        return [0, *np.cumsum([one.basis.shape[1] for one in found]).tolist()]

    def changes(self, found: Sequence[Crossed], step: FloatArray, unit: float = 1.0) -> list[FloatArray]:
        """What a step (m + 1,) along the directions and the parameter changes each start by, (2 n,)."""
        ends = self.columns(found)
        return [
            one.basis @ step[first:last] + one.lift * (unit * step[-1])
            for one, first, last in zip(found, ends, ends[1:], strict=False)
        ]

    def blocks(self, found: Sequence[Crossed]) -> list[FloatArray]:
        """The derivative of each map, from the directions of its start to those of the next one; what may advance does
        not count."""
        parts = []
        for k, (a_map, one) in enumerate(zip(self.maps, found, strict=True)):
            onto, units = found[(k + 1) % len(found)].basis, a_map.units[:, None]
            free = np.delete(np.eye(len(units)), a_map.compared, axis=1)
            parts.append(least_change(np.hstack([onto, free]) / units, one.ends / units)[: onto.shape[1]])
        return parts


def whole(a_map: Map) -> Chain:
    """One segment."""
    return Chain(a_map, [a_map], [True])


def parted(a_map: Map, starts: Sequence[State], segments: int) -> tuple[Chain, list[State]]:
    """The segments and the states in which they begin, of one state, from which a run gives them, or of all of them.
    Where time tells the phase segments end at crossings of the section, else after times, and the last at the section.

    Raises ``ValueError`` where a motion cannot be parted so.
    """
    if a_map.crossings % segments == 0:
        return _by_crossings(a_map, starts, segments)
    if a_map.crossings > 1 or depends_on_time(a_map.model):
        crossings, all_of = a_map.crossings, math.lcm(a_map.crossings, segments)
        raise ValueError(
            f"segments: found {segments} with {crossings} crossing{'s' if crossings > 1 else ''}, expected a divisor "
            f"of {crossings}: in a model that depends on time, or with several crossings, the number of segments has "
            f"to divide the number of crossings; ask for {all_of} crossings (--crossings {all_of}, or "
            f"crossings={all_of} from Python)"
        )
    return _by_time(a_map, starts, segments)


def _by_crossings(a_map: Map, starts: Sequence[State], segments: int) -> tuple[Chain, list[State]]:
    first = copy.copy(a_map)
    first.crossings = a_map.crossings // segments
    nodes = list(starts)
    if len(nodes) == 1:
        nodes = [first.first(*nodes[0])]
        first.relabel = None if segments > 1 else a_map.relabel
        while len(nodes) < segments:
            nodes.append(first.after(*nodes[-1]))
    if segments == 1:
        return whole(a_map), nodes
    return Chain(a_map, _joined(a_map, [first] * segments), [True] * segments), nodes


def _by_time(a_map: Map, starts: Sequence[State], segments: int) -> tuple[Chain, list[State]]:
    nodes = list(starts)
    if len(nodes) > 1:
        timed = isinstance(a_map.section, float)
        time = a_map.time_of(*nodes[-1]) * (1 if timed else segments)
        return _timed(a_map, [time / segments] * segments), nodes
    nodes = [a_map.first(*nodes[0])]
    time = a_map.time_of(*nodes[0])
    run = simulate(a_map.model, *nodes[0], until=time, **a_map.options)
    assert isinstance(run, Run)
    ends = _ends(time, segments, [impact.t for impact in run.impacts])
    return _timed(a_map, np.diff([0.0, *ends, time]).tolist()), [*nodes, *(run.at(t) for t in ends)]


def _timed(a_map: Map, times: Sequence[float]) -> Chain:
    """Segments of these times, the last to the section."""
    maps = []
    for k, time in enumerate(times):
        one = copy.copy(a_map)
        if k < len(times) - 1 or isinstance(a_map.section, float):
            one.section = float(time)
        if k:
            one.fixed, one.closed = one.fixed[:0], BETWEEN
        maps.append(one)
    return Chain(a_map, _joined(a_map, maps), [True] + [False] * (len(times) - 1))


def _joined(a_map: Map, maps: Sequence[Map]) -> Iterator[Map]:
    """Segments one behind the other: all of a state goes on into the next, and only the last is relabelled. What may
    advance begins where it begins, and is anywhere later."""
    for k, one in enumerate(maps):
        found = copy.copy(one)
        found.relabel = a_map.relabel if k == len(maps) - 1 else None
        if k:
            found.fixed = np.setdiff1d(found.fixed, a_map.free)
        if k < len(maps) - 1:
            found.free, found.compared = a_map.free[:0], np.arange(len(a_map.units))
        yield found


def _ends(time: float, segments: int, impacts: Sequence[float]) -> list[float]:
    """The times at which segments end but the last, as equal as impacts let them be."""
    part = time / segments
    nearest = sorted(range(-PLACES // 4, PLACES // 4 + 1), key=abs)
    found = []
    for k in range(1, segments):
        places = [part * (k + j / PLACES) for j in nearest]
        found.append(max(places, key=lambda t: min(_away(t, impacts), part / PLACES)))
    return found


def _away(t: float, impacts: Sequence[float]) -> float:
    """How far a time is from the nearest impact."""
    return min((abs(t - one) for one in impacts), default=np.inf)


def spread(chain: Chain, found: Sequence[Crossed]) -> tuple[Chain, list[State]] | None:
    """The segments of a motion that is ``found`` with times that have followed its period, and their nodes; None where
    those that it has will do. Of a doubled motion each turn has its own times: each begins on the section, where
    the state may be relabelled."""
    if not chain.timed:
        return None
    single, maps, nodes, anew = chain.map.single(), list[Map](), list[State](), False
    for turn in chain.turns():
        fresh = _spread(single, found[turn])
        if fresh is None:
            maps += chain.maps[turn]
            nodes += [(one.q, one.u) for one in found[turn]]
        else:
            maps += fresh[0].maps
            nodes += fresh[1]
            anew = True
    return (Chain(chain.map, maps, chain.crosses), nodes) if anew else None


def _spread(a_map: Map, found: Sequence[Crossed]) -> tuple[Chain, list[State]] | None:
    """The same of one turn, of whose map the segments are parts."""
    starts = np.cumsum([0.0, *(one.time for one in found)]).tolist()
    impacts = [first + one.t for first, part in zip(starts, found, strict=False) for one in part.runs[0].impacts]
    part = starts[-1] / len(found)
    equal = all(SHORT * part <= one.time <= LONG * part for one in found)
    if equal and all(_away(t, impacts) >= part / (2 * PLACES) for t in starts[1:-1]):
        return None
    ends = _ends(starts[-1], len(found), impacts)
    nodes = [(found[0].q, found[0].u)]
    for t in ends:
        k = max(int(np.searchsorted(starts[:-1], t, side="right")) - 1, 0)
        nodes.append(found[k].runs[0].at(t - starts[k]))
    times = np.diff([0.0, *ends, starts[-1]]).tolist()
    return _timed(a_map, times), nodes


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
