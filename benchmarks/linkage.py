"""A linkage as physics engines want it: links by their mass centres, pins by arms, corners that touch the floor y = 0.

States are rows (n, 6), one for each link: x, y (m) and angle (rad) of its mass centre, and their rates.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from workload import Array

from ccgen.generator import Scene
from ccgen.generator.mechanism.joints import PointRef
from ccgen.generator.mechanism.links import GROUND
from ccgen.runtime import Model


@dataclass(frozen=True, eq=False)
class Pin:
    """Two links that turn about a point: its arms (m) from their mass centres, in their frames; on ground its place."""

    first: int
    first_arm: Array
    second: int
    second_arm: Array


@dataclass(frozen=True)
class Corner:
    """A point of a link that the floor stops, as an arm (m) from its mass centre, in its frame."""

    link: int
    arm: Array


@dataclass(frozen=True)
class Linkage:
    """Masses (kg) and inertias about the mass centres (kg m²), both (n,), pins, corners, and the start (n, 6).

    ``restitution`` is Newton's, of every corner on the smooth floor; gravity (m/s²) pulls down.
    """

    masses: Array
    inertias: Array
    pins: tuple[Pin, ...]
    corners: tuple[Corner, ...]
    restitution: float
    gravity: float
    start: Array


@dataclass(frozen=True, eq=False)
class Bond:
    """How a link hangs in the tree: on link ``parent`` (or the ground) by a pin; a root that floats has no pin."""

    link: int
    parent: int
    pin: Pin | None


def of_model(model: Model, scene: Scene, corners: bool = False, restitution: float = 0.0) -> Linkage:
    """The linkage of a scene of pins at the start of its model; with ``corners``, the first joint of each link is one.

    Raises ``ValueError`` for joints that do not turn.
    """
    mechanism = scene.mechanism
    masses = np.array([link.mass.value if link.mass else 0.0 for link in mechanism.links])
    inertias = np.array([link.inertia.value if link.inertia else 0.0 for link in mechanism.links])
    centres = np.array([link.com.values() for link in mechanism.links], dtype=float)

    def arm(end: PointRef) -> Array:
        place = np.array(mechanism.point(end).values(), dtype=float)
        return place if end.link == GROUND else place - centres[end.link]

    pins = []
    for joint in mechanism.joints:
        if joint.slides:
            raise ValueError(f"{scene.package}: joint {joint.name} does not turn; engines are given pins alone")
        pins.append(Pin(joint.first.link, arm(joint.first), joint.second.link, arm(joint.second)))
    gravity = model.parameters["gravity.g"]
    q, u = model.start()
    start = centred(model.poses(q), model.velocities(q, u), centres)
    feet = tuple(Corner(k, -centres[k]) for k in range(len(masses))) if corners else ()
    return Linkage(masses, inertias, tuple(pins), feet, restitution, gravity, start)


def centred(poses: Array, velocities: Array, centres: Array) -> Array:
    """States (..., n, 6) of mass centres, from poses and velocities (..., n, 3) of frames that have them at centres."""
    turned = turn(centres, poses[..., 2])
    states = np.concatenate([poses, velocities], axis=-1)
    states[..., :2] += turned
    states[..., 3] -= velocities[..., 2] * turned[..., 1]
    states[..., 4] += velocities[..., 2] * turned[..., 0]
    return states


def turn(arms: Array, angles: Array) -> Array:
    """Arms (..., 2) turned by angles (...)."""
    c, s = np.cos(angles), np.sin(angles)
    return np.stack([c * arms[..., 0] - s * arms[..., 1], s * arms[..., 0] + c * arms[..., 1]], axis=-1)


def places(states: Array, links: Sequence[int], arms: Array) -> Array:
    """Where points are: x, y (..., k, 2), each an arm (k, 2) of a link; the ground's arms are places."""
    chosen = states[..., np.maximum(links, 0), :]
    found = chosen[..., :2] + turn(arms, chosen[..., 2])
    return np.where(np.array(links)[:, None] == GROUND, arms, found)


def tree(linkage: Linkage) -> tuple[list[Bond], list[Pin]]:
    """The links from the ground outwards, or from link 0 of a linkage that floats, and the pins that close loops."""
    n = len(linkage.masses)
    grounded = any(GROUND in (pin.first, pin.second) for pin in linkage.pins)
    bonds = [] if grounded else [Bond(0, GROUND, None)]
    reached = {GROUND} if grounded else {0}
    left = sorted(linkage.pins, key=lambda pin: GROUND not in (pin.first, pin.second))  # loops are cut off the ground
    while len(bonds) < n:
        for pin in left:
            ends = ((pin.first, pin.second), (pin.second, pin.first))
            found = next(((here, there) for here, there in ends if here in reached and there not in reached), None)
            if found is not None:
                break
        else:
            raise ValueError("linkage: some links hang on no others; engines are given one linkage")
        bonds.append(Bond(found[1], found[0], pin))
        reached.add(found[1])
        left.remove(pin)
    return bonds, left


def arm_of(pin: Pin, link: int) -> Array:
    """The arm of the pin on a link that it holds."""
    return pin.first_arm if pin.first == link else pin.second_arm


@dataclass(frozen=True)
class Tree:
    """Coordinates for engines that want trees: shifts x, y of a root that floats, then each link's turn on its parent.

    All are zero at the start; links stand in the order of ``bonds``.
    """

    linkage: Linkage
    bonds: tuple[Bond, ...]
    cuts: tuple[Pin, ...]

    @property
    def floats(self) -> bool:
        return self.bonds[0].pin is None

    def speeds(self) -> Array:
        """Rates of the coordinates at the start."""
        start = self.linkage.start
        turns = [start[b.link, 5] - (start[b.parent, 5] if b.parent != GROUND else 0.0) for b in self.bonds]
        shifts = [start[self.bonds[0].link, 3], start[self.bonds[0].link, 4]] if self.floats else []
        return np.array([*shifts, *turns])

    def states(self, q: Array, v: Array) -> Array:
        """States (..., n, 6) at coordinates and their rates, (..., n) or (..., n + 2)."""
        start, shifts = self.linkage.start, 2 if self.floats else 0
        states = np.zeros((*q.shape[:-1], len(self.bonds), 6))
        for number, bond in enumerate(self.bonds):
            mine, held = states[..., bond.link, :], bond.parent != GROUND
            parent = states[..., bond.parent, :] if held else np.zeros(6)
            before = start[bond.parent, 2] if held else 0.0
            mine[..., 2] = start[bond.link, 2] - before + parent[..., 2] + q[..., shifts + number]
            mine[..., 5] = parent[..., 5] + v[..., shifts + number]
            if bond.pin is None:
                mine[..., :2], mine[..., 3:5] = start[bond.link, :2] + q[..., :2], v[..., :2]
                continue
            outwards = turn(arm_of(bond.pin, bond.parent), parent[..., 2])
            inwards = turn(arm_of(bond.pin, bond.link), mine[..., 2])
            mine[..., :2] = parent[..., :2] + outwards - inwards
            mine[..., 3] = parent[..., 3] - parent[..., 5] * outwards[..., 1] + mine[..., 5] * inwards[..., 1]
            mine[..., 4] = parent[..., 4] + parent[..., 5] * outwards[..., 0] - mine[..., 5] * inwards[..., 0]
        return states


def as_tree(linkage: Linkage) -> Tree:
    """The linkage with its tree."""
    bonds, cuts = tree(linkage)
    return Tree(linkage, tuple(bonds), tuple(cuts))
