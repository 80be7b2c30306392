"""``fit(model, curve, of="coupler.tip", crank="crank", vary=["crank.length", "coupler.length"])``."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ..analysis.follow import follow
from ..analysis.wants import Turn, read_wants
from ..arrays import FloatArray, IntArray
from ..faults import Faults
from ..model.derivatives import need_derivatives
from ..model.model import Model, with_params
from ..model.numbers import read_numbers
from ..precision import need_doubles
from .search import Search, Varied, least_squares, varied

SAMPLES = 120
"""Angles of a turn at which the curve is looked at to guess which belongs to which point: 3 degrees apart."""

NEARER = 0.5
"""A search that leaves more than this part of the squares of the one before is the last: that was at its minimum."""

AT_ONCE = 1e-12
"""A root mean square of distances below this part of the curve's size is rounding: nothing is nearer."""

CANDIDATES = 8
"""Angles that are tried for the first point, the others being in order behind it."""


@dataclass(frozen=True, eq=False)
class Fitted:
    """A model whose point comes nearest to a curve.

    ``values`` are the parameters that were varied, and ``model`` has them; ``angles`` (m,) of the crank (rad) at which
    the point is at ``points`` (m, 2) in m, in the configurations ``q`` (m, nq), which are all on one branch.
    ``error`` is the root mean square of the distances to the curve's points, ``largest`` the largest (m). ``in_order``
    is false where the crank does not pass the points in the order in which they were given, or backwards.
    """

    values: Mapping[str, float]
    model: Model = field(repr=False)
    angles: FloatArray = field(repr=False)
    points: FloatArray = field(repr=False)
    q: FloatArray = field(repr=False)
    error: float
    largest: float
    in_order: bool
    evaluations: int
    converged: bool
    message: str


def fit(
    model: Model,
    curve: ArrayLike,
    *,
    of: str,
    crank: str,
    vary: Sequence[str],
    angles: ArrayLike | None = None,
    q0: ArrayLike | None = None,
    params: Mapping[str, float] | None = None,
    most: int = 200,
) -> Fitted:
    """The parameters ``vary`` with which the point ``of`` comes nearest to the points of a ``curve`` (m, 2) in m.

    ``crank`` is the link or joint whose angle runs; with ``angles`` (m,) in rad the point is to be at each place at
    that angle (a function is generated), without them at any, which are found too (a path is generated). All other
    freedoms have to follow from the crank's angle. The search begins at the values that the model has, or ``params``,
    and at the configuration ``q0``, the scene's start unless given, whose branch it keeps: dimensions with which the
    mechanism cannot go from one point to the next on it are no solutions. Driven joints are as free as others.

    Least squares with exact derivatives of the configurations by dimensions, from the implicit function theorem (J. M.
    McCarthy, G. S. Soh, Geometric Design of Linkages, 2011, chapter 3, has the problem). It finds the nearest minimum,
    not the least of all: begin near. Needs SciPy, and a model generated with its derivatives.

    Raises ``ValueError`` for names, shapes and numbers that are wrong, all at once; where the first mechanism does not
    reach, with why; where the crank leaves freedoms.
    """
    if not isinstance(model, Model):
        raise TypeError(f"model: found {type(model).__name__}, expected a Model; load one with load_model(folder)")
    need_doubles(model.precision, model.name, "fitting a curve")
    begun = with_params(model, params)
    faults, search, places, given = Faults(), None, None, None
    with faults.collecting():
        search = varied(begun, vary, "vary")
    with faults.collecting():
        places = _places(curve)
    with faults.collecting():
        given = _angles(angles, places)
    if of not in begun.points:
        faults.add(f"of: found {of!r}, expected one of {', '.join(begun.points)}")
    with faults.collecting():
        read_wants(begun, None, {crank: 0.0}, None)
    with faults.collecting():
        need_derivatives(begun)
    if isinstance(most, bool) or not isinstance(most, int) or most < 1:
        faults.add(f"most: found {most!r}, expected a number of tries, at least 1")
    faults.stop_if_any()
    assert search is not None and places is not None
    start = begun.start()[0] if q0 is None else np.asarray(read_numbers(q0, "q0"), dtype=float)
    curves = _Curves(begun, search, places, of, crank, start)
    curves.check_freedoms()
    found, turned = _timed(curves, given, most) if given is not None else _untimed(curves, most)
    misses = curves.size * found.residuals.reshape(-1, 2)
    distances = np.hypot(*misses.T)
    return Fitted(
        values=dict(zip(search.paths, found.x[: len(search.paths)].tolist(), strict=True)),
        model=curves.model,
        angles=turned,
        points=places + misses,
        q=curves.q,
        error=float(np.sqrt(np.mean(distances**2))),
        largest=float(distances.max()),
        in_order=_in_order(turned),
        evaluations=curves.count,
        converged=found.converged,
        message=found.message,
    )


def _timed(curves: _Curves, angles: FloatArray, most: int) -> tuple[Search, FloatArray]:
    """With given angles. Where the first mechanism does not get to all of them it is fitted to those that it gets to,
    and gets farther then; it is refused where that ends."""
    x, known = curves.search.start, 0
    while True:
        reached, why = curves.reached(x, angles)
        if len(reached) == len(angles):
            break
        if len(reached) <= known:
            raise ValueError(
                f"{curves.begun.name}: found a mechanism that gets to {len(reached)} of {len(angles)} angles, also "
                f"where it is fitted to these; begin with other dimensions or on another branch: {why}"
            )
        known = len(reached)
        part = curves.of_points(np.sort(reached))
        x = part.find(x, angles[np.sort(reached)], most)[0].x
    return curves.find(x, angles, most)


def _untimed(curves: _Curves, most: int) -> tuple[Search, FloatArray]:
    """With angles that are found too. They are guessed anew from the curve that a search has led to, as long as that
    brings it nearer."""
    p = len(curves.search.paths)
    best = None
    x = curves.search.start
    while True:
        guess = curves.guess(x)
        found, turned = curves.find(np.concatenate([x, guess]), None, most)
        error = float(found.residuals @ found.residuals)
        if best is not None and not error < NEARER * best[0]:
            _, found, turned = best
            curves.residuals(found.x)
            return found, turned
        best, x = (error, found, turned), found.x[:p]
        if error <= AT_ONCE**2 * len(curves.places):
            return found, turned


def _places(curve: ArrayLike) -> FloatArray:
    found = np.asarray(read_numbers(curve, "curve"), dtype=float)
    if found.ndim != 2 or found.shape[1] != 2 or len(found) < 2 or not np.all(np.isfinite(found)):
        raise ValueError(f"curve: found shape {found.shape}, expected at least two points (m, 2) of finite numbers")
    return found


def _angles(angles: ArrayLike | None, places: FloatArray | None) -> FloatArray | None:
    if angles is None:
        return None
    found = np.asarray(read_numbers(angles, "angles"), dtype=float)
    if found.ndim != 1 or (places is not None and len(found) != len(places)) or not np.all(np.isfinite(found)):
        raise ValueError(f"angles: found shape {found.shape}, expected a finite number for each point of the curve")
    return found


def _in_order(angles: FloatArray) -> bool:
    """Whether a crank that turns one way passes them one after the other within a turn."""
    steps = np.diff(angles)
    return any(bool(np.all(s * steps >= 0.0)) for s in (1.0, -1.0)) and abs(angles[-1] - angles[0]) < 2.0 * math.pi


class _Curves:
    """Places of the point with values of the parameters and angles; the last ones are kept."""

    def __init__(
        self, model: Model, search: Varied, places: FloatArray, of: str, crank: str, start: FloatArray
    ) -> None:
        self.begun = self.model = model
        self.search, self.paths = search, search.paths
        self.places, self.of, self.crank = places, of, crank
        self.start, self.q = start, np.zeros((0, len(start)))
        self.size = float(np.max(np.ptp(places, axis=0))) or model.length
        """How large the curve is (m): residuals are parts of it."""
        self.given: FloatArray | None = None
        self.kept: FloatArray | None = None
        self.failed = ""
        self.count = 0

    def of_points(self, which: IntArray) -> _Curves:
        """The same for some of the points."""
        return _Curves(self.begun, self.search, self.places[which], self.of, self.crank, self.start)

    def find(self, x: FloatArray, angles: FloatArray | None, most: int) -> tuple[Search, FloatArray]:
        """The nearest minimum, with these angles, or with such that it finds where they are None; and the angles.

        Raises ``ValueError`` where the mechanism that the search begins with does not get there."""
        p, free, search = len(self.paths), angles is None, self.search
        self.given = angles
        self.residuals(x)
        if self.failed:
            raise ValueError(
                f"{self.begun.name}: the mechanism that the search begins with does not get there: {self.failed}"
            )
        open_ = np.full(len(self.places), np.inf) if free else np.zeros(0)
        scales = np.concatenate([search.scales, np.ones(len(open_))])
        bounds = np.concatenate([search.lowest, -open_]), np.concatenate([search.highest, open_])
        found = least_squares(self.residuals, self.jacobian, x, bounds, scales, most, "fitting a curve")
        self.residuals(found.x)
        return found, found.x[p:] if angles is None else angles

    def with_values(self, x: FloatArray) -> Model:
        """The model with values of the parameters."""
        return self.begun.with_parameters(dict(zip(self.paths, x[: len(self.paths)].tolist(), strict=True)))

    def reached(self, x: FloatArray, angles: FloatArray) -> tuple[IntArray, str]:
        """Which of the angles the mechanism of these values gets to, one after the other from its start both ways, and
        why not farther."""
        model, why = self.with_values(x), ""
        begin = model.assemble(self.start)
        at = float(Turn(model, self.crank).value(begin)[0])
        order, found = np.argsort(angles, kind="stable"), list[int]()
        ahead = [k for k in order if angles[k] >= at]
        for way in (ahead, [k for k in order[::-1] if angles[k] < at]):
            q, before = begin, at
            for k in way:
                try:
                    q = _next(model, self.crank, q, before, float(angles[k]))
                except ValueError as error:
                    why = str(error)
                    break
                before = float(angles[k])
                found.append(int(k))
        return np.array(found, dtype=int), why

    def check_freedoms(self) -> None:
        """Raise ``ValueError`` where the crank's angle does not give the rates of all others."""
        try:
            rows = self._rows(self.begun, self.begun.assemble(self.start))
        except ValueError as error:
            raise ValueError(f"{self.begun.name}: found dimensions that cannot be assembled: {error}") from error
        values = np.linalg.svd(rows, compute_uv=False)
        rank = int(np.sum(values > 1e-10 * values[0]))
        if rank < rows.shape[1]:
            raise ValueError(
                f"{self.begun.name}: found {rows.shape[1] - rank} freedoms left with the angle of {self.crank} given, "
                "expected none; fix them by joints, or choose another crank"
            )

    def _rows(self, model: Model, q: FloatArray) -> FloatArray:
        return np.vstack([model.jacobian(q), Turn(model, self.crank).rows(q)])

    def guess(self, x: FloatArray) -> FloatArray:
        """Angles for all points, in order along the turn, at which the mechanism of these values is nearest to them."""
        angles, points = self._sweep(self.with_values(x))
        count, whole = len(angles), angles[-1] - angles[0] > 2.0 * math.pi * (1.0 - 1.5 / SAMPLES)
        best, chosen = np.inf, angles[:1]
        for places, backwards in ((self.places, False), (self.places[::-1], True)):
            far = np.linalg.norm(places[:, None] - points[None], axis=2)
            firsts = np.argsort(far[0], kind="stable")[:CANDIDATES] if whole else [0]
            for first in firsts:
                order = (first + np.arange(count)) % count
                cost, which = _in_turn(far[:, order] ** 2)
                if cost < best:
                    turned = angles[order[which]] + 2.0 * math.pi * (order[which] < first)
                    best, chosen = cost, turned[::-1] if backwards else turned
        return np.array(chosen)

    def _sweep(self, model: Model) -> tuple[FloatArray, FloatArray]:
        """Angles of a turn, or as far as the crank gets, and places of the point there."""
        turn = Turn(model, self.crank)
        q = model.assemble(self.start)
        begin, step = float(turn.value(q)[0]), 2.0 * math.pi / SAMPLES
        ahead = self._one_way(model, q, begin, step, SAMPLES)
        behind = [] if len(ahead) == SAMPLES else self._one_way(model, q, begin, -step, SAMPLES - len(ahead))
        rows = [*behind[::-1], (begin, q), *ahead] if len(ahead) < SAMPLES else [(begin, q), *ahead[:-1]]
        return np.array([angle for angle, _ in rows]), np.array([model.point(self.of, one) for _, one in rows])

    def _one_way(
        self, model: Model, q: FloatArray, begin: float, step: float, most: int
    ) -> list[tuple[float, FloatArray]]:
        rows: list[tuple[float, FloatArray]] = []
        for k in range(1, most + 1):
            angle = begin + k * step
            try:
                q = _next(model, self.crank, q, angle - step, angle)
            except ValueError:
                break
            rows.append((angle, q))
        return rows

    def at(self, x: FloatArray) -> FloatArray:
        """Places of the point (m, 2), NaN where there is no way to them."""
        if self.kept is None or not np.array_equal(self.kept, x):
            self.kept, self.failed, self.count = x.copy(), "", self.count + 1
            p = len(self.paths)
            angles = x[p:] if self.given is None else self.given
            order = np.argsort(angles, kind="stable")
            try:
                model = self.with_values(x)
                first = model.assemble(self.q[order[0]] if len(self.q) else self.start)
                found = follow(model, first, angles={self.crank: angles[order]}).q
            except ValueError as error:
                self.failed = str(error)
                return np.full(self.places.shape, np.nan)
            self.model, self.q = model, np.empty_like(found)
            self.q[order] = found
        if self.failed:
            return np.full(self.places.shape, np.nan)
        return np.array([self.model.point(self.of, one) for one in self.q])

    def residuals(self, x: FloatArray) -> FloatArray:
        return np.asarray((self.at(x) - self.places).ravel() / self.size)

    def jacobian(self, x: FloatArray) -> FloatArray:
        """By the parameters, and by the angles where these are free."""
        self.at(x)
        m, p = len(self.places), len(self.paths)
        index, none = self.model.points.index(self.of), np.zeros_like(self.q)
        shut = self.model.derivatives("closure", self.q, none, wrt=self.paths)
        moved = self.model.derivatives("points", self.q, none, wrt=self.paths)[:, index]
        found = np.zeros((m, 2, p + (m if self.given is None else 0)))
        for k, q in enumerate(self.q):
            rows = self._rows(self.model, q)
            wanted = np.zeros((len(rows), p + 1))
            wanted[:-1, :p], wanted[-1, p] = -shut[k], 1.0
            dq = np.linalg.lstsq(rows, wanted, rcond=1e-10)[0]
            by = self.model.point_jacobian(self.of, q) @ dq
            found[k, :, :p] = by[:, :p] + moved[k]
            if self.given is None:
                found[k, :, p + k] = by[:, p]
        return found.reshape(2 * m, -1) / self.size


def _next(model: Model, crank: str, q: FloatArray, before: float, angle: float) -> FloatArray:
    """The configuration on the branch of q, which is at the angle before; ``ValueError`` where there is none."""
    return np.asarray(follow(model, q, angles={crank: [before, angle]}).q[1])


def _in_turn(cost: FloatArray) -> tuple[float, FloatArray]:
    """Of costs (m, s) the least sum with a sample for each of m, none before that of the one ahead: dynamic
    programming."""
    m, s = cost.shape
    total, came = cost[0].copy(), np.zeros((m, s), dtype=int)
    total[1:] = np.inf  # the first is the first sample
    for k in range(1, m):
        least = np.minimum.accumulate(total)
        first = np.where(np.concatenate([[True], least[1:] < least[:-1]]), np.arange(s), 0)
        came[k] = np.maximum.accumulate(first)
        total = least + cost[k]
    which = [int(np.argmin(total))]
    for k in range(m - 1, 0, -1):
        which.append(int(came[k, which[-1]]))
    return float(total.min()), np.array(which[::-1])
