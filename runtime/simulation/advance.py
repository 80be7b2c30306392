"""States of a run between its rows, by a step of its method; can be pickled with the run."""

from __future__ import annotations

import copy
import pickle
from dataclasses import dataclass
from typing import Any

import numpy as np

from .._core import Supply
from ..arrays import FloatArray
from ..model.inputs import Given, supply_of
from ..model.model import Model


@dataclass(frozen=True, eq=False)
class Latched:
    """What effects hold along a run: ``values`` (rows, latches) from the times ``t`` (rows,) of its rows on."""

    t: FloatArray
    values: FloatArray

    def at(self, t: float | FloatArray) -> FloatArray:
        """What they hold at a time, (latches,), or at times (b,), (b, latches), from then on."""
        found: FloatArray = self.values[np.searchsorted(self.t, t, side="right") - 1]
        return found

    def before(self, t: float) -> FloatArray:
        """What they have held up to a time later than the first: (latches,)."""
        found: FloatArray = self.values[max(int(np.searchsorted(self.t, t, side="left")) - 1, 0)]
        return found


LOST = "lost"
"""In place of a controller that cannot be pickled."""


COLLOCATION = "gauss"
"""Method of steps that end beside a singular configuration, where that of the run may have none."""


@dataclass(eq=False)
class Advance:
    """Called with (t0, q0, u0, h): the state (q, u) that one projected step reaches from a recorded row.

    ``method``, ``drift`` and the two ``tolerances`` are the run's, as are the ``scales``, its
    characteristic time (s) and energy (J); ``inputs`` as they were given to it and ``supply``
    what became of them; ``held`` are the contacts, and how each is held, from the times ``hold_t`` on,
    and ``latched`` is what effects hold.
    ``stepped`` are times, q and u of the rows where it went on by time stepping: states between are on lines between
    them.
    Raises ``ValueError`` where no step can be made.
    """

    model: Model
    method: str
    drift: str
    hold_t: FloatArray
    held: list[list[tuple[int, str]]]
    tolerances: tuple[float, float]
    scales: tuple[float, float]
    inputs: Given
    supply: Supply | None
    latched: Latched
    stepped: tuple[tuple[FloatArray, FloatArray, FloatArray], ...] = ()

    def __post_init__(self) -> None:
        if self.inputs is not None and not callable(self.inputs):
            self.inputs = copy.deepcopy(self.inputs)  # the caller may change his

    def __call__(self, t0: float, q0: FloatArray, u0: FloatArray, h: float) -> tuple[FloatArray, FloatArray]:
        if isinstance(self.inputs, str):
            raise ValueError(
                f"no state between the rows at t = {t0} and after: the run was pickled without its controller, which "
                "cannot be; define it at the top of a module, or ask for states before the run is pickled"
            )
        for t, q, u in self.stepped:
            if t[0] <= t0 < t[-1]:
                return self._between_steps(t, q, u, t0 + h)
        change = int(np.searchsorted(self.hold_t, t0, side="right")) - 1
        held = [(contact, how) for contact, how in self.held[change] if how != "carried"] if change >= 0 else []
        latched = self.latched.at(t0) if h >= 0.0 else self.latched.before(t0)
        for method in dict.fromkeys((self.method, COLLOCATION)):
            start, settings = (t0, np.array(q0), np.array(u0), h), (*self.tolerances, self.scales, latched)
            new_q, new_u, outcome = self.model.kernels.advance(method, *start, self.supply, self.drift, held, *settings)
            if outcome == "done":
                return new_q, new_u
        raise ValueError(f"no state between the rows at t = {t0} and after ({outcome.replace('_', ' ')})")

    def _between_steps(self, t: FloatArray, q: FloatArray, u: FloatArray, at: float) -> tuple[FloatArray, FloatArray]:
        """The state between two steps in time: on the line between them, put onto the closure."""
        row = int(np.searchsorted(t, at, side="right")) - 1
        part = (at - t[row]) / (t[row + 1] - t[row])
        return self.model.project(q[row] + part * (q[row + 1] - q[row]), u[row] + part * (u[row + 1] - u[row]))

    def __copy__(self) -> Advance:
        return self

    def __deepcopy__(self, memo: object) -> Advance:
        return self

    def __getstate__(self) -> dict[str, Any]:
        """All but the supply, which is in memory of its own, and a controller that has no name to be found by."""
        state = vars(self) | {"supply": None}
        if callable(self.inputs):
            try:
                pickle.dumps(self.inputs)
            except (pickle.PicklingError, AttributeError, TypeError):
                state["inputs"] = LOST
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        if not isinstance(self.inputs, str):
            self.supply = supply_of(self.model.inputs, self.inputs, self.model.core.Supply)[0]
