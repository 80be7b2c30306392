"""What a motion of a linkage lost: gaps of its joints, energy, impacts that came late or not at all."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from linkage import Linkage, places
from workload import Array

WINDOW = 0.02
"""An impact that comes later or earlier than this (s) is another one."""
NEAR = 0.05
"""A corner that turns back higher than this (m) above the floor has struck nothing."""


@dataclass(frozen=True)
class Strike:
    """An impact of a corner, by its number, at a time (s)."""

    time: float
    corner: int


def gap(linkage: Linkage, states: Array) -> float:
    """The largest distance (m) of the two points of a pin, in states (..., n, 6)."""
    pins = linkage.pins
    ends = (
        ([p.first for p in pins], [p.first_arm for p in pins]),
        ([p.second for p in pins], [p.second_arm for p in pins]),
    )
    first, second = (places(states, links, np.array(arms)) for links, arms in ends)
    return float(np.max(np.hypot(*np.moveaxis(second - first, -1, 0))))


def energy(linkage: Linkage, states: Array) -> Array:
    """Kinetic and potential energy (J), the latter zero at y = 0, of states (..., n, 6)."""
    speeds = states[..., 3] ** 2 + states[..., 4] ** 2
    kinetic = 0.5 * (speeds @ linkage.masses + states[..., 5] ** 2 @ linkage.inertias)
    return np.asarray(kinetic + linkage.gravity * (states[..., 1] @ linkage.masses))


def drift(linkage: Linkage, states: Array) -> float:
    """The largest distance (J) of the energy of states (t, n, 6) from that of the start."""
    return float(np.max(np.abs(energy(linkage, states) - energy(linkage, linkage.start))))


def heights(linkage: Linkage, states: Array) -> Array:
    """Heights (m) of the corners, (..., corners)."""
    corners = linkage.corners
    return places(states, [c.link for c in corners], np.array([c.arm for c in corners]))[..., 1]


def strikes(linkage: Linkage, states: Array, step: float) -> list[Strike]:
    """Where corners near the floor turn from falling to rising, in states (t, n, 6) after every step (s)."""
    y = np.concatenate([heights(linkage, linkage.start[None]), heights(linkage, states)])
    fast = _climbs(linkage, np.concatenate([linkage.start[None], states]))
    back = (fast[:-1] < 0.0) & (fast[1:] >= 0.0) & (np.minimum(y[:-1], y[1:]) < NEAR)
    return [Strike(float((row + 1) * step), int(corner)) for row, corner in np.argwhere(back)]


def _climbs(linkage: Linkage, states: Array) -> Array:
    """Vertical speeds (m/s) of the corners, (..., corners)."""
    corners = linkage.corners
    links = [c.link for c in corners]
    arms = places(states, links, np.array([c.arm for c in corners])) - states[..., links, :2]
    return np.asarray(states[..., links, 4] + states[..., links, 5] * arms[..., 0])


def compare(found: Sequence[Strike], known: Sequence[Strike]) -> tuple[int, float]:
    """How many known impacts are missing, and how late or early (s) the others are at most; each is found once."""
    left, missed, latest = list(found), 0, 0.0
    for strike in known:
        same = [one for one in left if one.corner == strike.corner and abs(one.time - strike.time) <= WINDOW]
        if not same:
            missed += 1
            continue
        nearest = min(same, key=lambda one: abs(one.time - strike.time))
        left.remove(nearest)
        latest = max(latest, abs(nearest.time - strike.time))
    return missed, latest
