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
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Discriminator, Field, Tag, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticCustomError

from .expression_of_state import InLoad
from .expression_of_time import InTime, Law
from .laws_of_rise import LawOfRise
from .motion_laws import Monotone, Motion, Rises
from .piecewise_in_time import ENDS, Ends, Piecewise, State, derived, value
from .table import Columns, Table
from .written_numbers import Anything, Measured

ROWS = 500
"""Rows of a value over time, all of which stand in the equations: so many take some seconds to derive."""
KNOWN, SWEEPS = Fraction(1, 10**45), 60
"""Part of the terms of a condition by which it may be missed: what is solved in doubles is corrected until then, so
that what is rounded in the end is the same on all machines, whatever order they add up in. Each correction is good for
ten digits where rows are even; where all of these are not enough, rows are too near to each other for doubles."""

HERMITE = {1: ((1,),), 2: ((3, -1), (-2, 1)), 3: ((10, -4, 1), (-15, 7, -2), (6, -3, 1))}
"""What the upper half of the powers of x has of what the lower half misses at x = 1, in its value and its derivatives
over their factorials."""

PAIR = Field(min_length=2, max_length=2)
_OF_ANYTHING = Annotated[float, Anything()]


@dataclass(frozen=True)
class Spline(Piecewise):
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
        return f"a spline of order {self.order} through {len(self.rows)} rows, {ENDS[self.ends]}"

    @property
    def kind(self) -> str:
        return f"the spline of order {self.order}"

    def has_rate(self) -> bool:
        return self.order > 1

    def jumps(self, order: int) -> Mapping[int, float]:
        last = len(self.rows) - 1
        found = [*range(1, last)] if order >= self.order else []
        if self.ends == "rest" and order > (self.order - 1) // 2:
            found = [0, *found, last]
        return {row: self.rows[row][0] for row in found}

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
                for (row, d), share in self._derivative(piece, end, order):
                    one = (0, d) if self.ends == "periodic" and row == last and d else (row, d)
                    if self.ends == "periodic" or one not in gone:
                        found[one] = found.get(one, Fraction(0)) + factor * share
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
                yield (piece + row, d), value(derived(powers, order), h * end)


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

    ONE_OF: ClassVar[tuple[str, ...]] = ("order", "law")

    rows: list[list[float]] = Field(min_length=2)
    order: Literal[1, 3, 5] | None = Field(
        default=None,
        description="the order of the spline through the rows, 1 (straight from row to row), 3 or 5",
    )
    law: Motion | None = Field(
        default=None,
        description='in place of the order a law that keeps within the rows: "monotone" (a cubic), or from rest at '
        'each row to rest at the next by "cycloidal", "3-4-5", "4-5-6-7", "harmonic" or "modified-trapezoidal"',
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
                raise _wrong(cls._not_growing(number, row[0], after[0]))
        return rows

    @classmethod
    def _not_growing(cls, number: int, before: float, found: float) -> str:
        """What to say of a row that does not come after the one before."""
        return f"row {number} has t = {found:g} after t = {before:g}; write rows with times that grow"

    @field_validator("ends")
    @classmethod
    def _return(cls, ends: Ends, info: ValidationInfo) -> Ends:
        rows = info.data.get("rows")
        if ends == "periodic" and rows and rows[0][1] != rows[-1][1]:
            raise _wrong(f"the last row has {rows[-1][1]:g}, the first {rows[0][1]:g}; end with the value of the first")
        return ends

    @model_validator(mode="after")
    def _has_curve(self) -> Rows:
        if (self.order is None) == (self.law is None):
            found = "neither order nor law" if self.order is None else "order beside law"
            raise _wrong(f'it has {found}; write one of them, order = 1, 3 or 5, or law = "monotone"')
        if self.ends == "straight" and self.law not in (None, "monotone"):
            raise _wrong(f'law = "{self.law}" rests at the last row; write ends = "rest" or "periodic"')
        _check_size(self.curve(), f"{len(self.rows)} rows")
        _check_finite(self.curve(), "no spline in doubles goes through these rows; write times farther apart, or ")
        return self

    def curve(self) -> Piecewise:
        rows = tuple((t, value) for t, value in self.rows)
        if self.order is not None:
            return Spline(rows, self.order, self.ends)
        if self.law is None or self.law == "monotone":
            return Monotone(rows, self.ends)
        laws = (self.law if before != after else None for (_, before), (_, after) in pairwise(rows))
        return Rises(rows, tuple(laws), self.ends)


def _check_size(curve: Piecewise, given: str) -> None:
    """Laws of several parts, as the modified trapezium with its five, have rows where these meet besides the given."""
    count = f"{len(curve.rows)} rows"
    if len(curve.rows) > ROWS:
        of = "" if count == given else f" ({count}, with the ends of all their parts)"
        raise _wrong(f"there are {given}{of}, and all stand in the equations; write at most {ROWS} rows")


def _check_finite(curve: Piecewise, wrong: str) -> None:
    try:
        numbers = [float(c) for one in curve.curves for c in one.powers]
        numbers += [c for one in curve.curves for c in (one.size, one.frequency)]
    except (OverflowError, np.linalg.LinAlgError):
        numbers = [math.inf]
    if not all(map(math.isfinite, numbers)):
        raise _wrong(f"{wrong}smaller values")


class PieceInTime(Table):
    """A piece of a motion."""

    to: Annotated[float, Measured("s")] = Field(description="where it ends, in s, after the piece before")
    value: float | None = None
    law: LawOfRise | None = Field(
        default=None,
        description='how it gets there: "cycloidal" unless it says "3-4-5", "4-5-6-7", "harmonic" or '
        '"modified-trapezoidal"',
    )


class Pieces(Table):
    """Pieces over time in place of a value: ``{ pieces = [{ to = 1, value = "90 deg" }, { to = 2 }] }``."""

    pieces: Sequence[PieceInTime]
    start: float = 0.0
    begin: Annotated[float, Measured("s")] = Field(
        default=0.0, description="where the first piece begins, in s; 0 if not given"
    )
    ends: Literal["rest", "periodic"] = Field(
        default="rest", description='what it does before and after, "rest" (stay) or "periodic" (begin anew)'
    )

    @model_validator(mode="after")
    def _in_order(self) -> Pieces:
        time, value = self.begin, self.start
        for number, one in enumerate(self.pieces):
            if not time < one.to:
                before = "the one before ends" if number else "it begins"
                advice = "write later ones" if number else 'write a later end, or an earlier "begin"'
                raise _wrong(f"piece {number} ends at {one.to:.12g} s, where {before} at {time:.12g}; {advice}")
            if one.law and one.value is None:
                raise _wrong(f'piece {number} has law = "{one.law}" and no value, so it rests; leave the law out')
            time, value = one.to, value if one.value is None else one.value
        if self.ends == "periodic" and value != self.start:
            raise _wrong(f"the last piece ends at {value:g}, the first begins at {self.start:g}; end with the start")
        _check_size(self.curve(), f"{len(self.pieces)} pieces")
        _check_finite(self.curve(), "no motion in doubles goes through these pieces; write longer ones, or ")
        return self

    def curve(self) -> Piecewise:
        rows, laws = [(self.begin, self.start)], list[LawOfRise | None]()
        for one in self.pieces:
            before = rows[-1][1]
            rows.append((one.to, before if one.value is None else one.value))
            laws.append(None if rows[-1][1] == before else one.law or "cycloidal")
        return Rises(tuple(rows), tuple(laws), self.ends)


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


class AnglePiece(PieceInTime):
    """A piece of an angle."""

    value: Annotated[float, Measured("rad")] | None = Field(
        default=None, description="the angle at its end in rad; without it the piece rests"
    )


class AnglePieces(Pieces):
    """Pieces of an angle."""

    pieces: list[AnglePiece] = Field(min_length=1, description="what it does, piece after piece")
    start: Annotated[float, Measured("rad")] = Field(
        default=0.0, description="the angle before the first piece in rad; 0 if not given"
    )


class PositionPiece(PieceInTime):
    """A piece of a position."""

    value: Annotated[float, Measured("m")] | None = Field(
        default=None, description="the position at its end in m; without it the piece rests"
    )


class PositionPieces(Pieces):
    """Pieces of a position."""

    pieces: list[PositionPiece] = Field(min_length=1, description="what it does, piece after piece")
    start: Annotated[float, Measured("m")] = Field(
        default=0.0, description="the position before the first piece in m; 0 if not given"
    )


class SpeedPiece(PieceInTime):
    """A piece of a speed."""

    value: Annotated[float, Measured("rad/s", "m/s")] | None = Field(
        default=None, description="the speed at its end in rad/s (m/s where it slides); without it the piece rests"
    )


class SpeedPieces(Pieces):
    """Pieces of a speed."""

    pieces: list[SpeedPiece] = Field(min_length=1, description="what it does, piece after piece")
    start: Annotated[float, Measured("rad/s", "m/s")] = Field(
        default=0.0, description="the speed before the first piece in rad/s (m/s where it slides); 0 if not given"
    )


class TorquePiece(PieceInTime):
    """A piece of a torque."""

    value: Annotated[float, Measured("N m")] | None = Field(
        default=None, description="the torque at its end in N m; without it the piece rests"
    )


class TorquePieces(Pieces):
    """Pieces of a torque."""

    pieces: list[TorquePiece] = Field(min_length=1, description="what it does, piece after piece")
    start: Annotated[float, Measured("N m")] = Field(
        default=0.0, description="the torque before the first piece in N m; 0 if not given"
    )


class ForcePiece(PieceInTime):
    """A piece of a force."""

    value: Annotated[float, Measured("N")] | None = Field(
        default=None, description="the force at its end in N; without it the piece rests"
    )


class ForcePieces(Pieces):
    """Pieces of a force."""

    pieces: list[ForcePiece] = Field(min_length=1, description="what it does, piece after piece")
    start: Annotated[float, Measured("N")] = Field(
        default=0.0, description="the force before the first piece in N; 0 if not given"
    )


class CurveRows(Rows):
    """A function of one variable by rows [x, value]: ``{ rows = [[0, 0], [0.1, 3]], law = "monotone" }``."""

    rows: list[Annotated[list[float], PAIR, Columns(_OF_ANYTHING, _OF_ANYTHING)]] = Field(
        min_length=2, description="rows [x, value], at least two, of x that grows"
    )
    law: Literal["monotone"] | None = Field(
        default=None, description='in place of the order "monotone", a cubic that keeps within the rows'
    )
    ends: Literal["rest", "straight"] = Field(
        default="rest",
        description='what it does before the first row and after the last, "rest" (stay) or "straight" (go on)',
    )

    @classmethod
    def _not_growing(cls, number: int, before: float, found: float) -> str:
        return f"row {number} has x = {found:g} after x = {before:g}; write rows with x that grows"


def number_or_table(value: Any) -> str:
    """Which alternative of such a value is meant, as pydantic's tag."""
    if not isinstance(value, dict):
        return "<number>"
    misspelt = "rows" not in value and any(
        isinstance(one, list) and one and isinstance(one[0], dict) for one in value.values()
    )
    return "<pieces>" if "pieces" in value or misspelt else "<table>"


def law_of(value: Law | Rows | Pieces) -> Law:
    """What a value that may be given by rows or pieces is in a record."""
    return value.curve() if isinstance(value, Rows | Pieces) else value


def straying(law: object, key: str, unit: str) -> tuple[tuple[str, str], ...]:
    """The key and a sentence where a law over time leaves the range of its rows."""
    sentence = law.strays(unit) if isinstance(law, Piecewise) else ""
    return ((key, sentence),) if sentence else ()


_EITHER = Discriminator(number_or_table)

AngleInTime = Annotated[
    Annotated[Law, InTime("rad"), Tag("<number>")]
    | Annotated[AngleRows, Tag("<table>")]
    | Annotated[AnglePieces, Tag("<pieces>")],
    _EITHER,
]
PositionInTime = Annotated[
    Annotated[Law, InTime("m"), Tag("<number>")]
    | Annotated[PositionRows, Tag("<table>")]
    | Annotated[PositionPieces, Tag("<pieces>")],
    _EITHER,
]
SpeedInTime = Annotated[
    Annotated[Law, InTime("rad/s", "m/s"), Tag("<number>")]
    | Annotated[SpeedRows, Tag("<table>")]
    | Annotated[SpeedPieces, Tag("<pieces>")],
    _EITHER,
]
TorqueInTime = Annotated[
    Annotated[Law, InLoad("N m"), Tag("<number>")]
    | Annotated[TorqueRows, Tag("<table>")]
    | Annotated[TorquePieces, Tag("<pieces>")],
    _EITHER,
]
ForceInTime = Annotated[
    Annotated[Law, InLoad("N"), Tag("<number>")]
    | Annotated[ForceRows, Tag("<table>")]
    | Annotated[ForcePieces, Tag("<pieces>")],
    _EITHER,
]
