"""The tables of a scene file, except those of effects. Numbers are SI; angles are rad or text such as ``"10 deg"``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag

from ..effect_base.angle import Angle, read_angle
from ..effect_base.contact import LAW_MEANS, Law, OnGain
from ..effect_base.table import EndName, Name, Pair, Positive, Table, number_or_list

TAGS = ("<number>", "<list>", "<table>", "<text>")
"""Marks that pydantic puts into the place of a fault to say which alternative of a value was meant."""


def read_pose(value: object) -> object:
    """``[x, y, angle]`` with its angle in radians; anything else as it is."""
    return [*value[:2], read_angle(value[2])] if isinstance(value, list) and len(value) == 3 else value


def _list_or_table(value: Any) -> str:
    return "<table>" if isinstance(value, dict) else "<list>"


PerLink = Annotated[
    Annotated[Positive, Tag("<number>")] | Annotated[list[Positive], Tag("<list>")], Discriminator(number_or_list)
]
Along = Annotated[Annotated[float, Tag("<number>")] | Annotated[Pair, Tag("<list>")], Discriminator(number_or_list)]
Coms = Annotated[
    Annotated[float, Tag("<number>")] | Annotated[list[Along], Tag("<list>")], Discriminator(number_or_list)
]
Angles = Annotated[
    Annotated[list[Angle], Tag("<list>")] | Annotated[dict[str, Angle], Tag("<table>")], Discriminator(_list_or_table)
]
Rates = Annotated[
    Annotated[list[float], Tag("<list>")] | Annotated[dict[str, float], Tag("<table>")], Discriminator(_list_or_table)
]
Axis = Annotated[Annotated[Angle, Tag("<number>")] | Annotated[Pair, Tag("<list>")], Discriminator(number_or_list)]
Points = dict[str, Pair]
NotNegative = Annotated[float, Field(ge=0.0)]
Pose = Annotated[list[float], Field(min_length=3, max_length=3), BeforeValidator(read_pose)]


class Rods(Table):
    """What ``[loop]``, ``[chain]`` and ``[pinned]`` share: links in a row, link k from joint k to joint k+1."""

    links: int = Field(ge=1, le=2000, description="the number of links, a whole number from 1 to 2000")
    length: PerLink = Field(default=1.0, description="a length in m, a positive number or a list with one per link")
    mass: PerLink = Field(default=1.0, description="a mass in kg, a positive number or a list with one per link")
    inertia: PerLink | None = Field(
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

    span: Positive | None = Field(
        default=None, description="the distance of the two supports in m, a positive number (default: the mean length)"
    )


class FourBarsTable(Table):
    """``[four_bars]``: uprights in a row on the ground, each joined to the next by a bar."""

    count: int = Field(ge=1, le=600, description="the number of four-bars, a whole number from 1 to 600")
    length: Positive = Field(default=1.0, description="the length of every link in m, a positive number")
    mass: Positive = Field(default=1.0, description="the mass of every link in kg, a positive number")


class LinkTable(Table):
    """One ``[[link]]`` of the general form."""

    name: Name | None = Field(default=None, description="a name of letters, digits and _, beginning with a letter")
    mass: NotNegative = Field(description="the mass in kg, a positive number, or 0 for a link without mass")
    inertia: NotNegative = Field(
        description="the inertia about the centre of mass in kg m², a positive number, or 0 for a point mass"
    )
    com: Pair = Field(description="the centre of mass in the link's frame, [x, y] in m")
    points: Points = Field(min_length=1, description="named points, { A = [x, y], ... } in m, at least one")


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


Lengths = dict[str, float]


class StartTable(Table):
    """``[start]``: where the mechanism begins, and how fast."""

    MISPLACED: ClassVar[Mapping[str, str]] = {
        "gravity": "gravity is a table of its own; write [gravity]",
        "until": "the end belongs to [run]",
    }

    position: Pair | None = Field(default=None, description="where the first link's frame begins, [x, y] in m")
    velocity: Pair | None = Field(default=None, description="the velocity of that point, [x, y] in m/s")
    height: float | None = Field(default=None, description="the height of the lowest joint in m, a finite number")
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
    slides: Lengths | None = Field(
        default=None, description="how far sliding joints are along their lines in m, a table by the joint's name"
    )
    sliding_velocities: Lengths | None = Field(
        default=None, description="how fast they slide in m/s, a table by the joint's name"
    )


class RunTable(Table):
    """``[run]``: what a simulation does unless told otherwise."""

    MISPLACED: ClassVar[Mapping[str, str]] = {
        "method": "the method is an option; write ccgen run --method NAME, or simulate(method=...)",
        "step": "a fixed step is an option; write ccgen run --step H, or simulate(step=...)",
    }

    until: Positive = Field(default=10.0, description="the time at which the run ends in s, a positive number")
    rtol: Annotated[float, Field(gt=0.0, lt=1.0)] = Field(
        default=1e-9, description="the relative tolerance, a number between 0 and 1"
    )
    atol: Positive | None = Field(default=None, description="the absolute tolerance, a positive number")
    law: Law | None = Field(default=None, description=LAW_MEANS)
    on_gain: OnGain = Field(
        default="reduce", description='what becomes of an impact that would gain energy, "reduce" or "stop"'
    )
