"""``find_orbit(model, q, u, section=0.2)``, or ``section=("ball.C", "ground_0")``: periodic motions, stable or not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..faults import Faults
from ..model.model import Model
from ..model.numbers import read_numbers
from .orbit import Orbit, orbit_at
from .repeats import check_advance, check_time
from .section import RANK, Crossed, Map, Section, read_map
from .shooting import shoot
from .tolerance import LESS, tolerance_of
from .trial import trying


def find_orbit(
    model: Model,
    q0: ArrayLike | None = None,
    u0: ArrayLike | None = None,
    *,
    section: Section,
    crossings: int = 1,
    until: float | None = None,
    relabel: tuple[ArrayLike, ArrayLike] | None = None,
    advances: Sequence[str] = (),
    params: Mapping[str, float] | None = None,
    rtol: float | None = None,
    method: str | None = None,
    most: int = 30,
    segments: int = 1,
) -> Orbit:
    """The periodic motion near the state (q0, u0), the scene's start unless given, by Newton's method on its map.

    ``section`` is a time (s), the period of what drives the model, ``crossings`` of which the motion takes; or, of a
    model that does not depend on time, a contact, (point, surface) as in ``model.contacts``: the state behind its
    impact, the ``crossings``-th one of the run, which may take as long as ``until`` (s) to get there, the scene's end
    unless given; or a coordinate and a value, (name, number) as in ``model.q_of``, which it passes as it grows, an
    angle in any turn. The search begins at the first of these crossings of a run from (q0, u0). ``relabel`` (A, b) is
    what is done to the state x = (q, u) there before it is compared, A x + b, of shapes (2 n, 2 n) and (2 n,): where a
    walker's legs change their parts. ``advances`` names coordinates that need not come back, as the place of a walker.
    ``most`` is how many steps Newton's method may take. Derivatives of the map are exact, through impacts and
    friction, so that orbits need not be stable.

    A long or very unstable motion is found in ``segments``, each with a start of its own (multiple shooting): q0 and u0
    are then one state, from which a run gives the starts, or (segments, n). Where the model depends on time, or
    ``crossings`` is more than one, segments are whole crossings, and their number is a part of that.

    With one segment it is single shooting (S. H. Strogatz, Nonlinear Dynamics and Chaos, 1994, section 8.7, has the map
    and its multipliers).
    Raises ``ValueError`` for names, shapes and numbers that are wrong, all at once; where a run does not get to the
    section; where a map has no derivative, as :func:`~.sensitivities.sensitivities` says; where Newton's method does
    not converge; and where a state comes back that does not go on as it did: a time that is no period of the forces, or
    coordinates that need not come back and on which the motion depends. A model has to be generated with its
    derivatives.
    """
    if not isinstance(model, Model):
        raise TypeError(f"model: found {type(model).__name__}, expected a Model; load one with load_model(folder)")
    chosen = model.with_parameters(dict(params)) if params else model.as_it_is()
    faults, a_map, start = Faults(), None, None
    options: dict[str, Any] = {"rtol": rtol, "method": method}
    with faults.collecting():
        a_map = read_map(chosen, section, crossings, until, relabel, advances, options)
        check_time(a_map)
    with faults.collecting():
        start = _starts(chosen, q0, u0, segments)
    if isinstance(most, bool) or not isinstance(most, int) or most < 1:
        faults.add(f"most: found {most!r}, expected a number of steps, at least 1")
    faults.stop_if_any()
    assert a_map is not None and start is not None
    if segments > 1:
        orbit = shoot(a_map, start, segments, most)
    else:
        orbit = _converged(a_map, start[0], tolerance_of(a_map), most)
    check_advance(orbit)
    return orbit


def _starts(
    model: Model, q0: ArrayLike | None, u0: ArrayLike | None, segments: int
) -> list[tuple[FloatArray, FloatArray]]:
    """One state, or one for each segment; loops are shut."""
    if isinstance(segments, bool) or not isinstance(segments, int) or segments < 1:
        raise ValueError(f"segments: found {segments!r}, expected a number, at least 1")
    own = model.start()
    q, u = (
        one if given is None else np.asarray(read_numbers(given, name), dtype=float)
        for one, given, name in zip(own, (q0, u0), ("q0", "u0"), strict=True)
    )
    if q.ndim == 1 and u.ndim == 1:
        return [model.project(q, u)]
    if q.shape != (segments, len(own[0])) or u.shape != q.shape:
        raise ValueError(
            f"q0, u0: found shapes {q.shape} and {u.shape}, expected one state, ({len(own[0])},), or one for each of "
            f"the segments, {(segments, len(own[0]))}"
        )
    return [model.project(*one) for one in zip(q, u, strict=True)]


def _step(a_map: Map, crossed: Crossed) -> FloatArray:
    """Newton's step (2 n,) of least size. Rows are differences of what directions become along the motion and these
    directions: where all of a row is rounding of them, as of motions of any speed that have one period, no step is
    known."""
    size = float(np.linalg.norm(crossed.basis / a_map.units[:, None], 2))
    left, values, right = np.linalg.svd(crossed.moves, full_matrices=False)
    known = values > RANK * max(float(values.max(initial=0.0)), size)
    found = right[known].T @ ((left[:, known].T @ -crossed.rest) / values[known])
    return np.asarray(crossed.basis @ found)


def _converged(a_map: Map, start: tuple[FloatArray, FloatArray], tolerance: float, most: int) -> Orbit:
    """Newton's method until what is missed no longer becomes less."""
    best: tuple[float, Crossed] | None = None
    guess = q, u = a_map.first(*start)
    for step in range(most):
        with trying(a_map.model, step, guess, (q, u)):
            crossed = a_map.at(q, u, about=best and best[1].time)
        missed = float(np.max(np.abs(crossed.rest)))
        if best is not None and best[0] <= tolerance and not missed < best[0] / LESS:
            break
        if best is None or missed < best[0]:
            best = missed, crossed
        if missed == 0.0:
            break
        change = _step(a_map, crossed)
        n = len(crossed.q)
        with trying(a_map.model, step + 1, guess, (crossed.q + change[:n], crossed.u + change[n:])):
            q, u = a_map.moved(crossed, change)
    assert best is not None
    missed, crossed = best
    if missed > tolerance:
        raise ValueError(
            f"{a_map.model.name}: found no periodic motion in {most} steps of Newton's method, the nearest misses "
            f"by {missed:.2g} of its size; begin nearer, or ask for more steps"
        )
    return orbit_at(a_map, crossed)
