"""Points of a branch of periodic motions: Newton's method in state and parameter (docs/theory.md, eq. 12.2)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from .grazing import Nearness, nearness
from .orbit import Orbit, orbit_at
from .repeats import check_advance
from .section import RANK, Crossed, Map
from .tolerance import KNOWN, LESS, tolerance_of
from .trial import told, why

MOST = 10
"""Steps of Newton's method; from near enough it needs three or four."""

FAR = 10.0
"""A correction that leads further than this many times the length of the step leads to another branch."""


FAMILY = 1e-7
"""What is missed along a direction (of length 1, in units of the mechanism) of a family of motions is below this."""


class Missed(Exception):
    """There is no point there, and why."""


class Point(NamedTuple):
    """A periodic motion at a ``value`` of the parameter: its ``orbit``, its ``place`` (2 n + 1,) and the ``tangent`` of
    the branch there, in units of the mechanism and of the parameter, how many ``steps`` found it, what it is ``near``
    to, and which contacts strike in it, one after the other."""

    value: float
    orbit: Orbit
    crossed: Crossed
    place: FloatArray
    tangent: FloatArray
    steps: int
    near: list[Nearness]
    pattern: tuple[tuple[tuple[str, str], ...], ...]


class Corrector:
    """Finds points of the branch through a periodic motion; ``unit`` is what the parameter is measured in, and rates
    are in those of a swing of the ``period`` (s)."""

    def __init__(self, a_map: Map, period: float, parameter: str, unit: float) -> None:
        self.map, self.parameter, self.unit = a_map, parameter, unit
        length = a_map.model.coordinate_units
        self.units = np.concatenate([length, 2.0 * np.pi / period * length])
        self.tolerance = tolerance_of(a_map)

    def value_at(self, place: FloatArray) -> float:
        """The parameter at a place."""
        return float(place[-1]) * self.unit

    def begin(self, orbit: Orbit, value: float) -> Point:
        """The first point, of a motion that is known; its tangent is that along which the parameter grows."""
        crossed = self._map(value).at(orbit.q, orbit.u, self.parameter)
        up = np.zeros(2 * len(orbit.q) + 1)
        up[-1] = 1.0
        return self._point(value, crossed, up, 0)

    def point(self, guess: FloatArray, normal: FloatArray, last: Point, *, exactly: bool = False) -> Point:
        """The point of the branch in the plane through the ``guess`` (2 n + 1,) that is normal to ``normal``, from the
        ``last`` one on, ``exactly`` to rounding. Raises :class:`Missed` where there is none."""
        try:
            return self._newton(guess, normal, last, 0.0 if exactly else KNOWN * self.tolerance, None)
        except ValueError as error:
            raise Missed(str(error)) from error

    def point_at(self, value: float, last: Point) -> Point:
        """The point near the ``last`` one at a value of the parameter."""
        up = np.append(np.zeros(len(last.place) - 1), 1.0)
        guess = last.place + (value / self.unit - last.place[-1]) / last.tangent[-1] * last.tangent
        try:
            return self._newton(guess, up, last, KNOWN * self.tolerance, value)
        except ValueError as error:
            raise Missed(str(error)) from error

    def _newton(self, guess: FloatArray, normal: FloatArray, last: Point, enough: float, fixed: float | None) -> Point:
        crossed, units = last.crossed, self.units
        best: tuple[float, float, Crossed] = np.inf, last.value, crossed
        change, value = (guess - last.place)[:-1] * units, self.value_at(guess) if fixed is None else fixed
        reach = FAR * float(np.linalg.norm(guess - last.place))
        for steps in range(MOST):
            crossed = self._tried(value, crossed, change, steps)
            place, missed = self._place(value, crossed), float(np.max(np.abs(crossed.rest), initial=0.0))
            off = float(normal @ (place - guess))
            if missed <= enough or (missed <= self.tolerance and not missed < best[0] / LESS):
                value, crossed = min(best, (missed, value, crossed), key=lambda one: one[0])[1:]
                point = self._point(value, crossed, last.tangent, steps)
                check_advance(point.orbit)
                return point
            if float(np.linalg.norm(place - guess)) > reach:
                break
            best = min(best, (missed, value, crossed), key=lambda one: one[0])
            along = self._along(crossed)
            rows = np.vstack([np.column_stack([crossed.moves, crossed.by]), normal @ along])
            step = np.linalg.lstsq(rows, -np.append(crossed.rest, off), rcond=RANK)[0]
            change, value = crossed.basis @ step[:-1] + crossed.lift * step[-1], value + float(step[-1])
            value = value if fixed is None else fixed
            if abs(value - self.value_at(guess)) > reach * self.unit:
                break
        raise Missed("Newton's method does not converge")

    def _tried(self, value: float, crossed: Crossed, change: FloatArray, steps: int) -> Crossed:
        """What comes of the state that is (2 n,) away from one, at a value of the parameter, after so many steps.
        Raises :class:`Missed` with the place where no run can be made there."""
        n = len(crossed.q)
        try:
            a_map = self._map(value)
            return a_map.at(*a_map.moved(crossed, change), self.parameter)
        except ValueError as error:
            model = self.map.model
            state = told(model, (crossed.q + change[:n], crossed.u + change[n:]))
            came = f"step {steps} of Newton's method" if steps else "the step along the branch"
            place = f"{self.parameter} = {value:.9g}, {state}"
            raise Missed(f"{came} led to {place}, where no run could be made: {why(model, error)}") from error

    def _map(self, value: float) -> Map:
        return self.map.of(self.map.model.with_parameters({self.parameter: value}))

    def _place(self, value: float, crossed: Crossed) -> FloatArray:
        return np.append(np.concatenate([crossed.q, crossed.u]) / self.units, value / self.unit)

    def _along(self, crossed: Crossed) -> FloatArray:
        """What places move by (2 n + 1, m + 1) with the directions on the section and the parameter."""
        columns = np.column_stack([crossed.basis, crossed.lift]) / self.units[:, None]
        return np.vstack([columns, np.append(np.zeros(columns.shape[1] - 1), 1.0 / self.unit)])

    def _point(self, value: float, crossed: Crossed, before: FloatArray, steps: int) -> Point:
        orbit = orbit_at(self._map(value), crossed)
        tangent = self._tangent(crossed, before)
        pattern = tuple(_pattern(crossed))
        return Point(
            value, orbit, crossed, self._place(value, crossed), tangent, steps, nearness(crossed.runs), pattern
        )

    def among_others(self, point: Point) -> bool:
        """Whether motions of the same value of the parameter stay periodic too, to the accuracy of runs: of all
        directions on the section and of the parameter more than one leaves nothing missed."""
        values = np.linalg.svd(self._rows(point.crossed)[1], compute_uv=False)
        return bool(np.sum(values > FAMILY) < point.crossed.moves.shape[1])

    def _rows(self, crossed: Crossed) -> tuple[FloatArray, FloatArray]:
        """Orthonormal directions (2 n + 1, m + 1) of places on the section, and what these miss, (k, m + 1)."""
        orthonormal, triangle = np.linalg.qr(self._along(crossed))
        return orthonormal, np.linalg.solve(triangle.T, np.column_stack([crossed.moves, crossed.by]).T).T

    def _tangent(self, crossed: Crossed, before: FloatArray) -> FloatArray:
        """The direction (2 n + 1,) of length 1 in which motions stay periodic; of several that nearest to the one
        ``before``."""
        orthonormal, rows = self._rows(crossed)
        _, values, directions = np.linalg.svd(rows)
        rank = min(int(np.sum(values > RANK * values.max(initial=0.0))), len(directions) - 1)
        free = orthonormal @ directions[rank:].T
        found = free @ (free.T @ before)
        if not np.linalg.norm(found) > RANK:
            found = free[:, 0]
        return np.asarray(found / np.linalg.norm(found))


def _pattern(crossed: Crossed) -> Sequence[tuple[tuple[str, str], ...]]:
    """The contacts of each instant at which some strike."""
    found = list[tuple[tuple[str, str], ...]]()
    for run in crossed.runs:
        by: dict[float, dict[tuple[str, str], None]] = {}
        for impact in run.impacts:
            by.setdefault(impact.t, {}).update(dict.fromkeys(impact.contacts))
        found += [tuple(sorted(contacts)) for contacts in by.values()]
    return found
