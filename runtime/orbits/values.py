"""Coordinates and rates of periodic motions by name, where they cross the section."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray
from ..model.model import Model
from ..model.places import rate_of
from .orbit import Orbit


def names_of(model: Model) -> list[str]:
    """Names of the state's entries: coordinates, and their rates behind them."""
    return [*model.q_of, *map(rate_of, model.q_of)]


def unit_of(name: str) -> str:
    """The unit of a coordinate or rate."""
    kinds = {"angle": "rad", "angular_velocity": "rad/s", "slide": "m", "slide_rate": "m/s"}
    kind = name.rpartition(".")[2]
    return kinds.get(kind, "m/s" if kind.startswith("v") else "m")


def varied_most(orbits: Sequence[Orbit]) -> str:
    """The name of the coordinate that changes most along a branch, in units of the mechanism; what a drive moves, or
    may advance, does not count, and rates only where no coordinate changes."""
    a_map = orbits[0].return_map
    n = len(orbits[0].q)
    states = np.vstack([orbit.states for orbit in orbits])
    moves = np.ptp(states, axis=0) / a_map.units
    moves[a_map.free] = 0.0
    first = moves[:n] if np.any(moves[:n] > STILL) else moves
    return names_of(a_map.model)[int(np.argmax(first))]


STILL = 1e-6
"""What changes by less than this part of the mechanism is still."""


def shown(orbit: Orbit, name: str) -> FloatArray:
    """A coordinate or rate each time that an orbit crosses its section, (crossings,)."""
    return np.asarray(orbit.states[:, names_of(orbit.return_map.model).index(name)])
