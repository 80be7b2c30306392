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
from .rank import least_change

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
    closed = np.flatnonzero(model.kernels.closed(q[None])[0]).tolist()
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
    model: Model, q: FloatArray, u: FloatArray, kept: Kept, units: FloatArray, parameter: str | None = None
) -> tuple[FloatArray, FloatArray]:
    """Rows (k, 2 n) of all that a start keeps shut, by the state (q, u), and (k,) by a ``parameter``: lengths, angles
    and rates in units of the mechanism, of which ``units`` (2 n,) are those of the state."""
    n = len(q)
    at = at_one(model, moving_of(model, ["q0", "u0", *([parameter] if parameter else [])]), 0.0, q)
    per = float(units[n] / units[0])  # of a rate, to its length or angle
    lengths, gaps = np.full(len(model.rows), model.length), gap_units(model)
    parts, sizes = list[FloatArray](), list[FloatArray]()
    if model.rows:
        parts += [at.closure_moves(), at.closure_rates_move(u)]
        sizes += [lengths, per * lengths]
    driven, more = drive_rows(model), int(parameter is not None)
    if len(driven):
        drives, none = model.data["drives"], np.zeros_like(driven)
        size = np.max(np.abs(driven) * units[:n], axis=1)
        places = [drive["position"] is not None for drive in drives]
        speeds = np.array([[-float(drive["speed"] == parameter)] * more for drive in drives])
        parts.append(np.hstack([driven, none, np.zeros((len(driven), more))])[places])
        parts.append(np.hstack([none, driven, speeds.reshape(len(driven), more)]))
        sizes += [size[places], per * size]
    if kept.gaps:
        parts.append(at.gaps_move()[list(kept.gaps)])
        sizes.append(gaps[list(kept.gaps)])
    if kept.held:
        parts.append(at.gap_rates_move(u)[list(kept.held)])
        sizes.append(per * gaps[list(kept.held)])
    if kept.sticks:
        parts.append(at.slips_move(u)[list(kept.sticks)])
        sizes.append(per * gaps[list(kept.sticks)])
    rows = np.vstack(parts) if parts else np.zeros((0, 2 * n + more))
    rows /= np.concatenate([*sizes, np.zeros(0)])[:, None]
    return rows[:, : 2 * n] * units, rows[:, -1] if more else np.zeros(len(rows))


def gap_units(model: Model) -> FloatArray:
    """What gaps (contacts,) are measured by: the mechanism's length (m), of stops of joints that turn 1 rad."""
    return np.array([1.0 if ground in model.stops else model.length for _, ground in model.contacts])


def settled(model: Model, q: FloatArray, u: FloatArray, kept: Kept, units: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A state near (q, u) with loops shut and contacts as they are ``kept``, by Newton's method; ``units`` (2 n,) are
    those of the state."""
    n = len(q)
    q, u = model.project(q, u)
    if not kept.gaps:
        return q, u
    sizes, per = gap_units(model), float(units[n] / units[0])
    gaps, held, sticks = map(list, kept)
    for _ in range(ROUNDS):
        missed = [model.gaps(q)[gaps] / sizes[gaps], model.gap_rates(q, u)[held] / (per * sizes[held])]
        if sticks:
            missed.append((rate_rows(model, "slips", q) @ u)[sticks] / (per * sizes[sticks]))
        wrong = np.concatenate(missed)
        if float(np.max(np.abs(wrong), initial=0.0)) <= SHUT:
            break
        rows, _ = rows_of(model, q, u, kept, units)
        change = units * least_change(rows, np.concatenate([np.zeros(len(rows) - len(wrong)), -wrong]))
        q, u = model.project(q + change[:n], u + change[n:])
    return q, u
