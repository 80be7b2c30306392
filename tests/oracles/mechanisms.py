"""Random mechanisms: the same links and joints as plain arrays for the references and as a scene's text for ccgen.

A mechanism is drawn in the plane: joint positions first, then link frames anywhere, then the joint positions are read
off in the link frames. So unequal lengths, offset centres of mass and frames off the joints come for free, and the
drawing is a closed configuration.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .maximal import GROUND, Array, Pin, System, turned

Vertex = int
"""Index of a drawn joint position."""


@dataclass(frozen=True)
class Drawing:
    """A mechanism with the closed configuration in which it was drawn."""

    name: str
    system: System
    poses: Array
    points: tuple[Mapping[str, tuple[float, float]], ...]
    ground: Mapping[str, tuple[float, float]]
    ends: tuple[tuple[str, str], ...]

    def toml(self, start: bool = True, extra: str = "") -> str:
        """The scene's text in the general form; floats are written so that they read back equal."""
        lines = [f'name = "{self.name}"']
        if start:
            lines += ["[start]", f"angles = {[float(a) for a in self.poses[:, 2]]}"]
            if not self.ground:
                lines += [f"position = {[float(p) for p in self.poses[0, :2]]}"]
        if self.system.gravity:
            lines += ["[gravity]", f"g = {float(self.system.gravity)!r}"]
        if self.ground:
            lines += ["[ground_link]", f"points = {{ {_points(self.ground)} }}"]
        for k, points in enumerate(self.points):
            mass, inertia = float(self.system.mass[k]), float(self.system.inertia[k])
            lines += ["[[link]]", f'name = "body_{k}"', f"mass = {mass!r}", f"inertia = {inertia!r}"]
            lines += [f"com = {[float(c) for c in self.system.com[k]]}", f"points = {{ {_points(points)} }}"]
        for first, second in self.ends:
            lines += ["[[joint]]", 'type = "revolute"', f'between = ["{first}", "{second}"]']
        return "\n".join(lines) + "\n" + extra


def _points(points: Mapping[str, tuple[float, float]]) -> str:
    return ", ".join(f"{name} = [{float(x)!r}, {float(y)!r}]" for name, (x, y) in points.items())


def draw(
    name: str,
    places: Array,
    bodies: Sequence[Sequence[Vertex]],
    joints: Sequence[tuple[Vertex, int, int]],
    rng: np.random.Generator,
    gravity: float = 9.81,
) -> Drawing:
    """A mechanism from joint positions ``places``, those that each body reaches, and joints (position, a, b)."""
    n = len(bodies)
    poses = np.empty((n, 3))
    com, points = np.empty((n, 2)), []
    for k, reached in enumerate(bodies):
        middle = places[list(reached)].mean(axis=0)
        poses[k] = *(middle + rng.uniform(-0.4, 0.4, 2)), rng.uniform(-3.0, 3.0)
        points.append({f"P{v}": _local(poses[k], places[v]) for v in reached})
        com[k] = _local(poses[k], middle + rng.uniform(-0.25, 0.25, 2))
    ground = {f"O{v}": (float(places[v][0]), float(places[v][1])) for v, a, b in joints if GROUND in (a, b)}
    pins, ends = [], []
    for v, a, b in joints:
        on = [ground[f"O{v}"] if k == GROUND else points[k][f"P{v}"] for k in (a, b)]
        pins.append(Pin(a, on[0], b, on[1]))
        first, second = (f"ground.O{v}" if k == GROUND else f"body_{k}.P{v}" for k in (a, b))
        ends.append((first, second))
    mass = rng.uniform(0.5, 2.0, n)
    system = System(mass, mass * rng.uniform(0.06, 0.2, n), com, tuple(pins), gravity)
    return Drawing(name, system, poses, tuple(points), ground, tuple(ends))


def _local(pose: Array, place: Array) -> tuple[float, float]:
    x, y = turned(np.asarray(-pose[2]), place - pose[:2])
    return float(x), float(y)


def _polygon(n: int, rng: np.random.Generator, phase: float = 0.0) -> Array:
    """Corners of an irregular n-gon with sides of about one metre, the first in the direction ``phase``."""
    angle = phase + 2 * np.pi * np.arange(n) / n + rng.uniform(-0.2, 0.2, n) * 2 * np.pi / n
    radius = 0.5 / np.sin(np.pi / n) * (1 + rng.uniform(-0.25, 0.25, n) / max(1.0, n / 8))
    corners: Array = radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return corners


def _path(n: int, rng: np.random.Generator) -> Array:
    """Corners of a wandering path of n sides."""
    heading = np.cumsum(rng.uniform(-0.9, 0.9, n))
    steps = rng.uniform(0.6, 1.4, n)[:, None] * np.stack([np.cos(heading), np.sin(heading)], axis=1)
    return np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])


def floating(n: int, seed: int = 1) -> Drawing:
    """A free ring of n links."""
    rng = np.random.default_rng([seed, n, 1])
    joints = [(k, (k - 1) % n, k) for k in range(n)]
    return draw(f"ring_{n}", _polygon(n, rng), [(k, (k + 1) % n) for k in range(n)], joints, rng)


def pinned(n: int, seed: int = 1) -> Drawing:
    """n links between two supports."""
    rng = np.random.default_rng([seed, n, 2])
    joints = [(0, GROUND, 0), *((k, k - 1, k) for k in range(1, n)), (n, n - 1, GROUND)]
    return draw(f"pinned_{n}", _polygon(n + 1, rng), [(k, k + 1) for k in range(n)], joints, rng)


def open_chain(n: int, seed: int = 1) -> Drawing:
    """A free chain of n links."""
    rng = np.random.default_rng([seed, n, 3])
    bodies = [(k, k + 1) for k in range(n)]
    return draw(f"open_{n}", _path(n, rng), bodies, [(k, k - 1, k) for k in range(1, n)], rng)


def hinged(n: int, seed: int = 1) -> Drawing:
    """A chain of n links that hangs on one support."""
    rng = np.random.default_rng([seed, n, 4])
    joints = [(0, GROUND, 0), *((k, k - 1, k) for k in range(1, n))]
    return draw(f"hinged_{n}", _path(n, rng), [(k, k + 1) for k in range(n)], joints, rng)


def two_loops(n: int, seed: int = 1) -> Drawing:
    """Two free rings that share link 0; n links in all."""
    rng = np.random.default_rng([seed, n, 5])
    half = (n + 2) // 2  # links of the first ring, link 0 among them
    rest = n - half + 1
    first = _polygon(half, rng, phase=-np.pi / half)
    second = _polygon(rest, rng, phase=np.pi - np.pi / rest)
    second += (first[:2, 0].mean() - second[:2, 0].mean() + 0.6, 0.1)
    places = np.concatenate([first, second])
    bodies: list[tuple[Vertex, ...]] = [(0, 1, half, half + 1)]
    bodies += [(k, (k + 1) % half) for k in range(1, half)]
    bodies += [(half + k, half + (k + 1) % rest) for k in range(1, rest)]
    joints = [(k, (k - 1) % half, k) for k in range(half)]
    offset = half - 1
    ring = [0, *range(offset + 1, offset + rest)]
    joints += [(half + k, ring[k - 1], ring[k]) for k in range(rest)]
    return draw(f"two_loops_{n}", places, bodies, joints, rng)


def ladder(loops: int, seed: int = 1) -> Drawing:
    """Four-link loops side by side over the ground, neighbours sharing their upright; each loop has two cross links."""
    rng = np.random.default_rng([seed, loops, 6])
    feet = np.stack([1.2 * np.arange(loops + 1), np.zeros(loops + 1)], axis=1)
    heads = feet + np.array([0.0, 1.0]) + rng.uniform(-0.2, 0.2, (loops + 1, 2))
    knees = (heads[:-1] + heads[1:]) / 2 + np.array([0.0, 0.45]) + rng.uniform(-0.15, 0.15, (loops, 2))
    places = np.concatenate([feet, heads, knees])
    head, knee = loops + 1, 2 * (loops + 1)
    bodies: list[tuple[Vertex, ...]] = [(k, head + k) for k in range(loops + 1)]
    joints = [(k, GROUND, k) for k in range(loops + 1)]
    for k in range(loops):
        left, right = len(bodies), len(bodies) + 1
        bodies += [(head + k, knee + k), (knee + k, head + k + 1)]
        joints += [(head + k, k, left), (knee + k, left, right), (head + k + 1, right, k + 1)]
    return draw(f"ladder_{loops}", places, bodies, joints, rng)


FAMILIES = {
    "floating": floating,
    "pinned": pinned,
    "open": open_chain,
    "hinged": hinged,
    "two_loops": two_loops,
    "ladder": ladder,
}


def in_a_row(drawing: Drawing) -> System:
    """The system with its pins in the order of the chain; the pin that closes a ring on link 0 comes last."""
    pins = drawing.system.pins
    if pins and pins[0].a == drawing.system.size - 1 and pins[0].b == 0:
        pins = (*pins[1:], pins[0])
    return replace(drawing.system, pins=pins)
