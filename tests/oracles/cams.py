"""Cams in maximal coordinates: the distance of a follower from a curve whose nearest place is searched for.

The curve of a roller's centre is the cam's polar equation, that of a face's cam is built from its support function;
the nearest place is where the curve's direction is across the way to the follower, by Newton's iteration in wide
numbers. Nothing here knows polar gaps or their weights.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .distances import Place, carried, place
from .maximal import GROUND, WIDE, Array, System, turned


@dataclass(frozen=True)
class Shape:
    """base + size·cos(times·φ + shift) with φ from ``mounted`` on, counted by ``sense``."""

    base: float
    size: float
    times: int
    shift: float
    mounted: float
    sense: int

    def text(self) -> str:
        return f"{self.size!r}*cos({self.times}*angle + {self.shift!r})"

    def at(self, angle: Any) -> tuple[Any, Any, Any, Any]:
        """The function and three derivatives by an angle that is counted counter-clockwise in the cam's frame."""
        inner = self.times * (self.sense * angle - WIDE(self.mounted)) + WIDE(self.shift)
        rate, size = self.times * self.sense, WIDE(self.size)
        return (
            WIDE(self.base) + size * np.cos(inner),
            -size * rate * np.sin(inner),
            -size * rate**2 * np.cos(inner),
            size * rate**3 * np.sin(inner),
        )


def seen(system: System, centres: Array, link: int, vector: Array) -> Array:
    """A vector in the axes of a link."""
    return vector if link == GROUND else np.asarray(turned(-centres[link, 2], vector))


def unit(angle: Any) -> Array:
    return np.array([np.cos(angle), np.sin(angle)], WIDE)


def left(v: Array) -> Array:
    return np.array([-v[1], v[0]], WIDE)


@dataclass(frozen=True)
class Roller:
    """A disc of ``radius`` whose centre stays outside of the curve ``shape`` (radius included) about ``cam``."""

    cam: Place
    disc: Place
    radius: float
    shape: Shape

    def meet(self, system: System, centres: Array) -> tuple[Any, Array]:
        """How far its centre is off the curve, and the normal there, in the cam's axes."""
        link = self.cam[0]
        off = seen(system, centres, link, place(system, centres, self.disc) - place(system, centres, self.cam))
        angle = np.arctan2(off[1], off[0])
        for _ in range(30):
            r, r1, r2, _ = self.shape.at(angle)
            e, n = unit(angle), left(unit(angle))
            tangent, bend = r1 * e + r * n, (r2 - r) * e + 2 * r1 * n
            reach = off - r * e
            angle += (reach @ tangent) / (tangent @ tangent - reach @ bend)
        r, r1, _, _ = self.shape.at(angle)
        tangent = r1 * unit(angle) + r * left(unit(angle))
        normal = -left(tangent) / np.sqrt(tangent @ tangent)
        return (off - r * unit(angle)) @ normal, normal

    def gap(self, system: System, centres: Array) -> Any:
        return self.meet(system, centres)[0]

    def slip(self, system: System, centres: Array, rates: Array) -> Any:
        """Of the disc's material point that touches against the cam's, along the normal turned clockwise."""
        link = self.cam[0]
        normal = self.meet(system, centres)[1]
        normal = normal if link == GROUND else np.asarray(turned(centres[link, 2], normal))
        touching = place(system, centres, self.disc) - WIDE(self.radius) * normal
        moving = carried(system, centres, rates, self.disc[0], touching)
        return -(moving - carried(system, centres, rates, link, touching)) @ left(normal)


@dataclass(frozen=True)
class Face:
    """A line through two points of a link that the cam with the support function ``shape`` touches."""

    cam: Place
    ends: tuple[Place, Place]
    shape: Shape

    def meet(self, system: System, centres: Array) -> tuple[Any, Array, Array]:
        """The distance of the line from the cam's nearest place, its normal, and that place, in fixed axes."""
        link = self.cam[0]
        centre, start, end = (place(system, centres, point) for point in (self.cam, *self.ends))
        normal = left(end - start) / np.sqrt((end - start) @ (end - start))
        normal = normal * np.sign(normal @ (start - centre))
        own = seen(system, centres, link, normal)
        angle = np.arctan2(own[1], own[0]) + WIDE(1e-3)
        for _ in range(30):  # the place that is farthest along the normal: x'·n = 0, where x' = (h + h'')·e⊥
            h, h1, h2, h3 = self.shape.at(angle)
            e = unit(angle)
            first = (h + h2) * left(e)
            second = (h1 + h3) * left(e) - (h + h2) * e
            angle -= (first @ own) / (second @ own)
        h, h1, _, _ = self.shape.at(angle)
        spot = h * unit(angle) + h1 * left(unit(angle))
        touching = centre + (spot if link == GROUND else np.asarray(turned(centres[link, 2], spot)))
        return (start - touching) @ normal, normal, touching

    def gap(self, system: System, centres: Array) -> Any:
        return self.meet(system, centres)[0]

    def slip(self, system: System, centres: Array, rates: Array) -> Any:
        _, normal, touching = self.meet(system, centres)
        moving = carried(system, centres, rates, self.ends[0][0], touching)
        return -(moving - carried(system, centres, rates, self.cam[0], touching)) @ left(normal)
