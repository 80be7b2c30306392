"""Joints that let go and take hold while a mechanism moves."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

from ..effect_base.arithmetic import Written
from ..effect_base.points import find_joint, find_point
from ..effect_base.table import Named, Table, kind_of_key
from ..effect_base.units import dimension_of
from ..mechanism.joints import Joint
from ..mechanism.mechanism import Mechanism
from .change_tables import HoldTable, ReleaseTable, WhenTable
from .errors import Path, Report
from .schema import StartTable

GO_ALONG = ("motor", "drive", "stop", "joint_friction", "brake")
"""Effects at a joint that are absent while it is open, and take no energy along."""
UNITS = {"angle": "rad", "direction": "rad", "slide": "m", "height": "m", "distance": "m"}
"""What is watched, and its unit."""


@dataclass(frozen=True)
class Watch:
    """A quantity of the ``kind`` of :data:`UNITS`, of what has the ``names``: a change comes where ``sign`` times it
    rises through ``sign`` times ``limit``."""

    kind: str
    names: tuple[str, ...]
    sign: int
    limit: float


@dataclass(frozen=True)
class Change:
    """``joint`` lets go (``release``) or takes hold.

    At the time ``at`` (s), where ``watch`` says, at a ``force`` (N) or an ``impulse`` (N s) in the joint, or, of a hold
    that says none of these, where its points meet. ``within`` (m) is how far they may be apart then, ``None`` for a
    millionth of the mechanism's length.
    """

    kind: Literal["release", "hold"]
    joint: str
    at: float | None = None
    watch: Watch | None = None
    force: float | None = None
    impulse: float | None = None
    within: float | None = None

    @property
    def meets(self) -> bool:
        """Whether it comes where the points of the joint meet."""
        return self.kind == "hold" and self.at is None and self.watch is None

    def describe(self) -> str:
        """What ``ccgen show`` says of it."""
        limits = [f"it carries {self.force:g} N"] if self.force is not None else []
        limits += [f"an impact puts {self.impulse:g} N s into it"] if self.impulse is not None else []
        where = f"where {' or '.join(limits)}" if limits else "where its points meet"
        if self.at is not None:
            where = f"at {self.at:g} s"
        if watch := self.watch:
            side, unit = "above" if watch.sign > 0 else "below", UNITS[watch.kind]
            where = f"where the {watch.kind} of {' and '.join(watch.names)} comes {side} {watch.limit:.6g} {unit}"
        return f"{self.joint} {'lets go' if self.kind == 'release' else 'takes hold'} {where}"


@dataclass(frozen=True)
class ChangeTables:
    """The tables of a scene that say what changes, as far as they are right, each with its place."""

    rows: tuple[tuple[Path, ReleaseTable | HoldTable], ...]
    open: tuple[str, ...] | None

    @property
    def joints(self) -> tuple[str, ...]:
        """Joints that change, each once."""
        return tuple(dict.fromkeys(table.joint for _, table in self.rows))

    def of(self, kind: type[ReleaseTable] | type[HoldTable]) -> frozenset[str]:
        """Joints that tables of a kind name."""
        return frozenset(table.joint for _, table in self.rows if isinstance(table, kind))

    def open_at_start(self) -> frozenset[str]:
        """Joints that do not hold at the start: those that only take hold, and those that the start says."""
        return (self.of(HoldTable) - self.of(ReleaseTable)) | frozenset(self.open or ()) & self.of(HoldTable)


def check_tables(said: ChangeTables, joints: Collection[str], report: Report) -> bool:
    """What tables say of joints is possible."""
    before = len(report.found)
    for path, table in said.rows:
        if table.joint not in joints:
            known = ", ".join(dict.fromkeys(joints)) or "none"
            report.add((*path, "joint"), f'found "{table.joint}", expected a joint; the joints are {known}')
        _check_keys(path, table, report)
    for index, name in enumerate(said.open or ()):
        if name not in said.of(HoldTable):
            report.add(
                ("start", "open", index),
                f'found "{name}", expected a joint that a [[hold]] names: another can never close; add a [[hold]]',
            )
    return len(report.found) == before


def _check_keys(path: Path, table: ReleaseTable | HoldTable, report: Report) -> None:
    given = [key for key in ("at", "when") if getattr(table, key) is not None]
    if isinstance(table, ReleaseTable):
        given += [key for key in ("force", "impulse") if getattr(table, key) is not None]
        if not given:
            report.add(path, "found nothing that lets it go, expected at, when, force or impulse; add one of them")
        if len(given) > 1 and given != ["force", "impulse"]:
            report.add(
                path,
                f"found {' and '.join(given)}, expected at, when, or force and impulse; write another [[release]] for "
                "the other",
            )
    elif len(given) > 1:
        report.add(path, "found at and when, expected one of them, or none; write another [[hold]] for the other")
    if table.when is not None:
        _check_when((*path, "when"), table.when, report)


def _check_when(path: Path, when: WhenTable, report: Report) -> None:
    kinds = [kind for kind in UNITS if getattr(when, kind) is not None]
    if len(kinds) != 1:
        found = " and ".join(kinds) or "nothing that is watched"
        report.add(path, f"found {found}, expected one of {', '.join(UNITS)}; name what is watched")
    sides = [side for side in ("above", "below") if getattr(when, side) is not None]
    if len(sides) != 1:
        report.add(path, f"found {' and '.join(sides) or 'no side'}, expected above or below; write one of them")
    for side in sides if len(kinds) == 1 else ():
        value, unit = getattr(when, side), UNITS[kinds[0]]
        if isinstance(value, Written) and value.dimension not in (None, dimension_of(unit)):
            told = f'found "{value.text}", expected a number in {unit}, because {kinds[0]} is; write it in {unit}'
            report.add((*path, side), told)


def changes_of(said: ChangeTables, mechanism: Mechanism, report: Report) -> tuple[Change, ...]:
    """The records of the tables, which are as :func:`check_tables` wants them."""
    found = []
    every = (*mechanism.joints, *mechanism.open)
    for path, table in said.rows:
        watch = None if table.when is None else _watch((*path, "when"), table.when, mechanism, every, report)
        kind: Literal["release", "hold"] = "release" if isinstance(table, ReleaseTable) else "hold"
        numbers = {
            key: None if value is None else float(value)
            for key in ("at", "force", "impulse", "within")
            for value in [getattr(table, key, None)]
        }
        found.append(Change(kind, table.joint, watch=watch, **numbers))
    return tuple(found)


def _watch(path: Path, when: WhenTable, mechanism: Mechanism, every: Sequence[Joint], report: Report) -> Watch | None:
    kind = next(kind for kind in UNITS if getattr(when, kind) is not None)
    given = getattr(when, kind)
    names: list[str] = [given] if isinstance(given, str) else given
    by_name = {joint.name: joint for joint in every}
    for index, name in enumerate(names):
        place: Path = (*path, kind) if isinstance(given, str) else (*path, kind, index)
        wrong = ""
        if kind in ("angle", "slide"):
            if name not in by_name:
                wrong = f"expected a joint; {find_joint(name, mechanism)[1]}"
            elif kind == "angle" and not by_name[name].turns:
                wrong = "expected a joint that turns; its links keep their angle"
            elif kind == "slide" and not by_name[name].slides:
                wrong = "expected a joint that slides; it only turns"
        elif kind == "direction":
            links = [link.name for link in mechanism.links]
            wrong = "" if name in links else f"expected a link; the links are {', '.join(links)}"
        elif find_point(name, mechanism)[0] is None:
            wrong = f"expected a point; {find_point(name, mechanism)[1]}"
        if wrong:
            report.add(place, f'found "{name}", {wrong}')
    above = when.above is not None
    limit = when.above if when.above is not None else when.below
    assert limit is not None
    return Watch(kind, tuple(names), 1 if above else -1, float(limit))


def at_open_joints(table: Table, key: str, opened: Collection[str]) -> Table | None:
    """The table of an effect as it is while joints are open: ``None`` where it acts at one of them alone."""
    for name in _joint_keys(type(table)):
        value = getattr(table, name)
        if isinstance(value, str) and value in opened and key in GO_ALONG:
            return None
        if isinstance(value, list) and key in GO_ALONG and any(one in opened for one in value):
            rest = [one for one in value if one not in opened]
            return table.model_copy(update={name: rest}) if rest else None
    return table


def check_effects_at(tables: Sequence[tuple[str, Path, Table]], said: ChangeTables, report: Report) -> None:
    """No effect acts at a joint that changes but those that go along with it, and no drive at one that takes hold: it
    would have to catch up with its law."""
    for key, path, table in tables:
        if key == "drive" and (joint := getattr(table, "joint", None)) in said.of(HoldTable):
            report.add(
                (*path, "joint"),
                f'found "{joint}", which takes hold, expected a joint that holds from the start: what it moves '
                "then need not be where the drive has it; move it by a [[motor]]",
            )
        for name in () if key in GO_ALONG else _joint_keys(type(table)):
            value = getattr(table, name)
            several = [((name, k), one) for k, one in enumerate(value)] if isinstance(value, list) else []
            for place, joint in (*several, ((name,), value)):
                if not isinstance(joint, str) or joint not in said.joints:
                    continue
                report.add(
                    (*path, *place),
                    f'found "{joint}", which lets go or takes hold, expected a joint that always holds; at one that '
                    f"changes there may be {', '.join(f'[[{one}]]' for one in GO_ALONG)}",
                )


def _joint_keys(model: type[Table]) -> list[str]:
    """Keys whose values name joints, and nothing else."""
    return [key for key in model.model_fields if _names_joints(kind_of_key(model, key))]


def _names_joints(kind: Any) -> bool:
    return kind.kind == "joint" if isinstance(kind, Named) else any(map(_names_joints, get_args(kind)))


def without_open(start: StartTable, opened: Collection[str]) -> StartTable:
    """``[start]`` without what it says of joints that are open."""
    given = {key: getattr(start, key) for key in ("slides", "sliding_velocities", "joints")}
    kept = {
        key: {name: one for name, one in of.items() if name not in opened}
        for key, of in given.items()
        if of is not None
    }
    return start.model_copy(update=kept)
