"""Effects that events switch on and off."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..effect_base.table import Table
from ..mechanism.links import OFF_OR_ON, Parameter
from .errors import Path, Report
from .event_table import EventTable
from .scene import ON

SWITCHABLE = (
    *("ground", "compliant_ground", "stop", "touch", "compliant_touch", "journal", "rope"),
    *("spring", "damper", "torsion", "joint_friction", "brake", "drag", "motor", "force", "torque"),
)
"""Effects without which a mechanism has the same coordinates and loops."""


def name_of(path: Path, table: Table) -> str:
    """The name of an effect: its own, or that of its kind with its number."""
    given = getattr(table, "name", None)
    return given if isinstance(given, str) else "_".join(str(part) for part in path)


def gates_of(
    events: Sequence[tuple[Path, EventTable]],
    off: Sequence[str],
    effects: Sequence[tuple[Path, str]],
    report: Report,
) -> dict[Path, Parameter]:
    """The gates of the effects that events switch, by the keys of their tables, with ``off`` at the start; ``effects``
    are keys and names of the scene's effects. Faults are told, and nothing is switched then."""
    before = len(report.found)
    known = {name: str(path[0]) for path, name in effects}
    named = _named(events, report)
    _check_named(named, known, report)
    switched_on = {name for _, event in events for name in event.on}
    for index, name in enumerate(off):
        if name not in switched_on:
            report.add(
                ("start", "off", index),
                f'found "{name}", expected an effect that an [[event]] switches on; add it to on of one',
            )
    if len(report.found) > before:
        return {}
    return {
        path: Parameter(f"{name}{ON}", f"on_{'_'.join(map(str, path))}", float(name not in off), OFF_OR_ON, "1")
        for path, name in effects
        if name in named
    }


def _named(events: Sequence[tuple[Path, EventTable]], report: Report) -> dict[str, Path]:
    """What events switch, and where that is first said."""
    named: dict[str, Path] = {}
    for path, event in events:
        for key in ("on", "off"):
            for index, name in enumerate(getattr(event, key)):
                place = (*path, key, index)
                named.setdefault(name, place)
                if key == "off" and name in event.on:
                    report.add(place, f'found "{name}" in on too, expected it in one of them; remove it from the other')
    return named


def _check_named(named: Mapping[str, Path], known: Mapping[str, str], report: Report) -> None:
    """They are effects that a mechanism can be without."""
    names = [name for name, kind in known.items() if kind in SWITCHABLE]
    for name, place in named.items():
        if name not in known:
            report.add(place, f'found "{name}", expected an effect; those that can be switched are {_listed(names)}')
        elif known[name] not in SWITCHABLE:
            report.add(
                place,
                f'found "{name}", a [[{known[name]}]], expected an effect that the mechanism can be without; those are '
                f"{_listed(names)}",
            )


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) or "none here"
