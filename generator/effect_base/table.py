"""What every table of a scene file has in common: strict types, no unknown keys, finite numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Field

NAME = r"^[A-Za-z][A-Za-z0-9_]*$"
"""Names of links, points, joints and effects."""


class Table(BaseModel):
    """A table of a scene file. Each field's description says what is expected, for editors and for fault sentences."""

    MISPLACED: ClassVar[Mapping[str, str]] = {}
    """Keys that are often looked for here, each with where it belongs."""
    INSTEAD: ClassVar[Mapping[str, str]] = {}
    """Keys that show that another table is meant, each with that: nothing else of such a table is judged."""

    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False, frozen=True)


def number_or_list(value: Any) -> str:
    """Which alternative of such a value is meant, as pydantic's tag."""
    return "<list>" if isinstance(value, list) else "<number>"


@dataclass(frozen=True)
class Named:
    """Marks a text that is the name of something: a joint, a link, a point (``link.point`` or a joint), or an end of a
    joint (``link.point``)."""

    kind: Literal["joint", "link", "point", "end"]


JointName = Annotated[str, Named("joint")]
LinkName = Annotated[str, Named("link")]
PointName = Annotated[str, Named("point")]
EndName = Annotated[str, Named("end")]

Name = Annotated[str, Field(pattern=NAME)]
Positive = Annotated[float, Field(gt=0.0)]
Pair = Annotated[list[float], Field(min_length=2, max_length=2)]
