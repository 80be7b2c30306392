"""Joints: which points of which links coincide."""

from __future__ import annotations

from dataclasses import dataclass

from .links import GROUND


@dataclass(frozen=True)
class PointRef:
    """A named point of a link; ``link`` is the link's index, or ``GROUND``."""

    link: int
    point: str


@dataclass(frozen=True)
class Joint:
    """A revolute joint between the point ``first`` and the point ``second``.

    When the joint is cut to open a loop, closure is (second point) − (first point), and the multiplier is the force on
    the link of ``second``.
    """

    name: str
    first: PointRef
    second: PointRef

    def __post_init__(self) -> None:
        if self.first.link == self.second.link:
            raise ValueError(f"{self.name} joins a link to itself; a joint needs two different links")

    @property
    def on_ground(self) -> bool:
        return GROUND in (self.first.link, self.second.link)
