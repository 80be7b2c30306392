"""The record of a periodic motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..arrays import ComplexArray, FloatArray
from ..model.thresholds import characteristic_time
from ..run import Run
from ..simulate import simulate
from .section import BEHIND, Crossed, Map
from .shooting import Chain, multipliers_of
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
    u), and ``nodes`` (segments, 2 n) those in which the segments begin that it was found in. ``return_map`` is the map
    from the section back to it, and ``chain`` its segments, for :func:`continue_orbit`.
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
    nodes: FloatArray = field(repr=False)
    return_map: Map = field(repr=False)
    chain: Chain = field(repr=False)

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


def orbit_of(chain: Chain, found: Sequence[Crossed], missed: float) -> Orbit:
    """The orbit through the nodes of segments, which miss each other by no more: multipliers by the segments, and one
    run through all of it."""
    parts, first, a_map = chain.blocks(found), found[0], chain.map
    matrix = np.linalg.multi_dot(parts[::-1]) if len(parts) > 1 else parts[0]
    run = first.runs[0]
    if len(found) > 1:
        until = 0.0
        for one, crossed in zip(chain.maps, found, strict=True):
            until += crossed.time
            if one.relabel is not None:
                break
        until *= 1.0 + BEHIND if isinstance(a_map.section, tuple) else 1.0  # with the impact of the section
        again = simulate(a_map.model, first.q, first.u, until=until, **a_map.options)
        assert isinstance(again, Run)
        run = again
    states = np.vstack([one.states for one, crosses in zip(found, chain.crosses, strict=True) if crosses])
    return Orbit(
        q=first.q,
        u=first.u,
        period=float(sum(one.time for one in found)),
        multipliers=multipliers_of(parts),
        matrix=matrix,
        basis=first.basis,
        missed=missed,
        runs=a_map.count,
        run=run,
        states=states,
        nodes=np.array([np.concatenate([one.q, one.u]) for one in found]),
        return_map=a_map,
        chain=chain,
    )
