"""How near a motion is to grazing: the least closing speed of its impacts, and the least gap it keeps (eq. 12.4)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..model.model import Model
from ..model.thresholds import characteristic_time
from ..run import Run

HALVINGS = 60
"""Halvings of the interval in which a gap is least, to rounding of its time."""


class Nearness(NamedTuple):
    """Which ``contact`` of a motion is nearest to grazing, ``size`` from it: the speed with which it closes where it
    ``strikes``, in lengths of the mechanism per characteristic time, or the least gap that it keeps, in lengths."""

    size: float
    contact: tuple[str, str]
    strikes: bool


def nearness(runs: Sequence[Run]) -> list[Nearness]:
    """All impacts, and all least gaps, of a motion."""
    return [one for run in runs for part in run.stretches for one in (*_speeds(part), *_gaps(part))]


def _speeds(run: Run) -> list[Nearness]:
    model = run.model
    assert isinstance(model, Model)
    unit = model.length / characteristic_time(model)
    found, before = [], -1.0
    for impact in run.impacts:
        if impact.t != before:  # of several at one instant the first has the speeds that all met with
            row = run.q[np.flatnonzero(run.t == impact.t)[0]]
            rates = model.gap_rates(row, impact.u_minus)
            closing = {contact: -float(rates[model._contact(contact)]) / unit for contact in impact.contacts}
            contact = max(closing, key=lambda one: closing[one])
            found.append(Nearness(closing[contact], contact, True))
        before = impact.t
    return found


def _gaps(run: Run) -> list[Nearness]:
    """Where gaps turn from closing to opening without an impact."""
    model = run.model
    assert isinstance(model, Model)
    if not model.contacts or len(run.t) < 2:
        return []
    # rates vanish between the rows of a run where it oscillates within a step: four parts of each
    rows = np.flatnonzero(np.diff(run.t) > 0.0)
    parts = np.linspace(0.0, 1.0, 5)
    found = []
    for row in rows.tolist():
        t = run.t[row] + parts * (run.t[row + 1] - run.t[row])
        q, u = run.at(t[1:-1])
        q, u = np.vstack([run.q[row], q, run.q[row + 1]]), np.vstack([run.u[row], u, run.u[row + 1]])
        rates = model.gap_rates(q, u)
        for k, c in np.argwhere((rates[:-1] < 0.0) & (rates[1:] >= 0.0)).tolist():
            gap = _least(run, c, float(t[k]), float(t[k + 1]), q[k + 1])
            if gap > 0.0:
                found.append(Nearness(gap / model.length, model.contacts[c], False))
    return found


def _least(run: Run, contact: int, low: float, high: float, end: FloatArray) -> float:
    """The gap of a contact where its rate comes to zero."""
    model = run.model
    assert isinstance(model, Model)
    for _ in range(HALVINGS):
        middle = (low + high) / 2.0
        if not low < middle < high:
            break
        q, u = run.at(middle)
        if float(model.gap_rates(q, u)[contact]) < 0.0:
            low = middle
        else:
            high, end = middle, q
    return float(model.gaps(end)[contact])
