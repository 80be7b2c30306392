"""The tables of a scene file, except those of effects: what each key is, and what its number measures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, TypeVar

from pydantic import Discriminator, Field, Tag

from ..effect_base.contact import LAW_MEANS, Law, OnGain
from ..effect_base.table import (
    Columns,
    Direction,
    EndName,
    JointName,
    Name,
    NotNegative,
    Position,
    Positive,
    Table,
    number_or_list,
    text_or_list,
)
from ..effect_base.written_numbers import Angle, Length, Measured, Whole

TAGS = ("<number>", "<list>", "<table>", "<pieces>", "<text>")
"""Marks that pydantic puts into the place of a fault to say which alternative of a value was meant."""


def _list_or_table(value: Any) -> str:
    return "<table>" if isinstance(value, dict) else "<list>"


def table_or_list(value: Any) -> str:
    """Which alternative of one table or several is meant, as pydantic's tag."""
    return "<list>" if isinstance(value, list) else "<table>"


Lengths = Annotated[
    Annotated[Positive, Measured("m"), Tag("<number>")]
    | Annotated[list[Annotated[Positive, Measured("m")]], Tag("<list>")],
    Discriminator(number_or_list),
]
Masses = Annotated[
    Annotated[Positive, Measured("kg"), Tag("<number>")]
    | Annotated[list[Annotated[Positive, Measured("kg")]], Tag("<list>")],
    Discriminator(number_or_list),
]
Inertias = Annotated[
    Annotated[Positive, Measured("kg m²"), Tag("<number>")]
    | Annotated[list[Annotated[Positive, Measured("kg m²")]], Tag("<list>")],
    Discriminator(number_or_list),
]
Along = Annotated[
    Annotated[Length, Tag("<number>")] | Annotated[Position, Tag("<list>")], Discriminator(number_or_list)
]
Coms = Annotated[
    Annotated[Length, Tag("<number>")] | Annotated[list[Along], Tag("<list>")], Discriminator(number_or_list)
]
Angles = Annotated[
    Annotated[list[Angle], Tag("<list>")] | Annotated[dict[str, Angle], Tag("<table>")], Discriminator(_list_or_table)
]
AngularVelocity = Annotated[float, Measured("rad/s")]
Rates = Annotated[
    Annotated[list[AngularVelocity], Tag("<list>")] | Annotated[dict[str, AngularVelocity], Tag("<table>")],
    Discriminator(_list_or_table),
]
Axis = Annotated[Annotated[Angle, Tag("<number>")] | Annotated[Direction, Tag("<list>")], Discriminator(number_or_list)]
Points = dict[str, Position]
Speed = Annotated[float, Measured("m/s")]
Pose = Annotated[list[float], Field(min_length=3, max_length=3), Columns(Length, Length, Angle)]
Polar = Annotated[list[float], Field(min_length=2, max_length=2), Columns(Length, Angle)]
"""A radius (m) and an angle (rad)."""
Spot = Annotated[Annotated[str, Tag("<text>")] | Annotated[Position, Tag("<list>")], Discriminator(text_or_list)]
"""A point of the link by its name, or a place in its frame."""
MOST_CORNERS = 500
"""Corners of one plate: each edge is compared with all others."""
T = TypeVar("T")
OneOrMore = Annotated[
    Annotated[T, Tag("<table>")] | Annotated[list[T], Field(min_length=1), Tag("<list>")],
    Discriminator(table_or_list),
]


class Rods(Table):
    """What ``[loop]``, ``[chain]`` and ``[pinned]`` share: links in a row, link k from joint k to joint k+1."""

    links: Whole = Field(ge=1, le=2000, description="the number of links, a whole number from 1 to 2000")
    length: Lengths = Field(default=1.0, description="a length in m, a positive number or a list with one per link")
    mass: Masses = Field(default=1.0, description="a mass in kg, a positive number or a list with one per link")
    inertia: Inertias | None = Field(
        default=None,
        description="an inertia about the centre of mass in kg m², a positive number or a list with one per link",
    )
    com: Coms | None = Field(
        default=None,
        description="the centre of mass in m: a distance along the link, [x, y], or a list with one of these per link",
    )


class LoopTable(Rods):
    """``[loop]``: a closed chain that floats in the plane."""


class ChainTable(Rods):
    """``[chain]``: an open chain, free in the plane or with its first end on the ground."""

    hinged: bool = Field(default=False, description="true or false: whether the first end is pinned to the ground")


class PinnedTable(Rods):
    """``[pinned]``: a chain with both ends on the ground."""

    span: Annotated[Positive, Measured("m")] | None = Field(
        default=None, description="the distance of the two supports in m, a positive number (default: the mean length)"
    )


class FourBarsTable(Table):
    """``[four_bars]``: uprights in a row on the ground, each joined to the next by a bar."""

    count: Whole = Field(ge=1, le=600, description="the number of four-bars, a whole number from 1 to 600")
    length: Annotated[Positive, Measured("m")] = Field(
        default=1.0, description="the length of every link in m, a positive number"
    )
    mass: Annotated[Positive, Measured("kg")] = Field(
        default=1.0, description="the mass of every link in kg, a positive number"
    )


class Body(Table):
    """What the uniform bodies of a link share: how heavy they are."""

    ONE_OF: ClassVar[tuple[str, ...]] = ("mass", "mass_per_area", "density")

    mass: Annotated[Positive, Measured("kg")] | None = Field(
        default=None, description="a mass in kg, a positive number"
    )
    mass_per_area: Annotated[Positive, Measured("kg/m²")] | None = Field(
        default=None, description="a mass per area in kg/m², a positive number"
    )
    density: Annotated[Positive, Measured("kg/m³")] | None = Field(
        default=None, description="a density in kg/m³, a positive number, with a thickness"
    )
    thickness: Annotated[Positive, Measured("m")] | None = Field(
        default=None, description="how thick it is across the plane in m, a positive number, with a density"
    )


class RodTable(Body):
    """``rod`` of a ``[[link]]``: a uniform rod, thin unless it has a width."""

    ONE_OF: ClassVar[tuple[str, ...]] = ("mass", "mass_per_length", "mass_per_area", "density")

    mass_per_length: Annotated[Positive, Measured("kg/m")] | None = Field(
        default=None, description="a mass per length in kg/m, a positive number"
    )
    between: Annotated[list[Spot], Field(min_length=2, max_length=2)] | None = Field(
        default=None, description='its two ends, points of the link or [x, y] in m, ["A", "B"]'
    )
    width: Annotated[Positive, Measured("m")] | None = Field(
        default=None, description="how wide it is in the plane in m, a positive number"
    )


class PlateTable(Body):
    """``plate`` of a ``[[link]]``: a uniform polygon."""

    corners: Annotated[list[Spot], Field(min_length=3, max_length=MOST_CORNERS)] | None = Field(
        default=None,
        description=f"its corners in order round it, 3 to {MOST_CORNERS} points of the link or [x, y] in m, "
        '["A", "B", "C"]',
    )


class DiscTable(Body):
    """``disc`` of a ``[[link]]``: a uniform disc, or a ring."""

    radius: Annotated[Positive, Measured("m")] = Field(description="the radius in m, a positive number")
    inner_radius: Annotated[Positive, Measured("m")] | None = Field(
        default=None, description="the radius of the hole in m, a positive number below the radius"
    )
    centre: Spot | None = Field(default=None, description="its centre, a point of the link or [x, y] in m")


class PointMassTable(Table):
    """``point_mass`` of a ``[[link]]``: a mass in one place."""

    mass: Annotated[Positive, Measured("kg")] = Field(description="a mass in kg, a positive number")
    at: Spot = Field(description="where it is, a point of the link or [x, y] in m")


class AroundTable(Table):
    """``around`` of a ``[[link]]``: points in equal steps round a circle, as of a wheel's teeth."""

    count: Whole = Field(
        ge=1,
        le=MOST_CORNERS,
        description=f"how often the points stand round the circle, a whole number to {MOST_CORNERS}",
    )
    points: dict[Name, Polar] = Field(
        min_length=1,
        description="the points of the first step, { A = [radius in m, angle in rad], ... }, called A0, A1, ...",
    )
    centre: Spot | None = Field(
        default=None, description="the centre of the circle, a point of the link or [x, y] in m (default: [0, 0])"
    )
    clockwise: bool = Field(default=False, description="true or false: whether the steps go clockwise")


class LinkTable(Table):
    """One ``[[link]]`` of the general form."""

    MISPLACED: ClassVar[Mapping[str, str]] = {
        **dict.fromkeys(("length", "between"), "a rod lies between points of the link; write rod = { mass = ... }"),
        **dict.fromkeys(("density", "thickness", "corners"), "it is a plate's; write plate = { density = ..., ... }"),
        **dict.fromkeys(("radius", "centre"), "it is a disc's; write disc = { mass = ..., radius = ... }"),
    }

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    mass: Annotated[NotNegative, Measured("kg")] | None = Field(
        default=None, description="the mass in kg, a positive number, or 0 for a link without mass"
    )
    inertia: Annotated[NotNegative, Measured("kg m²")] | None = Field(
        default=None,
        description="the inertia about the centre of mass in kg m², a positive number, or 0 for a point mass",
    )
    com: Spot | None = Field(
        default=None, description="the centre of mass, a point of the link or [x, y] in m in its frame"
    )
    points: Points = Field(min_length=1, description="named points, { A = [x, y], ... } in m, at least one")
    outline: Annotated[list[Spot], Field(max_length=MOST_CORNERS)] | None = Field(
        default=None,
        description='what is drawn of it, its points or [x, y] in m in their order, ["A", "B", [0.1, 0.2]], or [] for '
        "nothing",
    )
    around: OneOrMore[AroundTable] | None = Field(
        default=None, description="points round a circle, { count = ..., points = { ... } }, or a list of such tables"
    )
    free: bool = Field(
        default=False, description="true or false: whether it and what hangs on it move freely beside what is held"
    )
    rod: OneOrMore[RodTable] | None = Field(
        default=None, description="a uniform rod between two points, { mass = ... }, or a list of them"
    )
    plate: OneOrMore[PlateTable] | None = Field(
        default=None, description="a uniform plate with corners in points, { mass = ... }, or a list of them"
    )
    disc: OneOrMore[DiscTable] | None = Field(
        default=None, description="a uniform disc about a point, { mass = ..., radius = ... }, or a list of them"
    )
    point_mass: OneOrMore[PointMassTable] | None = Field(
        default=None, description='a mass in one place, { mass = ..., at = "A" }, or a list of them'
    )


class GroundLinkTable(Table):
    """``[ground_link]``: the points of the ground that joints can name."""

    points: Points = Field(description="named points of the ground, { O = [x, y], ... } in m")


class JointTable(Table):
    """One ``[[joint]]`` of the general form."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    type: Literal["revolute", "prismatic", "weld", "pin-in-slot"] = Field(
        default="revolute", description='the kind of joint, "revolute", "prismatic", "weld" or "pin-in-slot"'
    )
    between: list[EndName] = Field(
        min_length=2, max_length=2, description='the two points that it joins, ["link.point", "link.point"]'
    )
    axis: Axis | None = Field(
        default=None,
        description='the direction of the line in the first link\'s frame, [x, y], an angle in rad or as "30 deg"',
    )
    angle: Angle | None = Field(
        default=None, description='the angle of the second link against the first in rad, or a text such as "30 deg"'
    )


class StartTable(Table):
    """``[start]``: where the mechanism begins, and how fast."""

    MISPLACED: ClassVar[Mapping[str, str]] = {
        "gravity": "gravity is a table of its own; write [gravity]",
        "until": "the end belongs to [run]",
    }

    position: Position | None = Field(default=None, description="where the first link's frame begins, [x, y] in m")
    velocity: Annotated[list[Speed], Field(min_length=2, max_length=2)] | None = Field(
        default=None, description="the velocity of that point, [x, y] in m/s"
    )
    height: Length | None = Field(default=None, description="the height of the lowest joint in m, a finite number")
    tilt: Angle = Field(default=0.0, description='an angle in rad, or a text such as "10 deg" or "0.2 rad"')
    angles: Angles | None = Field(
        default=None,
        description='absolute angles of the links in rad or as "10 deg", a list with one per link or a table by name',
    )
    joints: Points | None = Field(
        default=None, description="where joints are roughly, a table by name, { A = [x, y], ... } in m"
    )
    poses: dict[str, Pose] | None = Field(
        default=None,
        description='where frames of links are roughly, a table by name, { crank = [x, y, "30 deg"], ... } in m',
    )
    angular_velocities: Rates | None = Field(
        default=None, description="absolute angular velocities in rad/s, a list with one per link or a table by name"
    )
    slides: dict[str, Length] | None = Field(
        default=None, description="how far sliding joints are along their lines in m, a table by the joint's name"
    )
    sliding_velocities: dict[str, Speed] | None = Field(
        default=None, description="how fast they slide in m/s, a table by the joint's name"
    )
    open: list[JointName] | None = Field(
        default=None, description='joints of [[hold]] that do not hold at the start, such as ["gripper"]'
    )
    off: list[str] | None = Field(
        default=None, description='effects that an [[event]] switches and that are off at the start, ["left_sole"]'
    )


class RunTable(Table):
    """``[run]``: what a simulation does unless told otherwise."""

    MISPLACED: ClassVar[Mapping[str, str]] = {
        "method": "the method is an option; write ccgen run --method NAME, or simulate(method=...)",
        "step": "a fixed step is an option; write ccgen run --step H, or simulate(step=...)",
    }

    until: Annotated[Positive, Measured("s")] = Field(
        default=10.0, description="the time at which the run ends in s, a positive number"
    )
    rtol: Annotated[float, Field(gt=0.0, lt=1.0), Measured("1")] = Field(
        default=1e-9, description="the relative tolerance, a number between 0 and 1"
    )
    atol: Annotated[Positive, Measured("1")] | None = Field(
        default=None, description="the absolute tolerance, a positive number"
    )
    law: Law | None = Field(default=None, description=LAW_MEANS)
    on_gain: OnGain = Field(
        default="reduce", description='what becomes of an impact that would gain energy, "reduce" or "stop"'
    )


class OutputTable(Table):
    """``[output]``: what ``ccgen run`` draws and writes of a run, by name."""

    MISPLACED: ClassVar[Mapping[str, str]] = {
        "until": "the end belongs to [run]",
        "names": "write plot = [...] for what is drawn, table = [...] for what is written as CSV",
    }

    plot: list[str] = Field(
        default=[], description='names of what is drawn over time, ["crank.angle", "coupler.tip.vy"]'
    )
    table: list[str] = Field(default=[], description='names of what is written as CSV, ["crank.angle", "pin.force"]')
    times: Annotated[int, Field(ge=2, le=1_000_000), Measured("1")] | None = Field(
        default=None, description="beside table: at how many even times, a whole number from 2 to 1000000"
    )


class LetTable(Table):
    """``[let]``: names of numbers. They are read one by the other (``let.py``), not all by this schema."""

    NAMED: ClassVar[Any] = float
