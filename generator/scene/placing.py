"""Parts that a scene writes once, ``[[part]]``, put where ``[[place]]`` says, before anything else of it is read.

What comes out is a scene without parts: links, joints, effects and names of numbers of each place have its name behind
their own (``hip`` placed as ``left`` is ``hip_left``).
"""

from __future__ import annotations

import copy
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..effect_base.arithmetic import ExpressionError, Names, calculate, free_names, parsed
from ..effect_base.effect import Entry
from ..effect_base.grammar_of_state import asks_state
from ..effect_base.table import Named, NameKind
from ..effect_base.written_numbers import read_quantity
from ..effects import REGISTRY
from .check import check, show
from .errors import Path, Report
from .kinds import KINDS, MODELS
from .let import read_names, wrong_name
from .limits import MOST_PLACED
from .meant import kinds_of, unknown_key
from .part_tables import ROWS_OF_PARTS, TABLES_OF_PARTS, PartTable, PlacedStartTable, PlaceTable
from .texts import Rewriting, rewritten
from .turned_states import turned_state
from .turning import Sides, Turning

EFFECTS: Mapping[str, Entry] = {entry.key: entry for entry in REGISTRY}
Tables = Mapping[str, Any]


@dataclass
class Row:
    """One table of an array, and where it is written; ``inside``: where values of it are that stand elsewhere."""

    key: str
    table: Any
    written: Path
    inside: dict[tuple[str | int, ...], Path] = field(default_factory=dict)

    @property
    def name(self) -> str | None:
        """Its name, if it has one."""
        name = self.table.get("name") if isinstance(self.table, Mapping) else None
        return name if isinstance(name, str) else None


@dataclass
class Assembly:
    """What a part amounts to: rows of arrays, and entries of tables by (key, name), with where they are written."""

    rows: list[Row] = field(default_factory=list)
    let: dict[str, tuple[Any, Path]] = field(default_factory=dict)
    ground: dict[str, tuple[Any, Path]] = field(default_factory=dict)
    start: dict[tuple[str, str], tuple[Any, Path]] = field(default_factory=dict)

    def add(self, other: Assembly) -> None:
        self.rows += other.rows
        self.let |= other.let
        self.ground |= other.ground
        self.start |= other.start

    def named(self, key: str) -> dict[str, Row]:
        """Rows of this key by their names."""
        return {row.name: row for row in self.rows if row.key == key and row.name is not None}


@dataclass(frozen=True)
class Part:
    """A ``[[part]]`` as written."""

    table: PartTable
    raw: Tables
    path: Path


def place_parts(tables: Tables, report: Report) -> tuple[Tables, dict[Path, Path]]:
    """The tables with every part in its places, and where what came of them is written, by its path.

    Tables without parts are given back as they are. Faults of parts and places go to ``report``.
    """
    if "part" not in tables and "place" not in tables:
        return tables, {}
    names = read_names(tables.get("let", {}), report)
    placer = _Placer(tables, report)
    whole = Assembly()
    for index, raw in enumerate(_list(tables, "place", (), report)):
        whole.add(placer.placed(raw, ("place", index), names, ()))
    for part in placer.parts.values():
        if part.table.name not in placer.used:
            report.remark(part.path, f"{part.table.name} stands nowhere, because no [[place]] names it")
    return _joined(tables, whole, report)


_KINDS_OF_PARTS = {key: KINDS.get(key) or kinds_of(PartTable)[key] for key in TABLES_OF_PARTS}


class _Placer:
    """Places the parts of one scene."""

    def __init__(self, tables: Tables, report: Report) -> None:
        self.report = report
        self.parts: dict[str, Part] = {}
        self.used: set[str] = set()
        self.count = 0
        for index, raw in enumerate(_list(tables, "part", (), report)):
            self._read(raw, ("part", index))

    def _read(self, raw: Any, path: Path) -> None:
        if not isinstance(raw, Mapping):
            self.report.add(path, f"found {show(raw)}, expected a table; write [[part]]")
            return
        once = [key for key, table in raw.items() if not isinstance(table, list)]
        for key in raw:
            if key not in TABLES_OF_PARTS:
                self.report.add((*path, key), unknown_key(key, raw[key], _KINDS_OF_PARTS, once))
        table = check(PartTable, {key: raw[key] for key in raw if key in PartTable.model_fields}, path, {}, self.report)
        if table is None:
            return
        for name in table.let:
            if wrong := wrong_name(name):
                self.report.add((*path, "let", name), f'found "{name}", expected {wrong}; rename it')
        if table.name in self.parts:
            message = f'found "{table.name}" a second time, expected a new name; rename one of them'
            self.report.add((*path, "name"), message)
        else:
            self.parts[table.name] = Part(table, raw, path)

    def placed(self, raw: Any, path: Path, names: Names, above: tuple[str, ...]) -> Assembly:
        """The part that a ``[[place]]`` names, as it stands there; nothing after faults. ``names`` stand for numbers
        around the place, ``above`` are the parts that it belongs to."""
        place = check(PlaceTable, raw, path, names, self.report)
        if place is None:
            return Assembly()
        part = self.parts.get(place.part)
        if part is None:
            known = ", ".join(self.parts) or "none, because there is no [[part]]"
            self.report.add((*path, "part"), f"found {show(place.part)}, expected one of {known}; correct the name")
            return Assembly()
        self.used.add(part.table.name)
        if part.table.name in above:
            way = " in ".join((part.table.name, *reversed(above)))
            self.report.add((*path, "part"), f"found {way}, expected parts that do not hold themselves; remove it")
            return Assembly()
        told = self.count > MOST_PLACED
        self.count += 1 + sum(len(rows) for key in ROWS_OF_PARTS if isinstance(rows := part.raw.get(key), list))
        if self.count > MOST_PLACED:
            if not told:
                message = (
                    f"found parts of more than {MOST_PLACED} tables in all their places, expected at most that many"
                )
                self.report.add(path, f"{message}; make the mechanism smaller")
            return Assembly()
        if not (self._check_ports(part, self._rows_of(part)) & self._check_keys(place, part, path)):
            return Assembly()
        inner = read_names({**part.table.let, **_values(place.let, names)}, Report(""))
        assembly = self._whole(part, inner, (*above, part.table.name))
        if not self._check_ports(part, assembly.rows):
            return Assembly()
        return _Placing(assembly, place, raw, part, path, self.report).run()

    def _rows_of(self, part: Part) -> list[Row]:
        """A part's own tables."""
        return [
            Row(key, copy.deepcopy(table), (*part.path, key, index))
            for key in ROWS_OF_PARTS
            for index, table in enumerate(_list(part.raw, key, part.path, self.report))
        ]

    def _whole(self, part: Part, names: Names, above: tuple[str, ...]) -> Assembly:
        """A part's own tables, and those of the parts that are placed in it."""
        found = Assembly(self._rows_of(part))
        found.let = {key: (value, (*part.path, "let", key)) for key, value in part.table.let.items()}
        ground = part.raw.get("ground_link", {})
        points = ground.get("points", {}) if isinstance(ground, Mapping) else {}
        if not isinstance(points, Mapping) or (isinstance(ground, Mapping) and ground.keys() - {"points"}):
            message = (
                "found something else than points in it, expected named points, { O = [x, y], ... } in m; correct it"
            )
            self.report.add((*part.path, "ground_link"), message)
            points = {}
        found.ground = {key: (at, (*part.path, "ground_link", "points", key)) for key, at in points.items()}
        found.start = dict(self._start(part.raw.get("start", {}), (*part.path, "start")))
        for index, raw in enumerate(_list(part.raw, "place", part.path, self.report)):
            found.add(self.placed(raw, (*part.path, "place", index), names, above))
        return found

    def _start(self, raw: Any, path: Path) -> Iterator[tuple[tuple[str, str], tuple[Any, Path]]]:
        """Entries of the start of a part; their values are checked with those of the whole scene."""
        if not isinstance(raw, Mapping):
            self.report.add(path, f"found {show(raw)}, expected a table; write [part.start]")
            return
        for key, table in raw.items():
            if key in PlacedStartTable.MISPLACED:
                elsewhere = PlacedStartTable.MISPLACED[key]
                self.report.add((*path, key), f"found {key}, expected it elsewhere: {elsewhere}")
            elif key not in PlacedStartTable.model_fields:
                self.report.add((*path, key), unknown_key(key, table, kinds_of(PlacedStartTable), raw))
            elif not isinstance(table, Mapping):
                expected = PlacedStartTable.model_fields[key].description
                self.report.add((*path, key), f"found {show(table)}, expected {expected}; correct it")
            else:
                yield from (((key, name), (value, (*path, key, name))) for name, value in table.items())

    def _check_ports(self, part: Part, rows: Sequence[Row]) -> bool:
        """No port has the name of something in the part: nobody could say which of the two is meant."""
        assembly = Assembly([*rows])
        fine = True
        for index, port in enumerate(part.table.ports):
            same = next((key for key in ("joint", "link") if port in assembly.named(key)), None)
            if port in part.table.ports[:index]:
                same = "port"
            if same is not None:
                message = f'found "{port}", which is a {same} of the part too, expected a name of its own; rename one'
                self.report.add((*part.path, "ports", index), message)
                fine = False
        return fine

    def _check_keys(self, place: PlaceTable, part: Part, path: Path) -> bool:
        """The place gives what the part asks for, and nothing that it does not know."""
        fine = True
        for port in part.table.ports:
            if port not in place.ports:
                message = f'missing, expected a point for every port of {place.part}, {port} = "link.point"; add it'
                self.report.add((*path, "ports", port), message)
                fine = False
        for key, given, known in (("ports", place.ports, part.table.ports), ("let", place.let, [*part.table.let])):
            for name in given:
                if name not in known:
                    expected = f"one of {', '.join(known)}" if known else f"none, because it has no {key}"
                    message = f"found {name}, which {place.part} does not have among its {key}, expected {expected}"
                    self.report.add((*path, key, name), f"{message}; correct the name or add it to the part")
                    fine = False
        return fine


class _Placing:
    """One part put in one place."""

    def __init__(
        self, assembly: Assembly, place: PlaceTable, raw: Tables, part: Part, path: Path, report: Report
    ) -> None:
        self.assembly, self.place, self.raw, self.part, self.path, self.report = (
            *(assembly, place, raw, part, path),
            report,
        )
        self.turning = Turning(place.mirror, float(place.angle), (float(place.at[0]), float(place.at[1])))
        self.links, self.joints = assembly.named("link"), assembly.named("joint")

    def run(self) -> Assembly:
        """The part's tables as they stand in the place."""
        found = Assembly([self._row(row) for row in self.assembly.rows])
        for key, (value, written) in self.assembly.let.items():
            if key in self.place.let:
                found.let[self._named(key)] = self.raw["let"][key], (*self.path, "let", key)
            else:
                found.let[self._named(key)] = self._number(value) if isinstance(value, str) else value, written
        for key, (place, written) in self.assembly.ground.items():
            found.ground[self._named(key)] = self.turning.place(self._numbers(place)), written
        entries = {key: (self._numbers(value), written) for key, (value, written) in self.assembly.start.items()}
        for key, table in self.raw.get("start", {}).items():
            entries |= {(key, name): (value, (*self.path, "start", key, name)) for name, value in table.items()}
        for (key, name), (value, written) in entries.items():
            own = self.links if key in ("angles", "poses", "angular_velocities") else self.joints
            if name not in own:
                kind = "link" if own is self.links else "joint"
                expected = f"one of {', '.join(own)}" if own else "none"
                message = f"found an unknown {kind} of {self.place.part}, expected {expected}; correct the name"
                self.report.add(written, message)
                continue
            found.start[key, self._named(name)] = _PUT[key](self.turning, value), written
        return found

    def _row(self, row: Row) -> Row:
        """A table with the names of this place, turned as the place says."""
        if not isinstance(row.table, Mapping):
            return row
        inside = dict(row.inside)

        def name(mark: Named, text: str, where: tuple[str | int, ...]) -> str:
            if text in self.part.table.ports:
                inside[where] = (*self.path, "ports", text)
                return self.place.ports[text]
            return self._reference(mark, text)

        table = rewritten(MODELS[row.key], row.table, Rewriting(name, self._number, self._state))
        if row.name is not None:
            table["name"] = self._named(row.name)
        if row.key == "link":
            table = self.turning.link(table)
        elif row.key == "joint":
            table = self.turning.joint(table, self._sides(row))
        elif not self.turning.nothing:
            turned = EFFECTS[row.key].turned
            if row.key == "cam" and not self._is_own(row.table.get("centre")):
                message = "found the centre of a cam on a link that is not the part's, expected one that turns with it"
                message += "; write the cam outside of the part, or place the part as it is"
                self.report.add((*self.path, "mirror" if self.place.mirror else "angle"), message)
            elif turned is None:
                message = f"found a part with a [[{row.key}]], of which nobody has said what it becomes in a part that"
                message += " is turned or mirrored; write it outside of the part, or place the part as it is"
                self.report.add((*self.path, "mirror" if self.place.mirror else "angle"), message)
            else:
                joint = self.joints.get(str(row.table.get("joint", "")))
                seen = [key for key, kind in turned.items() if kind == "vector" and self._is_seen(row.table.get(key))]
                table = self.turning.effect(table, turned, self._sides(joint) if joint else None, seen)
        return Row(row.key, table, row.written, inside)

    def _sides(self, joint: Row) -> Sides:
        """Which sides of a joint of the part are its own."""
        ends = joint.table.get("between") if isinstance(joint.table, Mapping) else None
        ends = ends if isinstance(ends, list) and len(ends) == 2 else ["", ""]
        own = [isinstance(end, str) and end.partition(".")[0] in self.links for end in ends]
        kind = joint.table.get("type", "revolute")
        return Sides(own[0], own[1], kind == "revolute", kind in ("revolute", "pin-in-slot"))

    def _is_own(self, point: object) -> bool:
        """Whether a point is on a link of the part, or a joint of it, as far as it is a name."""
        return not isinstance(point, str) or point.partition(".")[0] in (*self.links, *self.joints)

    def _is_seen(self, vector: Any) -> bool:
        """Whether a vector has two parts, and in one of them something of the state, or a law of the part."""
        laws, parts = self.assembly.named("law"), vector if isinstance(vector, list) and len(vector) == 2 else []
        return any(isinstance(one, str) and bool(asks_state(one, laws)) for one in parts)

    def _named(self, name: str) -> str:
        found = f"{name}_{self.place.name}"
        self.report.renamed[found] = name
        return found

    def _reference(self, mark: Named, text: str) -> str:
        """What a name in the part is called outside of it; names that are not the part's stay."""
        owner, dot, point = text.partition(".")
        if mark.kind == "link" or dot:
            if owner in self.links:
                return f"{self._named(owner)}{dot}{point}"
            return f"ground.{self._named(point)}" if owner == "ground" and point in self.assembly.ground else text
        own = text in self.joints or (mark.kind == "point" and text in self.links)  # a link for its outline
        return self._named(text) if own else text

    def _numbers(self, value: Any) -> Any:
        """A number or several, with the names of this place."""
        if isinstance(value, list):
            return [self._numbers(one) for one in value]
        return self._number(value) if isinstance(value, str) else value

    def _state(self, text: str) -> str:
        """An expression of the state as it is here, seen from the part."""
        laws = {name: self._named(name) for name in self.assembly.named("law")}
        joints = {name: self._sides(row) for name, row in self.joints.items()}

        def outside(kind: NameKind, name: str) -> str:
            return self.place.ports.get(name) or self._reference(Named(kind), name)

        if not asks_state(text, laws):
            return self._number(text)
        numbers = {name: self._named(name) for name in self.assembly.let}
        return turned_state(text, self.turning, numbers | laws, joints, outside)

    def _number(self, text: str) -> str:
        """Arithmetic with the names that the part's ``let`` has in this place."""
        try:
            if read_quantity(text, None) is not None:
                return text
            own = [name for name in dict.fromkeys(free_names(parsed(text))) if name in self.assembly.let]
        except ExpressionError:
            return text  # told when it is read
        if not own:
            return text
        return re.sub(rf"\b({'|'.join(own)})\b", lambda found: self._named(found[1]), text)


_PUT: Mapping[str, Any] = {
    "angles": Turning.link_angle,
    "joints": Turning.place,
    "poses": Turning.pose,
    "angular_velocities": Turning.rate,
    "slides": lambda _, value: value,
    "sliding_velocities": lambda _, value: value,
}
"""What becomes of the entries of a start."""


def _values(table: Mapping[str, Any], names: Names) -> dict[str, Any]:
    """A place's ``let`` with numbers for texts, as far as they can be read there."""
    found = dict(table)
    for key, value in table.items():
        if isinstance(value, str):
            try:
                quantity = read_quantity(value, None)
                found[key] = calculate(value, names) if quantity is None else quantity
            except ExpressionError:
                continue
    return found


def _list(tables: Tables, key: str, base: Path, report: Report) -> list[Any]:
    raw = tables.get(key, [])
    if isinstance(raw, list):
        return raw
    header = ".".join((*(part for part in base if isinstance(part, str)), key))
    report.add((*base, key), f"found {show(raw)}, expected an array of tables; write [[{header}]]")
    return []


def _joined(tables: Tables, whole: Assembly, report: Report) -> tuple[Tables, dict[Path, Path]]:
    """The scene's own tables, then those of its places, and where these are written."""
    found = {key: value for key, value in tables.items() if key not in ("part", "place")}
    written: dict[Path, Path] = {}
    for row in whole.rows:
        rows = found.get(row.key, [])
        if not isinstance(rows, list):
            continue
        path: Path = (row.key, len(rows))
        found[row.key] = [*rows, row.table]
        written[path] = row.written
        written |= {(*path, *place): origin for place, origin in row.inside.items()}
    entries: list[tuple[Path, tuple[Any, Path]]] = [(("let", key), one) for key, one in whole.let.items()]
    entries += [(("ground_link", "points", key), one) for key, one in whole.ground.items()]
    entries += [(("start", *key), one) for key, one in whole.start.items()]
    for place, (value, origin) in entries:
        wrong = _put(found, place, value)
        if wrong:
            report.add(origin, wrong)
        else:
            written[place] = origin
    return found, written


def _put(tables: dict[str, Any], path: Path, value: Any) -> str:
    """Write a value into tables inside of ``tables``, whose copies are made; what is in the way, if something is."""
    node = tables
    for depth, part in enumerate(path[:-1]):
        below = node.get(str(part), {})
        if not isinstance(below, Mapping):
            name = ".".join(map(str, path[: depth + 1]))
            return f"found {name} of the scene as {show(below)}, expected a table, which this is added to; write names"
        node[str(part)] = dict(below)
        node = node[str(part)]
    if path[-1] in node:
        return f"found {path[-1]} in [{path[0]}] too, expected it once; remove one of them"
    node[str(path[-1])] = value
    return ""
