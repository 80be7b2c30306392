"""Impacts and phases of a run as tables for other programs."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..files import read_path, write_whole
from .impact import Impact
from .record import Record

IMPACTS = (
    "number",
    "t [s]",
    "point",
    "ground",
    "speed before [m/s; rad/s]",
    "impulse [N s; N m s]",
    "friction [N s]",
    "restitution share",
    "energy lost [J]",
    "energy after [J]",
)
"""What a line of the table of impacts says, which is of one contact; units behind the semicolon are those of stops of
angles, and energies are of the whole impact."""
PHASES = ("number", "kind", "start [s]", "end [s]", "point", "ground", "how", "step [s]", "missed [rad, lengths]")
"""What a line of the table of phases says, which is of one contact that stays closed, or of none."""


def write_impacts(run: Record, path: str | os.PathLike[str]) -> Path:
    """Write the impacts of a run as CSV: a heading with units, and a line for each contact that struck, in order.

    ``number`` counts impacts from 1 on, as ``ccgen run`` does; columns are those of :data:`IMPACTS`.
    """
    return _write(path, IMPACTS, _impacts(run))


def write_phases(run: Record, path: str | os.PathLike[str]) -> Path:
    """Write the phases of a run as CSV: a heading with units, and a line for each contact that stays closed in one, one
    line for a phase without; columns are those of :data:`PHASES`, as :class:`~.phase.Phase` has them. What steps of a
    fixed length miss is not known, and left empty."""
    return _write(path, PHASES, _phases(run))


def closing_rates(run: Record, number: int) -> list[float]:
    """How fast the gaps of the contacts of impact ``number``, from 0, changed before it (m/s; of stops of angles
    rad/s); of a joint that takes hold how fast its points came (m/s).

    Of a run that was put together from pieces, the piece that the impact is in knows its own contacts."""
    impact = run.impacts[number]
    for piece in getattr(run.advance, "pieces", ()):
        for k, own in enumerate(piece.run.impacts):
            if _same(own, impact):
                return closing_rates(piece.run, k)
    model: Any = run.in_force.at_impact(number)
    q = run.q[np.searchsorted(run.t, impact.t)]
    if impact.contacts[0] not in model.contacts:
        rows = [k for k, row in enumerate(model.rows) if row.rpartition(".")[0] == impact.contacts[0][0]]
        return [float(np.linalg.norm(model.jacobian(q)[rows] @ impact.u_minus))]
    rates = model.gap_rates(q, impact.u_minus)
    return [float(rates[model.contacts.index(contact)]) for contact in impact.contacts]


def _same(one: Impact, other: Impact) -> bool:
    """Whether two records are of the same impact, in whatever coordinates."""
    return one.t == other.t and one.contacts == other.contacts and np.array_equal(one.impulses, other.impulses)


def _impacts(run: Record) -> Iterator[list[object]]:
    in_force = run.in_force
    for number, impact in enumerate(run.impacts):
        model: Any = in_force.at_impact(number)
        q = run.q[np.searchsorted(run.t, impact.t)]
        after = float(sum(model.energy(q, impact.u_plus)))
        rates = closing_rates(run, number)
        friction = impact.friction if len(impact.friction) else np.zeros(len(impact.contacts))
        for (point, ground), rate, impulse, rubbing in zip(
            impact.contacts, rates, impact.impulses.tolist(), friction.tolist(), strict=True
        ):
            numbers = (rate, impulse, rubbing, impact.restitution_share, impact.energy_loss, after)
            yield [number + 1, repr(float(impact.t)), point, ground, *(repr(float(one)) for one in numbers)]


def _phases(run: Record) -> Iterator[list[object]]:
    compared = run.method != "moreau"  # steps of a fixed length are not compared with their halves
    for number, phase in enumerate(run.phases, 1):
        missed = repr(float(phase.missed)) if compared else ""
        span = [number, phase.kind, repr(float(phase.start)), repr(float(phase.end))]
        held = [(*contact, how) for contact, how in zip(phase.contacts, phase.how, strict=True)] or [("", "", "")]
        steps = [repr(float(phase.step)), missed] if phase.kind == "steps" else ["", ""]
        for one in held:
            yield [*span, *one, *steps]


def _write(path: str | os.PathLike[str], heading: Sequence[str], lines: Iterable[Sequence[object]]) -> Path:
    target = read_path(path, "a file")
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(heading)
    table.writerows(lines)
    write_whole(target, lambda part: part.write(text.getvalue().encode()))
    return target
