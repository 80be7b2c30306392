"""Closing the loops: the angles and slides nearest to a sketch, and rates that hold every loop closed.

Only NumPy is needed here; where everything is as a function of angles and slides is ``layout.py``'s.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .layout import Layout, Real

CLOSED = 1e-14
"""A closed joint misses by no more than this times the length of all its arms."""

_ATTEMPTS = 8
_STEPS = 200
_SHORT = 12
_STIFF = 1e12
"""Multipliers as large as this mean that the closure cannot be reached from here."""
_KNOWN = 1.0
"""Newton's steps turn no link by more than this (rad): the tip of an arm is then half of its length off its tangent."""
_STANDS = 1e-13
"""A step (rad, or lengths in units) as short as this is the rounding of angles about 1 after a few sums."""
_AS_NEAR = 1e-8
"""Misses larger by no more than this of themselves are the same: a smallest one is found to the root of rounding."""


class CannotClose(ValueError):
    """No closed configuration was found: joint ``joint`` misses by ``miss`` ``unit`` at the best one, ``best``."""

    def __init__(self, joint: int, miss: float, unit: str, best: Real) -> None:
        super().__init__(f"joint {joint} misses by {miss:.3g} {unit}")
        self.joint = joint
        self.miss = miss
        self.unit = unit
        self.best = best


class Contradiction(ValueError):
    """Given angular velocities pull joint ``joint`` apart at ``speed`` m/s; ``links`` are those given that move it."""

    def __init__(self, joint: int, speed: float, links: tuple[int, ...]) -> None:
        super().__init__(f"joint {joint} opens at {speed:.3g} m/s")
        self.joint = joint
        self.speed = speed
        self.links = links


@dataclass(frozen=True)
class Speed:
    """Joint ``joint`` moves at ``speed`` (rad/s, or m/s along its line) = ``row`` · rates of the displacements."""

    joint: int
    row: Real
    speed: float


def nearest(layout: Layout, sketch: Real, weights: Real | None = None) -> Real:
    """The closed configuration whose displacements have the smallest sum of squared changes from ``sketch`` (nl + ns,).

    ``weights`` (nl + ns,) of the squares are 1 unless given. A sketch that is closed already comes back as it is.
    Raises ``CannotClose`` when no closed configuration is found.
    """
    tolerance = CLOSED * layout.reach
    if not layout.groups or _closed(layout, sketch, tolerance):
        return sketch
    weights = np.ones(len(sketch)) if weights is None else weights
    best = sketch
    for attempt in range(_ATTEMPTS):
        # A sketch can be a dead end, all links in one line say: the later attempts leave it by different ways.
        detour = 0.3 * attempt * np.cos(1.0 + (attempt + 1.0) * np.arange(len(sketch)))
        found = _polish(layout, _descend(layout, sketch, sketch + detour, weights))
        if _closed(layout, found, tolerance):
            return _returned(layout, sketch, found, weights)
        best = _nearer(layout, best, found)
    worst = int(np.argmax(_misses(layout, best)))
    raise CannotClose(*_worst(layout, best, worst), best)


def shut(layout: Layout, near: Real) -> Real:
    """A closed configuration beside one that is closed but for what curves away in a short step, by smallest steps.

    They take a fraction of the time of :func:`nearest`, which stands in where they find none.
    """
    tolerance, x = CLOSED * layout.reach, near
    for _ in range(_SHORT):
        if not layout.groups or _closed(layout, x, tolerance):
            return x
        x = x - _smallest(layout.jacobian(x), layout.closure(x))
    return nearest(layout, near)


def _worst(layout: Layout, x: Real, entry: int) -> tuple[int, float, str]:
    joint, unit = layout.groups[entry]
    return joint, float(_misses(layout, x)[entry]), unit


def follow(layout: Layout, sketch: Real, loose: Sequence[int]) -> Real:
    """The ``sketch`` with the displacements ``loose`` changed as little as closes their loops, the others held.

    Where that cannot be, they come as near as they get, and change as little as that takes.
    """
    free = np.array(loose, dtype=int)
    moved = np.abs(layout.jacobian(sketch + 0.1)[:, free]).max(axis=1, initial=0.0) > 0.0
    gaps = [k for k in range(len(layout.gaps)) if moved[2 * k] or moved[2 * k + 1]]
    others = moved[2 * len(layout.gaps) :]
    if not moved.any():
        return sketch
    part = replace(
        layout,
        gaps=tuple(layout.gaps[k] for k in gaps),
        gap_base=layout.gap_base[gaps],
        gap_arms=layout.gap_arms[gaps],
        held=tuple(h for h, loosened in zip(layout.held, others, strict=False) if loosened),
        lengths=tuple(
            one for one, loosened in zip(layout.lengths, others[len(layout.held) :], strict=True) if loosened
        ),
        ends=tuple(layout.ends[k] for k in gaps),
    )
    return _follow(part, sketch, free)


def _follow(layout: Layout, sketch: Real, free: NDArray[np.int_]) -> Real:
    """The ``free`` displacements polished until the layout closes, from the sketch or a detour from it.

    What a detour moved that no loop needs to be moved is moved back. Where Newton's steps lead further than ``_KNOWN``
    they say nothing of which of several closed configurations is the nearest, as from links that lie on each other:
    then it is that of all detours.
    """
    best, weights = sketch, np.ones(len(sketch))
    closed: list[Real] = []
    for attempt in range(_ATTEMPTS):
        start = sketch.copy()
        start[free] += 0.3 * attempt * np.cos(1.0 + (attempt + 1.0) * np.arange(len(free)))
        found = _polish(layout, start, free)
        if not _closed(layout, found, CLOSED * layout.reach):
            best = _nearer(layout, best, found)
            continue
        closed.append(_returned(layout, sketch, _without_turns(layout, sketch, found, free), weights, free))
        if np.abs(closed[0] - sketch).max() <= _KNOWN:
            return closed[0]
    if closed:
        far = [_distance(x, sketch, weights[free], free) for x in closed]
        return next(x for x, way in zip(closed, far, strict=True) if way <= (1.0 + _AS_NEAR) * min(far))
    return _returned(layout, sketch, _without_turns(layout, sketch, best, free), weights, free)


def _without_turns(layout: Layout, sketch: Real, x: Real, free: NDArray[np.int_]) -> Real:
    """``x`` with each angle turned back by whole turns to the nearest to the ``sketch``, unless that opens a loop
    further, as one in which angles of joints are held."""
    turns = np.zeros(len(x))
    angles = slice(0, len(x) - len(layout.lines))
    turns[angles] = 2.0 * np.pi * np.round((x - sketch)[angles] / (2.0 * np.pi))
    if not turns.any():
        return x
    back = _polish(layout, x - turns, free)
    may_miss = (1.0 + _AS_NEAR) * np.maximum(_misses(layout, x), CLOSED * layout.reach)
    return back if np.all(_misses(layout, back) <= may_miss) else x


def _nearer(layout: Layout, best: Real, found: Real) -> Real:
    """Which of two configurations that do not close misses by less."""
    least, miss = (float(_misses(layout, x).max()) for x in (best, found))
    return found if miss < least else best


def _returned(
    layout: Layout, sketch: Real, x: Real, weights: Real, free: NDArray[np.int_] | slice = slice(None)
) -> Real:
    """``x`` with its displacements ``free`` moved back to the ``sketch`` as far as that opens no loop further.

    Newton's steps know how the loops curve. Where they break off, because loops do not close or beside a dead end, each
    step goes along the motions that open nothing (to first order), to where Σ w (x - sketch)² is least on them,
    and is polished; it is halved where that does not come nearer. Where it ends before ``_STEPS`` of them, the
    conditions of the constrained minimum hold; else it is nearer than ``x`` was.
    """
    root = np.sqrt(weights[free])
    back = _back(layout, sketch, x, root, free)
    if np.abs(back).max(initial=0.0) > _STANDS:
        near = _polish(layout, _descend(layout, sketch, x, weights, free), free)
        if _closed(layout, near, CLOSED * layout.reach) and _distance(near, sketch, root, free) < _distance(
            x, sketch, root, free
        ):
            x, back = near, _back(layout, sketch, near, root, free)
    for _ in range(_STEPS):
        most = float(np.abs(back).max(initial=0.0))
        distance = _distance(x, sketch, root, free)
        may_miss = (1.0 + _AS_NEAR) * np.maximum(_misses(layout, x), CLOSED * layout.reach)
        size = 1.0 / max(1.0, most)
        while size * most > _STANDS:
            moved = x.copy()
            moved[free] += size * back
            moved = _polish(layout, moved, free)
            if _distance(moved, sketch, root, free) < distance and np.all(_misses(layout, moved) <= may_miss):
                break
            size /= 2.0
        else:
            return x
        x, back = moved, _back(layout, sketch, moved, root, free)
    return x


def _back(layout: Layout, sketch: Real, x: Real, root: Real, free: NDArray[np.int_] | slice) -> Real:
    """The way of the displacements ``free`` back to the sketch, less what opens loops; ``root``: of weights."""
    away = root * (sketch - x)[free]
    jacobian = layout.jacobian(x)[:, free] / root
    return np.asarray((away - _smallest(jacobian, jacobian @ away)) / root, dtype=np.float64)


def _distance(x: Real, sketch: Real, root: Real, free: NDArray[np.int_] | slice) -> float:
    away = root * (x - sketch)[free]
    return float(away @ away)


def alone(layout: Layout, sketch: Real, gap: int) -> float:
    """By how much (m) the loop of ``layout.gaps[gap]`` misses when no other has to close; 0 when it closes."""
    one = slice(gap, gap + 1)
    part = replace(
        layout,
        gaps=layout.gaps[one],
        gap_base=layout.gap_base[one],
        gap_arms=layout.gap_arms[one],
        held=(),
        lengths=(),
        ends=layout.ends[one],
    )
    try:
        nearest(part, sketch)
    except CannotClose as error:
        return error.miss
    return 0.0


def rates(
    layout: Layout,
    angles: Real,
    given: Mapping[int, float],
    tolerance: float = 1e-9,
    speeds: Sequence[Speed] = (),
) -> Real:
    """Rates of the displacements (nl + ns,) that keep joints closed: those ``given`` as they are, the others smallest.

    ``speeds`` are prescribed ones of joints. Raises ``Contradiction`` when those given pull a joint apart, or move it
    otherwise than prescribed, faster than ``tolerance`` (m/s or rad/s) whatever the others do.
    """
    found: Real = np.zeros(len(angles))
    held = np.array(sorted(given), dtype=int)
    found[held] = [given[link] for link in sorted(given)]
    joints = [joint for joint, _ in layout.groups] + [one.joint for one in speeds]
    if not joints:
        return found
    jacobian = np.vstack([layout.jacobian(angles), *(one.row for one in speeds)])
    wanted = np.concatenate([np.zeros(len(jacobian) - len(speeds)), [one.speed for one in speeds]])
    free = np.setdiff1d(np.arange(len(angles)), held)
    found[free] = _smallest(jacobian[:, free], wanted - jacobian @ found)
    opening = jacobian @ found - wanted
    sizes = _sizes(layout, opening)
    worst = int(np.argmax(sizes))
    if sizes[worst] > tolerance:
        moving = [int(link) for link in held if np.abs(jacobian[:, link]).max() > 0.0]
        raise Contradiction(joints[worst], float(sizes[worst]), tuple(moving))
    if sizes[worst] > CLOSED * float(np.abs(found).max()) * float(layout.reach.max(initial=1.0)):
        found -= _smallest(jacobian, opening)
    return found


def tangent(layout: Layout, x: Real, direction: Real) -> Real:
    """The part (nl + ns,) of a ``direction`` at ``x`` that opens no loop; where nothing is fixed, nor turns link 0."""
    jacobian = layout.jacobian(x)
    if layout.floating:
        jacobian = np.vstack([jacobian, np.eye(1, len(x))])
    return direction - _smallest(jacobian, jacobian @ direction)


def _descend(
    layout: Layout, sketch: Real, start: Real, weights: Real, free: NDArray[np.int_] | slice = slice(None)
) -> Real:
    """Stationary point of ½ Σ w (x - sketch)² on the closed configurations, by damped Newton steps from ``start``.

    Only the displacements ``free`` change, all unless given.

    The closure's second derivatives are diagonal, because each arm turns with one angle only (what a length and its
    line's angle share is left out); so is the Hessian of the Lagrangian, kept positive here so that every step goes
    down.
    """
    angles: Real = start
    multipliers: Real = np.zeros(2 * len(layout.gaps) + len(layout.held) + len(layout.lengths))
    penalty = 1.0
    for _ in range(_STEPS):
        gap, jacobian = layout.closure(angles), layout.jacobian(angles)[:, free]
        away = (weights * (angles - sketch))[free]
        hessian = np.maximum(weights + layout.curvature(angles, multipliers), 0.1 * weights)[free]
        schur = (jacobian / hessian) @ jacobian.T
        multipliers = _smallest(schur, gap - (jacobian / hessian) @ away)
        if np.linalg.norm(multipliers) > _STIFF:
            break
        step = np.zeros(len(angles))
        step[free] = -(away + jacobian.T @ multipliers) / hessian
        penalty = max(penalty, 2.0 * float(np.linalg.norm(multipliers)))
        size = _line_search(layout, sketch, weights, angles, step, penalty)
        angles = angles + size * step
        if float(np.abs(size * step).max()) <= _STANDS:
            break
    return angles


def _line_search(layout: Layout, sketch: Real, weights: Real, angles: Real, step: Real, penalty: float) -> float:
    """Largest halving of ``step`` that lowers distance plus penalised gap; no step turns a link by over ``_KNOWN``."""

    def merit(size: float) -> float:
        at = angles + size * step
        return 0.5 * float(np.sum(weights * (at - sketch) ** 2)) + penalty * float(np.linalg.norm(layout.closure(at)))

    size = min(1.0, _KNOWN / max(float(np.abs(step).max()), 1e-300))
    here = merit(0.0)
    while size > 1e-6 and merit(size) > here + 1e-14 * abs(here):
        size *= 0.5
    return size


def _polish(layout: Layout, angles: Real, free: NDArray[np.int_] | slice = slice(None)) -> Real:
    """The gaps made as small as they get from here, by smallest steps, damped where the full step does not help.

    Only the displacements ``free`` change, all unless given.
    """
    damping = 0.0
    for _ in range(_STEPS):
        gap, jacobian = layout.closure(angles), layout.jacobian(angles)[:, free]
        if damping:
            square = jacobian @ jacobian.T
            step = jacobian.T @ np.linalg.solve(square + damping * np.eye(len(gap)), gap)
        else:
            step = _smallest(jacobian, gap)
        moved = angles.copy()
        moved[free] -= step
        if np.linalg.norm(layout.closure(moved)) < np.linalg.norm(gap):
            angles = moved
            damping = 0.1 * damping if damping > 1e-6 else 0.0
        elif damping < 1e3 * float(layout.reach.max()) ** 2:
            damping = max(10.0 * damping, 1e-6)
        else:
            break
    return angles


def _smallest(matrix: Real, right: Real) -> Real:
    """Least-squares solution of matrix·x = right; the smallest where there are many."""
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=1e-12)[0], dtype=np.float64)


def _misses(layout: Layout, x: Real) -> Real:
    """How far each gap is open (m), and by how much each held angle is missed (rad), shape (nc + nh,)."""
    return _sizes(layout, layout.closure(x))


def _sizes(layout: Layout, rows: Real) -> Real:
    """Sizes of closure rows, gap by gap, then of the held angles'."""
    gaps = 2 * len(layout.gaps)
    return np.append(np.hypot(rows[0:gaps:2], rows[1:gaps:2]), np.abs(rows[gaps:]))


def _closed(layout: Layout, angles: Real, tolerance: Real) -> bool:
    return bool(np.all(_misses(layout, angles) <= tolerance))
