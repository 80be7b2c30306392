"""What puts differences behind steps back onto the loops and the contacts that are held, as the run is (docs/theory.md,
section 11.5)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .._core import sure_inverses
from ..arrays import FloatArray, IntArray
from ..model.drives import drive_rows
from ..model.forces import Held
from ..model.model import Model
from .held import SURE, pushing, well
from .local import Places
from .moving import Moving


class Shutting(NamedTuple):
    """Of places and then of rates, the first entry of the state, pull (k, n, rows), and moves (k, rows, D): differences
    of the part of the state are less by the pull times what rows move by. ``rows`` (k, rows, n) and ``rates``
    (k, rows, D) are those of rates, which depend on each other, or nearly, behind the ``unsure`` steps."""

    at: Places
    back: tuple[tuple[int, FloatArray, FloatArray], ...]
    rows: FloatArray
    rates: FloatArray
    unsure: IntArray

    def some(self, which: Any) -> Shutting:
        """Of some of the steps, to put them back."""
        return self._replace(back=tuple((first, pull[which], moves[which]) for first, pull, moves in self.back))

    def behind(self, matrices: FloatArray) -> FloatArray:
        """Matrices (k, 2 n, D) of steps, with their ends put back; they are overwritten."""
        states = matrices.shape[1]
        for first, pull, moves in self.back:
            missed = moves[:, :, :states] @ matrices
            missed[:, :, states:] += moves[:, :, states:]
            matrices[:, first : first + states // 2] -= pull @ missed
        return matrices


def shutting_of(model: Model, moving: Moving, held: Held, t: FloatArray, q: FloatArray, u: FloatArray) -> Shutting:
    """At the ends of steps, times t (k,) and states (k, n)."""
    at, n = Places(model, moving, t, q), q.shape[1]
    (R, places), (Rs, rates) = _rows(at, held, u)
    free, drives = np.diag(model.coordinate_units), drive_rows(model)
    if len(drives):  # driven joints stay where they are
        free = free @ (np.eye(n) - np.linalg.pinv(drives) @ drives)
    pull = free @ _inverted(R @ free)
    back = (0, pull, places), (n, pull if Rs is R else free @ _inverted(Rs @ free), rates)
    return Shutting(at, back, Rs, rates, np.flatnonzero(~well(Rs @ Rs.transpose(0, 2, 1))))


def _rows(at: Places, held: Held, u: FloatArray) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
    """Rows that a motion keeps, of those that are on, and by what they change, (b, rows, n) and (b, rows, D): of
    places, and of rates at u."""
    chosen = [contact for contact, _ in pushing(held)]
    sticks = [contact for contact, how in pushing(held) if how == "sticks"]
    R, places, rates = at.closure_rows, at.closure_moves(), at.closure_rates_move(u)
    on = at.model.kernels.rows_on
    if len(on) < R.shape[1]:  # the others vanish, as rows do that depend on others
        R, places, rates = R[:, on], places[:, on], rates[:, on]
    if chosen:
        R = np.concatenate([R, at.gap_rows[:, chosen]], axis=1)
        places = np.concatenate([places, at.gaps_move()[:, chosen]], axis=1)
        rates = np.concatenate([rates, at.gap_rates_move(u)[:, chosen]], axis=1)
    Rs = R
    if sticks:
        Rs = np.concatenate([R, at.slip_rows[:, sticks]], axis=1)
        rates = np.concatenate([rates, at.slips_move(u)[:, sticks]], axis=1)
    return (R, places), (Rs, rates)


def _inverted(rows: FloatArray) -> FloatArray:
    """The pseudo-inverse (b, n, k) of rows (b, k, n)."""
    across = rows.transpose(0, 2, 1)
    gram = rows @ across
    inverses, sure = sure_inverses(gram, SURE)
    found = across @ inverses
    if not sure.all():
        found[~sure] = np.linalg.pinv(rows[~sure], rcond=1e-10)
    return found
