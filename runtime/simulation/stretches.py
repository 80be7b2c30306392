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
from ..record.event import ENDED
from ..record.hybrid_state import HybridState
from ..record.in_force import InForce
from ..record.unexplained import largest
from ..run import Run
from .changes import Answered, told_of
from .dead_point import Way
from .one_run import Recorded, run_of_record
from .pieces import Piece, number_at, parts_of, phases_of, unexplained_of
from .unset import why_not


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
            row += len(piece.run.t)
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


def strung(record: Recorded, answers: Sequence[Answered], changed: frozenset[str]) -> Run:
    """The run of what its core has found, with its events and changes of joints; functions have given these
    ``answers``, and on the way to its start the parameters ``changed`` were set.

    Its ``model`` has the parameters of the beginning. Each piece is a run of one model.
    """
    model, found = record.model, record.found
    told = told_of(model, found, answers)
    parts, unset = parts_of(found, told.begins), why_not(model, found, told, answers)
    if unset:
        parts[-1]["outcome"] = "done"
    pieces, way = list[Piece](), Way(float(found["t"][0]), {})
    for begin, part in zip(told.begins, parts, strict=True):
        run = run_of_record(record, begin.model, part, way)
        pieces.append(Piece(run, begin.given, begin.struck))
        way = way.on(begin.model, part["q"][0], part["q"][-1])
    last, set_in_all = pieces[-1].run, changed | told.set
    message = unset or last.message
    if told.ends and not unset:
        message = f"{ENDED}{last.t[-1]:.12g} s by {' and '.join(told.ends)}"
    success = last.success and not unset
    if len(pieces) == 1 and not set_in_all:
        return replace(last, message=message, success=success, events=tuple(told.events))
    unexplained = unexplained_of(pieces, _jumps(pieces))
    return StretchedRun(
        model=model,
        t=np.concatenate([piece.run.t for piece in pieces]),
        q=np.concatenate([piece.run.q for piece in pieces]),
        u=np.concatenate([piece.run.u for piece in pieces]),
        impacts=tuple(impact for piece in pieces for impact in piece.impacts),
        phases=phases_of(pieces),
        success=success,
        message=message,
        nfev=last.nfev,
        closure_max=max(piece.run.closure_max for piece in pieces),
        energy_drift=largest(unexplained),
        advance=Between(tuple(pieces)),
        motion=Along(tuple(pieces)),
        method=last.method,
        drift=last.drift,
        rest_speed=last.rest_speed,
        choices=last.choices,
        chosen_at=last.chosen_at,
        closure_rate_max=max(piece.run.closure_rate_max for piece in pieces),
        acceleration_error=max(piece.run.acceleration_error for piece in pieces),
        changes=tuple(told.joints),
        events=tuple(told.events),
        unexplained=unexplained,
        traced=last.traced,
        last=replace(last.state, changed=set_in_all) if last.state is not None else None,
    )


def _jumps(pieces: Sequence[Piece]) -> list[float]:
    """By how much (J) the energy changes where each piece begins, beside what events say that it does."""
    return [0.0] + [_energy(piece.run, 0) - _energy(before.run, -1) - piece.given for before, piece in pairwise(pieces)]


def _energy(run: Run, row: int) -> float:
    model = run.in_force.models[run.in_force.at_rows(len(run.t))[row]]
    return float(sum(model.energy(run.q[row], run.u[row])))
