"""Effects that events switch on and off, and the structures that a scene comes to by that."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..effect_base.table import Table
from .errors import Path, Report
from .event_table import EventTable

SWITCHABLE = (
    *("ground", "compliant_ground", "stop", "touch", "compliant_touch", "journal", "rope"),
    *("spring", "damper", "torsion", "joint_friction", "brake", "drag", "motor", "force", "torque"),
)
"""Effects without which a mechanism has the same coordinates and loops."""
MOST_STRUCTURES = 16
"""Each is a model of its own."""


@dataclass(frozen=True)
class Switches:
    """What is ``off`` at the start, and what is off together at some time, in the scene's order, but nothing."""

    off: tuple[str, ...] = ()
    sets: tuple[tuple[str, ...], ...] = ()


NOTHING_SWITCHED = Switches()


def name_of(path: Path, table: Table) -> str:
    """The name of an effect: its own, or that of its kind with its number."""
    given = getattr(table, "name", None)
    return given if isinstance(given, str) else "_".join(str(part) for part in path)


def switches_of(
    events: Sequence[tuple[Path, EventTable]],
    off: Sequence[str],
    effects: Sequence[tuple[Path, str]],
    changing: bool,
    report: Report,
) -> Switches:
    """What the events switch, with ``off`` at the start; ``effects`` are keys and names of the scene's effects.

    ``changing``: whether joints let go or take hold. Faults are told, and nothing is switched then.
    """
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
    if named and changing:
        report.add(
            next(iter(named.values())),
            "found an effect that is switched beside joints that let go or take hold, expected one of the two; set its "
            "parameters instead, as a stiffness to 0",
        )
    if len(report.found) > before or not named:
        return NOTHING_SWITCHED
    found = [frozenset(off)]
    for now in found:
        every = [(now | frozenset(event.off)) - frozenset(event.on) for _, event in events]
        found += [then for then in dict.fromkeys(every) if then not in found]
    if len(found) > MOST_STRUCTURES:
        report.add(
            next(iter(named.values())),
            f"found effects that are on and off in {len(found)} ways, expected at most {MOST_STRUCTURES}, because each "
            "is a model of its own; switch fewer",
        )
        return NOTHING_SWITCHED
    order = list(known)
    sets = [tuple(sorted(one, key=order.index)) for one in found]
    return Switches(sets[0], tuple(sorted(filter(None, sets), key=lambda one: [order.index(name) for name in one])))


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
