"""The mechanism: a graph whose nodes are links (ground among them) and whose edges are joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .joints import Joint, PointRef
from .links import GROUND, Link, Parameter, Point


@dataclass(frozen=True)
class Mechanism:
    """Links, the points of the ground link, and the joints between them, in scene order.

    Raises ``ValueError`` when a name is used twice, or a joint names a link or point that does not exist.
    """

    links: tuple[Link, ...]
    ground_points: Mapping[str, Point]
    joints: tuple[Joint, ...]

    def __post_init__(self) -> None:
        for kind, names in (("link", [k.name for k in self.links]), ("joint", [j.name for j in self.joints])):
            twice = sorted({name for name in names if names.count(name) > 1})
            if twice:
                raise ValueError(f"{kind} name used twice: {', '.join(twice)}")
        for joint in self.joints:
            for end in (joint.first, joint.second):
                self.point(end)
        symbols = [p.symbol for p in self.parameters()]
        if len(set(symbols)) != len(symbols):
            raise ValueError("two parameters share a symbol")

    def point(self, ref: PointRef) -> Point:
        """The point that ``ref`` names."""
        points = self.ground_points if ref.link == GROUND else self.links[ref.link].points
        if ref.point not in points:
            raise ValueError(f"{self.link_name(ref.link)} has no point {ref.point!r}; it has {', '.join(points)}")
        return points[ref.point]

    def link_name(self, link: int) -> str:
        return "ground" if link == GROUND else self.links[link].name

    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters of all links, then of the ground's points, each once."""
        found = [p for link in self.links for p in link.parameters()]
        found += [p for point in self.ground_points.values() for p in point.parameters()]
        return tuple(dict.fromkeys(found))
