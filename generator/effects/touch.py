"""Touch: a disc on one link that touches a disc, or an edge, of another: only pairs that a scene lists."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import Discriminator, Field, Tag

from ..effect_base.between import Side, distance_from, edge_between, find_disc, find_extent, on_two_links, title_of
from ..effect_base.contact import DEPTH, LAW_MEANS, Friction, Law, Radius, Restitution
from ..effect_base.effect import Complain, ContactPoint, Effect, Entry, Place, Rim, Surroundings
from ..effect_base.points import choose_carrier
from ..effect_base.table import Name, Table, number_or_list
from ..mechanism.joints import PointRef
from ..mechanism.links import FROM_0_TO_1, NOT_NEGATIVE, Parameter, Point
from ..mechanism.mechanism import Mechanism

if TYPE_CHECKING:
    from ..derive.gaps import Gap
    from ..derive.terms_of_effects import Let


class TouchTable(Table):
    """One ``[[touch]]``."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    between: list[Side] = Field(
        min_length=2,
        max_length=2,
        description='a disc\'s centre, and another one or an edge: ["ball.C", "other.C"], ["ball.C", "plank"] or '
        '["ball.C", ["plank.A", "plank.B"]]',
    )
    radius: Annotated[
        Annotated[Radius, Tag("<number>")]
        | Annotated[Annotated[list[Radius], Field(min_length=2, max_length=2)], Tag("<list>")],
        Discriminator(number_or_list),
    ] = Field(
        description="the radius of the discs in m, not negative, or a list of two: of an edge, half of its thickness"
    )
    restitution: Restitution = Field(description="the coefficient of restitution, a number from 0 to 1")
    friction: Friction | None = Field(default=None, description="Coulomb's coefficient of friction, a positive number")
    law: Law | None = Field(default=None, description=LAW_MEANS)


@dataclass(frozen=True)
class Body:
    """One side of a touch: a disc about ``start``, or an edge from there to ``end``; ``title`` is what the scene says.

    ``radius`` is the disc's, or half of what the edge is thick (m); ``None`` is zero.
    """

    title: str
    start: PointRef
    end: PointRef | None
    radius: Parameter | None

    @property
    def size(self) -> float:
        return self.radius.value if self.radius else 0.0


@dataclass(frozen=True)
class Touch(Effect):
    """Keeps ``disc`` out of ``other``, with ``restitution`` (0 to 1) and ``friction``.

    ``ends`` are those of an edge in its link's frame, ``None`` where ``other`` is a disc.
    """

    index: int
    name: str
    disc: Body
    other: Body
    ends: tuple[Point, Point] | None
    restitution: Parameter
    friction: Parameter | None = None

    def __post_init__(self) -> None:
        if not self.disc.size + self.other.size > 0.0:
            raise ValueError(f"{self.name} has radii without a positive sum")
        if self.disc.end or self.disc.start.link == self.other.start.link:
            raise ValueError(f"{self.name} is not between a disc and another link")

    def parameters(self) -> tuple[Parameter, ...]:
        radii = dict.fromkeys(body.radius for body in (self.disc, self.other) if body.radius)
        return (*radii, self.restitution, *((self.friction,) if self.friction else ()))

    def describe(self, mechanism: Mechanism) -> str:
        return f"{self.disc.title} against {self.other.title}, {super().describe(mechanism)}"

    def gaps(self, let: Let) -> tuple[Gap, ...]:
        """One gap, called after the disc's centre and the touch."""
        from ..derive.touching import TouchGap
        from ..derive.vectors import symbol

        disc, other = self.disc, self.other
        return (
            TouchGap(
                name=disc.title,
                ground=self.name,
                label=f"touch_{self.index}",
                disc=disc.start,
                other=other.start,
                edge=edge_between(self.ends, other.end, f"span_touch_{self.index}", let),
                radius=symbol(disc.radius),
                thickness=symbol(other.radius),
                restitution=symbol(self.restitution),
                friction=symbol(self.friction),
            ),
        )

    def rims(self) -> tuple[Rim, ...]:
        bodies = (self.disc, self.other)
        return tuple((body.start, body.end, body.radius) for body in bodies if body.end or body.radius)

    def contact_points(self) -> tuple[ContactPoint, ...]:
        discs = (self.disc, self.other) if self.other.end is None else (self.disc,)
        return tuple((body.title, self.name, body.start, body.radius) for body in discs)

    def check_start(self, place: Place) -> tuple[str, ...]:
        centre, start = place(self.disc.start), place(self.other.start)
        away = distance_from(centre, start, place(self.other.end) if self.other.end else start)
        depth = self.disc.size + self.other.size - away
        if depth <= DEPTH:
            return ()
        return (
            f"the start has {self.disc.title} inside {self.other.title} by {depth:.6g} m, expected at or off its "
            "surface; change the start or the radii",
        )


def build(table: TouchTable, index: int, around: Surroundings, complain: Complain) -> Touch | None:
    """The record of a table, or ``None`` after having complained."""
    name = table.name or f"touch_{index}"
    mechanism, (first, second) = around.mechanism, table.between
    disc = find_disc(first, "the disc's", mechanism, complain)
    other = find_extent(second, mechanism, complain)
    apart = disc is not None and other is not None and on_two_links(first, disc, second, other, mechanism, complain)
    radii = _radii(table, name, index, other is not None and other[1] is not None, complain)
    if disc is None or other is None or not apart or radii is None:
        return None
    if not _check_carriers(table, radii, mechanism, complain):
        return None
    return Touch(
        index=index,
        name=name,
        disc=Body(title_of(first), disc, None, radii[0]),
        other=Body(title_of(second), *other, radii[1]),
        ends=(mechanism.point(other[0]), mechanism.point(other[1])) if other[1] else None,
        restitution=Parameter(f"{name}.restitution", f"et_{index}", table.restitution, FROM_0_TO_1),
        friction=None
        if table.friction is None
        else Parameter(f"{name}.friction", f"ft_{index}", table.friction, NOT_NEGATIVE),
    )


def _check_carriers(
    table: TouchTable, radii: tuple[Parameter | None, Parameter | None], mechanism: Mechanism, complain: Complain
) -> bool:
    """Every disc turns with a link that the scene names."""
    fine = True
    for index, (side, radius) in enumerate(zip(table.between, radii, strict=True)):
        if radius and isinstance(side, str) and (wrong := choose_carrier(side, mechanism)):
            complain(("between", index), wrong)
            fine = False
    return fine


def _radii(
    table: TouchTable, name: str, index: int, edge: bool, complain: Complain
) -> tuple[Parameter | None, Parameter | None] | None:
    """Radii of both sides: one parameter for two discs if the scene gives one number, which an edge does not share."""
    given = table.radius
    one, other = given if isinstance(given, list) else (given, 0.0 if edge else given)
    if not one + other > 0.0:
        complain(
            ("radius",),
            f"found radii with the sum {one + other:.6g}, expected a positive one, because points have no common "
            "normal; give one of them a radius",
        )
        return None
    if not isinstance(given, list):
        both = Parameter(f"{name}.radius", f"rt_{index}", one, NOT_NEGATIVE)
        return both, None if edge else both
    paths = [f"{name}.radius.{title_of(side)}" for side in table.between]
    return (
        Parameter(paths[0], f"rt_{index}_0", one, NOT_NEGATIVE) if one else None,
        Parameter(paths[1], f"rt_{index}_1", other, NOT_NEGATIVE) if other else None,
    )


ENTRY = Entry("touch", True, TouchTable, build)
