"""Pieces of a run, between which parameters were set, effects switched, or joints let go or took hold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..record.impact import Impact
from ..record.phase import Phase
from ..record.unexplained import in_a_row
from ..run import Run
from .changes import Begin


@dataclass(frozen=True, eq=False)
class Piece:
    """A run of one model. ``given`` is the energy (J) that the mechanism is said to have got where it begins,
    ``struck`` are impacts by which joints took hold there."""

    run: Run
    given: float = 0.0
    struck: tuple[Impact, ...] = ()

    @property
    def begin(self) -> float:
        begin: float = self.run.t[0].item()
        return begin

    @property
    def impacts(self) -> tuple[Impact, ...]:
        return (*self.struck, *self.run.impacts)


def parts_of(found: Mapping[str, Any], begins: Sequence[Begin]) -> list[dict[str, Any]]:
    """What the core has ``found`` of the run from each of its ``begins`` to the next, counted from there."""
    if len(begins) == 1:
        return [dict(found)]
    ends = [*((one.row, one.impact, one.mode) for one in begins[1:]), (len(found["t"]), len(found["impact_t"]), None)]
    return [
        _part(found, begin, row, impact, mode, last=begin is begins[-1])
        for begin, (row, impact, mode) in zip(begins, ends, strict=True)
    ]


def _part(
    found: Mapping[str, Any], begin: Begin, row: int, impact: int, mode: int | None, last: bool
) -> dict[str, Any]:
    """What it has found from where it begins up to a ``row``, an ``impact`` and a ``mode``, ``last`` or not."""
    rows, impacts = slice(begin.row, row), slice(begin.impact + len(begin.struck), impact)
    first = found["first"][impacts.start : impact + 1]
    struck = slice(first[0], first[-1])
    stepping = [(one, jumps) for one, jumps in zip(found["stepping"], found["jumps"], strict=True)]
    own = [(one, jumps) for one, jumps in stepping if begin.row <= one[-2] < row]
    part = {
        **{name: found[name][rows] for name in ("t", "q", "u", "work", "latched")},
        **{name: found[name][impacts] for name in ("impact_t", "u_minus", "u_plus", "energy_loss", "share")},
        **{name: found[name][struck] for name in ("contacts", "impulses", "friction")},
        **{name: found[name][begin.mode : mode] for name in ("hold_t", "held")},
        "first": [one - struck.start for one in first],
        "after": [one - begin.row for one in found["after"][impacts]],
        "stepping": [(*times, one - begin.row, end - begin.row) for (*times, one, end), _ in own],
        "jumps": [jumps for _, jumps in own],
        "scales": begin.scales,
    }
    return {**found, **part} if last else {**found, **part, "outcome": "done", "t_end": float(found["t"][row - 1])}


def number_at(pieces: Sequence[Piece], t: float, before: bool) -> int:
    """The piece that the time t is in; at the beginning of one, that or the one before."""
    begins = np.array([piece.begin for piece in pieces])
    return max(int(np.searchsorted(begins, t, side="left" if before else "right")) - 1, 0)


def unexplained_of(pieces: Sequence[Piece], jumps: Sequence[float]) -> FloatArray:
    """What of the energy (J) at the rows of all ``pieces`` nothing accounts for; ``jumps`` are what of it comes where
    each piece begins."""
    return in_a_row([piece.run.unexplained for piece in pieces], jumps)


def phases_of(pieces: Sequence[Piece]) -> tuple[Phase, ...]:
    """Those of all pieces, with an impact where a joint takes hold."""
    found: list[Phase] = []
    for piece in pieces:
        if piece.struck:
            found.append(Phase("impact", piece.begin, piece.begin))
        found += piece.run.phases
    return tuple(found)
