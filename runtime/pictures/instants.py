"""Which instants of a run are worth a picture."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..record.record import Record
from .frames import Frames, placed, sample
from .strokes import size_of_looks

PANELS = 6  # poses drawn
GRID = 400  # instants among which one is sought that does not look like another
ALIKE = 0.25  # poses nearer than this part of the motion's extent look alike, unless the motion is still on its way
APART = 0.3  # least distance of impacts from each other, as part of that of even instants
NEAR = 0.15  # impacts that are nearer in time are shown where a point has moved by this part of the links' size
MOST = 200  # impacts among which those are sought
FEW = 2  # times as many impacts as there is room for are too many to show some of them


def instants(run: Record, count: int = PANELS) -> list[tuple[float, str]]:
    """Up to `count` instants worth a picture, with their titles, in order: start, end, joints that change, events, and
    impacts.

    Of events the first of each name, where they are few. Of impacts those with the largest impulses, not near each
    other; where there are many, none. Gaps are filled with even instants, moved where the motion has come back to what
    another one shows.
    """
    start, end = float(run.t[0]), float(run.t[-1])
    struck = "start, impact 1" if run.impacts and run.impacts[0].t == start else "start"
    named = {start: struck, end: "end"} if end > start else {start: struck}
    for change in run.changes[: count - 2]:
        named.setdefault(float(change.t), f"{change.joint} {'lets go' if change.kind == 'release' else 'takes hold'}")
    apart = APART * (end - start) / max(count - 1, 1)
    named |= _events(run, [*named], apart, count - len(named))
    found = _impacts(run, sorted(named), apart)
    room = count - len(named)
    if len(found) <= FEW * room:
        named |= dict(found[:room])
    times = np.array(sorted(named))
    if len(times) > 1 and len(times) < count:
        times = _filled(run, times, count)
    return [(float(t), named.get(float(t), "")) for t in times]


def _events(run: Record, taken: list[float], apart: float, room: int) -> dict[float, str]:
    """The first event of each name and its title, without those near what is ``taken``; none where there is no
    ``room`` for all names."""
    first = {event.name: float(event.t) for event in reversed(run.events)}
    named: dict[float, str] = {}
    for name, t in sorted(first.items(), key=lambda one: one[1]) if len(first) <= room else ():
        if t in named:
            named[t] += f", {name}"
        elif all(abs(t - other) > apart for other in [*taken, *named]):
            named[t] = name
    return named


def _impacts(run: Record, taken: list[float], apart: float) -> list[tuple[float, str]]:
    """Impacts and their titles, the largest first, without those that look like another one or what is ``taken``."""
    numbered = [(k, impact) for k, impact in enumerate(run.impacts, start=1) if run.t[0] < impact.t < run.t[-1]]
    sizes = {k: float(f"{np.abs(impact.impulses).sum():.6g}") for k, impact in numbered}  # equal ones in their order
    largest = sorted(numbered, key=lambda one: (-sizes[one[0]], one[0]))[:MOST]
    times = np.array([*taken, *(float(impact.t) for _, impact in largest)])
    frames = sample(run, times)
    shown = _seen(run, frames)
    near = NEAR * size_of_looks(frames, 0.0)
    chosen = list(range(len(taken)))
    for k in range(len(taken), len(times)):
        moved = _distance(shown[chosen], shown[k][None]) if shown.shape[1] else np.zeros(len(chosen))
        if np.all((np.abs(times[chosen] - times[k]) > apart) | ((near > 0.0) & (moved > near))):
            chosen.append(k)
    return [(float(times[k]), f"impact {largest[k - len(taken)][0]}") for k in chosen[len(taken) :]]


def _filled(run: Record, times: FloatArray, count: int) -> FloatArray:
    """With even instants in the gaps, of which none shows what another does if that can be."""
    parts = np.ones(len(times) - 1)  # into how many equal parts each gap is cut
    while parts.sum() < count - 1:
        parts[np.argmax(np.diff(times) / parts)] += 1
    even = np.interp(np.arange(parts.sum() + 1), np.concatenate([[0], np.cumsum(parts)]), times)
    free = [k for k, t in enumerate(even) if t not in times]
    slot = float(np.min(np.diff(even)))
    grid = np.unique(np.concatenate([even, np.linspace(times[0], times[-1], GRID)]))
    frames = sample(run, grid)
    shown = _seen(run, frames)
    if not shown.shape[1]:
        return even
    travelled = np.concatenate([[0.0], np.cumsum(_distance(shown[1:], shown[:-1]))])
    extent = float(np.max(_distance(shown, shown[:1])))
    chosen = {int(np.searchsorted(grid, t)) for t in times}
    for k in free:
        near = np.flatnonzero(np.abs(grid - even[k]) < 0.45 * slot)
        at = int(np.searchsorted(grid, even[k]))
        others = sorted(chosen)
        away = np.array([_distance(shown[near], shown[other][None]) for other in others])
        way = np.array([np.minimum(np.abs(travelled[near] - travelled[other]), extent) for other in others])
        here = int(np.searchsorted(near, at))
        if np.any(away[:, here] < ALIKE * way[:, here]):
            at = int(near[np.argmax(away.min(axis=0))])
        chosen.add(at)
        even[k] = grid[at]
    return even


def _seen(run: Record, frames: Frames) -> FloatArray:
    """The places (n, points, 2), in m, of all that is drawn of links, and of joints."""
    in_force, which = frames.states.in_force

    def drawn(k: int) -> FloatArray:
        return in_force.told(which, lambda model, rows: placed(np.asarray(model.outlines[k]), frames.poses[rows, k]))

    outlines = [drawn(k) for k in range(len(run.model.outlines))]
    rims = [placed(disc.outline[:1], frames.poses[:, disc.link]) for disc in run.model.discs if not disc.fixed]
    return np.concatenate([*outlines, *rims, frames.joints], axis=1)


def _distance(one: FloatArray, other: FloatArray) -> FloatArray:
    """How far the farthest point moves between configurations (n, points, 2): (n,)."""
    return np.asarray(np.max(np.hypot(*np.moveaxis(one - other, -1, 0)), axis=-1))
