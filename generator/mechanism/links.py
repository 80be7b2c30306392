"""Links, named points and the parameters that describe them.

A coordinate that a scene gives as exactly zero is *structural*: it is ``None`` here, adds no parameter and no
arithmetic. Every other number is a :class:`Parameter`, symbolic in the equations and changeable at run time.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

GROUND = -1
"""Index of the ground in every place where a link index stands."""


@dataclass(frozen=True)
class Domain:
    """Finite numbers that a parameter may be: from ``minimum``, or above ``above``, to ``maximum``, as far as given;
    only ``whole`` ones, if so."""

    minimum: float | None = None
    above: float | None = None
    maximum: float | None = None
    whole: bool = False

    def __contains__(self, value: float) -> bool:
        return (
            math.isfinite(value)
            and (self.minimum is None or value >= self.minimum)
            and (self.above is None or value > self.above)
            and (self.maximum is None or value <= self.maximum)
            and not (self.whole and value % 1.0)
        )


ANY = Domain()
POSITIVE = Domain(above=0.0)
NOT_NEGATIVE = Domain(minimum=0.0)
FROM_0_TO_1 = Domain(minimum=0.0, maximum=1.0)
OFF_OR_ON = Domain(minimum=0.0, maximum=1.0, whole=True)


@dataclass(frozen=True)
class Parameter:
    """A number of the mechanism that stays symbolic.

    ``path`` is its name in the scene (``link_0.mass``), ``symbol`` its name in the equations (``m_0``), ``value`` its
    value in SI units when the model is loaded, ``domain`` what it may be set to then. ``unit`` is said of those that
    are no key of a table: the others measure what their key does.
    """

    path: str
    symbol: str
    value: float
    domain: Domain = field(default=ANY, compare=False)
    unit: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        if not math.isfinite(self.value):
            raise ValueError(f"{self.path} is {self.value}; a parameter must be a finite number")
        if self.value not in self.domain:
            raise ValueError(f"{self.path} is {self.value}, outside of its domain, {self.domain}")


@dataclass(frozen=True)
class Point:
    """A point fixed in a link, in the link's frame (m). ``None`` stands for a coordinate that is structurally zero."""

    x: Parameter | None = None
    y: Parameter | None = None

    def parameters(self) -> tuple[Parameter, ...]:
        return tuple(p for p in (self.x, self.y) if p is not None)

    def values(self) -> tuple[float, float]:
        """Coordinates in m."""
        return (self.x.value if self.x else 0.0, self.y.value if self.y else 0.0)


ORIGIN = Point()
"""The origin of a link's frame."""

Corner = str | tuple[float, float]
"""A corner of what is drawn of a link: one of its points, or a place in its frame (m)."""


INTEGRATES = 2.0**-60
"""Inertia of a link that integrates (kg m²): a power of two, by which no digit changes, and so small that scales of
energy, which are those of the heaviest part, are the mechanism's own."""


@dataclass(frozen=True)
class Link:
    """A rigid link: ``mass`` (kg), ``inertia`` about the centre of mass (kg m²), ``com`` and named ``points`` (m).

    A mass or inertia that is ``None`` is structurally zero: a point mass, or a link without mass. A link that
    ``integrates`` (:mod:`.integrators`) has no mass and ``INTEGRATES`` for its inertia, and no energy is told of it.
    """

    name: str
    mass: Parameter | None
    inertia: Parameter | None
    com: Point
    points: Mapping[str, Point]
    integrates: bool = field(default=False, compare=False)

    def __post_init__(self) -> None:
        for what, found in (("a mass", self.mass), ("an inertia", self.inertia)):
            if found and not found.value > 0.0:
                raise ValueError(f"{found.path} is {found.value}; {what} must be positive")
        if self.mass is None and self.inertia is not None:
            raise ValueError(f"{self.inertia.path} is {self.inertia.value}; a link without mass has no inertia")

    @property
    def massless(self) -> bool:
        return self.mass is None

    def parameters(self) -> tuple[Parameter, ...]:
        """All parameters, each once, in the order mass, inertia, centre of mass, points."""
        found = [p for p in (self.mass, self.inertia) if p is not None]
        found += self.com.parameters()
        found += [p for point in self.points.values() for p in point.parameters()]
        return tuple(dict.fromkeys(found))
