"""Joints: which points of which links coincide, or slide along which line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from .links import GROUND, Parameter

Kind = Literal["revolute", "prismatic", "pin-in-slot", "weld"]


@dataclass(frozen=True)
class PointRef:
    """A named point of a link; ``link`` is the link's index, or ``GROUND``."""

    link: int
    point: str


@dataclass(frozen=True)
class Joint:
    """A joint between the point ``first`` and the point ``second``.

    ``revolute``: the points coincide. ``pin-in-slot``: the second point slides along a line that is fixed in the first
    link, passes through the first point and points in the direction ``axis`` (rad, in the first link's frame).
    ``prismatic``: the same, and the second link's frame keeps the angle ``angle`` (rad) against the first one's.
    ``weld``: the points coincide, and it keeps that angle; only one that lets go or takes hold is a joint.
    ``None`` stands for a direction or angle of exactly zero.

    When the joint is cut to open a loop, closure is (second point) − (first point), across the line if it slides, and
    the multiplier is the force on the link of ``second``.
    """

    name: str
    first: PointRef
    second: PointRef
    kind: Kind = "revolute"
    axis: Parameter | None = None
    angle: Parameter | None = None

    def __post_init__(self) -> None:
        if self.first.link == self.second.link:
            raise ValueError(f"{self.name} joins a link to itself; a joint needs two different links")
        if (self.axis and not self.slides) or (self.angle and self.turns):
            raise ValueError(f"{self.name} is {self.kind}; it has no axis or angle of that kind")

    @property
    def on_ground(self) -> bool:
        return GROUND in (self.first.link, self.second.link)

    @property
    def slides(self) -> bool:
        """Whether the second point moves along a line of the first link."""
        return self.kind in ("prismatic", "pin-in-slot")

    @property
    def turns(self) -> bool:
        """Whether the links turn against each other."""
        return self.kind in ("revolute", "pin-in-slot")

    @property
    def later(self) -> PointRef:
        """The end on the link that comes later, the ground being before all: of a prismatic joint the moment is about
        it, whichever end is the second."""
        return max(self.first, self.second, key=lambda end: end.link)

    def parameters(self) -> tuple[Parameter, ...]:
        return tuple(p for p in (self.axis, self.angle) if p is not None)
