"""Values over time that a scene gives by rows [t, value]: a spline that says its order, with ends that it says too.

Between the rows t_i and t_(i+1) = t_i + h a spline of order k is a polynomial of degree k; at a row its derivatives up
to k - 1 do not jump. It is told by its derivatives up to (k - 1)/2 at the rows (Hermite's form), which follow from
that: C. de Boor, A Practical Guide to Splines, 1978, chapters IV and XIII.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import Discriminator, Field, Tag, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticCustomError

from .expression_of_time import InTime, Law, OfTime
from .table import Columns, Table
from .written_numbers import Measured

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Motion
    from ..derive.terms_of_effects import Let

ROWS = 500
"""Rows of a table, all of which stand in the equations: so many take some seconds to derive."""
KNOWN, SWEEPS = Fraction(1, 10**45), 60
"""Part of the terms of a condition by which it may be missed: what is solved in doubles is corrected until then, so
that what is rounded in the end is the same on all machines, whatever order they add up in. Each correction is good for
ten digits where rows are even; where all of these are not enough, rows are too near to each other for doubles."""

HERMITE = {1: ((1,),), 2: ((3, -1), (-2, 1)), 3: ((10, -4, 1), (-15, 7, -2), (6, -3, 1))}
"""What the upper half of the powers of x has of what the lower half misses at x = 1, in its value and its derivatives
over their factorials."""

PAIR = Field(min_length=2, max_length=2)
Ends = Literal["rest", "straight", "periodic"]
State = list[Fraction]
"""A value and its derivatives at a row."""


@dataclass(frozen=True)
class Spline(OfTime):
    """A value over time through ``rows`` (t, value) by a spline of ``order`` 1, 3 or 5. Its numbers are no parameters.

    Before the first row and after the last it rests at its value there, goes on straight, or begins anew, as ``ends``
    says.
    """

    rows: tuple[tuple[float, float], ...]
    order: int
    ends: Ends

    @property
    def shown(self) -> str:
        """``a spline of order 3 through 4 rows, at rest before and after``."""
        how = {"rest": "at rest before and after", "straight": "straight before and after", "periodic": "periodic"}
        return f"a spline of order {self.order} through {len(self.rows)} rows, {how[self.ends]}"

    def at(self, t: float) -> float:
        return self.slope_at(t, 0)

    def has_rate(self) -> bool:
        return self.order > 1

    def slope_at(self, t: float, order: int = 1) -> float:
        first, last = (Fraction(row[0]) for row in (self.rows[0], self.rows[-1]))
        time = Fraction(t)
        if self.ends == "periodic":
            time = first + (time - first) % (last - first)
        if not first <= time <= last:
            return float(self._beyond(time, first if time < first else last, order))
        piece = max(0, sum(start <= time for start, _ in self.rows[:-1]) - 1)
        return float(_value(_derived(self.pieces[piece], order), time - Fraction(self.rows[piece][0])))

    def jumps(self, order: int) -> Mapping[int, float]:
        last = len(self.rows) - 1
        found = [*range(1, last)] if order >= self.order else []
        if self.ends == "rest" and order > (self.order - 1) // 2:
            found = [0, *found, last]
        return {row: self.rows[row][0] for row in found}

    def kinks(self) -> tuple[tuple[float, float], ...]:
        return tuple((t, self._period) for t, _ in self.rows)

    def realise(self, motion: Motion, name: str) -> Expr:
        return self.derivative(motion, name, 0, {})

    def rate(self, motion: Motion, name: str) -> Expr:
        return self.derivative(motion, f"{name}_rate", 1, {})

    def derivative(self, motion: Motion, name: str, order: int, begun: Mapping[int, Expr]) -> Expr:
        """What it is before the first row; by how much it jumps at rows that have ``begun``; and what it adds from each
        row to the next, a polynomial of the time since that row, of which no more counts than that between them,
        (h + |t - t_i| - |t - t_(i+1)|)/2."""
        import sympy as sp

        time, let = motion.time, motion.let
        if self.ends == "periodic":
            time = self._begun_anew(time, let, name)
        pieces = [_derived(piece, order) for piece in self.pieces]
        first, last = (Fraction(row[0]) for row in (self.rows[0], self.rows[-1]))
        jumps = {row: self._jump(pieces, row, order) for row in self.jumps(order)}
        start = self._beyond(first, first, order) if 0 in jumps else pieces[0][0]
        terms: list[Any] = [_number(start), *(_number(jump) * begun[row] for row, jump in jumps.items())]
        since = [let(f"since_{name}_{i}", sp.Abs(time - sp.Float(t))) for i, (t, _) in enumerate(self.rows)]
        for i, ((t0, _), (t1, _)) in enumerate(pairwise(self.rows)):
            cut = let(f"part_{name}_{i}", (sp.Float(t1 - t0) + since[i] - since[i + 1]) / 2)
            added = sp.S.Zero
            for c in reversed(pieces[i][1:]):
                added = (added + _number(c)) * cut
            terms.append(let(f"added_{name}_{i}", added))
        if self.ends == "straight" and order == 0:
            before, after = (self._beyond(end, end, 1) for end in (first, last))
            terms.append(_number(before) * (time - sp.Float(self.rows[0][0]) - since[0]) / 2)
            terms.append(_number(after) * (time - sp.Float(self.rows[-1][0]) + since[-1]) / 2)
        return sp.Add(*terms)

    def _beyond(self, time: Fraction, end: Fraction, order: int) -> Fraction:
        """A derivative before the first row or after the last, whichever ``end`` is."""
        piece, start = (0, self.rows[0][0]) if end == self.rows[0][0] else (-1, self.rows[-2][0])
        value, slope = (_value(_derived(self.pieces[piece], d), end - Fraction(start)) for d in (0, 1))
        slope = Fraction(0) if self.ends == "rest" else slope
        return (value + slope * (time - end), slope)[order] if order < 2 else Fraction(0)

    def _jump(self, pieces: Sequence[State], row: int, order: int) -> Fraction:
        """By how much a derivative, which has these ``pieces``, jumps at a row."""
        times = [Fraction(t) for t, _ in self.rows]
        before = (
            _value(pieces[row - 1], times[row] - times[row - 1]) if row else self._beyond(times[0], times[0], order)
        )
        after = pieces[row][0] if row < len(pieces) else self._beyond(times[-1], times[-1], order)
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

    @cached_property
    def pieces(self) -> tuple[State, ...]:
        """The coefficients of the powers of t - t_i between each row and the next, to some forty digits."""
        times, states = [Fraction(t) for t, _ in self.rows], self._states()
        return tuple(_powers(a, b, t1 - t0) for (t0, t1), (a, b) in zip(pairwise(times), pairwise(states), strict=True))

    def _states(self) -> list[State]:
        """Values at the rows, and derivatives there that make the higher ones continuous, and are as the ends say."""
        states = [[Fraction(y)] + [Fraction(0)] * ((self.order - 1) // 2) for _, y in self.rows]
        conditions = [*self._conditions()]
        unknown = sorted({one for condition in conditions for one in condition if one[1]})
        if not unknown:
            return states
        solve = _solution(conditions, unknown)
        for _ in range(SWEEPS):
            terms = [[factor * states[row][d] for (row, d), factor in one.items()] for one in conditions]
            misses = [sum(parts, Fraction(0)) for parts in terms]
            if all(abs(miss) <= KNOWN * max(map(abs, parts)) for miss, parts in zip(misses, terms, strict=True)):
                break
            for (row, d), change in zip(unknown, solve(misses), strict=True):
                states[row][d] -= change
        else:
            raise np.linalg.LinAlgError("corrections of the derivatives at rows do not come to an end")
        if self.ends == "periodic":
            states[-1][1:] = states[0][1:]
        return states

    def _conditions(self) -> Iterator[Condition]:
        """What is zero: how much derivatives jump at rows, and those at the ends of what goes on straight. Derivatives
        of lower order that are zero at an end are left out."""
        half, last = (self.order + 1) // 2, len(self.rows) - 1
        gone = {(row, d) for row in (0, last) for d in range(1 if self.ends == "rest" else 2, half)}

        def told(*parts: tuple[int, int, int, int]) -> Condition:
            """The sum of these derivatives: factor, piece, its end (0 or 1) and order."""
            found: Condition = {}
            for factor, piece, end, order in parts:
                for (row, d), value in self._derivative(piece, end, order):
                    one = (0, d) if self.ends == "periodic" and row == last and d else (row, d)
                    if self.ends == "periodic" or one not in gone:
                        found[one] = found.get(one, Fraction(0)) + factor * value
            return found

        if half == 1:
            return
        for order in range(half, self.order):
            for row in range(1, last):
                yield told((1, row - 1, 1, order), (-1, row, 0, order))
            if self.ends == "periodic":
                yield told((1, last - 1, 1, order), (-1, 0, 0, order))
        if self.ends == "straight":
            yield told((1, 0, 0, half))
            yield told((1, last - 1, 1, half))

    def _derivative(self, piece: int, end: int, order: int) -> Iterator[tuple[tuple[int, int], Fraction]]:
        """How a derivative at an end of a piece hangs on the value and the derivatives at its two rows."""
        half = (self.order + 1) // 2
        h = Fraction(self.rows[piece + 1][0]) - Fraction(self.rows[piece][0])
        for row in (0, 1):
            for d in range(half):
                one, none = [Fraction(j == d) for j in range(half)], [Fraction(0)] * half
                powers = _powers(one, none, h) if row == 0 else _powers(none, one, h)
                yield (piece + row, d), _value(_derived(powers, order), h * end)


Condition = dict[tuple[int, int], Fraction]
"""A sum that is to be zero: factors of derivatives, each told by its row and its order."""


def _solution(
    conditions: Sequence[Condition], unknown: Sequence[tuple[int, int]]
) -> Callable[[Sequence[Fraction]], Sequence[Fraction]]:
    """What solves the conditions for the unknown derivatives, to rounding: in doubles, of rows and columns that powers
    of two have brought near to one, for derivatives differ as the times between rows do, to their powers."""
    sizes = [_power_of_two(max(map(abs, condition.values()))) for condition in conditions]
    scaled = [{one: factor / size for one, factor in row.items()} for row, size in zip(conditions, sizes, strict=True)]
    units = {
        one: _power_of_two(max((abs(row[one]) for row in scaled if one in row), default=Fraction(1))) for one in unknown
    }
    matrix = np.array([[float(row[one] / units[one]) if one in row else 0.0 for one in unknown] for row in scaled])

    def solve(right: Sequence[Fraction]) -> list[Fraction]:
        values = [value / size for value, size in zip(right, sizes, strict=True)]
        whole = _power_of_two(max(map(abs, values)))
        found = np.linalg.solve(matrix, np.array([float(value / whole) for value in values])).tolist()
        return [Fraction(value) * whole / units[one] for value, one in zip(found, unknown, strict=True)]

    return solve


def _power_of_two(value: Fraction) -> Fraction:
    """The power of two next to it, at most twice as large; 1 of zero."""
    return Fraction(2) ** (value.numerator.bit_length() - value.denominator.bit_length()) if value else Fraction(1)


def _number(value: Fraction) -> Expr:
    import sympy as sp

    return sp.Float(float(value))


def _value(coefficients: Sequence[Fraction], x: Fraction) -> Fraction:
    """A polynomial at x."""
    value = Fraction(0)
    for c in reversed(coefficients):
        value = value * x + c
    return value


def _derived(coefficients: Sequence[Fraction], order: int) -> State:
    """The coefficients of a derivative, at least one."""
    return [c * math.perm(j, order) for j, c in enumerate(coefficients)][order:] or [Fraction(0)]


def _powers(a: State, b: State, h: Fraction) -> State:
    """The coefficients of the powers of t - t_i of the polynomial with the value and derivatives ``a`` at t_i and ``b``
    at t_i + h."""
    half = len(a)
    low = [value * h**j / math.factorial(j) for j, value in enumerate(a)]
    missing = [
        value * h**d / math.factorial(d) - sum(math.comb(j, d) * low[j] for j in range(d, half))
        for d, value in enumerate(b)
    ]
    high = [sum(factor * one for factor, one in zip(row, missing, strict=True)) for row in HERMITE[half]]
    return [c / h**j for j, c in enumerate([*low, *high])]


class Rows(Table):
    """Rows over time in place of a value: ``{ rows = [[0, 0], [1, "90 deg"]], order = 5 }``."""

    rows: list[list[float]] = Field(min_length=2)
    order: Literal[1, 3, 5] = Field(
        description="the order of the spline through the rows, 1 (straight from row to row), 3 or 5"
    )
    ends: Ends = Field(
        default="rest",
        description='what it does before the first row and after the last, "rest" (stay), "straight" (go on) or '
        '"periodic" (begin anew)',
    )

    @field_validator("rows")
    @classmethod
    def _grow(cls, rows: list[list[float]]) -> list[list[float]]:
        for number, (row, after) in enumerate(pairwise(rows), start=1):
            if not row[0] < after[0]:
                raise _wrong(f"row {number} has t = {after[0]:g} after t = {row[0]:g}; write rows with times that grow")
        if len(rows) > ROWS:
            raise _wrong(f"there are {len(rows)} rows, and all stand in the equations; write at most {ROWS}")
        return rows

    @field_validator("ends")
    @classmethod
    def _return(cls, ends: Ends, info: ValidationInfo) -> Ends:
        rows = info.data.get("rows")
        if ends == "periodic" and rows and rows[0][1] != rows[-1][1]:
            raise _wrong(f"the last row has {rows[-1][1]:g}, the first {rows[0][1]:g}; end with the value of the first")
        return ends

    @model_validator(mode="after")
    def _has_spline(self) -> Rows:
        try:
            numbers = [float(c) for piece in self.spline().pieces for c in piece]
        except (OverflowError, np.linalg.LinAlgError):
            numbers = [math.inf]
        if not all(map(math.isfinite, numbers)):
            raise _wrong("no spline in doubles goes through these rows; write times farther apart, or smaller values")
        return self

    def spline(self) -> Spline:
        return Spline(tuple((t, value) for t, value in self.rows), self.order, self.ends)


def _wrong(advice: str) -> PydanticCustomError:
    return PydanticCustomError("rows", "{advice}", {"advice": advice})


def _row(*units: str) -> Any:
    return Columns(Annotated[float, Measured("s")], Annotated[float, Measured(*units)])


class AngleRows(Rows):
    """Rows of angles."""

    rows: list[Annotated[list[float], PAIR, _row("rad")]] = Field(
        min_length=2, description="rows [t, angle] in s and rad, at least two"
    )


class PositionRows(Rows):
    """Rows of lengths along a line."""

    rows: list[Annotated[list[float], PAIR, _row("m")]] = Field(
        min_length=2, description="rows [t, position] in s and m, at least two"
    )


class SpeedRows(Rows):
    """Rows of a joint's rate."""

    rows: list[Annotated[list[float], PAIR, _row("rad/s", "m/s")]] = Field(
        min_length=2, description="rows [t, speed] in s and rad/s (m/s where it slides), at least two"
    )


class TorqueRows(Rows):
    """Rows of a torque."""

    rows: list[Annotated[list[float], PAIR, _row("N m")]] = Field(
        min_length=2, description="rows [t, torque] in s and N m, at least two"
    )


class ForceRows(Rows):
    """Rows of a force."""

    rows: list[Annotated[list[float], PAIR, _row("N")]] = Field(
        min_length=2, description="rows [t, force] in s and N, at least two"
    )


def number_or_table(value: Any) -> str:
    """Which alternative of such a value is meant, as pydantic's tag."""
    return "<table>" if isinstance(value, dict) else "<number>"


def law_of(value: Law | Rows) -> Law:
    """What a value that may be given by rows is in a record."""
    return value.spline() if isinstance(value, Rows) else value


_EITHER = Discriminator(number_or_table)

AngleInTime = Annotated[
    Annotated[Law, InTime("rad"), Tag("<number>")] | Annotated[AngleRows, Tag("<table>")],
    _EITHER,
]
PositionInTime = Annotated[
    Annotated[Law, InTime("m"), Tag("<number>")] | Annotated[PositionRows, Tag("<table>")],
    _EITHER,
]
SpeedInTime = Annotated[
    Annotated[Law, InTime("rad/s", "m/s"), Tag("<number>")] | Annotated[SpeedRows, Tag("<table>")],
    _EITHER,
]
TorqueInTime = Annotated[
    Annotated[Law, InTime("N m"), Tag("<number>")] | Annotated[TorqueRows, Tag("<table>")],
    _EITHER,
]
ForceInTime = Annotated[
    Annotated[Law, InTime("N"), Tag("<number>")] | Annotated[ForceRows, Tag("<table>")],
    _EITHER,
]
