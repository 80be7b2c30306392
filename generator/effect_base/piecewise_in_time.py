"""Values over time in pieces, from one row [t, value] to the next: powers of the time since the row, and a sine."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .expression_of_time import OfTime

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Motion
    from ..derive.terms_of_effects import Let

Ends = Literal["rest", "straight", "periodic"]
ENDS: Mapping[Ends, str] = {
    "rest": "at rest before and after",
    "straight": "straight before and after",
    "periodic": "periodic",
}
State = list[Fraction]
"""Coefficients of powers, or a value and its derivatives."""

FARTHER = 0.01
"""A law that leaves the range of its rows by more than this part of it is remarked on; less comes of rows of a smooth
motion that has its largest value between two of them: of a sine with 24 rows a period at most 1 - cos(7.5°)."""
REAL = 1e-6
"""Roots of a slope are real whose imaginary part is smaller, in parts of the piece."""


@dataclass(frozen=True)
class Curve:
    """The coefficients of the powers of the time x since a row, at least one, and a sine, size sin(frequency x) after
    so many ``quarters`` of a turn."""

    powers: State
    size: float = 0.0
    frequency: float = 0.0
    quarters: int = 0

    def derived(self, order: int) -> Curve:
        powers = derived(self.powers, order)
        return Curve(powers, self.size * self.frequency**order, self.frequency, self.quarters + order)

    def at(self, x: Fraction) -> Fraction:
        """Its value, of the sine as near as doubles are."""
        return value(self.powers, x) + (Fraction(self._wave(float(x))) if self.size else Fraction(0))

    def _wave(self, x: float) -> float:
        angle, turned = self.frequency * x, self.quarters % 4
        return self.size * (1.0 if turned < 2 else -1.0) * (math.cos(angle) if turned % 2 else math.sin(angle))

    def added(self, x: Expr, let: Let, name: str) -> Expr:
        """What it is at ``x``, an expression, less what it is at zero."""
        import sympy as sp

        found = sp.S.Zero
        for c in reversed(self.powers[1:]):
            found = (found + number(c)) * x
        if not self.size:
            return found
        angle = let(f"turned_{name}", sp.Float(self.frequency) * x)
        size = sp.Float(self.size if self.quarters % 4 < 2 else -self.size)
        return found + size * (sp.cos(angle) - 1 if self.quarters % 2 else sp.sin(angle))

    def extremes(self, length: float) -> Iterator[float]:
        """Values among which are the largest and the smallest from 0 to ``length``."""
        places = [0.0, length]
        slopes = [float(c) * length**k for k, c in enumerate(derived(self.powers, 1))]
        roots = np.roots(slopes[::-1]) if np.all(np.isfinite(slopes)) and any(slopes) else np.zeros(0)
        places += [float(r.real) * length for r in roots if abs(r.imag) < REAL and 0.0 < r.real < 1.0]
        yield from (float(self.at(Fraction(place))) for place in places)


class Piecewise(OfTime):
    """A value over time from row to row (t, value). Its numbers are no parameters.

    Before the first row and after the last it rests at its value there, goes on straight, or begins anew, as ``ends``
    says.
    """

    rows: tuple[tuple[float, float], ...]
    ends: Ends

    @property
    @abstractmethod
    def pieces(self) -> tuple[State, ...] | tuple[Curve, ...]:
        """What it is between each row and the next, by the time since the row."""

    @property
    @abstractmethod
    def kind(self) -> str:
        """What it is, as a title: ``the spline of order 5``."""

    @property
    def curves(self) -> tuple[Curve, ...]:
        return tuple(one if isinstance(one, Curve) else Curve(one) for one in self.pieces)

    def at(self, t: float) -> float:
        return self.slope_at(t, 0)

    def slope_at(self, t: float, order: int = 1) -> float:
        first, last = (Fraction(row[0]) for row in (self.rows[0], self.rows[-1]))
        time = Fraction(t)
        if self.ends == "periodic":
            time = first + (time - first) % (last - first)
        if not first <= time <= last:
            return float(self._beyond(time, first if time < first else last, order))
        piece = max(0, sum(start <= time for start, _ in self.rows[:-1]) - 1)
        return float(self.curves[piece].derived(order).at(time - Fraction(self.rows[piece][0])))

    def kinks(self) -> tuple[tuple[float, float], ...]:
        return tuple((t, self._period) for t, _ in self.rows)

    def realise(self, motion: Motion, name: str) -> Expr:
        return self.derivative(motion, name, 0, {})

    def rate(self, motion: Motion, name: str) -> Expr:
        return self.derivative(motion, f"{name}_rate", 1, {})

    def derivative(self, motion: Motion, name: str, order: int, begun: Mapping[int, Expr]) -> Expr:
        time, let = motion.time, motion.let
        if self.ends == "periodic":
            time = self._begun_anew(time, let, name)
        return self.along(time, let, name, order, begun)

    def along(
        self,
        time: Expr,
        let: Let,
        name: str,
        order: int,
        begun: Mapping[int, Expr],
        away: Callable[[int, Expr], Expr] | None = None,
    ) -> Expr:
        """What it, or a derivative, is at a ``time``, or at what else it is a function of: what it is before the first
        row; by how much it jumps at rows that have ``begun``; and what it adds from each row to the next, by the time
        since that row, of which no more counts than that between them, (h + |t - t_i| - |t - t_(i+1)|)/2.

        ``away`` gives |t - t_i| of a row and t - t_i, where that is not to be the absolute value itself."""
        import sympy as sp

        size = away or (lambda _, since: sp.Abs(since))
        curves = [curve.derived(order) for curve in self.curves]
        first, last = (Fraction(row[0]) for row in (self.rows[0], self.rows[-1]))
        jumps = {row: self._jump(curves, row, order) for row in self.jumps(order)}
        start = self._beyond(first, first, order) if 0 in jumps else curves[0].at(Fraction(0))
        terms: list[Any] = [number(start), *(number(jump) * begun[row] for row, jump in jumps.items())]
        since = [let(f"since_{name}_{i}", size(i, time - sp.Float(t))) for i, (t, _) in enumerate(self.rows)]
        for i, ((t0, _), (t1, _)) in enumerate(pairwise(self.rows)):
            cut = let(f"part_{name}_{i}", (sp.Float(t1 - t0) + since[i] - since[i + 1]) / 2)
            terms.append(let(f"added_{name}_{i}", curves[i].added(cut, let, f"{name}_{i}")))
        if self.ends == "straight" and order == 0:
            before, after = (self._beyond(end, end, 1) for end in (first, last))
            terms.append(number(before) * (time - sp.Float(self.rows[0][0]) - since[0]) / 2)
            terms.append(number(after) * (time - sp.Float(self.rows[-1][0]) + since[-1]) / 2)
        return sp.Add(*terms)

    def range(self) -> tuple[float, float]:
        """Its smallest and its largest value between the rows."""
        found = [
            one
            for curve, ((t0, _), (t1, _)) in zip(self.curves, pairwise(self.rows), strict=True)
            for one in curve.extremes(t1 - t0)
        ]
        return min(found), max(found)

    def strays(self, unit: str) -> str:
        """Where it leaves the range of its rows, and what to do; nothing where it does not."""
        values = [y for _, y in self.rows]
        (low, high), lowest, highest = self.range(), min(values), max(values)
        most = FARTHER * (highest - lowest)
        if low >= lowest - most and high <= highest + most:
            return ""
        return (
            f"{self.kind} goes from {low:.6g} to {high:.6g} {unit} between its rows, which have {lowest:.6g} to "
            f'{highest:.6g} {unit}; law = "monotone" in place of the order keeps within them, and a law as '
            '"cycloidal" rests at each row'
        )

    def _beyond(self, time: Fraction, end: Fraction, order: int) -> Fraction:
        """A derivative before the first row or after the last, whichever ``end`` is."""
        piece, start = (0, self.rows[0][0]) if end == self.rows[0][0] else (-1, self.rows[-2][0])
        here, slope = (self.curves[piece].derived(d).at(end - Fraction(start)) for d in (0, 1))
        slope = Fraction(0) if self.ends == "rest" else slope
        return (here + slope * (time - end), slope)[order] if order < 2 else Fraction(0)

    def _jump(self, curves: Sequence[Curve], row: int, order: int) -> Fraction:
        """By how much a derivative, which has these ``curves``, jumps at a row."""
        times = [Fraction(t) for t, _ in self.rows]
        before = curves[row - 1].at(times[row] - times[row - 1]) if row else self._beyond(times[0], times[0], order)
        after = curves[row].at(Fraction(0)) if row < len(curves) else self._beyond(times[-1], times[-1], order)
        return after - before

    def _begun_anew(self, time: Expr, let: Let, name: str) -> Expr:
        """The time within a period T from t_0 on, t_0 + T (arctan(tan(π (t - t_0)/T - π/2))/π + 1/2)."""
        import sympy as sp

        first, period = self.rows[0][0], self._period
        turned = let(f"turned_{name}", sp.Float(math.pi / period) * (time - sp.Float(first)) - sp.Float(math.pi / 2))
        folded = let(f"folded_{name}", sp.atan(let(f"tangent_{name}", sp.tan(turned))))
        return let(f"within_{name}", sp.Float(period / math.pi) * folded + sp.Float(first + period / 2))

    @property
    def _period(self) -> float:
        """After which it begins anew (s), 0 where it does not."""
        return self.rows[-1][0] - self.rows[0][0] if self.ends == "periodic" else 0.0


def number(value: Fraction) -> Expr:
    import sympy as sp

    return sp.Float(float(value))


def value(coefficients: Sequence[Fraction], x: Fraction) -> Fraction:
    """A polynomial at x."""
    found = Fraction(0)
    for c in reversed(coefficients):
        found = found * x + c
    return found


def derived(coefficients: Sequence[Fraction], order: int) -> State:
    """The coefficients of a derivative, at least one."""
    return [c * math.perm(j, order) for j, c in enumerate(coefficients)][order:] or [Fraction(0)]
