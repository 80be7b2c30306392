"""The line between two points of different links: what springs and dampers act along."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..mechanism.joints import PointRef
from ..mechanism.mechanism import Mechanism
from .effect import Complain
from .points import find_point

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.motion import Force, Motion
    from ..derive.vectors import Vector
    from ..mechanism.assembled import Assembled

NO_DIRECTION = 1e-9
"""Points closer than this (m) have no line between them."""


@dataclass(frozen=True)
class Line:
    """Between ``points``; ``label`` (``spring_0``) tells the names of its quantities from those of other lines."""

    label: str
    points: tuple[PointRef, PointRef]

    def reach(self, motion: Motion) -> Vector:
        """The vector from the first point to the second (m)."""
        return motion.let_vector(f"reach_{self.label}", motion.distance(*self.points))

    def square(self, motion: Motion) -> Expr:
        """The squared length (m²)."""
        from ..derive.vectors import dot

        reach = self.reach(motion)
        return motion.let(f"square_{self.label}", dot(reach, reach))

    def length(self, motion: Motion) -> Expr:
        """The length (m)."""
        from sympy import sqrt

        return motion.let(f"stretched_{self.label}", sqrt(self.square(motion)))

    def stretching(self, motion: Motion) -> Expr:
        """Half the rate of the squared length (m²/s)."""
        from ..derive.vectors import dot

        approach = motion.let_vector(f"approach_{self.label}", motion.approach(*self.points))
        return motion.let(f"stretching_{self.label}", dot(self.reach(motion), approach))

    def pull(self, motion: Motion, tension: Expr) -> tuple[Force, Force]:
        """The forces of a ``tension`` per length (N/m) that draws the points together."""
        from sympy import S

        from ..derive.motion import Force
        from ..derive.vectors import scale

        force = motion.let_vector(f"pull_{self.label}", scale(tension, self.reach(motion)))
        return Force(self.points[0], force), Force(self.points[1], scale(S.NegativeOne, force))

    def is_point(self, start: Assembled) -> bool:
        """Whether both ends are at the same place at the start."""
        (x, y), (x2, y2) = (start.place(ref) for ref in self.points)
        return math.hypot(x2 - x, y2 - y) <= NO_DIRECTION


def find_line(
    label: str, between: Sequence[str], mechanism: Mechanism, complain: Complain, key: str = "between"
) -> Line | None:
    """The line between two named points, or ``None`` after having complained about what stands at ``key``."""
    found = []
    for end, name in enumerate(between):
        ref, wrong = find_point(name, mechanism)
        if ref is None:
            complain((key, end), f'found "{name}", expected a joint or link.point; {wrong}')
        else:
            found.append(ref)
    if len(found) < 2:
        return None
    if links_at(between[0], found[0], mechanism) & links_at(between[1], found[1], mechanism):
        names = " and ".join(f'"{name}"' for name in between)
        complain((key,), f"found two points of one link, {names}, expected points of two; change one")
        return None
    return Line(label, (found[0], found[1]))


def links_at(name: str, ref: PointRef, mechanism: Mechanism) -> set[int]:
    """Links on which the point called ``name`` lies: both of a pin, and of a joint that slides the second."""
    pins = (joint for joint in mechanism.joints if joint.name == name and not joint.slides)
    return {ref.link} | {side.link for joint in pins for side in (joint.first, joint.second)}
