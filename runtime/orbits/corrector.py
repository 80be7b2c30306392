"""Points of a branch of periodic motions: Newton's method in state and parameter (docs/theory.md, eq. 12.2)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..run import Run
from .grazing import Nearness, nearness
from .newton import Found, led, newton
from .orbit import Orbit, orbit_of
from .rank import RANK, rank_of
from .repeats import check_advance
from .section import Crossed
from .shooting import Chain, State, spread
from .tolerance import KNOWN, tolerance_of
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
    """A periodic motion at a ``value`` of the parameter: its ``orbit``, what comes of its nodes, its ``place``
    (2 n segments + 1,) and the ``tangent`` of the branch there, in units of the mechanism and of the parameter, how
    many ``steps`` found it, what it is ``near`` to, and which contacts strike in it, one after the other.

    A place is all nodes over the root of their number, so that distances are as those of one, and the
    parameter."""

    value: float
    orbit: Orbit
    crossed: tuple[Crossed, ...]
    place: FloatArray
    tangent: FloatArray
    steps: int
    near: list[Nearness]
    pattern: tuple[tuple[tuple[str, str], ...], ...]

    def begins(self, place: FloatArray) -> FloatArray:
        """Of a place or a tangent the start of the motion and the parameter, (2 n + 1,), whatever its segments are."""
        count = len(self.crossed)
        return np.append(np.sqrt(count) * place[: (len(place) - 1) // count], place[-1])


class Plane:
    """Where a branch is looked for: in the plane through the place ``guess`` that is normal to ``normal``, within
    ``reach`` of it, at a value of the parameter that is ``fixed`` unless that is None."""

    def __init__(
        self, corrector: Corrector, guess: FloatArray, normal: FloatArray, reach: float, fixed: float | None
    ) -> None:
        self.parameter, self.unit = corrector.parameter, corrector.unit
        self.corrector, self.guess, self.normal, self.reach, self.fixed = corrector, guess, normal, reach, fixed

    def row(self, crossed: Sequence[Crossed], value: float) -> tuple[FloatArray, float]:
        """What the distance from the plane moves by, (m + 1,), and the distance."""
        off = self.normal @ (self.corrector.place(value, crossed) - self.guess)
        return self.normal @ self.corrector.along(crossed), float(off)

    def changed(self, value: float, by: float) -> float:
        """The value behind a step."""
        return value + by * self.unit if self.fixed is None else self.fixed

    def leaves(self, crossed: Sequence[Crossed] | None, value: float) -> bool:
        """Whether a place is out of reach, or the parameter alone."""
        if crossed is None:
            return abs(value - self.corrector.value_at(self.guess)) > self.reach * self.unit
        return float(np.linalg.norm(self.corrector.place(value, crossed) - self.guess)) > self.reach


class Corrector:
    """Finds points of the branch through a periodic motion; ``unit`` is what the parameter is measured in, and rates
    are in those of a swing of the ``period`` (s)."""

    def __init__(self, chain: Chain, period: float, parameter: str, unit: float) -> None:
        self.chain, self.parameter, self.unit = chain, parameter, unit
        length = chain.map.model.coordinate_units
        self.units = np.concatenate([length, 2.0 * np.pi / period * length])
        self.tolerance = tolerance_of(chain.map)

    def value_at(self, place: FloatArray) -> float:
        """The parameter at a place."""
        return float(place[-1]) * self.unit

    def begin(self, nodes: FloatArray, value: float) -> Point:
        """The first point, of a motion that is known by its nodes (segments, 2 n); its tangent is that along which the
        parameter grows."""
        up, n = np.zeros(nodes.size + 1), nodes.shape[1] // 2
        up[-1] = 1.0
        return self._begun(self.chain, [(x[:n], x[n:]) for x in nodes], value, up)

    def spread(self, point: Point) -> Point:
        """The same motion in segments with times that have followed its period, where they have to."""
        parts = spread(point.orbit.chain, point.crossed)
        if parts is None:
            return point
        before = np.zeros_like(point.tangent)
        first = len(self.units)
        before[:first], before[-1] = point.tangent[:first], point.tangent[-1]
        try:
            fresh = self._begun(*parts, point.value, before)._replace(steps=point.steps)
        except ValueError:  # where they cannot be begun anew they go on as they are
            return point
        return fresh if fresh.orbit.missed <= self.tolerance else point

    def point(self, guess: FloatArray, normal: FloatArray, last: Point, *, exactly: bool = False) -> Point:
        """The point of the branch in the plane through the place ``guess`` that is normal to ``normal``, from the
        ``last`` one on, ``exactly`` to rounding. Raises :class:`Missed` where there is none."""
        try:
            return self._found(guess, normal, last, 0.0 if exactly else KNOWN * self.tolerance, None)
        except ValueError as error:
            raise Missed(str(error)) from error

    def point_at(self, value: float, last: Point) -> Point:
        """The point near the ``last`` one at a value of the parameter."""
        up = np.append(np.zeros(len(last.place) - 1), 1.0)
        guess = last.place + (value / self.unit - last.place[-1]) / last.tangent[-1] * last.tangent
        try:
            return self._found(guess, up, last, KNOWN * self.tolerance, value)
        except ValueError as error:
            raise Missed(str(error)) from error

    def _found(self, guess: FloatArray, normal: FloatArray, last: Point, enough: float, fixed: float | None) -> Point:
        plane = Plane(self, guess, normal, FAR * float(np.linalg.norm(guess - last.place)), fixed)
        value = self.value_at(guess) if fixed is None else fixed
        chain, nodes = led(
            last.orbit.chain, self.parameter, value, last.crossed, self._states(guess - last.place), self._trial, 0
        )
        best, steps = newton(
            chain,
            nodes,
            self.tolerance,
            MOST,
            self._trial,
            enough=enough,
            curve=plane,
            value=value,
            about=[crossed.time for crossed in last.crossed],
        )
        if best is None or best.missed > self.tolerance:
            raise Missed("Newton's method does not converge")
        point = self._point(self._at_value(chain, best.value), best, last.tangent, steps)
        check_advance(point.orbit)
        return point

    @contextmanager
    def _trial(self, steps: int, state: State, value: float) -> Iterator[None]:
        """Raises :class:`Missed` with the place to which so many steps led, where no run can be made there."""
        try:
            yield
        except ValueError as error:
            model = self.chain.map.model
            came = f"step {steps} of Newton's method" if steps else "the step along the branch"
            place = f"{self.parameter} = {value:.9g}, {told(model, state)}"
            raise Missed(f"{came} led to {place}, where no run could be made: {why(model, error)}") from error

    def _at_value(self, chain: Chain, value: float) -> Chain:
        return chain.of(chain.map.model.with_parameters({self.parameter: value}))

    def _begun(self, chain: Chain, nodes: Sequence[State], value: float, before: FloatArray) -> Point:
        """The point of nodes that are known."""
        chain = self._at_value(chain, value)
        crossed = chain.at(nodes, self.parameter)
        missed = float(np.max(np.abs(chain.system(crossed)[0]), initial=0.0))
        return self._point(chain, Found(tuple(crossed), missed, value), before, 0)

    def _states(self, place: FloatArray) -> FloatArray:
        """The nodes (segments, 2 n) of a place."""
        count = (len(place) - 1) // len(self.units)
        return np.asarray(np.sqrt(count) * place[:-1].reshape(count, -1) * self.units)

    def place(self, value: float, crossed: Sequence[Crossed]) -> FloatArray:
        """All nodes, each in its units and over the root of their number, and the parameter in its own."""
        states = [np.concatenate([one.q, one.u]) / self.units for one in crossed]
        return np.append(np.concatenate(states) / np.sqrt(len(crossed)), value / self.unit)

    def along(self, crossed: Sequence[Crossed]) -> FloatArray:
        """What places move by (2 n segments + 1, m + 1) with the directions of all starts and the parameter."""
        size, ends = len(self.units), Chain.columns(crossed)
        found = np.zeros((size * len(crossed) + 1, ends[-1] + 1))
        for k, one in enumerate(crossed):
            rows = slice(k * size, (k + 1) * size)
            found[rows, ends[k] : ends[k + 1]] = one.basis / self.units[:, None]
            found[rows, -1] = one.lift / self.units * self.unit
        found /= np.sqrt(len(crossed))
        found[-1, -1] = 1.0
        return found

    def _point(self, chain: Chain, found: Found, before: FloatArray, steps: int) -> Point:
        crossed, runs = found.crossed, [run for one in found.crossed for run in one.runs]
        orbit, tangent = orbit_of(chain, crossed, found.missed), self._tangent(chain, crossed, before)
        place = self.place(found.value, crossed)
        return Point(found.value, orbit, crossed, place, tangent, steps, nearness(runs), tuple(_pattern(runs)))

    def among_others(self, point: Point) -> bool:
        """Whether motions of the same value of the parameter stay periodic too, to the accuracy of runs: of all
        directions on the section and of the parameter more than one leaves nothing missed."""
        rows = self._rows(point.orbit.chain, point.crossed)[1]
        values = np.linalg.svd(rows, compute_uv=False)
        return bool(np.sum(values > FAMILY) < rows.shape[1] - 1)

    def _rows(self, chain: Chain, crossed: Sequence[Crossed]) -> tuple[FloatArray, FloatArray]:
        """Orthonormal directions (2 n segments + 1, m + 1) of places on the section, and what these miss,
        (k, m + 1)."""
        orthonormal, triangle = np.linalg.qr(self.along(crossed))
        return orthonormal, np.linalg.solve(triangle.T, chain.system(crossed, self.unit)[1].T).T

    def _tangent(self, chain: Chain, crossed: Sequence[Crossed], before: FloatArray) -> FloatArray:
        """The direction of length 1 in which motions stay periodic; of several that nearest to the one ``before``."""
        orthonormal, rows = self._rows(chain, crossed)
        _, values, directions = np.linalg.svd(rows)
        free = orthonormal @ directions[min(rank_of(values), len(directions) - 1) :].T
        found = free @ (free.T @ before)
        if not np.linalg.norm(found) > RANK:
            found = free[:, 0]
        return np.asarray(found / np.linalg.norm(found))


def _pattern(runs: Sequence[Run]) -> Sequence[tuple[tuple[str, str], ...]]:
    """The contacts of each instant at which some strike."""
    found = list[tuple[tuple[str, str], ...]]()
    for run in runs:
        by: dict[float, dict[tuple[str, str], None]] = {}
        for impact in run.impacts:
            by.setdefault(impact.t, {}).update(dict.fromkeys(impact.contacts))
        found += [tuple(sorted(contacts)) for contacts in by.values()]
    return found
