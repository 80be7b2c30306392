"""From what a scene says about its start to a consistent one: loops closed, speeds that keep them closed."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from ..effect_base.effect import Effect, Level
from ..mechanism.assembled import Assembled
from ..mechanism.assembly import CannotClose, Contradiction, follow, nearest, rates
from ..mechanism.implied import implied
from ..mechanism.layout import Held, Layout, Length, Real, lay_out
from ..mechanism.mechanism import Mechanism
from .bodies import Bodies
from .contradictions import (
    RANK,
    check_meshed,
    closes,
    report_apart,
    report_drives,
    report_open,
    report_rates,
    report_stuck,
)
from .drawn import anchors, carried, drawn_lengths, offset, pinned_as_drawn, spread
from .driven import drive_layout, held_as_given, mesh_speeds, moved_from_given, with_given
from .errors import Path, Report
from .scene import Given, Kept, Sketch, Start
from .schema import StartTable

SKETCH = 1e-9
"""Angles that leave a joint open by more than this (m) are a sketch, to be assembled."""


def sketch(table: StartTable, bodies: Bodies, driven: Collection[int], report: Report) -> Sketch | None:
    """What ``[start]`` asks for, defaults filled in; ``None`` after faults."""
    fine = _check_held(table, bodies.mechanism, report)
    fine = _check_implied(table, bodies.mechanism, driven, report) and fine
    if table.position is not None and table.height is not None:
        message = "found a height beside a position, expected one of them; remove the other"
        report.add(("start", "height"), message)
        fine = False
    names = [link.name for link in bodies.mechanism.links]
    angles = _per_link(table.angles, bodies.mechanism, ("start", "angles"), report)
    speeds = _per_link(table.angular_velocities, bodies.mechanism, ("start", "angular_velocities"), report)
    lines = [joint.name for joint in bodies.mechanism.joints if joint.slides]
    slides = _by_name(table.slides, lines, ("start", "slides"), "sliding joint", report)
    sliding = _by_name(table.sliding_velocities, lines, ("start", "sliding_velocities"), "sliding joint", report)
    drawn = anchors(table, bodies.mechanism, report)
    if angles is None or speeds is None or slides is None or sliding is None or drawn is None or not fine:
        return None
    if table.angular_velocities is None and bodies.rates:
        speeds = list(bodies.rates)
    given_angles, given_speeds = list(angles), list(speeds)
    for one in bodies.mechanism.integrators:
        angles[one.link], speeds[one.link] = -table.tilt, 0.0
    for name, (_, _, angle) in (table.poses or {}).items():
        angles[names.index(name)] = angle
    said = table.angles is not None or bool(drawn) or bool(table.slides)
    found = spread(bodies.mechanism, angles, drawn) if said else angles
    chosen = [usual if angle is None else angle for angle, usual in zip(found, bodies.sketch, strict=True)]
    slides = carried(bodies.mechanism, [angle + table.tilt for angle in chosen], drawn, slides)
    slides = drawn_lengths(bodies.mechanism, [angle + table.tilt for angle in chosen], drawn, slides)
    return Sketch(
        angles=tuple(angle + table.tilt for angle in chosen),
        rates=tuple(speeds),
        position=_pair(table.position),
        velocity=_pair(table.velocity),
        height=table.height,
        slides=tuple(slides),
        sliding=tuple(sliding),
        loose=tuple(link for link, angle in enumerate(found) if said and angle is None),
        drawn=drawn,
        given=Given(
            _numbers_of(given_angles, bodies.mechanism),
            _numbers_of(given_speeds, bodies.mechanism),
            tuple(k for k, name in enumerate(lines) if name in (table.slides or ())),
            tuple(k for k, name in enumerate(lines) if name in (table.sliding_velocities or ())),
        ),
    )


def begin(
    sketch: Sketch,
    bodies: Bodies,
    effects: Sequence[tuple[Path, Effect]],
    report: Report,
    holds: Collection[str] = (),
) -> Start | None:
    """The consistent start nearest to ``sketch``, heights not yet applied; ``None`` after faults.

    ``holds`` are joints that take hold, and so may be open at the start."""
    layout = lay_out(bodies.mechanism, driven=[joint for _, effect in effects for joint in effect.driven()])
    if layout.apart:
        report_apart(layout, bodies, report)
        return None
    told = [k for k, joint in enumerate(bodies.mechanism.joints) if joint.slides]
    along = [told.index(line.joint) for line in layout.lines]
    slides, sliding = ([of[k] for k in along] for of in (sketch.slides, sketch.sliding))
    wanted = np.array([*sketch.angles, *((slide or 0.0) / layout.unit for slide in slides)])
    drives = [(path, effect) for path, effect in effects if effect.driven()]
    meshes = mesh_speeds(layout, bodies.mechanism)
    driven, prescribed = drive_layout(layout, bodies.mechanism, [effect for _, effect in drives])
    if not _check_slides(slides, len(sketch.angles), driven, bodies.mechanism, report):
        return None
    count = len(sketch.angles)
    loose = [*sketch.loose, *(count + k for k, slide in enumerate(slides) if slide is None)]
    drawn, exact = wanted, held_as_given(layout, bodies.mechanism, [effect for _, effect in drives], sketch)
    try:
        wanted, found, still = _closed(driven, drawn, loose, exact, sketch, bodies.mechanism)
    except CannotClose as error:
        if any(effect.begins()[0] is not None for _, effect in drives) and closes(layout, wanted):
            report_drives(drives, f"found positions that miss by {error.miss:.3g} {error.unit} together", report)
        else:
            report_open(driven, error, wanted, bodies, len(drives), report)
        return None
    asked = [*sketch.rates, *(rate if rate is None else rate / layout.unit for rate in sliding)]
    given = {index: rate for index, rate in enumerate(asked) if rate is not None}
    if meshes and not check_meshed(layout, found, prescribed, meshes, bodies.mechanism, effects, report):
        return None
    try:
        speeds = rates(layout, found, given, speeds=(*prescribed, *meshes))
    except Contradiction as error:
        if not report_stuck(layout, found, prescribed, drives, bodies.mechanism, report):
            report_rates(error, drives, layout, bodies.mechanism, holds, report)
        return None
    poses = layout.poses(found, sketch.position)
    if sketch.drawn and layout.floating:
        away = offset(bodies.mechanism, poses.tolist(), sketch.drawn)
        poses[:, :2] += (away.real, away.imag)
    velocities = layout.velocities(found, speeds, sketch.velocity)
    start = Start(_triples(poses), _triples(velocities), sketch)
    places, moving = _given_entries(sketch, along)
    untouched = all(abs(found[k] - wanted[k]) <= SKETCH for k in places)
    staying = _kept(driven.jacobian(found), places) if untouched else None
    rows = np.vstack([layout.jacobian(found), *(one.row for one in (*prescribed, *meshes))])
    going = _kept(rows, moving)
    all_told = staying is not None and {*places, *loose} == {*range(len(found))}
    as_wanted = not sketch.drawn and (not loose or all_told)
    start = replace(
        start,
        kept_places=_entries(staying or (), layout),
        kept_rates=_entries(going or (), layout),
        wanted=tuple(drawn.tolist()) if as_wanted and driven.groups else (),
        unit=layout.unit,
        sketched_rates=going is None or any(given[k] != 0.0 for k in given if k not in moving),
        free_rates=_freedoms(rows, going or ()) > 0,
        kept_drives=tuple(still) if staying is None else (),
        moved=moved_from_given(
            bodies.mechanism, [effect for _, effect in drives], sketch, _triples(poses), SKETCH * layout.unit
        ),
    )
    return _judged(start, driven, wanted, found, loose, bodies.mechanism)


def _closed(
    layout: Layout,
    drawn: Real,
    loose: Sequence[int],
    exact: Mapping[int, Held | Length],
    sketch: Sketch,
    mechanism: Mechanism,
) -> tuple[Real, Real, dict[int, Held | Length]]:
    """The sketch and the closed configuration nearest to it, with driven joints as ``exact`` has them, by the number of
    the drive: all of these if the loops close so, else as many as they do with, in their order; and which.

    Raises ``CannotClose`` where the loops do not close at all.
    """

    def close(still: Mapping[int, Held | Length]) -> tuple[Real, Real]:
        held = with_given(layout, still.values())
        pinned = pinned_as_drawn(held, mechanism, sketch.drawn, sketch.loose)
        near = follow(pinned, drawn, loose) if len(pinned.gaps) > len(held.gaps) else drawn
        wanted = follow(held, near, loose) if loose and held.groups else near
        return wanted, nearest(held, wanted)

    wanted, found = close({})
    if np.max(np.abs(with_given(layout, exact.values()).closure(found)), initial=0.0) <= SKETCH:
        return wanted, found, dict(exact)
    if len(exact) > 1:
        with suppress(CannotClose):
            return *close(exact), dict(exact)
    still = dict[int, Held | Length]()
    for number, one in exact.items():
        with suppress(CannotClose):
            wanted, found = close({**still, number: one})
            still[number] = one
    return wanted, found, still


def _numbers_of(values: Sequence[float | None], mechanism: Mechanism) -> tuple[int, ...]:
    """Links of the scene that have a value."""
    return tuple(link for link, value in enumerate(values[: mechanism.own_links]) if value is not None)


def _given_entries(sketch: Sketch, along: Sequence[int]) -> tuple[list[int], list[int]]:
    """The displacements that a scene gives, and those whose rates; ``along``: which sliding joint each line is of."""
    count, given = len(sketch.angles), sketch.given
    places = [*given.angles, *(count + k for k, joint in enumerate(along) if joint in given.slides)]
    rates = [*given.rates, *(count + k for k, joint in enumerate(along) if joint in given.sliding)]
    return places, rates


def _kept(rows: Real, entries: Sequence[int]) -> list[int] | None:
    """Which of the displacements ``entries`` can keep what the scene gives where ``rows`` are satisfied with other
    numbers: all that these rows do not fix by themselves. None where rows do not leave all of those free together, for
    then they are a sketch."""
    left = _motions(rows).T
    open_ones = [k for k in entries if np.linalg.norm(left[k]) > RANK]
    if int(np.linalg.matrix_rank(left[open_ones], tol=RANK)) < len(open_ones):
        return None
    return open_ones


def _motions(rows: Real) -> Real:
    """Directions of the displacements, a row each, that satisfy ``rows``."""
    _, values, motions = np.linalg.svd(rows)
    return np.asarray(motions[int(np.sum(values > RANK)) :], dtype=np.float64)


def _freedoms(rows: Real, kept: Sequence[int]) -> int:
    """How many motions satisfy ``rows`` and leave the displacements ``kept`` as they are."""
    return len(_motions(np.vstack([rows, np.eye(rows.shape[1])[[*kept]]])))


def _entries(kept: Sequence[int], layout: Layout) -> tuple[Kept, ...]:
    """What these displacements are: angles of links, or lengths along joints."""
    count = len(layout.base)
    return tuple(("angle", k) if k < count else ("slide", layout.lines[k - count].joint) for k in kept)


def _check_slides(
    slides: Sequence[float | None], links: int, driven: Layout, mechanism: Mechanism, report: Report
) -> bool:
    """Lengths that the scene gives are those that drives ask for at t = 0."""
    fine = True
    for one in driven.lengths:
        given = slides[one.index - links]
        if given is not None and abs(given - one.length) > SKETCH:
            name = mechanism.joints[one.joint].name
            message = f"found {given:.6g}, expected {one.length:.6g}, where its drive has it at t = 0; remove it"
            report.add(("start", "slides", name), message)
            fine = False
    return fine


def _judged(
    start: Start, layout: Layout, wanted: Real, found: Real, loose: Sequence[int], mechanism: Mechanism
) -> Start:
    """The start with how far it is from its sketch: links that turned, joints that slid, and the drawn point that is
    farthest off."""
    off = [offset(mechanism, start.poses, [anchor]) for anchor in start.sketch.drawn]
    start = replace(start, missed_by=max(map(abs, off), default=0.0))
    if float(np.abs(layout.closure(wanted)).max(initial=0.0)) <= SKETCH:
        return start
    count = len(start.poses)
    moved = np.abs(found - wanted)
    moved[[*loose]] = 0.0
    links = [link.name for link in mechanism.links]
    joints = [mechanism.joints[line.joint].name for line in layout.lines]
    return replace(
        start, turned=_largest_first(links, moved[:count]), slid=_largest_first(joints, moved[count:] * layout.unit)
    )


def _largest_first(names: Sequence[str], changes: Real) -> tuple[tuple[str, float], ...]:
    """The changes that are not zero, each with its name; of equal ones the first in the scene."""
    changed = [(name, float(change)) for name, change in zip(names, changes, strict=True) if change]
    return tuple(sorted(changed, key=lambda one: -one[1]))


def lift(start: Start, bodies: Bodies, effects: Sequence[Effect]) -> Start:
    """The start moved so that its lowest joint has the height that was asked for, above the first ground or y = 0."""
    if start.sketch.height is None:
        return start
    level = next((found for effect in effects if (found := effect.level())), None) or Level()
    assembled = Assembled(bodies.mechanism, start.poses)
    places = [assembled.place(ref) for _, ref in bodies.contacts] or [start.poses[0][:2]]
    rise = start.sketch.height - min(level.height(*xy) for xy in places)
    dx, dy = rise * level.normal[0], rise * level.normal[1]
    poses = tuple((x + dx, y + dy, angle) for x, y, angle in start.poses)
    return replace(start, poses=poses)


def check_effects(start: Start, bodies: Bodies, effects: Sequence[tuple[Path, Effect]], report: Report) -> None:
    """Report what each effect finds wrong with the start."""
    asked = start.sketch
    assembled = Assembled(bodies.mechanism, start.poses)
    for path, effect in effects:
        lifted = asked.height is not None and effect.level() is not None
        for sentence in effect.check_start(assembled):
            report.add(("start", "height") if lifted else path, sentence)


def settle(start: Start, bodies: Bodies, effects: Sequence[tuple[Path, Effect]]) -> list[tuple[Path, Effect]]:
    """The effects with what they take from the ``start`` of the scene, whose ``bodies`` these are."""
    assembled = Assembled(bodies.mechanism, start.poses)
    return [(path, effect.settled(assembled)) for path, effect in effects]


def check_energy(start: Start, mechanism: Mechanism, report: Report) -> None:
    """The kinetic energy of the start is a number."""
    total = 0.0
    for link, (_, _, angle), (vx, vy, spin) in zip(mechanism.links, start.poses, start.velocities, strict=True):
        arm = complex(*link.com.values()) * np.exp(1j * angle)
        speed = np.hypot(vx - spin * arm.imag, vy + spin * arm.real)
        total += 0.5 * (link.mass.value if link.mass else 0.0) * float(speed) * float(speed)
        total += 0.5 * (link.inertia.value if link.inertia else 0.0) * spin * spin
    if not np.isfinite(total):
        fastest = max(max(map(abs, row)) for row in start.velocities)
        message = f"found velocities of up to {fastest:.3g}, expected a kinetic energy that is a finite number"
        report.add(("start",), f"{message}; give smaller ones")


def _check_held(table: StartTable, mechanism: Mechanism, report: Report) -> bool:
    """A mechanism that the ground holds has no place or velocity of its own, nor a tilt if its angle is held too."""
    hinges = {one.joint for one in mechanism.integrators}
    on_ground = [joint for joint in mechanism.joints if joint.on_ground and joint.name not in hinges]
    held = sum(2 if not joint.turns else 1 for joint in on_ground)
    wrong = [key for key in ("position", "velocity", "height") if held and getattr(table, key) is not None]
    if held > 1 and table.tilt:
        wrong.append("tilt")
    for key in wrong:
        message = f"found a {key}, expected none, because the ground holds the mechanism; remove it or give angles"
        report.add(("start", key), message)
    return not wrong


def _check_implied(table: StartTable, mechanism: Mechanism, driven: Collection[int], report: Report) -> bool:
    """Lengths and speeds are given of joints that lead, not of those that follow from them."""
    followers = {mechanism.joints[idle.joint].name: idle for idle in implied(mechanism, driven)}
    wrong = [
        (key, name)
        for key in ("slides", "sliding_velocities")
        for name in getattr(table, key) or ()
        if name in followers
    ]
    for key, name in wrong:
        others = ", ".join(mechanism.joints[part.joint].name for part in followers[name].way)
        report.add(("start", key, name), f"found a joint that follows from {others}, expected none; remove it")
    return not wrong


def _per_link(
    given: Sequence[float] | Mapping[str, float] | None, mechanism: Mechanism, path: Path, report: Report
) -> list[float | None] | None:
    """One value per link, ``None`` where nothing is said; ``None`` altogether after faults."""
    names, welded = [link.name for link in mechanism.links[: mechanism.own_links]], mechanism.welded
    others: list[float | None] = [None] * (len(mechanism.links) - len(names))
    if given is None:
        return [None] * len(mechanism.links)
    if isinstance(given, Mapping):
        unknown = [name for name in given if name not in names]
        for name in unknown:
            advice = "correct the name"
            if name in welded:
                advice = f"it is welded to {mechanism.link_name(welded[name])}, whose angle says where it is"
            report.add((*path, name), f"found an unknown link, expected one of {', '.join(names)}; {advice}")
        return None if unknown else [*map(given.get, names), *others]
    if len(given) != len(names):
        message = f"found {len(given)} values, expected {len(names)}, one per link; correct the list or use a table"
        report.add(path, message)
        return None
    return [*given, *others]


def _by_name(
    given: Mapping[str, float] | None, names: Sequence[str], path: Path, kind: str, report: Report
) -> list[float | None] | None:
    """One value per name, ``None`` where nothing is said; ``None`` altogether after faults."""
    unknown = [name for name in given or () if name not in names]
    for name in unknown:
        known = f"one of {', '.join(names)}" if names else f"none, because there is no {kind}"
        advice = "correct the name" if names else "what is free has a position and a velocity"
        report.add((*path, name), f"found an unknown {kind}, expected {known}; {advice}")
    return None if unknown else [(given or {}).get(name) for name in names]


def _pair(value: Sequence[float] | None) -> tuple[float, float]:
    return (value[0], value[1]) if value is not None else (0.0, 0.0)


def _triples(rows: Real) -> tuple[tuple[float, float, float], ...]:
    return tuple((float(a), float(b), float(c)) for a, b, c in rows)
