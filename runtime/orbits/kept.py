"""What the start of a periodic motion keeps shut: loops, driven joints, and contacts that are closed there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..model.drives import drive_rows, rate_rows
from ..model.model import Model
from ..run import Run
from ..sensitivity.held import pushing
from ..sensitivity.local import at_one
from ..sensitivity.moving import moving_of
from ..simulate import simulate

RANK = 1e-10
"""Rows of loops and contacts below this part of the largest depend on others."""

AWHILE = 1e-9
"""A run of this part of the scene's time tells which contacts are held from its start on."""

ROUNDS = 8
"""Corrections that put a state back onto contacts: each squares what is left."""

SHUT = 1e-14
"""What gaps and rates are shut to, in units of the mechanism."""


class Kept(NamedTuple):
    """Contacts, by number, whose ``gaps`` stay zero, those whose rates do too, which are ``held``, and those that
    stick."""

    gaps: tuple[int, ...]
    held: tuple[int, ...]
    sticks: tuple[int, ...]


def kept_at(model: Model, q: FloatArray, u: FloatArray, section: tuple[int, bool]) -> Kept:
    """What a run from (q, u) (n,) keeps shut: contacts that it holds, the number of that on the ``section``, -1 for
    none, and with it all that are closed."""
    struck, others = section
    closed = np.flatnonzero(model.kernels.closed(q[None])[0]).tolist() if model.contacts else []
    held, sticks = list[int](), list[int]()
    if closed:
        run = simulate(model, q, u, until=AWHILE * model.duration)
        assert isinstance(run, Run)
        if run.motion is not None and len(run.motion.since) and run.motion.since[0] <= run.t[0]:
            ways = pushing(run.motion.ways[run.motion.which[0]])  # type: ignore[attr-defined]
            held, sticks = [c for c, _ in ways], [c for c, how in ways if how == "sticks"]
    gaps = dict.fromkeys([*held, *(closed if others else []), *([struck] if struck >= 0 else [])])
    return Kept(tuple(gaps), tuple(held), tuple(sticks))


def rows_of(
    model: Model, q: FloatArray, u: FloatArray, kept: Kept, parameter: str | None = None
) -> tuple[FloatArray, FloatArray]:
    """Rows (k, 2 n) of all that a start keeps shut, by the state (q, u), and (k,) by a ``parameter``."""
    n = len(q)
    at = at_one(model, moving_of(model, ["q0", "u0", *([parameter] if parameter else [])]), 0.0, q)
    parts = list[FloatArray]()
    if model.rows:
        parts += [at.closure_moves(), at.closure_rates_move(u)]
    driven, more = drive_rows(model), int(parameter is not None)
    if len(driven):
        places = [drive["position"] is not None for drive in model.data["drives"]]
        speeds = np.array([[-float(drive["speed"] == parameter)] * more for drive in model.data["drives"]])
        none = np.zeros_like(driven)
        parts.append(np.hstack([driven, none, np.zeros((len(driven), more))])[places])
        parts.append(np.hstack([none, driven, speeds.reshape(len(driven), more)]))
    if kept.gaps:
        parts.append(at.gaps_move()[list(kept.gaps)])
    if kept.held:
        parts.append(at.gap_rates_move(u)[list(kept.held)])
    if kept.sticks:
        parts.append(at.slips_move(u)[list(kept.sticks)])
    rows = np.vstack(parts) if parts else np.zeros((0, 2 * n + more))
    return rows[:, : 2 * n], rows[:, -1] if more else np.zeros(len(rows))


def settled(model: Model, q: FloatArray, u: FloatArray, kept: Kept, units: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A state near (q, u) with loops shut and contacts as they are ``kept``, by Newton's method; ``units`` (2 n,) are
    those of the state."""
    n = len(q)
    q, u = model.project(q, u)
    if not kept.gaps:
        return q, u
    length, speed = model.length, float(np.max(units[n:]))
    for _ in range(ROUNDS):
        missed = [model.gaps(q)[list(kept.gaps)], model.gap_rates(q, u)[list(kept.held)]]
        missed.append((rate_rows(model, "slips", q) @ u)[list(kept.sticks)] if kept.sticks else np.zeros(0))
        if (
            max(
                float(np.max(np.abs(part), initial=0.0)) / one
                for part, one in zip(missed, (length, speed, speed), strict=True)
            )
            <= SHUT
        ):
            break
        rows, _ = rows_of(model, q, u, kept)
        count = sum(map(len, missed))
        wanted = np.concatenate([np.zeros(len(rows) - count), *(-part for part in missed)])
        change = units * np.linalg.lstsq(rows * units, wanted, rcond=RANK)[0]
        q, u = model.project(q + change[:n], u + change[n:])
    return q, u
