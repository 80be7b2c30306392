"""Pieces of a run, between which parameters were set, effects switched, or joints let go or took hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray
from ..record.impact import Impact
from ..record.phase import Phase
from ..record.unexplained import in_a_row
from ..run import Run


@dataclass(frozen=True, eq=False)
class Piece:
    """A run of one model; ``anew``: it did not go on from the one before, but from a change. ``given`` is the energy
    (J) that the mechanism is said to have got where it begins, ``struck`` are impacts by which joints took hold there.
    """

    run: Run
    anew: bool
    given: float = 0.0
    struck: tuple[Impact, ...] = ()

    @property
    def begin(self) -> float:
        return float(self.run.t[0])

    @property
    def impacts(self) -> tuple[Impact, ...]:
        return (*self.struck, *self.run.impacts)


def number_at(pieces: Sequence[Piece], t: float, before: bool) -> int:
    """The piece that the time t is in; at the beginning of one, that or the one before."""
    begins = np.array([piece.begin for piece in pieces])
    return max(int(np.searchsorted(begins, t, side="left" if before else "right")) - 1, 0)


def unexplained_of(pieces: Sequence[Piece], jumps: Sequence[float]) -> FloatArray:
    """What of the energy (J) at the rows of all ``pieces`` nothing accounts for; ``jumps`` are what of it comes where
    each piece begins."""
    parts = in_a_row([piece.run.unexplained for piece in pieces], jumps)
    ends = np.cumsum([len(piece.run.t) for piece in pieces])[:-1]
    rows = [part if piece.anew else part[1:] for piece, part in zip(pieces, np.split(parts, ends), strict=True)]
    return np.concatenate(rows)


def phases_of(pieces: Sequence[Piece]) -> tuple[Phase, ...]:
    """Those of all pieces, with an impact where a joint takes hold; what goes on through a stop alike is one."""
    found: list[Phase] = []
    for piece in pieces:
        if piece.struck:
            found.append(Phase("impact", piece.begin, piece.begin))
        for phase in piece.run.phases:
            before = found[-1] if found else None
            same = before and not piece.anew and replace(before, start=phase.start, end=phase.end) == phase
            if same and before and before.end == phase.start and phase.kind in ("flight", "contact"):
                found[-1] = replace(before, end=phase.end)
            else:
                found.append(phase)
    return tuple(found)
