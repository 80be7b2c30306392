"""Reading the tables of a scene: every one is checked before it is given up, so that all faults come at once."""

from __future__ import annotations

import keyword
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, TypeVar

import numpy as np

from ..effect_base.arithmetic import Names
from ..effect_base.contact import Law
from ..effect_base.effect import Effect, Entry, Surroundings
from ..effect_base.table import Table
from ..effects import REGISTRY
from ..mechanism.links import Parameter
from ..mechanism.mechanism import Mechanism
from .angles import judge_angle
from .around import with_around
from .behind import tell_behind
from .bodies import Bodies, check_masses, general, name_of_link
from .change_tables import HoldTable, ReleaseTable
from .changes import (
    Change,
    ChangeTables,
    at_open_joints,
    changes_of,
    check_effects_at,
    check_tables,
    without_open,
)
from .check import check, show
from .driven import check_driven
from .errors import Path, Report
from .event_table import EventTable
from .events import Event, check_set, events_of
from .integrating import integrating
from .kinds import KEYS, KINDS, MANY, MODELS, SHORTHAND
from .law import law_of_all
from .let import read_names
from .limits import MOST_JOINTS, MOST_LINKS, MOST_TABLES
from .meant import unknown_key
from .meshed import meshed
from .module_names import hidden_module
from .on_off import gates_of, name_of
from .open_joints import on_carriages, with_gates, with_open
from .placing import place_parts
from .scene import HELD, Asked, RunSettings, Scene, Start
from .schema import (
    GroundLinkTable,
    JointTable,
    LinkTable,
    OutputTable,
    RunTable,
    StartTable,
)
from .shorthand import shorthand
from .sizes import SQUARES, check_lengths, tell_beyond
from .start import begin, check_effects, check_energy, lift, settle, sketch
from .states import Row, read_states, with_laws
from .valued import valued

PLACING = ("let", *SHORTHAND, "link", "joint", "ground_link", "start", "release", "hold")
"""Tables that say where links are and what holds them,"""
NOT_PLACING: frozenset[str | int] = frozenset({"mass", "inertia", "rod", "plate", "disc", "point_mass"})
"""but for these keys."""
OTHER_NAMES_OF_LET = ("variables", "constants", "parameters", "define")
"""Where somebody may look for it first."""

NO_VALUES: Mapping[str, float] = {}
"""Parameters have those of the tables."""

Tables = Mapping[str, Any]


class Gated(NamedTuple):
    """The ``joints`` that have gates, and of all joints those that are ``driven``."""

    joints: tuple[str, ...] = ()
    driven: tuple[str, ...] = ()


class EffectTable(NamedTuple):
    """A table of an effect that has passed its schema: what kind, which of those, at which key."""

    entry: Entry
    number: int
    path: Path
    table: Table


@dataclass(frozen=True)
class Parts:
    """What tables describe, as far as they are right."""

    bodies: Bodies | None
    effects: list[tuple[Path, Effect]]
    start: Start | None
    run: RunTable | None
    output: OutputTable | None
    law: Law
    said: ChangeTables
    changes: tuple[Change, ...] = ()
    events: tuple[Event, ...] = ()
    gates: Mapping[Path, Parameter] = field(default_factory=dict)
    everywhere: frozenset[Path] = frozenset()


class Begun(NamedTuple):
    """The start of a scene whose joints let go or take hold, found with those that hold there, and its mechanism."""

    start: Start
    mechanism: Mechanism


T = TypeVar("T", bound=Table)


def read_tables(
    tables: Tables,
    file: str,
    name: str,
    lines: Mapping[Path, int] | None = None,
    values: Mapping[str, float] = NO_VALUES,
) -> Scene:
    """The scene that ``tables`` describe: ``file`` and ``lines`` say where they stand, ``name`` is the default name.

    Parameters have these ``values`` instead of those of the tables, from before the start is assembled. Raises
    ``SceneError`` with all faults at once.
    """
    report = Report(file, lines)
    try:
        return _scene_of(tables, name, report, values)
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        named = tell_beyond(tables, MODELS, read_names(tables.get("let", {}), Report(file)), report)
        if not named and isinstance(error, ZeroDivisionError):
            raise
        if not report.found:
            report.add((), f"found numbers from which others cannot be worked out, expected each {SQUARES}")
        report.stop_if_any()
        raise AssertionError("a fault has just been noted") from error


def _scene_of(tables: Tables, name: str, report: Report, values: Mapping[str, float]) -> Scene:
    for key in tables:
        if key not in KEYS and (key not in OTHER_NAMES_OF_LET or "let" in tables):
            once = [one for one, table in tables.items() if not isinstance(table, list)]
            report.add((key,), unknown_key(key, tables[key], KINDS, once))
    given = tables
    tables = _let(_ground_link(tables, report), report)
    name = _name(tables, name, report)
    faults = len(report.found)
    tables, report.written = place_parts(tables, report)
    if len(report.found) > faults:
        _check_tables(tables, report)
        report.stop_if_any()
    parts = _read(tables, report, values=values)
    tell_behind(tables, parts.bodies.mechanism if parts.bodies else None, report, MODELS, _read_again)
    report.stop_if_any()
    scene = _scene(name, parts, report)
    if parts.changes:
        scene = _with_gates(scene, tables, report, values)
        report.stop_if_any()
        scene = replace(scene, remarks=report.remarks, changes=parts.changes)
    scene = replace(
        scene,
        keys_of_effects=tuple(str(path[0]) for path, _ in parts.effects),
        worked_out=_worked_out(tables, scene.mechanism),
    )
    return scene.written_as({"name": name, **given})


def _worked_out(tables: Tables, mechanism: Mechanism) -> tuple[str, ...]:
    """Names of links whose inertia the tables, their parts in their places, do not give as a number."""
    if "link" not in tables:
        forms = [tables[form] for form in SHORTHAND if form in tables]
        return tuple(link.name for link in mechanism.links) if any("inertia" not in form for form in forms) else ()
    return tuple(name_of_link(raw, index) for index, raw in enumerate(tables["link"]) if "inertia" not in raw)


def _scene(name: str, parts: Parts, report: Report) -> Scene:
    """The record of what has no faults."""
    run = parts.run
    output = parts.output
    if parts.bodies is None or parts.start is None or run is None or output is None:
        raise AssertionError("a scene without faults has all its parts")
    settings = RunSettings(run.until, run.rtol, run.atol, run.on_gain, parts.law)
    for path, effect in parts.effects:
        for key, sentence in effect.remarks():
            report.remark((*path, key), sentence)
    effects = tuple(effect for _, effect in parts.effects)
    mechanism = parts.bodies.mechanism
    asked = Asked(tuple(output.plot), tuple(output.table), output.times)
    gates = tuple(parts.gates.get(path) for path, _ in parts.effects) if parts.gates else ()
    everywhere = tuple(path in parts.everywhere for path, _ in parts.effects) if mechanism.gates else ()
    return Scene(
        name,
        mechanism,
        effects,
        parts.start,
        settings,
        asked,
        report.remarks,
        events=parts.events,
        gates=gates,
        everywhere=everywhere,
    )


def _with_gates(scene: Scene, tables: Tables, report: Report, values: Mapping[str, float]) -> Scene:
    """The ``scene``, which has the joints that hold at its start, with gates at all that let go or take hold."""
    own = Report(report.file)
    parts = _read(tables, own, begun=Begun(scene.start, scene.mechanism), values=values)
    for path, message in own.found:
        report.add(path, f"without {', '.join(parts.said.joints)}: {message}")
    return scene if own.found else replace(_scene(scene.name, parts, own), events=scene.events)


def _read(
    tables: Tables,
    report: Report,
    assemble: bool = True,
    begun: Begun | None = None,
    values: Mapping[str, float] = NO_VALUES,
    again: bool = False,
) -> Parts:
    """The parts that ``tables`` describe, as far as they are right; ``assemble``: the start is made consistent.

    The mechanism is that of the start, unless a start has ``begun``: then it has gates at the joints that let go or
    take hold, and begins there. What is read ``again``, with stand-ins, tells no lengths that are too large: they may
    be the cause of what is told.
    """
    names = with_laws(read_names(tables.get("let", {}), report), tables)
    asked = _table(StartTable, tables, "start", names, report)
    said = _change_tables(tables, asked, names, report)
    released = _released(said, values)
    effect_tables = _effect_tables(tables, names, report)
    gated = _gated(said, effect_tables) if begun else Gated()
    bodies = _bodies_with_squares(tables, names, report, released, gated, again)
    bodies = bodies and valued(bodies, values)
    if asked and released:
        asked = without_open(asked, released)
    every = effect_tables
    run = _table(RunTable, tables, "run", names, report)
    output = _table(OutputTable, tables, "output", names, report)
    if output and output.times is not None and not output.table:
        report.add(("output", "times"), "found beside no table, expected one; it says how many lines that has")
    many = enumerate(_tables(EventTable, tables, "event", names, report))
    events_said: list[tuple[Path, EventTable]] = [(("event", index), table) for index, table in many if table]
    changes: tuple[Change, ...] = ()
    if bodies and said.rows:
        joints = [joint.name for joint in (*bodies.mechanism.joints, *bodies.mechanism.open)]
        own = [name for name in joints if name not in bodies.mechanism.aids]
        own += [table["name"] for table in tables.get("joint", ()) if table.get("type") == "weld" and "name" in table]
        if check_tables(said, own, report):
            changes = changes_of(said, bodies.mechanism, report)
        check_effects_at([(one.entry.key, one.path, one.table) for one in effect_tables], said, report)
        absent_at = () if begun else released
        acting = [(one, at_open_joints(one.table, one.entry.key, absent_at)) for one in effect_tables]
        effect_tables = [one._replace(table=table) for one, table in acting if table is not None]
    named = [(one.path, name_of(one.path, one.table)) for one in every]
    gates = valued(gates_of(events_said, asked.off or () if asked else (), named, report), values)
    effects = _effects(effect_tables, bodies, names, report) if bodies else []
    if bodies:
        bodies = integrating(bodies, effects)
    effects = [(path, valued(effect, values)) for path, effect in effects]
    bodies = meshed(bodies, effects) if bodies else None
    absent = {path for path, gate in gates.items() if not gate.value}
    start = None
    if bodies and begun:
        start = _begun(begun, bodies, effects, report)
    elif bodies and asked:
        start = _start(asked, bodies, effects, report, assemble, absent, said.of(HoldTable))
    if bodies and start:
        settled = settle(start, bodies, effects)
        effects = [(path, valued(effect, values)) for path, effect in settled]
        bodies = meshed(bodies, effects)
    events = _events(events_said, bodies, effects, names, report) if bodies and not begun else ()
    law = law_of_all(tables, MODELS, report)
    everywhere = frozenset(one.path for one in effect_tables if getattr(one.table, "contacts", ()) is None)
    return Parts(bodies, effects, start, run, output, law, said, changes, events, gates, everywhere)


def _released(said: ChangeTables, values: Mapping[str, float]) -> frozenset[str]:
    """The joints that are open at the start, by what the scene says, and by values that gates are asked to have."""
    asked = {name: values[f"{name}{HELD}"] for name in said.joints if f"{name}{HELD}" in values}
    return frozenset(name for name in said.joints if not asked.get(name, name not in said.open_at_start()))


def _gated(said: ChangeTables, effects: list[EffectTable]) -> Gated:
    """The joints that let go or take hold, and those that drives move."""
    driven = (getattr(one.table, "joint", None) for one in effects if one.entry.key == "drive")
    return Gated(said.joints, tuple(name for name in driven if isinstance(name, str)))


def _begun(begun: Begun, bodies: Bodies, effects: list[tuple[Path, Effect]], report: Report) -> Start | None:
    """The start as one of bodies with gates, if all of their motions move some mass."""
    driven = [joint for _, effect in effects for joint in effect.driven()]
    fine = check_masses(bodies, driven, report)
    return on_carriages(begun.start, bodies.mechanism, begun.mechanism) if fine else None


def _events(
    rows: list[tuple[Path, EventTable]],
    bodies: Bodies,
    effects: list[tuple[Path, Effect]],
    names: Names,
    report: Report,
) -> tuple[Event, ...]:
    """Events that are asked for."""
    if not rows:
        return ()
    acting = [parameter for _, effect in effects for parameter in effect.parameters()]
    speeds = {one.path for _, effect in effects if effect.driven() for one in effect.parameters()}
    over_time = {path: law for _, effect in effects for path, law in effect.over_time().items()}
    parameters = {one.path: one for one in (*bodies.mechanism.parameters(), *acting)}
    check_set(rows, parameters, speeds, over_time, report)
    return events_of(rows, bodies.mechanism, names, report)


def _change_tables(tables: Tables, start: StartTable | None, names: Names, report: Report) -> ChangeTables:
    """The tables of what lets go and takes hold."""
    rows: list[tuple[Path, ReleaseTable | HoldTable]] = []
    for index, release in enumerate(_tables(ReleaseTable, tables, "release", names, report)):
        rows += [(("release", index), release)] if release else []
    for index, hold in enumerate(_tables(HoldTable, tables, "hold", names, report)):
        rows += [(("hold", index), hold)] if hold else []
    return ChangeTables(tuple(rows), tuple(start.open) if start and start.open is not None else None)


def _check_tables(tables: Tables, report: Report) -> None:
    """Each table by itself, where faults of parts leave open what others could name."""
    names = with_laws(read_names(tables.get("let", {}), report), tables)
    for key in (key for key in MODELS if key in tables and key != "let"):
        (_tables if key in MANY else _table)(MODELS[key], tables, key, names, report)


def _read_again(tables: Tables, report: Report, changed: Collection[Path], whole: bool) -> Mechanism | None:
    """Reads tables that hold stand-ins at the places ``changed``: where one could change where links are or what holds
    them, no start is looked for."""
    placing = any(path[0] in PLACING and not NOT_PLACING & set(path) for path in changed)
    bodies = _read(tables, report, whole and not placing, again=True).bodies
    return bodies.mechanism if bodies else None


def _ground_link(tables: Tables, report: Report) -> Tables:
    """The tables with ``[ground]`` read as ``[ground_link]`` where its points show that this is meant; a fault."""
    ground = tables.get("ground")
    if not isinstance(ground, Mapping) or "points" not in ground or "ground_link" in tables:
        return tables
    message = (
        "found [ground] with points, expected them in [ground_link], the link that does not move; write [ground_link]"
    )
    report.add(("ground",), message)
    return {key: value for key, value in tables.items() if key != "ground"} | {
        "ground_link": {"points": ground["points"]}
    }


def _let(tables: Tables, report: Report) -> Tables:
    """The tables with one of another name for ``[let]`` read as that; a fault."""
    for key in OTHER_NAMES_OF_LET:
        if key in tables and "let" not in tables:
            report.add((key,), f"found [{key}], expected names of numbers in [let]; write [let]")
            return {("let" if one == key else one): table for one, table in tables.items()}
    return tables


def _name(tables: Tables, default: str, report: Report) -> str:
    name = tables.get("name", default)
    if isinstance(name, str) and keyword.iskeyword(name):
        report.add(("name",), f"found {show(name)}, a word of Python's own, expected a name for a package; change it")
        return "scene"
    given = show(name) if "name" in tables else f"the file's name {show(name)}"
    advice = "change it" if "name" in tables else "add a name at the top of the file"
    if isinstance(name, str) and re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]*", name):
        if module := hidden_module(name.replace("-", "_")):
            report.add(("name",), f"found {given}, the name of {module}, expected one that hides no module; {advice}")
        return name
    report.add(("name",), f"found {given}, expected letters, digits, - and _, beginning with a letter; {advice}")
    return "scene"


def _table(model: type[T], tables: Tables, key: str, names: Names, report: Report) -> T | None:
    """The table ``key``, empty where it is missing."""
    return check(model, tables.get(key, {}), (key,), names, report)


def _tables(model: type[T], tables: Tables, key: str, names: Names, report: Report) -> list[T | None]:
    """The array of tables ``key``."""
    raw = tables.get(key, [])
    if not isinstance(raw, list):
        report.add((key,), f"found {show(raw)}, expected an array of tables; write [[{key}]]")
        return []
    return [check(model, one, (key, index), names, report) for index, one in enumerate(raw)]


def _bodies(tables: Tables, names: Names, report: Report, released: Collection[str], gated: Gated) -> Bodies | None:
    """The mechanism in the one form that the scene uses, without the ``released`` joints, or with these open among
    those that are ``gated``, if any are; ``None`` after faults."""
    forms = [key for key in (*SHORTHAND, "link") if key in tables]
    for key in forms[1:]:
        report.add((key,), f"found [{key}] beside [{forms[0]}], expected one description of the links; remove one")
    if not forms:
        message = "found no links, expected one of [loop], [chain], [pinned], [four_bars] or [[link]]; add one"
        report.add((), message)
    for key, most in (("link", MOST_LINKS), ("joint", MOST_JOINTS)):
        if isinstance(tables.get(key), list) and len(tables[key]) > most:
            message = f"found {len(tables[key])} tables, expected at most {most}; make the mechanism smaller"
            report.add((key, most), message)
            return None
    raw = tables.get("link", [])
    links = [
        table and with_around(table, ("link", index), report)
        for index, table in enumerate(_tables(LinkTable, tables, "link", names, report))
    ]
    joints = _tables(JointTable, tables, "joint", names, report)
    ground = _table(GroundLinkTable, tables, "ground_link", names, report) if "ground_link" in tables else None
    for key in ("joint", "ground_link"):
        if key in tables and "link" not in forms:
            report.add((key,), "found without [[link]], expected only with it; remove it or describe the links")
    rods = [(form, check(SHORTHAND[form], tables[form], (form,), names, report)) for form in forms if form != "link"]
    built = [shorthand(form, table, report) for form, table in rods if table]
    if len(forms) != 1:
        return None
    if forms == ["link"]:
        if raw == []:
            report.add(("link",), "found no links, expected at least one; add a [[link]]")
        found = general(tables, links, joints, ground, report) if links else None
    else:
        found = built[0] if built else None
    if found and gated.joints:
        return with_gates(found, gated.joints, released, gated.driven)
    return with_open(found, released) if found else None


def _bodies_with_squares(
    tables: Tables, names: Names, report: Report, released: Collection[str], gated: Gated, again: bool
) -> Bodies | None:
    """The mechanism, if its lengths have squares. Those that have none are told unless ``again``, or after faults of
    the bodies, of which they may be the cause."""
    faults = len(report.found)
    bodies = _bodies(tables, names, report, released, gated)
    if bodies is None:
        return None
    told = Report(report.file) if again or len(report.found) > faults else report
    return bodies if check_lengths(bodies.mechanism.parameters(), tables, MODELS, names, told) else None


def _effect_tables(tables: Tables, names: Names, report: Report) -> list[EffectTable]:
    """The tables of all effects that the scene names, in the order of the registry."""
    found: list[EffectTable] = []
    for entry in REGISTRY:
        if entry.key not in tables:
            continue
        if entry.many:
            given = tables[entry.key]
            if isinstance(given, list) and len(given) > MOST_TABLES:
                message = (
                    f"found {len(given)} tables, expected at most {MOST_TABLES}, because equations are written out"
                )
                report.add((entry.key, MOST_TABLES), f"{message} for each; leave out what is not needed")
                given = given[:MOST_TABLES]
            many = enumerate(_tables(entry.table, {entry.key: given}, entry.key, names, report))
            found += [EffectTable(entry, index, (entry.key, index), table) for index, table in many if table]
        elif table := _table(entry.table, tables, entry.key, names, report):
            found.append(EffectTable(entry, 0, (entry.key,), table))
    return found


def _effects(tables: list[EffectTable], bodies: Bodies, names: Names, report: Report) -> list[tuple[Path, Effect]]:
    """The records of the effects, with the keys at which their faults are reported."""
    around = Surroundings(bodies.mechanism, bodies.contacts)
    used = {link.name for link in bodies.mechanism.links} | {"ground"}
    used |= {joint.name for joint in bodies.mechanism.joints if joint.parameters()}
    built: list[tuple[Path, Effect]] = []
    read = read_states([Row(one.path, one.number, one.table) for one in tables], bodies.mechanism, names, report)
    for (entry, index, path, _), table in zip(tables, read, strict=True):
        effect = entry.build(table, index, around, report.below(path)) if table else None
        name = getattr(effect, "name", None)
        if name in used:
            report.add((*path, "name"), f"found {show(name)} a second time, expected a new name; rename one of them")
        elif effect is not None:
            built.append((path, effect))
            for key in effect.angles():
                judge_angle(getattr(table, key), (*path, key), names, report)
        used |= {name} if name else set()
    return built


def _start(
    table: StartTable,
    bodies: Bodies,
    effects: list[tuple[Path, Effect]],
    report: Report,
    assemble: bool,
    absent: Collection[Path] = (),
    holds: Collection[str] = (),
) -> Start | None:
    """Judged without effects that are ``absent``; ``holds`` are joints that take hold."""
    acting = [effect for _, effect in effects]
    driven = [joint for effect in acting for joint in effect.driven()]
    asked = sketch(table, bodies, driven, report)
    if not assemble:
        return None
    sound = check_driven(bodies.mechanism, effects, report)
    sound = check_masses(bodies, driven, report) and sound
    start = begin(asked, bodies, effects, report, holds) if asked and sound else None
    if start is None or not check_masses(bodies, driven, report, start.poses):
        return None
    present = [(path, effect) for path, effect in effects if path not in absent]
    start = lift(start, bodies, [effect for _, effect in present])
    check_effects(start, bodies, present, report)
    check_energy(start, bodies.mechanism, report)
    return start
