"""What contacts push and joints carry along a run, and the impulses of joints in its impacts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..model.compiled import Compiled
from ..model.forces import Held, Motion, Parts
from .advance import Advance

NEVER = np.zeros((0, 2))
"""No time by time stepping."""


@dataclass(frozen=True, eq=False)
class Along:
    """The motion along a run: in which of the ``ways`` contacts were held from each of the times ``since`` on.

    From when to when it went on by time stepping, ``stepped`` (k, 2) tells: forces are not numbers there, nor where
    links lie so nearly in a line, without going through it, that rounding leaves no acceleration known, at less than
    6e-6 from it (docs/theory.md, section 8). Where they go through, they are limits (docs/events.md, Forces).
    ``advance`` has the model and its inputs. Can be pickled with the run.
    """

    advance: Advance
    since: FloatArray
    which: Sequence[int]
    ways: Sequence[Held]
    stepped: FloatArray

    def __call__(self, t: FloatArray, q: FloatArray, u: FloatArray) -> Motion:
        """The motion at the times t (b,) and states of the run; where it changes, what it is from then on.

        Raises ``ValueError`` where there is none, and where a controller was lost by pickling.
        """
        model, supply = self.advance.model, self.advance.supply
        if isinstance(self.advance.inputs, str):
            raise ValueError("no forces: the run was pickled without its controller; ask for them before it is pickled")
        change = np.searchsorted(self.since, t, side="right") - 1
        which = np.append(np.array(self.which, dtype=int), -1)[change]  # the last is of what is before all changes
        found = Parts(model, len(t), reactions=True)
        for one in np.unique(which).tolist():
            rows = np.flatnonzero(which == one)
            held = self.ways[one] if one >= 0 else ()
            latched = self.advance.latched.at(t[rows])
            found.fill_in_contact(rows, q[rows], u[rows], t[rows], held, supply, latched, shared=True)
        unknown = found.unknown | ((t[:, None] >= self.stepped[:, 0]) & (t[:, None] < self.stepped[:, 1])).any(axis=1)
        for part in vars(found.motion).values():
            part[unknown] = np.nan
        return found.motion

    def __copy__(self) -> Along:
        return self

    def __deepcopy__(self, memo: object) -> Along:
        return self


def along(advance: Advance, found: Mapping[str, Any]) -> Along:
    """The motion along the run that the core recorded."""
    if not found["held"] and not found["stepping"]:
        return Along(advance, found["hold_t"], (), (), NEVER)
    numbers: dict[tuple[tuple[int, str], ...], int] = {}
    which = [numbers.setdefault(tuple(held), len(numbers)) for held in found["held"]]
    end = len(found["t"]) - 1  # after the last row of a run that ends so nothing is known either
    stretches = [(t0, np.inf if last == end else t1) for t0, t1, *_, last in found["stepping"]]
    stepped = np.array(stretches, dtype=float).reshape(-1, 2)
    return Along(advance, found["hold_t"], which, list(numbers), stepped)


def impulses_of_joints(model: Compiled, found: Mapping[str, Any]) -> FloatArray:
    """Impulses of the joints (impacts, joints, 3) in the impacts that the core recorded, on their second links.

    Not a number where the equations have no solution.
    """
    count, contacts, first = len(found["impact_t"]), len(model.contacts), found["first"]
    P: FloatArray = np.zeros((count, 2 * contacts), dtype=model.core.REAL)
    for i in range(count):
        part = slice(first[i], first[i + 1])
        chosen = np.array(found["contacts"][part])
        P[i, chosen], P[i, contacts + chosen] = found["impulses"][part], found["friction"][part]
    q = np.ascontiguousarray(found["q"][found["after"]]) if count else found["q"][:0]
    impulses, outcomes = model.kernels.joint_impulses(q, found["u_plus"] - found["u_minus"], P)
    impulses[[outcome != "done" for outcome in outcomes]] = np.nan
    impulses[~P.any(axis=1)] = 0.0  # a loop that lies in a line strikes itself: impulses of its joints have no bounds
    return impulses.reshape(count, len(model.joints), 3)
