"""What contacts push at states of a model, and what joints carry then."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import BoolArray, FloatArray
from .compiled import Compiled
from .thresholds import characteristic_time

if TYPE_CHECKING:
    from .._core import Supply

Contacts = Mapping[tuple[str, str], str] | Sequence[tuple[str, str]] | None
"""Contacts that are held, as (point, ground) names, and how; () for none; None for those that a run would hold."""

RUBS = ("slides backward", "slides forward", "sticks", "at the limit, forward", "at the limit, backward")
"""Ways to be held that need friction."""


@dataclass(frozen=True)
class Motion:
    """Of states (b, …): ``u_dot`` (b, nu), the ``multipliers`` (b, rows) and the forces ``pushes`` (b, contacts, 2) of
    contacts, along the normal and along the ground (N; of stops N m, in the first), that belong together. The joints'
    ``reactions`` (b, joints, 3) with them, and what effects have ``told`` (b, told) there, where they are asked for."""

    u_dot: FloatArray
    multipliers: FloatArray
    pushes: FloatArray
    reactions: FloatArray
    told: FloatArray


def in_flight(model: Compiled, q: FloatArray, contacts: Contacts) -> bool:
    """Whether no contact pushes in any of the configurations (b, nq).

    Raises ``ValueError`` unless ``contacts`` is None, a mapping, or a list of pairs.
    """
    if contacts is None:
        return not model.contacts or not model.kernels.closed(q).any()
    if not isinstance(contacts, Mapping) and not _pairs(contacts):
        raise ValueError(
            f"contacts: found {contacts!r}, expected a list of (point, ground), () for none, {{(point, ground): how}}, "
            "or None for those that are closed"
        )
    return not contacts


def _pairs(contacts: object) -> bool:
    """Whether it is a list of pairs of names."""
    if isinstance(contacts, str | np.ndarray) or not isinstance(contacts, Iterable):
        return False
    return all(isinstance(pair, Sequence) and not isinstance(pair, str) and len(pair) == 2 for pair in contacts)


def near_limits(model: Compiled, q: FloatArray) -> BoolArray:
    """At which of the configurations (b, nq) closure rows are so near to dependence that forces are limits (b,)."""
    return np.asarray(model.kernels.near_limits(q)) if model.rows else np.zeros(len(q), dtype=bool)


def flight_of(model: Compiled, q: FloatArray, u: FloatArray, t: float | FloatArray, what: str) -> FloatArray:
    """One field of ``Motion`` of states in which no contact pushes and none is ``near_limits``, under the inputs that
    are set."""
    forces = what in ("multipliers", "reactions")
    u_dot, multipliers = _accelerated(model, q, u, t, reactions=what == "reactions", forces=forces)
    if what == "reactions":
        return model.kernels.reactions(q, u, t, u_dot, multipliers).reshape(len(q), len(model.joints), 3)
    if what == "pushes":
        return np.zeros((len(q), len(model.contacts), 2), dtype=model.core.REAL)
    return u_dot if what == "u_dot" else multipliers


def _accelerated(
    model: Compiled,
    q: FloatArray,
    u: FloatArray,
    t: float | FloatArray,
    numbers: Sequence[int] | None = None,
    *,
    reactions: bool = False,
    forces: bool = True,
) -> tuple[FloatArray, FloatArray]:
    """Accelerations in flight, and multipliers where ``forces`` are asked for; ``numbers`` of the states in the batch.

    For ``reactions`` each state is what it is alone. They sum the accelerations of all links outboard, so that what
    lanes round otherwise would show as many times.
    """
    u_dot, multipliers, without = model.kernels.acceleration(q, u, t, side_by_side=not reactions, forces=forces)
    if without:
        wrong = min(without)
        raise no_motion(model, int(numbers[wrong]) if numbers else wrong, without[wrong])
    return u_dot, multipliers


def motion_of(
    model: Compiled, q: FloatArray, u: FloatArray, t: float | FloatArray, contacts: Contacts, *, reactions: bool = False
) -> tuple[Motion, float]:
    """The motion of states under the inputs that are set, and how exactly it is known (``Kernels.inexact``).

    Raises ``ValueError`` for unknown contacts, where a contact strikes or lies behind its surface, and where a state
    has no accelerations.
    """
    groups: Sequence[tuple[Held | None, Any]]
    if contacts is None:
        closed = model.kernels.closed(q).any(axis=1)
        groups = [((), ~closed), (None, closed)]
    else:
        groups = _held_as_named(model, q, u, contacts)
    found = Parts(model, len(q), reactions)
    for held, rows in groups:
        if rows.all():
            found.fill(slice(None), q, u, t, held)
        elif rows.any():
            found.fill(np.flatnonzero(rows), q[rows], u[rows], t[rows] if isinstance(t, np.ndarray) else t, held)
    return found.motion, found.inexact


Held = Sequence[tuple[int, str]]
"""Contacts by number, and how each is held."""


class Parts:
    """The motion of a batch, put together from groups of states."""

    def __init__(self, model: Compiled, count: int, reactions: bool) -> None:
        kind = model.core.REAL
        self.model, self.asked, self.inexact = model, reactions, 0.0
        self.unknown = np.zeros(count, dtype=bool)
        self.motion = Motion(
            np.empty((count, len(model.u_names)), dtype=kind),
            np.empty((count, len(model.rows)), dtype=kind),
            np.zeros((count, len(model.contacts), 2), dtype=kind),
            np.empty((count if reactions else 0, len(model.joints), 3), dtype=kind),
            np.full((count, len(model.told)), np.nan, dtype=kind),
        )

    def fill(self, rows: Any, q: FloatArray, u: FloatArray, t: float | FloatArray, held: Held | None) -> None:
        """The states ``rows``: in flight where nothing is held, with what a run would hold where that is None."""
        if held is None or held:
            self.fill_in_contact(rows, q, u, t, held, shared=held is None)
            return
        near = near_limits(self.model, q)
        if near.any():
            numbers = np.array(self._numbers(rows))
            for these, fill in ((near, self.fill_in_contact), (~near, self._fill_in_flight)):
                when = t[these] if isinstance(t, np.ndarray) and t.ndim else t
                if these.any():
                    fill(numbers[these], q[these], u[these], when)
        else:
            self._fill_in_flight(rows, q, u, t)

    def _fill_in_flight(self, rows: Any, q: FloatArray, u: FloatArray, t: float | FloatArray) -> None:
        """States that are not ``near_limits``."""
        kernels, motion = self.model.kernels, self.motion
        u_dot, multipliers = _accelerated(self.model, q, u, t, self._numbers(rows), reactions=self.asked)
        self.inexact = max(self.inexact, kernels.inexact)
        if self.asked:
            motion.reactions[rows] = kernels.reactions(q, u, t, u_dot, multipliers).reshape(
                len(q), len(self.model.joints), 3
            )
        motion.u_dot[rows], motion.multipliers[rows] = u_dot, multipliers

    def fill_in_contact(
        self,
        rows: Any,
        q: FloatArray,
        u: FloatArray,
        t: float | FloatArray,
        held: Held | None = (),
        supply: Supply | None = None,
        latched: FloatArray | None = None,
        *,
        shared: bool = False,
    ) -> None:
        """The same by the solver of a run, under the inputs of a ``supply`` if there is one, and with what effects hold
        there, ``latched`` (b, latches). Forces that this leaves open are ``shared`` as a run shares them, or are what
        is said."""
        kernels, motion = self.model.kernels, self.motion
        u_dot, multipliers, pushes, reactions, told, unknown, trouble = kernels.motion(
            q, u, t, held, supply, latched, shared
        )
        if trouble:
            raise _trouble(self.model, int(self._numbers(rows)[trouble[0]]), *trouble[1:])
        self.inexact = max(self.inexact, kernels.inexact)
        self.unknown[rows] = unknown
        motion.u_dot[rows], motion.multipliers[rows], motion.told[rows] = u_dot, multipliers, told
        motion.pushes[rows] = pushes.reshape(len(q), 2, len(self.model.contacts)).transpose(0, 2, 1)
        if self.asked:
            motion.reactions[rows] = reactions.reshape(len(q), len(self.model.joints), 3)

    def _numbers(self, rows: Any) -> Sequence[int]:
        return list(range(len(self.motion.u_dot))) if isinstance(rows, slice) else list(rows)


def no_motion(model: Compiled, state: int, outcome: str) -> ValueError:
    return ValueError(f"{model.name}: state {state} has no accelerations ({outcome.replace('_', ' ')})")


def _trouble(model: Compiled, state: int, outcome: str, obstacle: str, contact: int, size: float) -> ValueError:
    """Why a state has no motion with its contacts, and what to do."""
    if outcome == "jammed":
        return ValueError(
            f"{model.name}: friction jams in state {state}: the forces of its contacts have no solution, or more than "
            "one; say how contacts are held by contacts={(point, ground): how}, or leave them out with contacts=()"
        )
    if outcome == "repeats":
        return ValueError(
            f"{model.name}: the search for the forces of contacts in state {state} does not end; say how they "
            "are held by contacts={(point, ground): how}"
        )
    if not obstacle:
        return no_motion(model, state, outcome)
    point, ground = model.contacts[contact]
    unit = "rad" if ground in model.stops else "m"
    if obstacle == "strikes":
        return ValueError(
            f"{model.name}: state {state} is before an impact: {point} strikes {ground} at {size:.6g} {unit}/s; take "
            "the velocities after it from model.impact, or leave contacts out with contacts=()"
        )
    return ValueError(
        f"{model.name}: state {state} has {point} behind {ground} by {size:.6g} {unit}; move it out, or leave contacts "
        "out with contacts=()"
    )


def _held_as_named(
    model: Compiled, q: FloatArray, u: FloatArray, contacts: Mapping[tuple[str, str], str] | Sequence[tuple[str, str]]
) -> list[tuple[Held, Any]]:
    """What is held, and in which of the states (b,): as said, or as each contact moves along its ground."""
    numbers = model._contacts(contacts)
    if len(set(numbers)) != len(numbers):
        raise ValueError(f"contacts: found {list(contacts)}, expected each once")
    every = np.ones(len(q), dtype=bool)
    rough = model.kernels.friction
    if isinstance(contacts, Mapping):
        for number, how in zip(numbers, contacts.values(), strict=True):
            _check_how(model, number, how, bool(rough[number]))
        return [(list(zip(numbers, contacts.values(), strict=True)), every)]
    if not any(rough[c] for c in numbers):
        return [([(c, "smooth") for c in numbers], every)]
    slips = model.kernels.of_state("slips", q, u)[:, numbers]
    still = model.core.TOLERANCES["STILL"].value * model.length / characteristic_time(model)
    ways = np.where(np.abs(slips) <= still, 2.0, np.sign(slips))
    ways[:, [not rough[c] for c in numbers]] = 0.0
    names = {0.0: "smooth", 1.0: "slides forward", 2.0: "sticks", -1.0: "slides backward"}
    return [
        ([(c, names[way]) for c, way in zip(numbers, one.tolist(), strict=True)], (ways == one).all(axis=1))
        for one in np.unique(ways, axis=0)
    ]


def _check_how(model: Compiled, contact: int, how: str, rough: bool) -> None:
    known = ("smooth", "touches", "carried", *RUBS)
    where = "({}, {})".format(*model.contacts[contact])
    if how not in known:
        raise ValueError(f"contacts: found {how!r} for {where}, expected one of: {'; '.join(known)}")
    if how in RUBS and not rough:
        raise ValueError(f'contacts: found {how!r} for {where}, which has no friction, expected "smooth"')
