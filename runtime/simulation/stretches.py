"""A run put together from stretches, between which parameters were set, or joints let go or took hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..model.forces import Motion
from ..record.event import Event
from ..record.hybrid_state import HybridState
from ..record.in_force import InForce
from ..record.joint_change import JointChange
from ..record.unexplained import largest
from ..run import Run
from .pieces import Piece, number_at, phases_of, unexplained_of


@dataclass(frozen=True, eq=False, repr=False)
class StretchedRun(Run):
    """A run in which parameters were set; ``last`` is where it has come to."""

    last: HybridState | None = field(default=None, repr=False)

    @property
    def state(self) -> HybridState | None:
        return self.last

    @property
    def stretches(self) -> tuple[Run, ...]:
        """The runs of the pieces."""
        assert isinstance(self.advance, Between)
        return tuple(piece.run for piece in self.advance.pieces)

    @cached_property
    def in_force(self) -> InForce:
        """That of the stretches, each of which is a run of its own model."""
        assert isinstance(self.advance, Between)
        spans, row, impact = [], 0, 0
        for piece in self.advance.pieces:
            spans.append((piece.run.model, piece.begin, row, impact))
            row += len(piece.run.t) - (not piece.anew)
            impact += len(piece.impacts)
        return InForce.of_spans(spans)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "in_force"}  # it follows from the rest


@dataclass(frozen=True, eq=False)
class Between:
    """States between the rows: those of the stretch that the time is in."""

    pieces: tuple[Piece, ...]

    def between(self, t: float, times: FloatArray, q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        run = self.pieces[number_at(self.pieces, times[0].item(), before=False)].run
        return run.at(min(max(t, run.t[0]), run.t[-1]))


@dataclass(frozen=True, eq=False)
class Along:
    """Accelerations and forces along the stretches."""

    pieces: tuple[Piece, ...]

    @property
    def since(self) -> FloatArray:
        own = [piece.run.motion.since for piece in self.pieces if piece.run.motion is not None]
        return np.unique(np.concatenate([*own, np.array([piece.begin for piece in self.pieces[1:]])]))

    def __call__(self, t: FloatArray, q: FloatArray, u: FloatArray) -> Motion:
        which = np.array([number_at(self.pieces, one, before=False) for one in t], dtype=int)
        found: Motion | None = None
        for number in np.unique(which).tolist():
            rows, run = np.flatnonzero(which == number), self.pieces[number].run
            assert run.motion is not None
            times = np.clip(t[rows], run.t[0], run.t[-1])
            one = run.motion(times, *run.at(times))
            if found is None:
                found = Motion(*(np.zeros((len(t), *part.shape[1:]), dtype=part.dtype) for part in _parts(one)))
            for whole, part in zip(_parts(found), _parts(one), strict=True):
                whole[rows] = part
        if found is None:
            assert self.pieces[0].run.motion is not None
            return self.pieces[0].run.motion(t, q, u)
        return found


def _parts(motion: Motion) -> tuple[FloatArray, ...]:
    return motion.u_dot, motion.multipliers, motion.pushes, motion.reactions, motion.told


def strung(
    pieces: Sequence[Piece],
    events: Sequence[Event],
    changes: Sequence[JointChange],
    nfev: int,
    message: str | None,
    changed: frozenset[str],
) -> Run:
    """The run of all ``pieces``, with its ``events``, and ``changes`` of joints; ``nfev`` is what was evaluated in all,
    ``message`` says where an event ended it, ``changed`` are the parameters that were set, also before the run.

    Its ``model`` has the parameters of the beginning.
    """
    pieces, events = tuple(pieces), tuple(events)
    last = pieces[-1].run
    unexplained = unexplained_of(pieces, _jumps(pieces))
    message = last.message if message is None else message
    if len(pieces) == 1 and not changed:
        return replace(last, nfev=nfev, message=message, events=events)
    firsts = [0 if piece.anew else 1 for piece in pieces]
    return StretchedRun(
        model=pieces[0].run.model,
        t=np.concatenate([piece.run.t[first:] for piece, first in zip(pieces, firsts, strict=True)]),
        q=np.concatenate([piece.run.q[first:] for piece, first in zip(pieces, firsts, strict=True)]),
        u=np.concatenate([piece.run.u[first:] for piece, first in zip(pieces, firsts, strict=True)]),
        impacts=tuple(impact for piece in pieces for impact in piece.impacts),
        phases=phases_of(pieces),
        success=last.success,
        message=message,
        nfev=nfev,
        closure_max=max(piece.run.closure_max for piece in pieces),
        energy_drift=largest(unexplained),
        advance=Between(pieces),
        motion=Along(pieces),
        method=last.method,
        drift=last.drift,
        rest_speed=max(piece.run.rest_speed for piece in pieces),
        choices=sum(piece.run.choices for piece in pieces),
        chosen_at=next((piece.run.chosen_at for piece in pieces if piece.run.choices), None),
        closure_rate_max=max(piece.run.closure_rate_max for piece in pieces),
        acceleration_error=max(piece.run.acceleration_error for piece in pieces),
        changes=tuple(changes),
        events=events,
        unexplained=unexplained,
        last=replace(last.state, changed=changed) if last.state is not None else None,
    )


def _jumps(pieces: Sequence[Piece]) -> list[float]:
    """By how much (J) the energy changes where each piece begins, beside what events say that it does."""
    found = [0.0]
    for before, piece in pairwise(pieces):
        change = _energy(piece.run, 0) - _energy(before.run, -1) if piece.anew else 0.0
        found.append(change - piece.given)
    return found


def _energy(run: Run, row: int) -> float:
    model = run.in_force.models[run.in_force.at_rows(len(run.t))[row]]
    return float(sum(model.energy(run.q[row], run.u[row])))
