"""What the plastic impact by which a joint takes hold makes of small differences (docs/theory.md, eq. 11.14)."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..model.assembly import project
from ..model.directions import directions_of
from ..model.model import Model
from .local import Local, at_one
from .moving import Moving

BY = ("q", "k")

PASSES = 20
"""Of the projection by which points are drawn together, as the core has them at most."""

SHUT = 1e-13
"""Points are together after a pass that moves coordinates by less than this, in units of the mechanism: those of
Newton's method square what is left, and what passes do to differences is off by no more than what they move."""


class Drawn(NamedTuple):
    """A state q, u (n,) and what it moves by, (2 n, D)."""

    q: FloatArray
    u: FloatArray
    moves: FloatArray


def take_hold(model: Model, moving: Moving, t: float, state: Drawn, arguments: FloatArray) -> Drawn:
    """The state behind the impact by which a joint takes hold, which holds in the ``model`` already, from that before.
    The ``arguments`` move by (arguments, D).

    Raises ``ValueError`` where it cannot hold there.
    """
    moving = replace(moving, directions=directions_of(model, ("q", "u", *moving.arguments)))
    n = len(state.q)
    after, outcome = model.kernels.take_hold(np.ascontiguousarray(state.q), np.ascontiguousarray(state.u))
    if outcome != "done":
        raise ValueError(f"{model.name}: found no impact by which a joint takes hold at t = {t:.9g} s")
    whole = np.vstack([state.moves, arguments])
    whole[n : 2 * n] = _struck(at_one(model, moving, t, state.q), state.u, after, whole)
    q, u = project(model, state.q, after)
    _draw_together(model, moving, t, state.q, whole)
    whole[n : 2 * n] = _struck(at_one(model, moving, t, q), after, u, whole)
    return Drawn(q, u, whole[: 2 * n])


def _struck(at: Local, before: FloatArray, after: FloatArray, whole: FloatArray) -> FloatArray:
    """What rates ``after`` (n,) move by, (n, D), which impulses of the loops alone have made of those ``before``, where
    all there moves by ``whole`` (D, D)."""
    n, rows = len(before), len(at.model.rows)
    jump = np.ascontiguousarray(after - before)
    Lambda = _impulses(at, at.closure_rows @ jump)
    f = at.tangent("jump", n + rows, jump, BY, multipliers=Lambda)[:n] @ whole
    moves = whole[n : 2 * n]
    return np.asarray(moves + at.response(f, -at.closure_rates_move(after, BY) @ whole - at.closure_rows @ moves))


def _draw_together(model: Model, moving: Moving, t: float, q: FloatArray, whole: FloatArray) -> None:
    """Take the rows of the coordinates in ``whole`` (D, D) through the passes of the projection that begins at q (n,):
    each is a jump of the coordinates that closes the loops as they are linear there."""
    n, rows = len(q), len(model.rows)
    for _ in range(PASSES):
        at = at_one(model, moving, t, q)
        missing = np.asarray(model.closure(q))
        jump = np.ascontiguousarray(at.response(np.zeros((n, 1)), -missing[:, None])[:, 0])
        f = at.tangent("jump", n + rows, jump, BY, multipliers=_impulses(at, -missing))[:n] @ whole
        y = -(at.closure_moves() + at.closure_rates_move(jump, BY)) @ whole
        whole[:n] += at.response(f, y)
        q = q + jump
        if np.max(np.abs(jump) / model.coordinate_units) <= SHUT:
            return


def _impulses(at: Local, rates: FloatArray) -> FloatArray:
    """Impulses (rows,) of the loops that give their rows these ``rates`` (rows,)."""
    n = len(at.q)
    return np.asarray(at.places.responses[at.number, n:, n:] @ rates)
