"""From what a scene says about its start to a consistent one: loops closed, speeds that keep them closed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..effects.effect import Effect, Level
from ..mechanism.assembly import CannotClose, Contradiction, Layout, Real, lay_out, nearest, rates
from ..mechanism.joints import PointRef
from ..mechanism.mechanism import Mechanism
from .bodies import Bodies
from .errors import Path, Report
from .scene import Sketch, Start
from .schema import StartTable

SKETCH = 1e-9
"""Angles that leave a joint open by more than this (m) are a sketch, to be assembled."""


def sketch(table: StartTable, bodies: Bodies, report: Report) -> Sketch | None:
    """What ``[start]`` asks for, defaults filled in; ``None`` after faults."""
    fine = _check_held(table, bodies.mechanism, report)
    if table.position is not None and table.height is not None:
        message = "found a height beside a position, expected one of them; remove the other"
        report.add(("start", "height"), message)
        fine = False
    names = [link.name for link in bodies.mechanism.links]
    angles = _per_link(table.angles, names, ("start", "angles"), report)
    speeds = _per_link(table.angular_velocities, names, ("start", "angular_velocities"), report)
    if angles is None or speeds is None or not fine:
        return None
    if table.angular_velocities is None and bodies.rates:
        speeds = list(bodies.rates)
    chosen = [usual if angle is None else angle for angle, usual in zip(angles, bodies.sketch, strict=True)]
    return Sketch(
        angles=tuple(angle + table.tilt for angle in chosen),
        rates=tuple(speeds),
        position=_pair(table.position),
        velocity=_pair(table.velocity),
        height=table.height,
    )


def begin(sketch: Sketch, bodies: Bodies, report: Report) -> Start | None:
    """The consistent start nearest to ``sketch``, heights not yet applied; ``None`` after faults."""
    layout = lay_out(bodies.mechanism)
    if layout.apart:
        _report_apart(layout, bodies, report)
        return None
    wanted = np.array(sketch.angles)
    try:
        angles = nearest(layout, wanted)
    except CannotClose as error:
        name = bodies.mechanism.joints[error.joint].name
        path: Path = ("joint", error.joint) if bodies.path == ("joint",) else bodies.path
        report.add(
            path,
            f"found no way to close {name}, the nearest configuration misses by {error.miss:.3g} m, expected 0; "
            "change lengths or points, or give [start] angles nearer to a closed configuration",
        )
        return None
    given = {link: rate for link, rate in enumerate(sketch.rates) if rate is not None}
    try:
        speeds = rates(layout, angles, given)
    except Contradiction as error:
        names = ", ".join(bodies.mechanism.links[link].name for link in error.links)
        report.add(
            ("start", "angular_velocities"),
            f"found angular velocities of {names} that open {bodies.mechanism.joints[error.joint].name} at "
            f"{error.speed:.3g} m/s, expected loops to stay closed; correct one of them or give fewer",
        )
        return None
    open_by = float(np.abs(layout.closure(wanted)).max(initial=0.0))
    moved = float(np.abs(angles - wanted).max()) if open_by > SKETCH else 0.0
    poses = layout.poses(angles, sketch.position)
    velocities = layout.velocities(angles, speeds, sketch.velocity)
    return Start(_triples(poses), _triples(velocities), moved, sketch)


def lift(start: Start, bodies: Bodies, effects: Sequence[Effect]) -> Start:
    """The start moved so that its lowest joint has the height that was asked for, above the first ground or y = 0."""
    if start.sketch.height is None:
        return start
    level = next((found for effect in effects if (found := effect.level())), None) or Level()
    places = [place(bodies.mechanism, start, ref) for _, ref in bodies.contacts] or [start.poses[0][:2]]
    rise = start.sketch.height - min(level.height(*xy) for xy in places)
    dx, dy = rise * level.normal[0], rise * level.normal[1]
    poses = tuple((x + dx, y + dy, angle) for x, y, angle in start.poses)
    return Start(poses, start.velocities, start.assembled_by, start.sketch)


def check_effects(start: Start, bodies: Bodies, effects: Sequence[tuple[Path, Effect]], report: Report) -> None:
    """Report what each effect finds wrong with the start."""
    asked = start.sketch
    for path, effect in effects:
        for sentence in effect.check_start(lambda ref: place(bodies.mechanism, start, ref)):
            report.add(("start", "height") if asked.height is not None else path, sentence)


def place(mechanism: Mechanism, start: Start, ref: PointRef) -> tuple[float, float]:
    """Where the point ``ref`` is at the start (m)."""
    px, py = mechanism.point(ref).values()
    if ref.link < 0:
        return px, py
    x, y, angle = start.poses[ref.link]
    turned = complex(px, py) * np.exp(1j * angle)
    return float(x + turned.real), float(y + turned.imag)


def _check_held(table: StartTable, mechanism: Mechanism, report: Report) -> bool:
    """A mechanism that the ground holds has no place or velocity of its own, nor a tilt if it is held twice."""
    held = sum(joint.on_ground for joint in mechanism.joints)
    wrong = [key for key in ("position", "velocity", "height") if held and getattr(table, key) is not None]
    if held > 1 and table.tilt:
        wrong.append("tilt")
    for key in wrong:
        message = f"found a {key}, expected none, because the ground holds the mechanism; remove it or give angles"
        report.add(("start", key), message)
    return not wrong


def _per_link(
    given: Sequence[float] | Mapping[str, float] | None, names: Sequence[str], path: Path, report: Report
) -> list[float | None] | None:
    """One value per link, ``None`` where nothing is said; ``None`` altogether after faults."""
    if given is None:
        return [None] * len(names)
    if isinstance(given, Mapping):
        unknown = [name for name in given if name not in names]
        for name in unknown:
            report.add((*path, name), f"found an unknown link, expected one of {', '.join(names)}; correct the name")
        return None if unknown else [given.get(name) for name in names]
    if len(given) != len(names):
        message = f"found {len(given)} values, expected {len(names)}, one per link; correct the list or use a table"
        report.add(path, message)
        return None
    return list(given)


def _report_apart(layout: Layout, bodies: Bodies, report: Report) -> None:
    links = bodies.mechanism.links
    base = links[0].name if layout.floating else "the ground"
    for index in layout.apart:
        message = f"found no joints that connect {links[index].name} with {base}, expected one piece; add a [[joint]]"
        report.add(("link", index), message)


def _pair(value: Sequence[float] | None) -> tuple[float, float]:
    return (value[0], value[1]) if value is not None else (0.0, 0.0)


def _triples(rows: Real) -> tuple[tuple[float, float, float], ...]:
    return tuple((float(a), float(b), float(c)) for a, b, c in rows)
