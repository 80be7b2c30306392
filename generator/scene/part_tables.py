"""``[[part]]`` and ``[[place]]``: links, joints and effects that are written once, and the places where they stand."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import Field

from ..effect_base.table import Name, Position, Table
from ..effect_base.written_numbers import Angle, Length
from ..effects import REGISTRY
from .schema import AngularVelocity, Points, Pose, Speed

EFFECTS_OF_PARTS = tuple(entry.key for entry in REGISTRY if entry.many)
"""Effects that a part may have: those of which there may be several."""
ROWS_OF_PARTS = ("link", "joint", *EFFECTS_OF_PARTS)
"""Arrays of tables that a part may have."""


class PartTable(Table):
    """One ``[[part]]``, less the tables that it has as a scene has them."""

    name: Name = Field(description="a name of letters, digits and _, beginning with a letter")
    ports: list[Name] = Field(
        default=[], description='names for points outside of the part, which every [[place]] gives, ["pin", "hip"]'
    )
    let: dict[str, Any] = Field(default={}, description="a table of names and numbers")


class PlacedStartTable(Table):
    """``start`` of a ``[[part]]`` or a ``[[place]]``: as ``[start]``, about the part's own links and joints."""

    MISPLACED: ClassVar[Mapping[str, str]] = {
        "tilt": "a placed part is turned as a whole; write angle = ... in its [[place]]",
        **dict.fromkeys(("position", "velocity", "height"), "it is about the whole mechanism; write it in [start]"),
    }

    angles: dict[str, Angle] | None = Field(
        default=None, description='angles of the part\'s links, { hip = "30 deg", ... }'
    )
    joints: Points | None = Field(
        default=None, description="where the part's joints are roughly, { knee = [x, y], ... } in m"
    )
    poses: dict[str, Pose] | None = Field(
        default=None, description='where the part\'s links are roughly, { hip = [x, y, "30 deg"], ... } in m'
    )
    angular_velocities: dict[str, AngularVelocity] | None = Field(
        default=None, description="angular velocities of the part's links in rad/s, a table by name"
    )
    slides: dict[str, Length] | None = Field(
        default=None, description="how far the part's sliding joints are along their lines in m, a table by name"
    )
    sliding_velocities: dict[str, Speed] | None = Field(
        default=None, description="how fast they slide in m/s, a table by name"
    )


class PlaceTable(Table):
    """One ``[[place]]``: a part as it stands in one place."""

    part: str = Field(description="the name of a [[part]]")
    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9_]+$")] = Field(
        description="letters, digits and _, which are put behind all names of the part"
    )
    at: Position = Field(default=[0.0, 0.0], description="where the part's origin is, [x, y] in m")
    angle: Angle = Field(default=0.0, description='how far the part is turned in rad, or a text such as "120 deg"')
    mirror: bool = Field(
        default=False, description="true or false: whether left and right are exchanged, before it is turned"
    )
    ports: dict[str, str] = Field(
        default={}, description='a point for each of the part\'s ports, { pin = "shaft.A", ... }'
    )
    let: dict[str, Any] = Field(default={}, description="a table of numbers for names of the part's [let]")
    start: PlacedStartTable | None = Field(
        default=None, description="a table of what begins otherwise here, as the start of the part"
    )


TABLES_OF_PARTS = (*PartTable.model_fields, *ROWS_OF_PARTS, "ground_link", "start", "place")
"""All keys of a part."""
