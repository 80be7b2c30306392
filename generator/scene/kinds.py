"""All tables of a scene: their keys, whether there may be several, and whether they have names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..effect_base.table import Table
from ..effects import REGISTRY
from .change_tables import HoldTable, ReleaseTable
from .event_table import EventTable
from .part_tables import ROWS_OF_PARTS, PartTable, PlaceTable
from .schema import (
    ChainTable,
    FourBarsTable,
    GroundLinkTable,
    JointTable,
    LetTable,
    LinkTable,
    LoopTable,
    OutputTable,
    PinnedTable,
    RunTable,
    StartTable,
)

SHORTHAND: dict[str, type[LoopTable] | type[ChainTable] | type[PinnedTable] | type[FourBarsTable]] = {
    "loop": LoopTable,
    "chain": ChainTable,
    "pinned": PinnedTable,
    "four_bars": FourBarsTable,
}
MODELS: dict[str, type[Table]] = {
    "let": LetTable,
    **SHORTHAND,
    "link": LinkTable,
    "joint": JointTable,
    "ground_link": GroundLinkTable,
    "start": StartTable,
    "release": ReleaseTable,
    "hold": HoldTable,
    "event": EventTable,
    "run": RunTable,
    "output": OutputTable,
    **{entry.key: entry.table for entry in REGISTRY},
}
"""Tables of a scene whose parts stand in their places."""
MANY = (*ROWS_OF_PARTS, "release", "hold", "event")
"""Those of which there may be several."""
_LISTED = (*MANY, "part", "place")
KEYS = (
    *("name", "let", *SHORTHAND, "link", "joint", "ground_link", "part", "place", "start", "release", "hold", "event"),
    "run",
    "output",
    *(entry.key for entry in REGISTRY),
)
"""Keys of a scene file, in the order in which they are told."""
KINDS: dict[str, Any] = {
    key: str if key == "name" else dict[str, Any] | list[dict[str, Any]] if key in _LISTED else dict[str, Any]
    for key in KEYS
}
"""What kind of value each has. One of those of which there may be several is told by itself if it stands alone."""


@dataclass(frozen=True)
class TableKind:
    """A table of a scene: its schema, what each key is, whether there may be several, and whether they have names."""

    model: type[Table]
    keys: Mapping[str, str]
    many: bool

    @property
    def named(self) -> bool:
        """Whether tables of the kind have names."""
        return "name" in self.keys


def _kind(key: str) -> TableKind:
    models: dict[str, type[Table]] = {"part": PartTable, "place": PlaceTable, **MODELS}
    model = models[key]
    keys = {name: field.description or "" for name, field in model.model_fields.items()}
    if key == "part":
        keys |= {one: f"tables of the part, as [[{one}]]" for one in (*ROWS_OF_PARTS, "place")}
        keys |= {one: f"a table of the part, as [{one}]" for one in ("ground_link", "start")}
    return TableKind(model, keys, key in (*MANY, "part", "place"))


TABLES: Mapping[str, TableKind] = {key: _kind(key) for key in KEYS if key != "name"}
"""All tables of scene files."""
