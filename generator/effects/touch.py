"""Touch: a disc on one link that touches a disc, an edge or a polygon of another, or two polygons: only what a scene
lists."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated

from pydantic import Discriminator, Field, Tag

from ..effect_base.between import corners_of, points_of, shown, title_of
from ..effect_base.contact import DEPTH, LAW_MEANS, Friction, Law, Restitution
from ..effect_base.effect import Complain, ContactPoint, Effect, Entry, Rim, Surroundings
from ..effect_base.line import links_at
from ..effect_base.pair import Pair, PairTable, check_carriers, read_pair, read_radii
from ..effect_base.points import find_point, written
from ..effect_base.table import PointName, text_or_list
from ..mechanism.links import FROM_0_TO_1, NOT_NEGATIVE, Parameter
from ..mechanism.mechanism import Mechanism
from .outline_touch import Outline, OutlineTouch, fault_of

if TYPE_CHECKING:
    from ..derive.gaps import Gap
    from ..derive.terms_of_effects import Let
    from ..mechanism.assembled import Assembled


Corners = Annotated[list[PointName], Field(min_length=2, max_length=501)]
Side = Annotated[Annotated[PointName, Tag("<text>")] | Annotated[Corners, Tag("<list>")], Discriminator(text_or_list)]


class TouchTable(PairTable):
    """One ``[[touch]]``."""

    between: list[Side] = Field(
        min_length=2,
        max_length=2,
        description='a disc\'s centre, and another one or an edge: ["ball.C", "other.C"], ["ball.C", "plank"] or '
        '["ball.C", ["plank.A", "plank.B"]]; more points are a line, or a polygon where the last is the first again, '
        "and a link is its outline",
    )
    restitution: Restitution = Field(description="the coefficient of restitution, a number from 0 to 1")
    friction: Friction | None = Field(default=None, description="Coulomb's coefficient of friction, zero or positive")
    law: Law | None = Field(default=None, description=LAW_MEANS)


@dataclass(frozen=True)
class Touch(Effect):
    """Keeps the two of a ``pair`` out of each other, with ``restitution`` (0 to 1) and ``friction``."""

    index: int
    name: str
    pair: Pair
    restitution: Parameter
    friction: Parameter | None = None

    def parameters(self) -> tuple[Parameter, ...]:
        return (*self.pair.parameters(), self.restitution, *((self.friction,) if self.friction else ()))

    def describe(self, mechanism: Mechanism) -> str:
        return f"{self.pair.title}, {super().describe(mechanism)}"

    def gaps(self, let: Let) -> tuple[Gap, ...]:
        """One gap, called after the disc's centre and the touch."""
        from ..derive.vectors import symbol

        label = f"touch_{self.index}"
        return (self.pair.gap(let, self.name, label, symbol(self.restitution), symbol(self.friction)),)

    def rims(self) -> tuple[Rim, ...]:
        return self.pair.rims()

    def contact_points(self) -> tuple[ContactPoint, ...]:
        disc, other = self.pair.disc, self.pair.other
        discs = (disc, other) if other.end is None else (disc,)
        return tuple((body.title, self.name, body.start, body.radius) for body in discs)

    def check_start(self, start: Assembled) -> tuple[str, ...]:
        depth = self.pair.depth(start)
        if depth <= DEPTH:
            return ()
        return (
            f"the start has {self.pair.disc.title} inside {self.pair.other.title} by {depth:.6g} m, expected at or off "
            "its surface; change the start or the radii",
        )


def build(table: TouchTable, index: int, around: Surroundings, complain: Complain) -> Touch | OutlineTouch | None:
    """The record of a table, or ``None`` after having complained."""
    for number, side in enumerate(table.between):
        if isinstance(side, str) and _is_both(side, around.mechanism):
            message = f'found "{side}", a joint and a link with an outline, expected one of them; rename one'
            complain(("between", number), message)
            return None
    if _has_outlines(table.between, around.mechanism):
        return _build_outlines(table, index, around.mechanism, complain)
    name = table.name or f"touch_{index}"
    pair = read_pair(table, name, f"rt_{index}", around.mechanism, complain)
    if pair is None:
        return None
    return Touch(
        index=index,
        name=name,
        pair=pair,
        restitution=Parameter(f"{name}.restitution", f"et_{index}", table.restitution, FROM_0_TO_1),
        friction=None
        if table.friction is None
        else Parameter(f"{name}.friction", f"ft_{index}", table.friction, NOT_NEGATIVE),
    )


def _is_both(side: str, mechanism: Mechanism) -> bool:
    """Whether the name is one of a joint and of a link with an outline."""
    return side in mechanism.corners and find_point(side, mechanism)[0] is not None


def _has_outlines(between: list[str | list[str]], mechanism: Mechanism) -> bool:
    """Whether a side has more than two points, or both have two."""
    counts = [_count(side, mechanism) for side in between]
    return max(counts) > 2 or min(counts) == 2


def _count(side: str | list[str], mechanism: Mechanism) -> int:
    """How many points a side has: a text is one, or names a link."""
    if isinstance(side, list):
        return len(side)
    if find_point(side, mechanism)[0] is not None:
        return 1
    return len(corners_of(side, mechanism)) or len(points_of(side, mechanism)) or 1


def _build_outlines(table: TouchTable, index: int, mechanism: Mechanism, complain: Complain) -> OutlineTouch | None:
    """The record of a table one of whose sides is an outline."""
    name = table.name or f"touch_{index}"
    bodies = [_outline(side, number, mechanism, complain) for number, side in enumerate(table.between)]
    first, second = bodies
    if first and len(first.corners) > 1 and second and len(second.corners) == 1:
        complain(("between", 1), f"found {shown(table.between[1])}, expected the disc's centre first; swap the sides")
        return None
    apart = None not in bodies and _outlines_apart(table, bodies, mechanism, complain)
    radii = read_radii(table, name, f"rt_{index}", True, mechanism, complain)
    if first is None or second is None or not apart or radii is None:
        return None
    if not check_carriers(table, radii, mechanism, complain):
        return None
    return OutlineTouch(
        index=index,
        name=name,
        first=replace(first, radius=radii[0]),
        second=replace(second, radius=radii[1]),
        restitution=Parameter(f"{name}.restitution", f"et_{index}", table.restitution, FROM_0_TO_1),
        friction=None
        if table.friction is None
        else Parameter(f"{name}.friction", f"ft_{index}", table.friction, NOT_NEGATIVE),
    )


def _outline(side: str | list[str], number: int, mechanism: Mechanism, complain: Complain) -> Outline | None:
    """A side of outlines: a disc's centre, all points of a list, or the outline of a link."""
    names = side if isinstance(side, list) else [side]
    if isinstance(side, str) and find_point(side, mechanism)[0] is None and (points := points_of(side, mechanism)):
        names = corners_of(side, mechanism)
        names += names[:1] if len(names) > 2 else []
        if not names:
            outline = "" if side == "ground" else "give it an outline of its points, or "
            advice = f"it has the points {', '.join(points)}; {outline}list those that are its corners, in order"
            expected = "a point, a list of points of a link, or a link with an outline"
            complain(("between", number), f'found "{side}", expected {expected}; {advice}')
            return None
    closed = len(names) > 2 and names[0] == names[-1]
    names = names[:-1] if closed else names
    found = [find_point(name, mechanism) for name in names]
    wrong = next((f"{name}: {fault}" for name, (ref, fault) in zip(names, found, strict=True) if ref is None), "")
    corners = tuple(ref for ref, _ in found if ref is not None)
    if not wrong and len({corner.link for corner in corners}) > 1:
        wrong = "they are on different links"
    places = [complex(*mechanism.point(corner).values()) for corner in corners]
    if not wrong and len(corners) > 1:
        wrong = fault_of(names, places, closed)
    if wrong:
        expected = (
            "points of one link in a row, round a polygon or along a line" if len(names) > 1 else "a disc's centre"
        )
        complain(("between", number), f"found {shown(side)}, expected {expected}; {wrong}")
        return None
    written_as = names[0] if len(corners) == 1 else ""
    return Outline(
        title_of(side),
        corners,
        tuple(written_as or written(corner, mechanism) for corner in corners),
        tuple(mechanism.point(corner) for corner in corners),
        closed,
        None,
    )


def _outlines_apart(
    table: TouchTable, bodies: Sequence[Outline | None], mechanism: Mechanism, complain: Complain
) -> bool:
    """Whether the two sides are on two links."""
    on = [
        links_at(side, body.corners[0], mechanism)
        if isinstance(side, str) and len(body.corners) == 1
        else {body.corners[0].link}
        for side, body in zip(table.between, bodies, strict=True)
        if body is not None
    ]
    shared = on[0] & on[1]
    if shared:
        names = " and ".join(sorted(map(mechanism.link_name, shared)))
        complain(("between",), f"found two places on {names}, expected places on two links; change one")
    return not shared


ENTRY = Entry("touch", True, TouchTable, build, {})
