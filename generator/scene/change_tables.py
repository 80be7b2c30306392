"""The tables ``[[release]]`` and ``[[hold]]``: joints that let go and take hold while a mechanism moves."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from ..effect_base.table import JointName, LinkName, NotNegative, PointName, Positive, Table
from ..effect_base.written_numbers import Measured


class WhenTable(Table):
    """``when`` of such a table: what is watched, and the side on which the change comes."""

    ONE_OF: ClassVar[tuple[str, ...]] = ("angle", "direction", "slide", "height", "distance")

    angle: JointName | None = Field(
        default=None, description="a joint whose angle is watched, second link against first"
    )
    direction: LinkName | None = Field(default=None, description="a link whose angle against the x axis is watched")
    slide: JointName | None = Field(default=None, description="a sliding joint whose length along its line is watched")
    height: PointName | None = Field(default=None, description="a point whose y is watched")
    distance: Annotated[list[PointName], Field(min_length=2, max_length=2)] | None = Field(
        default=None, description='two points whose distance is watched, ["link.point", "link.point"]'
    )
    above: Annotated[float, Measured("rad", "m")] | None = Field(
        default=None, description="the value above which the change comes, in rad or m, a finite number"
    )
    below: Annotated[float, Measured("rad", "m")] | None = Field(
        default=None, description="the value below which the change comes, in rad or m, a finite number"
    )


class ReleaseTable(Table):
    """One ``[[release]]``."""

    joint: JointName = Field(description="the name of the joint that lets go")
    at: Annotated[NotNegative, Measured("s")] | None = Field(
        default=None, description="the time at which it lets go in s, a number that is not negative"
    )
    when: WhenTable | None = Field(
        default=None, description='where it lets go, { angle = "joint", above = "45 deg" } or alike'
    )
    force: Annotated[Positive, Measured("N")] | None = Field(
        default=None, description="the force in the joint at which it breaks in N, a positive number"
    )
    impulse: Annotated[Positive, Measured("N s")] | None = Field(
        default=None, description="the impulse in the joint at which it breaks in N s, a positive number"
    )


class HoldTable(Table):
    """One ``[[hold]]``."""

    joint: JointName = Field(description="the name of the joint that takes hold")
    at: Annotated[NotNegative, Measured("s")] | None = Field(
        default=None, description="the time at which it takes hold in s, a number that is not negative"
    )
    when: WhenTable | None = Field(
        default=None, description='where it takes hold, { angle = "joint", above = "45 deg" } or alike'
    )
    within: Annotated[Positive, Measured("m")] | None = Field(
        default=None, description="how far its points may be from each other then in m, a positive number"
    )
