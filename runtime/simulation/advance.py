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


@dataclass(eq=False)
class Advance:
    """States of a run beside its rows: between two of them, or, called with (t0, q0, u0, h), a step from one.

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
        """The state that one projected step of length h reaches from a recorded row."""
        latched = self.latched.at(t0) if h >= 0.0 else self.latched.before(t0)
        settings = self._settings(t0, latched)
        return self._found(t0, self.model.kernels.advance(self.method, t0, np.array(q0), np.array(u0), h, *settings))

    def between(self, t: float, times: FloatArray, q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The state at t between two rows at ``times`` (2,), q and u (2, n); the core says how it is found there."""
        t0, t1 = times.tolist()
        line = any(rows[0] <= t0 < rows[-1] for rows, _, _ in self.stepped)
        states = np.ascontiguousarray(q), np.ascontiguousarray(u)
        settings = self._settings(t0, self.latched.at(t0))
        return self._found(t0, self.model.kernels.between(self.method, (t0, t1), *states, t, line, *settings))

    def _settings(self, t0: float, latched: FloatArray) -> tuple[Any, ...]:
        """What the core is told beside rows."""
        if isinstance(self.inputs, str):
            raise ValueError(
                f"no state between the rows at t = {t0} and after: the run was pickled without its controller, which "
                "cannot be; define it at the top of a module, or ask for states before the run is pickled"
            )
        change = int(np.searchsorted(self.hold_t, t0, side="right")) - 1
        held = [(contact, how) for contact, how in self.held[change] if how != "carried"] if change >= 0 else []
        return self.supply, self.drift, held, *self.tolerances, self.scales, latched

    def _found(self, t0: float, found: tuple[FloatArray, FloatArray, str]) -> tuple[FloatArray, FloatArray]:
        q, u, outcome = found
        if outcome != "done":
            raise ValueError(f"no state between the rows at t = {t0} and after ({outcome.replace('_', ' ')})")
        return q, u

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
