"""``find_orbit(model, q, u, section=0.2)``, or ``section=("ball.C", "ground_0")``: periodic motions, stable or not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..faults import Faults
from ..model.model import Model, with_params
from ..model.numbers import read_numbers
from .newton import newton
from .orbit import Orbit, orbit_of
from .repeats import check_advance, check_time
from .section import Section, read_map
from .shooting import parted
from .tolerance import tolerance_of
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
    friction, and events of the scene that set and switch, so that orbits need not be stable; at the end parameters and
    effects have to be as they were where the motion begins.

    A long or very unstable motion is found in ``segments``, each with a start of its own (multiple shooting): q0 and u0
    are then one state, from which a run gives the starts, or (segments, n). Where the model depends on time, or
    ``crossings`` is more than one, segments are whole crossings, and their number has to divide that of crossings.

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
    chosen = with_params(model, params)
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
    chain, nodes = parted(a_map, start, segments)
    guess, tolerance = nodes[0], tolerance_of(a_map)
    best, _ = newton(chain, nodes, tolerance, most, lambda step, state, _: trying(a_map.model, step, guess, state))
    assert best is not None
    if best.missed > tolerance:
        several, more = (f" in {segments} segments", "segments or steps") if segments > 1 else ("", "steps")
        raise ValueError(
            f"{a_map.model.name}: found no periodic motion in {most} step{'s' if most > 1 else ''} of Newton's method"
            f"{several}, the nearest misses by {best.missed:.2g} of its size; begin nearer, or ask for more {more}"
        )
    orbit = orbit_of(chain, best.crossed, best.missed)
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
