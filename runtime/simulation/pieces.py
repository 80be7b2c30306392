"""A run through several structures, put together from the runs of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np

from ..arrays import FloatArray
from ..model.forces import Motion
from ..model.model import Model
from ..model.whole import Whole
from ..record.hybrid_state import HybridState
from ..record.impact import Impact
from ..record.joint_change import JointChange
from ..record.phase import Phase
from ..record.unexplained import in_a_row, largest
from ..run import Run


@dataclass(frozen=True, eq=False)
class Piece:
    """A run of one ``structure``; ``anew``: it did not go on from the one before, but from a change. ``given`` is the
    energy (J) that events say the mechanism got where it begins."""

    structure: int
    run: Run
    anew: bool
    given: float = 0.0

    @property
    def begin(self) -> float:
        return float(self.run.t[0])


@dataclass(frozen=True, eq=False, repr=False)
class SwitchedRun(Run):
    """A run in which joints let go and take hold.

    Its ``model`` is the whole mechanism, in the coordinates of the structure that has none of these joints; ``last`` is
    where it has come to, in those of the structure that it is in.
    """

    last: HybridState | None = field(default=None, repr=False)

    @property
    def state(self) -> HybridState | None:
        return self.last


@dataclass(frozen=True, eq=False)
class Between:
    """States between the rows: those of the piece that the time is in."""

    whole: Whole
    pieces: tuple[Piece, ...]

    def between(self, t: float, times: FloatArray, q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        piece = self.pieces[number_at(self.pieces, times[0].item(), before=False)]
        t = min(max(t, piece.run.t[0]), piece.run.t[-1])
        return self.whole.lifted(piece.structure, *piece.run.at(t))


@dataclass(frozen=True, eq=False)
class Along:
    """Accelerations and forces along the pieces, in the coordinates, contacts and joints of the whole."""

    whole: Whole
    pieces: tuple[Piece, ...]

    @property
    def since(self) -> FloatArray:
        own = [piece.run.motion.since for piece in self.pieces if piece.run.motion is not None]
        changed = [np.array([piece.begin]) for piece in self.pieces[1:] if piece.anew]
        return np.unique(np.concatenate([*own, *changed]))

    def __call__(self, t: FloatArray, q: FloatArray, u: FloatArray) -> Motion:
        count, whole = len(t), self.whole
        found = Motion(
            np.full((count, len(whole.u_names)), np.nan),
            np.zeros((count, len(whole.rows))),
            np.zeros((count, len(whole.contacts), 2)),
            np.zeros((count, len(whole.joints), 3)),
            np.zeros((count, len(whole.told))),
        )
        which = np.array([number_at(self.pieces, one, before=False) for one in t], dtype=int)
        for number in np.unique(which).tolist():
            rows, piece = np.flatnonzero(which == number), self.pieces[number]
            assert piece.run.motion is not None
            times = np.clip(t[rows], piece.run.t[0], piece.run.t[-1])
            own_q, own_u = piece.run.at(times)
            one = piece.run.motion(times, own_q, own_u)
            found.u_dot[rows] = whole.lifted_accelerations(piece.structure, own_q, own_u, one.u_dot)
            found.multipliers[rows] = whole.meshes_of(piece.structure, one.multipliers)
            found.pushes[rows] = whole.pushes_of(piece.structure, one.pushes)
            found.reactions[rows] = whole.reactions_of(piece.structure, one.reactions)
            found.told[rows] = whole.told_of(piece.structure, one.told)
        return found


def number_at(pieces: Sequence[Piece], t: float, before: bool) -> int:
    """The piece that the time t is in; at the beginning of one, that or the one before."""
    begins = np.array([piece.begin for piece in pieces])
    return max(int(np.searchsorted(begins, t, side="left" if before else "right")) - 1, 0)


def joined(
    whole: Whole,
    pieces: Sequence[Piece],
    strikes: Sequence[tuple[int, Impact]],
    changes: Sequence[JointChange],
    missed: Sequence[tuple[int, float]],
    nfev: int,
    message: str | None,
) -> SwitchedRun:
    """The run of all pieces, in the whole's coordinates.

    ``strikes`` are the impacts by which joints took hold, each with the number of the piece that it begins.
    ``missed`` is what changes added to the energy (J) beside what they take, each with the number of the piece that it
    begins, ``nfev`` what was evaluated in all, ``message`` why the run stopped after the last piece, if it did.
    """
    pieces = tuple(pieces)
    t, q, u = [], [], []
    jumps = [sum(miss for one, miss in missed if one == number) for number in range(len(pieces))]
    unexplained = unexplained_of(pieces, jumps)
    for piece in pieces:
        first = 0 if piece.anew else 1
        if first == len(piece.run.t):  # it has not gone on yet
            continue
        own = whole.lifted(piece.structure, piece.run.q[first:], piece.run.u[first:])
        t.append(piece.run.t[first:])
        q.append(own[0])
        u.append(own[1])
    impacts = [
        (impact.t, number, 1, _lifted(whole, piece, impact))
        for number, piece in enumerate(pieces)
        for impact in piece.run.impacts
    ]
    impacts += [(impact.t, number, 0, impact) for number, impact in strikes]
    last = pieces[-1].run
    return SwitchedRun(
        model=cast("Model", whole),  # for what a record and pictures ask, and what is the same of all structures
        t=np.concatenate(t),
        q=np.concatenate(q),
        u=np.concatenate(u),
        impacts=tuple(one[3] for one in sorted(impacts, key=lambda one: one[:3])),
        phases=phases_of(pieces, strikes),
        success=last.success and message is None,
        message=last.message if message is None else message,
        nfev=nfev,
        closure_max=max(piece.run.closure_max for piece in pieces),
        energy_drift=largest(unexplained),
        advance=Between(whole, pieces),
        motion=Along(whole, pieces),
        method=last.method,
        drift=last.drift,
        rest_speed=max(piece.run.rest_speed for piece in pieces),
        choices=sum(piece.run.choices for piece in pieces),
        chosen_at=next((piece.run.chosen_at for piece in pieces if piece.run.choices), None),
        closure_rate_max=max(piece.run.closure_rate_max for piece in pieces),
        acceleration_error=max(piece.run.acceleration_error for piece in pieces),
        changes=tuple(changes),
        unexplained=unexplained,
        last=last.state if message is None else None,
    )


def unexplained_of(pieces: Sequence[Piece], jumps: Sequence[float]) -> FloatArray:
    """What of the energy (J) at the rows of all ``pieces`` nothing accounts for; ``jumps`` are what of it comes where
    each piece begins."""
    parts = in_a_row([piece.run.unexplained for piece in pieces], jumps)
    ends = np.cumsum([len(piece.run.t) for piece in pieces])[:-1]
    rows = [part if piece.anew else part[1:] for piece, part in zip(pieces, np.split(parts, ends), strict=True)]
    return np.concatenate(rows)


def _lifted(whole: Whole, piece: Piece, impact: Impact) -> Impact:
    q, _ = piece.run.at(impact.t)
    sides = (whole.lifted(piece.structure, q, side)[1] for side in (impact.u_minus, impact.u_plus))
    u_minus, u_plus = sides
    reactions = whole.reactions_of(piece.structure, impact.reactions)
    return replace(impact, u_minus=u_minus, u_plus=u_plus, reactions=reactions)


def phases_of(pieces: Sequence[Piece], strikes: Sequence[tuple[int, Impact]]) -> tuple[Phase, ...]:
    """Those of all pieces, with an impact where a joint takes hold; what goes on through a stop alike is one."""
    found: list[Phase] = []
    striking = {number for number, _ in strikes}
    for number, piece in enumerate(pieces):
        if number in striking:
            found.append(Phase("impact", piece.begin, piece.begin))
        for phase in piece.run.phases:
            before = found[-1] if found else None
            same = before and not piece.anew and replace(before, start=phase.start, end=phase.end) == phase
            if same and before and before.end == phase.start and phase.kind in ("flight", "contact"):
                found[-1] = replace(before, end=phase.end)
            else:
                found.append(phase)
    return tuple(found)


def cut_at(run: Run, t: float) -> Run:
    """A run up to an instant at which it has a row, the last of those."""
    rows = int(np.searchsorted(run.t, t, side="right"))
    phases = [phase if phase.end <= t else replace(phase, end=t) for phase in run.phases if phase.start < t]
    unexplained = run.unexplained[:rows]
    phases += [phase for phase in run.phases if phase.kind == "impact" and phase.start == t and phase not in phases]
    return replace(
        run,
        t=run.t[:rows],
        q=run.q[:rows],
        u=run.u[:rows],
        impacts=tuple(impact for impact in run.impacts if impact.t <= t),
        phases=tuple(phases),
        unexplained=unexplained,
        energy_drift=largest(unexplained),
        success=True,
        message=f"reached t = {t:g} s",
        choices=run.choices if run.chosen_at is not None and run.chosen_at <= t else 0,
        chosen_at=run.chosen_at if run.chosen_at is not None and run.chosen_at <= t else None,
        left=None,
    )
