"""Where loads change faster than elsewhere: steps end there, so that none passes over a pulse without a look at it."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import pairwise

import numpy as np

from ..arrays import FloatArray
from .assembly import project
from .dynamics import at_states
from .geometry import Geometry
from .start import start
from .thresholds import characteristic_time

SAMPLES = 4096
"""Loads are looked at at so many equal distances of a run first: what lasts less than one of them may be missed."""

PIECE = 16
"""Distances between samples in the shortest piece; where loads are not known there, samples are taken anew in it."""

ANEW = 3
"""So many times at most: pieces are not shorter than a 10⁸th of a run, as beside a jump."""

DEGREE = 8
"""Of the polynomial that loads are like in a piece: the methods' stages, 6 and more, see what is in a step as long."""

LIKE = 1e-3
"""Part of what loads change by in all by which they may differ from it: so much is seen by the error of a step."""

ROUNDED = 1e-9
"""Part of the accelerations below which changes are rounding."""

SUMMED = 1e-12
"""In units of the mechanism: accelerations and their changes are rounding below that, as sums of terms of that size are
known to a few thousand of their last digits; a mechanism that a drive holds has none but those."""

MOST_KINKS = 64
"""Between kinks loads are looked at piece by piece; where there are more of them, steps end often enough."""

Loads = Callable[[FloatArray], FloatArray]
"""Loads (times, k) at times (s)."""


def ends_of_pieces(model: Geometry, kinks: list[float], until: float) -> list[float]:
    """Times (s) up to ``until`` between which the accelerations of the model at rest, and in motion, at its start are
    like polynomials of time; none where one polynomial is enough, or all pieces are as long as each other: what goes
    on in the same way is met by steps wherever they are.

    Pieces are halved until they are like that: as in adaptive quadrature (W. Gander, W. Gautschi, Adaptive quadrature
    revisited, BIT 40, 2000).
    """
    if not model.data.get("timed", False) or not until < np.inf:
        return []
    known = model.pieces_of_time.get((until, tuple(kinks)))
    if known is None:
        known = model.pieces_of_time[until, tuple(kinks)] = _found(model, kinks, until)
    return known


def _found(model: Geometry, kinks: list[float], until: float) -> list[float]:
    inside = sorted({kink for kink in kinks if 0.0 < kink < until})
    if len(inside) > MOST_KINKS:
        return []
    try:
        loads = _loads(model)
        edges = [0.0, *inside, until]
        count = max(PIECE, 2 ** int(np.log2(SAMPLES / (len(edges) - 1))))
        samples = [_sampled(loads, begin, end, count) for begin, end in pairwise(edges)]
    except ValueError:  # no accelerations there: the run will say why
        return []
    whole = np.concatenate(samples)
    change, size = float(np.max(np.ptp(whole, axis=0))), float(np.max(np.abs(whole)))
    if not np.isfinite(change) or change <= max(ROUNDED * size, SUMMED):
        return []
    found: list[float] = []
    for (begin, end), values in zip(pairwise(edges), samples, strict=True):
        pieces = np.array(_pieces(loads, begin, end, values, LIKE * change, ANEW))
        if np.ptp(np.diff(pieces)) > 1e-6 * (end - begin):
            found += pieces[1:-1].tolist()
    return found


def _loads(model: Geometry) -> Loads:
    """Accelerations in units of the mechanism, at rest and in motion: what damps does nothing at rest."""
    q, u = start(model)
    units = model.coordinate_units / characteristic_time(model) ** 2
    moving = project(model, q, u + model.coordinate_units / characteristic_time(model))
    inputs = dict.fromkeys(model.inputs, 0.0) or None

    def loads(times: FloatArray) -> FloatArray:
        found = list[FloatArray]()
        for one, rates in ((q, 0.0 * u), moving):
            at, moves = (np.tile(state, (len(times), 1)) for state in (one, rates))
            found.append(at_states(model, at, moves, times, inputs, (), "u_dot") / units)
        return np.hstack(found)

    return loads


def _sampled(loads: Loads, start: float, end: float, count: int) -> FloatArray:
    return loads(start + (end - start) * np.linspace(0.0, 1.0, count + 1))


def _pieces(loads: Loads, start: float, end: float, values: FloatArray, allowed: float, anew: int) -> list[float]:
    """The ends of all pieces from one time to another, at equal distances between which loads have ``values``."""
    count = len(values) - 1
    q = _polynomials(count)
    if float(np.max(np.abs(values - q @ (q.T @ values)))) <= allowed:
        return [start, end]
    if count <= PIECE:
        if not anew:
            return [start, end]
        values, anew = _sampled(loads, start, end, PIECE**2), anew - 1
        count = PIECE**2
    middle = 0.5 * (start + end)
    first = _pieces(loads, start, middle, values[: count // 2 + 1], allowed, anew)
    return first + _pieces(loads, middle, end, values[count // 2 :], allowed, anew)[1:]


@cache
def _polynomials(count: int) -> FloatArray:
    """An orthonormal basis (count + 1, DEGREE + 1) of polynomials at equal distances."""
    legendre = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, count + 1), DEGREE)
    return np.asarray(np.linalg.qr(legendre)[0])
