"""``find_orbit(model, q, u, section=0.2)``, or ``section=("ball.C", "ground_0")``: periodic motions, stable or not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import ComplexArray, FloatArray
from ..faults import Faults
from ..model.model import Model
from ..model.numbers import read_numbers
from ..run import Run
from .section import Crossed, Map, Section, read_map

RANK = 1e-10
"""Singular values of the map less the identity below this part of the largest are zero: directions along which there is
a whole family of orbits, of which the nearest is taken."""

LESS = 4.0
"""Newton's method squares what is missed; where that becomes less by no more than this factor it is rounding."""

CLOSED = 1e4
"""A motion comes back where it misses by less than this many tolerances of the run: it is known to a hundred of them,
which a period of an unstable orbit may make a hundred times as many."""


@dataclass(frozen=True, eq=False)
class Orbit:
    """A motion that comes back to where it began.

    ``q``, ``u`` (n,) are its state on the section and ``period`` (s) its time to come back. ``multipliers`` (k,),
    complex, largest first, are those by which small differences on the section grow in a period: the orbit is
    ``stable`` where all are less than 1 in size. ``matrix`` (k, k) has them as eigenvalues, in the coordinates of
    ``basis`` (2 n, k): directions of the state (q, u) that keep loops shut and stay on the section. ``missed`` is by
    how much it does not come back, the largest of all coordinates and rates, in units of the mechanism. ``runs`` is
    how many runs were derived, ``run`` the motion of one period.
    """

    q: FloatArray
    u: FloatArray
    period: float
    multipliers: ComplexArray
    matrix: FloatArray = field(repr=False)
    basis: FloatArray = field(repr=False)
    missed: float
    runs: int
    run: Run = field(repr=False)

    @property
    def stable(self) -> bool:
        """Whether small differences die away."""
        return bool(np.all(np.abs(self.multipliers) < 1.0))


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
) -> Orbit:
    """The periodic motion near the state (q0, u0), the scene's start unless given, by Newton's method on its map.

    ``section`` is a time (s), the period of what drives the model, ``crossings`` of which the motion takes; or a
    contact, (point, surface) as in ``model.contacts``, of a model that does not depend on time: the state behind its
    impact, the ``crossings``-th one of the run, which may take as long as ``until`` (s) to get there, the scene's end
    unless given. The search begins behind the first of these impacts of a run from (q0, u0). ``relabel`` (A, b) is what
    is done to the state x = (q, u) there before it is compared, A x + b, of shapes (2 n, 2 n) and (2 n,): where a
    walker's legs change their parts. ``advances`` names coordinates that need not come back, as the place of a walker.
    ``most`` is how many steps Newton's method may take. Derivatives of the map are exact, through impacts and
    friction, so that orbits need not be stable.

    Single shooting (S. H. Strogatz, Nonlinear Dynamics and Chaos, 1994, section 8.7, has the map and its multipliers).
    Raises ``ValueError`` for names, shapes and numbers that are wrong, all at once; where a run does not get to the
    section; where a map has no derivative, as :func:`~.sensitivities.sensitivities` says; and where Newton's method
    does not converge. A model has to be generated with its derivatives.
    """
    if not isinstance(model, Model):
        raise TypeError(f"model: found {type(model).__name__}, expected a Model; load one with load_model(folder)")
    chosen = model.with_parameters(dict(params)) if params else model.as_it_is()
    faults, a_map, start = Faults(), None, None
    options: dict[str, Any] = {"rtol": rtol, "method": method}
    with faults.collecting():
        a_map = read_map(chosen, section, crossings, until, relabel, advances, options)
    with faults.collecting():
        start = _start(chosen, q0, u0)
    if isinstance(most, bool) or not isinstance(most, int) or most < 1:
        faults.add(f"most: found {most!r}, expected a number of steps, at least 1")
    faults.stop_if_any()
    assert a_map is not None and start is not None
    return _converged(a_map, start, CLOSED * (chosen.data["run"]["rtol"] if rtol is None else rtol), most)


def _start(model: Model, q0: ArrayLike | None, u0: ArrayLike | None) -> tuple[FloatArray, FloatArray]:
    own = model.start()
    q, u = (
        one if given is None else np.asarray(read_numbers(given, name), dtype=float)
        for one, given, name in zip(own, (q0, u0), ("q0", "u0"), strict=True)
    )
    return model.project(q, u)


def _converged(a_map: Map, start: tuple[FloatArray, FloatArray], tolerance: float, most: int) -> Orbit:
    """Newton's method until what is missed no longer becomes less."""
    best: tuple[float, Crossed] | None = None
    q, u = a_map.first(*start)
    for _ in range(most):
        crossed = a_map.at(q, u)
        missed = float(np.max(np.abs(crossed.rest)))
        if best is not None and best[0] <= tolerance and not missed < best[0] / LESS:
            break
        if best is None or missed < best[0]:
            best = missed, crossed
        if missed == 0.0:
            break
        change = crossed.basis @ np.linalg.lstsq(crossed.moves, -crossed.rest, rcond=RANK)[0]
        q, u = a_map.model.project(q + change[: len(q)], u + change[len(q) :])
    assert best is not None
    missed, crossed = best
    if missed > tolerance:
        raise ValueError(
            f"{a_map.model.name}: found no periodic motion in {most} steps of Newton's method, the nearest misses "
            f"by {missed:.2g} of its size; begin nearer, or ask for more steps"
        )
    matrix = a_map.on_section(crossed)
    found = np.linalg.eigvals(matrix).astype(complex)
    found = found[np.lexsort((found.imag, -np.abs(found)))]
    state, basis, run = (crossed.q, crossed.u), crossed.basis, crossed.run
    return Orbit(*state, crossed.time, found, matrix, basis, missed, a_map.count, run)
