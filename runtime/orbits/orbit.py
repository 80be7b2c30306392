"""The record of a periodic motion."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..arrays import ComplexArray, FloatArray
from ..model.thresholds import characteristic_time
from ..run import Run
from .section import Crossed, Map
from .tolerance import KNOWN, tolerance_of

NEUTRAL = 1e-7
"""A multiplier whose size is this near to 1 is neither below nor above it, to the accuracy of runs."""


@dataclass(frozen=True, eq=False)
class Orbit:
    """A motion that comes back to where it began.

    ``q``, ``u`` (n,) are its state on the section and ``period`` (s) its time to come back. ``multipliers`` (k,),
    complex, largest first, are those by which small differences on the section grow in a period: the orbit is
    ``stable`` where all are less than 1 in size, by more than rounding, ``neutral`` where it is not and none is larger
    than 1. ``matrix`` (k, k) has them as eigenvalues, in the coordinates of
    ``basis`` (2 n, k): directions of the state (q, u) that keep loops shut and stay on the section. ``missed`` is by
    how much it does not come back, the largest of all coordinates and rates, in units of the mechanism. ``runs`` is
    how many runs were derived, ``run`` the motion of one period; of a doubled orbit whose state is relabelled on the
    way, up to there. ``states`` (crossings, 2 n) are those each time that it crosses the section, the first being (q,
    u). ``return_map`` is the map from the section back to it, for :func:`continue_orbit`.
    """

    q: FloatArray
    u: FloatArray
    period: float
    multipliers: ComplexArray
    matrix: FloatArray = field(repr=False)
    basis: FloatArray = field(repr=False)
    missed: float
    runs: int
    run: Run = field(repr=False)
    states: FloatArray = field(repr=False)
    return_map: Map = field(repr=False)

    @property
    def stable(self) -> bool:
        """Whether small differences die away."""
        return bool(np.all(np.abs(self.multipliers) < 1.0 - NEUTRAL))

    @property
    def at_rest(self) -> bool:
        """Whether nothing moves in the period by more than ten tolerances of the run, in units of the mechanism: it is
        an equilibrium then."""
        model, run = self.return_map.model, self.run
        most = KNOWN * tolerance_of(self.return_map)
        unit = model.coordinate_units
        away = np.max(np.abs(run.q - run.q[0]) / unit, initial=0.0)
        speed = np.max(np.abs(run.u) / unit, initial=0.0) * characteristic_time(model)
        return bool(max(away, speed) <= most)

    @property
    def neutral(self) -> bool:
        """Whether some small differences stay as large as they are, and none grow: as where energy is kept."""
        return not self.stable and bool(np.all(np.abs(self.multipliers) <= 1.0 + NEUTRAL))


def orbit_at(a_map: Map, crossed: Crossed) -> Orbit:
    """The orbit through a state that a map gives back."""
    matrix = a_map.on_section(crossed)
    found = np.linalg.eigvals(matrix).astype(complex)
    found = found[np.lexsort((found.imag, -np.abs(found)))]
    missed = float(np.max(np.abs(crossed.rest), initial=0.0))
    state, basis, run = (crossed.q, crossed.u), crossed.basis, crossed.runs[0]
    return Orbit(*state, float(crossed.time), found, matrix, basis, missed, a_map.count, run, crossed.states, a_map)
