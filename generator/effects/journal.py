"""Journal: a pin with clearance, inside a round bearing or a slot of another link."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from ..effect_base.between import (
    Extent,
    Side,
    distance_from,
    edge_between,
    find_disc,
    find_extent,
    on_two_links,
    title_of,
)
from ..effect_base.contact import DEPTH, LAW_MEANS, Friction, Law, Radius, Restitution
from ..effect_base.effect import Complain, ContactPoint, Effect, Entry, Rim, Surroundings
from ..effect_base.points import choose_carrier
from ..effect_base.table import Name, Positive, Table
from ..effect_base.written_numbers import Measured
from ..mechanism.joints import PointRef
from ..mechanism.links import FROM_0_TO_1, NOT_NEGATIVE, POSITIVE, Parameter, Point
from ..mechanism.mechanism import Mechanism

if TYPE_CHECKING:
    from ..derive.gaps import Gap
    from ..derive.terms_of_effects import Let
    from ..mechanism.assembled import Assembled


class JournalTable(Table):
    """One ``[[journal]]``."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    between: list[Side] = Field(
        min_length=2,
        max_length=2,
        description="the journal's centre, and that of its bearing or the two ends of a slot's middle line: "
        '["crank.pin", "rod.eye"] or ["crank.pin", ["rocker.A", "rocker.B"]]',
    )
    radius: Radius = Field(description="the journal's radius in m, not negative")
    clearance: Annotated[Positive, Measured("m")] = Field(
        description="how far its centre may be from that of the bearing, or from the slot's middle line, in m, a "
        "positive number"
    )
    restitution: Restitution = Field(description="the coefficient of restitution, a number from 0 to 1")
    friction: Friction | None = Field(default=None, description="Coulomb's coefficient of friction, zero or positive")
    law: Law | None = Field(default=None, description=LAW_MEANS)


@dataclass(frozen=True)
class Hole:
    """What the journal is in: a bearing about ``start``, or a slot whose middle line goes from there to ``end``.

    ``title`` is what the scene says; ``ends`` are those of a slot in its link's frame.
    """

    title: str
    start: PointRef
    end: PointRef | None
    ends: tuple[Point, Point] | None


@dataclass(frozen=True)
class Journal(Effect):
    """Keeps a disc of ``radius`` about ``pin`` inside ``hole``, which is wider than it by ``clearance`` on every side.

    Impacts have the coefficient ``restitution`` (0 to 1); without ``friction`` it slides freely.
    """

    index: int
    name: str
    title_of_pin: str
    pin: PointRef
    hole: Hole
    radius: Parameter | None
    clearance: Parameter
    restitution: Parameter
    friction: Parameter | None = None

    def __post_init__(self) -> None:
        if not self.clearance.value > 0.0:
            raise ValueError(f"{self.clearance.path} is {self.clearance.value}; it must be positive")
        if self.pin.link == self.hole.start.link:
            raise ValueError(f"{self.name} is not between two links")

    def parameters(self) -> tuple[Parameter, ...]:
        found = (self.radius, self.clearance, self.restitution, self.friction)
        return tuple(parameter for parameter in found if parameter)

    def describe(self, mechanism: Mechanism) -> str:
        return f"{self.title_of_pin} in {self.hole.title}, {super().describe(mechanism)}"

    def gaps(self, let: Let) -> tuple[Gap, ...]:
        """One gap, called after the journal's centre and the table."""
        from ..derive.containing import ContainedGap
        from ..derive.vectors import symbol

        label, reach = f"journal_{self.index}", symbol(self.clearance)
        return (
            ContainedGap(
                name=self.title_of_pin,
                ground=self.name,
                label=label,
                disc=self.pin,
                other=self.hole.start,
                edge=edge_between(self.hole.ends, self.hole.end, f"span_{label}", let),
                radius=symbol(self.radius),
                thickness=-reach - symbol(self.radius),
                reach=reach,
                restitution=symbol(self.restitution),
                friction=symbol(self.friction),
            ),
        )

    def rims(self) -> tuple[Rim, ...]:
        """The journal, and the hole, whose radius is the sum of two."""
        wide = (self.radius, self.clearance) if self.radius else self.clearance
        hole = (self.hole.start, self.hole.end, wide)
        return (hole,) if self.radius is None else ((self.pin, None, self.radius), hole)

    def contact_points(self) -> tuple[ContactPoint, ...]:
        return ((self.title_of_pin, self.name, self.pin, self.radius),)

    def check_start(self, start: Assembled) -> tuple[str, ...]:
        ends = (self.hole.start, self.hole.end or self.hole.start)
        off = distance_from(complex(*start.place(self.pin)), *(complex(*start.place(end)) for end in ends))
        if off - self.clearance.value <= DEPTH:
            return ()
        middle = "the middle line of" if self.hole.end else "the middle,"
        return (
            f"the start has {self.title_of_pin} {off:.6g} m from {middle} {self.hole.title}, expected at most the "
            f"clearance, {self.clearance.value:.6g} m; change the start, or widen the clearance",
        )


def build(table: JournalTable, index: int, around: Surroundings, complain: Complain) -> Journal | None:
    """The record of a table, or ``None`` after having complained."""
    name = table.name or f"journal_{index}"
    mechanism, (first, second) = around.mechanism, table.between
    pin = find_disc(first, "the journal's", mechanism, complain)
    hole = find_extent(second, mechanism, complain)
    if pin is None or hole is None or not on_two_links(first, pin, second, hole, mechanism, complain):
        return None
    if not _check_carriers(table, mechanism, complain):
        return None
    return Journal(
        index=index,
        name=name,
        title_of_pin=title_of(first),
        pin=pin,
        hole=_hole(title_of(second), hole, mechanism),
        radius=Parameter(f"{name}.radius", f"r_journal_{index}", table.radius, NOT_NEGATIVE) if table.radius else None,
        clearance=Parameter(f"{name}.clearance", f"c_journal_{index}", table.clearance, POSITIVE),
        restitution=Parameter(f"{name}.restitution", f"e_journal_{index}", table.restitution, FROM_0_TO_1),
        friction=None
        if table.friction is None
        else Parameter(f"{name}.friction", f"f_journal_{index}", table.friction, NOT_NEGATIVE),
    )


def _hole(title: str, found: Extent, mechanism: Mechanism) -> Hole:
    start, end = found
    return Hole(title, start, end, (mechanism.point(start), mechanism.point(end)) if end else None)


def _check_carriers(table: JournalTable, mechanism: Mechanism, complain: Complain) -> bool:
    """The journal and its bearing each turn with a link that the scene names."""
    fine = True
    for index, side in enumerate(table.between):
        if isinstance(side, str) and (wrong := choose_carrier(side, mechanism)):
            complain(("between", index), wrong)
            fine = False
    return fine


ENTRY = Entry("journal", True, JournalTable, build, {})
