"""Values over time that do not overshoot: a monotone cubic through rows, and rises from rest to rest as of cams."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import Literal

from .laws_of_rise import LAWS, LawOfRise
from .piecewise_in_time import ENDS, Curve, Ends, Piecewise, State

ROUGH: Mapping[LawOfRise, int] = {"harmonic": 2}
"""The lowest derivative that jumps where a rise begins and ends; 3 or more of all others."""


@dataclass(frozen=True)
class Monotone(Piecewise):
    """A piecewise cubic through ``rows`` (t, value) that rises where they rise, and rests between equal rows.

    Its slope at a row is the weighted harmonic mean of those to both sides, zero where these differ in sign (Fritsch
    and Butland, 1984, as SciPy's PchipInterpolator); at the ends that of a parabola through three rows, bounded alike,
    or zero where it ``rests``. Its second derivative jumps at the rows.
    """

    rows: tuple[tuple[float, float], ...]
    ends: Ends

    @property
    def shown(self) -> str:
        """``a monotone cubic through 4 rows, at rest before and after``."""
        return f"a monotone cubic through {len(self.rows)} rows, {ENDS[self.ends]}"

    @property
    def kind(self) -> str:
        return "the monotone cubic"

    def has_rate(self) -> bool:
        return True

    def jumps(self, order: int) -> Mapping[int, float]:
        if order < 2:
            return {}
        curves = [curve.derived(order) for curve in self.curves]
        last = len(self.rows) - 1
        rows = range(1, last) if self.ends == "periodic" else range(last + 1)
        found = {row: self.rows[row][0] for row in rows if self._jump(curves, row, order)}
        if self.ends == "periodic" and curves[0].at(Fraction(0)) != curves[-1].at(self._lengths[-1]):
            found[0] = self.rows[0][0]
        return found

    @cached_property
    def pieces(self) -> tuple[State, ...]:
        """The coefficients of the powers of t - t_i between each row and the next, exact."""
        found = []
        for i, (h, rise) in enumerate(zip(self._lengths, self._rises, strict=True)):
            a, b = self._slopes[i], self._slopes[i + 1]
            found.append([Fraction(self.rows[i][1]), a, (3 * rise - 2 * a - b) / h, (a + b - 2 * rise) / h**2])
        return tuple(found)

    @cached_property
    def _lengths(self) -> list[Fraction]:
        return [Fraction(t1) - Fraction(t0) for (t0, _), (t1, _) in pairwise(self.rows)]

    @cached_property
    def _rises(self) -> list[Fraction]:
        values = [Fraction(y) for _, y in self.rows]
        return [(b - a) / h for (a, b), h in zip(pairwise(values), self._lengths, strict=True)]

    @cached_property
    def _slopes(self) -> list[Fraction]:
        h, d = self._lengths, self._rises
        inner = [_mean(d[k - 1], d[k], h[k - 1], h[k]) for k in range(1, len(d))]
        if self.ends == "rest":
            return [Fraction(0), *inner, Fraction(0)]
        if self.ends == "periodic":
            end = _mean(d[-1], d[0], h[-1], h[0])
            return [end, *inner, end]
        if len(d) == 1:
            return [d[0], d[0]]
        return [_end(d[0], d[1], h[0], h[1]), *inner, _end(d[-1], d[-2], h[-1], h[-2])]


def _mean(before: Fraction, after: Fraction, h: Fraction, k: Fraction) -> Fraction:
    """The slope at a row between pieces of those slopes and lengths."""
    if before * after <= 0:
        return Fraction(0)
    one, other = h + 2 * k, 2 * h + k
    return (one + other) / (one / before + other / after)


def _end(first: Fraction, second: Fraction, h: Fraction, k: Fraction) -> Fraction:
    """The slope at an end, beside pieces of those slopes and lengths from there on."""
    found = ((2 * h + k) * first - h * second) / (h + k)
    if found * first <= 0:
        return Fraction(0)
    return 3 * first if first * second < 0 and abs(found) > 3 * abs(first) else found


@dataclass(frozen=True)
class Rises(Piecewise):
    """From row to row (t, value) by the ``laws`` (rows - 1,) of cams, each from rest to rest, ``None`` where the values
    are equal."""

    stations: tuple[tuple[float, float], ...]
    laws: tuple[LawOfRise | None, ...]
    ends: Ends

    @property
    def shown(self) -> str:
        """``a cycloidal motion between 4 rests, at rest before and after``."""
        named = " and ".join(dict.fromkeys(law for law in self.laws if law)) or "resting"
        return f"a {named} motion between {len(self.stations)} rests, {ENDS[self.ends]}"

    @property
    def kind(self) -> str:
        return "the motion"

    def has_rate(self) -> bool:
        return True

    def jumps(self, order: int) -> Mapping[int, float]:
        last = len(self.stations) - 1
        rough = [order >= (ROUGH.get(law, 3) if law else math.inf) for law in self.laws]
        found = [k for k in range(last + 1) if (k and rough[k - 1]) or (k < last and rough[k])]
        places = [t for t, _ in self.rows]
        return {places.index(self.stations[k][0]): self.stations[k][0] for k in found}

    @cached_property
    def rows(self) -> tuple[tuple[float, float], ...]:  # type: ignore[override]
        """The stations, and where parts of laws meet between them."""
        found = []
        for ((t0, y0), (t1, y1)), law in zip(pairwise(self.stations), self.laws, strict=True):
            for part in LAWS[law] if law else (None,):
                share = part.start if part else 0.0
                found.append((t0 + (t1 - t0) * share, y0 + (y1 - y0) * part.at(0.0, 0) if part else y0))
        return (*found, self.stations[-1])

    @cached_property
    def pieces(self) -> tuple[Curve, ...]:
        found = []
        for ((t0, y0), (t1, y1)), law in zip(pairwise(self.stations), self.laws, strict=True):
            rise, before, h = Fraction(y1) - Fraction(y0), Fraction(y0), Fraction(t1) - Fraction(t0)
            if law is None:
                found.append(Curve([before]))
                continue
            for part in LAWS[law]:
                powers = [Fraction(0)] * (1 + max(power for power, _ in part.powers))
                for power, factor in part.powers:
                    powers[power] = rise * Fraction(factor) / h**power
                powers[0] += before
                size, frequency, phase = part.wave
                found.append(
                    Curve(
                        powers, float(rise * Fraction(size)), float(Fraction(frequency) / h), round(2 * phase / math.pi)
                    )
                )
        return tuple(found)


Motion = Literal["monotone", LawOfRise]
"""Laws through rows."""
