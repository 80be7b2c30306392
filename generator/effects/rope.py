"""Rope: points that may be no farther apart, straight or over eyelets, than it is long."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from ..effect_base.contact import DEPTH, LAW_MEANS, Law, Restitution
from ..effect_base.effect import Complain, ContactPoint, Drawn, Effect, Entry, Surroundings
from ..effect_base.line import NO_DIRECTION, links_at
from ..effect_base.points import find_point
from ..effect_base.table import Name, PointName, Positive, Table
from ..effect_base.written_numbers import Measured
from ..mechanism.assembled import Assembled
from ..mechanism.joints import PointRef
from ..mechanism.links import FROM_0_TO_1, POSITIVE, Parameter, Point
from ..mechanism.mechanism import Mechanism

if TYPE_CHECKING:
    from sympy import Expr

    from ..derive.gaps import Gap
    from ..derive.terms_of_effects import Let

DIGITS = 12
"""To so many digits a length is taken from the start: fewer than an assembled start has on any machine."""


MOST_EYELETS = 100
"""Equations are written out for each piece of a rope."""


class RopeTable(Table):
    """One ``[[rope]]``."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    between: list[PointName] = Field(
        min_length=2, max_length=2, description='the two points that it joins, ["link.point", "ground.point"]'
    )
    over: list[PointName] = Field(
        default=[],
        max_length=MOST_EYELETS,
        description='the eyelets that it runs over, in order from the first point to the second, ["ground.P"], at most '
        f"{MOST_EYELETS}",
    )
    length: Annotated[Positive, Measured("m")] | None = Field(
        default=None, description="its length in m, a positive number; unless given that of its way at the start"
    )
    restitution: Restitution = Field(description="the coefficient of restitution, a number from 0 to 1")
    law: Law | None = Field(default=None, description=LAW_MEANS)


Written = tuple[tuple[str, int], str]
"""Where a point stands in the table, and how."""


@dataclass(frozen=True)
class Rope(Effect):
    """Keeps the way along its ``points`` from being longer than ``length`` (m), with ``restitution`` (0 to 1).

    ``titles`` are the points as the scene names them, ``places`` where they are in the frames of their links. Without a
    ``length`` it is as long as its way at the start: see :meth:`settled`.
    """

    index: int
    name: str
    titles: tuple[str, ...]
    points: tuple[PointRef, ...]
    places: tuple[Point, ...]
    length: Parameter | None
    restitution: Parameter

    def parameters(self) -> tuple[Parameter, ...]:
        return (*((self.length,) if self.length else ()), self.restitution)

    def describe(self, mechanism: Mechanism) -> str:
        return f"{' - '.join(self.titles)}, {super().describe(mechanism)}"

    def settled(self, start: Assembled) -> Rope:
        """Its length, where the scene leaves it open, is that of its way at the start."""
        if self.length:
            return self
        length = float(f"{self._way(start):.{DIGITS}g}")
        return replace(self, length=_length(self.name, self.index, length)) if length > 0.0 else self

    def gaps(self, let: Let) -> tuple[Gap, ...]:
        """One gap, called after the rope's last point and its name."""
        from ..derive.roping import RopeGap
        from ..derive.vectors import symbol

        moving = tuple((one, other) for one, other in pairwise(self.points) if one.link != other.link)
        return (
            RopeGap(
                name=self.titles[-1],
                ground=self.name,
                label=f"rope_{self.index}",
                pieces=moving,
                fixed=self._fixed(let),
                length=symbol(self.length),
                restitution=symbol(self.restitution),
            ),
        )

    def _fixed(self, let: Let) -> Expr:
        """The sum of its pieces between points of one link, which depends on parameters alone."""
        from sympy import Add, S, sqrt

        from ..derive.vectors import dot, less, local

        spans = [
            less(local(b), local(a))
            for (a, b), (one, other) in zip(pairwise(self.places), pairwise(self.points), strict=True)
            if one.link == other.link
        ]
        return let(f"fixed_rope_{self.index}", Add(*(sqrt(dot(span, span)) for span in spans))) if spans else S.Zero

    def ropes(self) -> tuple[Drawn, ...]:
        return ((self.name, self.points),)

    def contact_points(self) -> tuple[ContactPoint, ...]:
        return ((self.titles[-1], self.name, self.points[-1], None),)

    def check_start(self, start: Assembled) -> tuple[str, ...]:
        way = self._way(start)
        if self.length is None and len(self.points) == 2 and way <= NO_DIRECTION:
            both = " and ".join(self.titles)
            return (
                f"the start has {both} at the same place, expected a length of {self.name} beside that; add length",
            )
        faults = [
            f"the start has {a} and {b} at the same place, where that piece of {self.name} has no direction; "
            "change the start"
            for (a, b), (one, other) in zip(pairwise(self.titles), pairwise(self.points), strict=True)
            if len(self.points) > 2 and _apart(start.place(one), start.place(other)) <= NO_DIRECTION
        ]
        if self.length and way - self.length.value > DEPTH:
            along = " - ".join(self.titles)
            faults.append(
                f"the start has {way:.6g} m along {along}, expected at most the length of {self.name}, "
                f"{self.length.value:.6g} m; change the start, or make it longer"
            )
        return tuple(faults)

    def _way(self, start: Assembled) -> float:
        """How long its way is at the start (m)."""
        return math.fsum(_apart(one, other) for one, other in pairwise(map(start.place, self.points)))


def _apart(one: Sequence[float], other: Sequence[float]) -> float:
    return math.hypot(other[0] - one[0], other[1] - one[1])


def _length(name: str, index: int, value: float) -> Parameter:
    return Parameter(f"{name}.length", f"L_rope_{index}", value, POSITIVE)


def build(table: RopeTable, index: int, around: Surroundings, complain: Complain) -> Rope | None:
    """The record of a table, or ``None`` after having complained."""
    name, mechanism = table.name or f"rope_{index}", around.mechanism
    way = _written(table)
    found = _points(way, mechanism, complain)
    if found is None or not _check_way(way, found, mechanism, complain):
        return None
    return Rope(
        index=index,
        name=name,
        titles=tuple(title for _, title in way),
        points=found,
        places=tuple(map(mechanism.point, found)),
        length=None if table.length is None else _length(name, index, table.length),
        restitution=Parameter(f"{name}.restitution", f"e_rope_{index}", table.restitution, FROM_0_TO_1),
    )


def _written(table: RopeTable) -> tuple[Written, ...]:
    """Its points in order, each with where it stands in the table."""
    first, last = table.between
    eyelets = tuple((("over", k), title) for k, title in enumerate(table.over))
    return ((("between", 0), first), *eyelets, (("between", 1), last))


def _points(way: Sequence[Written], mechanism: Mechanism, complain: Complain) -> tuple[PointRef, ...] | None:
    """The points of a rope; ``None`` after a complaint of each that is not known."""
    found = []
    for key, title in way:
        ref, wrong = find_point(title, mechanism)
        if ref is None:
            complain(key, f'found "{title}", expected a joint or link.point; {wrong}')
        else:
            found.append(ref)
    return tuple(found) if len(found) == len(way) else None


def _check_way(way: Sequence[Written], points: Sequence[PointRef], mechanism: Mechanism, complain: Complain) -> bool:
    """No point twice in a row, and a piece at least whose length can change."""
    fine = True
    if len(way) > 2:
        for (_, before), (key, title) in pairwise(way):
            if title == before:
                complain(key, f'found "{title}" twice in a row, expected another point; remove one of them')
                fine = False
    links = [links_at(title, ref, mechanism) for (_, title), ref in zip(way, points, strict=True)]
    if fine and all(one & other for one, other in pairwise(links)):
        names = ", ".join(f'"{title}"' for _, title in way)
        message = f"found {names}, neighbours all on one link, expected points of two links next to each other"
        complain(("between",), f"{message}; change one")
        return False
    return fine


ENTRY = Entry("rope", True, RopeTable, build, {})
