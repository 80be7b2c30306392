"""Lines by which pictures show where effects act: coils, dashpots, arcs, teeth, belts, blocks in guides, and ropes.

A stroke says how its corners hang on the links, so that a page can evaluate it for any frame; ``corners`` does here.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..arrays import FloatArray
from ..model.part import Part
from ..model.rope import Rope
from ..record.drawable import Drawable
from .frames import Frames, placed

Place = tuple[int, float, float]
"""A point of a link's frame: the link (-1: the ground), x and y in m."""

SLACK = 1e-6  # part of its length by which the way of a rope is shorter where it is drawn slack
IN_LINE = 1e-6  # part of its length by which a link's points may be off a line
TEETH = 12  # of the smaller wheel; how many there are only a scene knows that gives teeth
COIL, COILS = 8, 2.5  # corners of a spring on either side, turns of a torsional one
HALF_WIDTH = 0.04  # of springs, dampers and blocks, part of the size
PUSH = 0.25  # length of the arrows of forces, part of the size
REACH = 0.10  # radius of arcs and of stops about joints, part of the size


@dataclass(frozen=True)
class Stroke:
    """A line through corners that hang on links, called after an effect or a joint.

    "turn": `points` (m, 3) are radius (m), angle and share about the first of `at`; a corner is seen at its angle plus
    that of the first of `links` plus its share of what the second has turned against it. "span": `points` (m, 2) are
    the part of the way from the first to the second of `at`, and the distance across it (m). "way": through all `at`.
    `colour` is a link's number, "ink", "soft" or "accent"; a `length` (m) is that of a way, dashed where it is slack.
    `said` stands beyond the second corner, as seen from the first: how large a force is.
    """

    name: str
    kind: Literal["turn", "span", "way"]
    at: tuple[Place, ...]
    points: FloatArray
    colour: int | str
    links: tuple[int, int] = (-1, -1)
    filled: bool = False
    length: float | None = None
    said: str = ""

    def corners(self, poses: FloatArray) -> FloatArray:
        """The corners (m, 2), in m, when links have ``poses`` (links, 3)."""
        places = np.array([placed(np.array([[x, y]]), _pose(poses, link))[0] for link, x, y in self.at])
        if self.kind == "way":
            return places
        if self.kind == "span":
            way = places[1] - places[0]
            across = np.array([-way[1], way[0]]) / (float(np.hypot(*way)) or 1.0)
            return np.asarray(places[0] + np.outer(self.points[:, 0], way) + np.outer(self.points[:, 1], across))
        first, second = (float(_pose(poses, link)[2]) for link in self.links)
        radius, angle, share = self.points.T
        seen = first + share * (second - first) + angle
        return np.asarray(places[0] + radius[:, None] * np.column_stack([np.cos(seen), np.sin(seen)]))

    def slack(self, poses: FloatArray) -> bool:
        """Whether it is a rope that is shorter than it could be."""
        if self.length is None:
            return False
        way = float(np.sum(np.hypot(*np.diff(self.corners(poses), axis=0).T)))
        return way < (1.0 - SLACK) * self.length


def straightened(outline: FloatArray) -> FloatArray:
    """The two ends of an outline (m, 2) whose points are in line; any other as it is."""
    if len(outline) < 3:
        return outline
    away = outline - outline[0]
    farthest = away[int(np.argmax(np.hypot(*away.T)))]
    across = np.abs(away[:, 0] * farthest[1] - away[:, 1] * farthest[0])
    if np.any(across > IN_LINE * (farthest @ farthest)):
        return outline
    along = away @ farthest
    return np.asarray(outline[[int(np.argmin(along)), int(np.argmax(along))]])


def strokes(model: Drawable, frames: Frames, size: float) -> list[Stroke]:
    """What is drawn where effects act, over a motion that ``frames`` show: guides are as long as it needs.

    ``size`` (m) is that of the mechanism's links, and says how large what has no size of its own is drawn.
    """
    found: list[Stroke] = []
    coils = {_ends(part) for part in model.parts if part.kind == "spring"}
    for part in model.parts:
        found += _strokes(part, model, frames, size, coils)
    return [*found, *(_rope(rope) for rope in model.ropes)]


def size_of_links(model: Drawable, otherwise: float) -> float:
    """The largest extent (m) of a link or of a disc; of a mechanism of points, what is said."""
    extents = [float(np.max(np.ptp(outline, axis=0))) for outline in map(np.asarray, model.outlines) if len(outline)]
    extents += [float(np.max(np.ptp(disc.outline, axis=0))) for disc in model.discs]
    return max(extents, default=0.0) or otherwise


def size_of_looks(frames: Frames, otherwise: float) -> float:
    """The same (m) of the models that are in force in some of the ``frames``."""
    return max(size_of_links(model, 0.0) for model, _ in frames.looks()) or otherwise


def _strokes(part: Part, model: Drawable, frames: Frames, size: float, coils: set[tuple[Place, ...]]) -> list[Stroke]:
    wide = HALF_WIDTH * size
    if part.kind == "spring":
        return [_span(part, _coil(wide))]
    if part.kind == "damper":  # beside the spring where both join the same points
        return [_span(part, line) for line in _dashpot(wide, 2.5 * wide if _ends(part) in coils else 0.0)]
    if part.kind == "torsion":
        share = np.linspace(0.0, 1.0, 61)
        spiral = np.column_stack([REACH * size * (0.25 + 0.75 * share), -2.0 * np.pi * COILS * (1.0 - share), share])
        return [_turn(part, spiral, "ink")]
    if part.kind == "motor":
        return [_turn(part, _arc_arrow(1.3 * REACH * size, float(part.links[1] >= 0)), "accent")]
    if part.kind == "linear motor":
        return [_linear_motor(part, wide)]
    if part.kind in ("brake", "linear brake"):
        return [_shoe(part, size, side) for side in (1.0, -1.0)]
    if part.kind == "force":
        return list(_force(part, size))
    if part.kind == "torque":
        return [_torque(part, size)] if part.numbers[0] else []
    if part.kind in ("stop", "linear stop"):
        return [_stop(part, model, size) if part.kind == "stop" else _slide_stop(part, wide)]
    if part.kind == "gear":
        small = min(part.numbers)
        return [_wheel(part, k, radius, small) for k, radius in enumerate(part.numbers)]
    if part.kind == "belt":
        return [_fixed(part, part.links[0], _belt(part), "ink")]
    if part.kind == "rack":
        return [_wheel(part, 0, part.numbers[0], part.numbers[0]), _rack(part, frames)]
    return list(_slider(part, model, frames, wide)) if part.kind in ("slider", "rails") else []


def _pose(poses: FloatArray, link: int) -> FloatArray:
    """The pose (..., 3) of a link; zeros for the ground."""
    return np.zeros((*poses.shape[:-2], 3)) if link < 0 else poses[..., link, :]


def _ends(part: Part) -> tuple[Place, ...]:
    found = [(link, float(x), float(y)) for link, (x, y) in zip(part.links, part.points, strict=True)]
    return tuple(found)


def _span(part: Part, points: Sequence[tuple[float, float]]) -> Stroke:
    return Stroke(part.name, "span", _ends(part), np.array(points), "ink")


def _turn(part: Part, points: FloatArray, colour: int | str) -> Stroke:
    """About the first point of a joint."""
    return Stroke(part.name, "turn", _ends(part)[:1], points, colour, (part.links[0], part.links[1]))


def _fixed(part: Part, link: int, points: FloatArray, colour: int | str) -> Stroke:
    """Through points (m, 2) of a link's frame, in m."""
    polar = np.column_stack([np.hypot(*points.T), np.arctan2(points[:, 1], points[:, 0]), np.zeros(len(points))])
    return Stroke(part.name, "turn", ((link, 0.0, 0.0),), polar, colour, (link, link))


def _rope(rope: Rope) -> Stroke:
    at = tuple((link, float(x), float(y)) for link, (x, y) in zip(rope.links, rope.points, strict=True))
    return Stroke(rope.name, "way", at, np.zeros((0, 2)), "ink", length=rope.length)


def _coil(wide: float) -> list[tuple[float, float]]:
    inner = [(0.15 + 0.7 * (k + 0.5) / COIL, wide if k % 2 else -wide) for k in range(COIL)]
    return [(0.0, 0.0), (0.15, 0.0), *inner, (0.85, 0.0), (1.0, 0.0)]


def _dashpot(wide: float, aside: float) -> list[list[tuple[float, float]]]:
    """The rod with its piston, and the cylinder with the other rod."""
    rod = [(0.0, 0.0), (0.1, aside), (0.5, aside), (0.5, aside + 0.7 * wide), (0.5, aside - 0.7 * wide)]
    cylinder = [(0.35, wide), (0.7, wide), (0.7, -wide), (0.35, -wide), (0.7, -wide), (0.7, 0.0)]
    return [rod, [*((s, aside + across) for s, across in cylinder), (0.9, aside), (1.0, 0.0)]]


def _arc_arrow(radius: float, share: float) -> FloatArray:
    """Three quarters of a circle and a head, counter-clockwise, as the joint's angle grows."""
    turned = np.linspace(0.0, 1.5 * np.pi, 31)
    tip = turned[-1]
    head = [(1.0, tip), (1.25, tip - 0.4), (1.0, tip), (0.75, tip - 0.4)]
    polar = np.array([*((1.0, angle) for angle in turned), *head])
    return np.column_stack([radius * polar[:, 0], polar[:, 1], np.full(len(polar), share)])


def _shoe(part: Part, size: float, side: float) -> Stroke:
    """One of two shoes of the first link about the pin, or of two pads beside the line."""
    if part.kind == "brake":
        bent = np.linspace(-0.6, 0.6, 13) + side * 0.5 * np.pi
        inner, outer = (np.column_stack([np.full(13, part_of * REACH * size), bent]) for part_of in (0.5, 0.75))
        polar = np.concatenate([inner, outer[::-1], inner[:1]])
        at = _ends(part)[:1]
    else:
        x, y = HALF_WIDTH * size * np.array([(-1.2, 1.1), (1.2, 1.1), (1.2, 1.7), (-1.2, 1.7), (-1.2, 1.1)]).T
        polar = np.column_stack([np.hypot(x, y), side * np.arctan2(y, x) + part.numbers[0]])
        at = _ends(part)[1:]
    points = np.column_stack([polar, np.zeros(len(polar))])
    return Stroke(part.name, "turn", at, points, "soft", (part.links[0], part.links[0]), filled=True)


def _force(part: Part, size: float) -> Iterator[Stroke]:
    """An arrow from the point as the force points, with its size; one that changes with time has arrows both ways along
    its axes. All are of one length, so that a small force is seen beside a large one."""
    x, y, changes, turns = part.numbers
    held = part.links[0] if turns else -1
    head = [(1.0, 0.0), (0.8, 0.08), (1.0, 0.0), (0.8, -0.08)]
    back = [(-s, across) for s, across in reversed(head)]
    for along in [x + 0j, 1j * y] if changes else [complex(x, y)]:
        if along:
            way = PUSH * size * np.array([complex(*xy) for xy in [*(back if changes else [(0.0, 0.0)]), *head]])
            polar = np.column_stack([np.abs(way), np.angle(way) + np.angle(along), np.zeros(len(way))])
            said = "" if changes else f"{abs(along):.3g} N"
            yield Stroke(part.name, "turn", _ends(part)[:1], polar, "accent", (held, held), said=said)


def _torque(part: Part, size: float) -> Stroke:
    """An arc with a head, the way that the torque turns its link."""
    arc = _arc_arrow(1.3 * REACH * size, 0.0) * [1.0, np.sign(part.numbers[0]), 1.0]
    return Stroke(part.name, "turn", _ends(part)[:1], arc, "accent", (part.links[0], part.links[0]))


def _linear_motor(part: Part, wide: float) -> Stroke:
    """An arrow along the line, beside the second link's point."""
    x, y = wide * np.array([(-3, 2), (3, 2), (2, 2.6), (3, 2), (2, 1.4)], dtype=float).T
    points = np.column_stack([np.hypot(x, y), np.arctan2(y, x) + part.numbers[0], np.zeros(len(x))])
    return Stroke(part.name, "turn", _ends(part)[1:], points, "accent", (part.links[0], part.links[0]))


def _stop(part: Part, model: Drawable, size: float) -> Stroke:
    """A bar on the first link where the second one, as far as it reaches from the joint, lies against it."""
    outline = np.zeros((0, 2)) if part.links[1] < 0 else np.asarray(model.outlines[part.links[1]])
    away = outline - part.points[1] if len(outline) else np.array([[1.0, 0.0]])
    farthest = away[int(np.argmax(np.round(np.hypot(*away.T), 12)))]
    angle = part.numbers[0] + float(np.arctan2(farthest[1], farthest[0]))
    bar = np.array([(0.5 * REACH * size, angle, 0.0), (1.6 * REACH * size, angle, 0.0)])
    return _turn(part, bar, "ink")


def _slide_stop(part: Part, wide: float) -> Stroke:
    """A bar on the first link across the line, behind the second link's point as it is at the limit."""
    place, axis, beyond = part.numbers
    behind = place + 1.9 * wide * beyond
    x, y = np.array([behind, behind]), wide * np.array([-2.5, 2.5])
    bar = np.column_stack([np.hypot(x, y), np.arctan2(y, x) + axis, np.zeros(2)])
    return Stroke(part.name, "turn", _ends(part)[:1], bar, "ink", (part.links[0], part.links[0]))


def _wheel(part: Part, k: int, radius: float, small: float) -> Stroke:
    """A toothed rim on the pitch circle of wheel k, of teeth as large as those of the ``small`` wheel."""
    module = 2.0 * small / TEETH
    number = max(3, round(2.0 * radius / module))
    steps = 2.0 * np.pi / number * (np.arange(number)[:, None] + np.array([0.0, 0.15, 0.35, 0.5])).ravel()
    heights = radius + 0.7 * module * np.tile([-0.5, 0.5, 0.5, -0.5], number)
    points = np.column_stack([heights, steps, np.zeros(4 * number)])
    link = part.links[k]
    at = (_ends(part)[k],)
    return Stroke(part.name, "turn", at, np.concatenate([points, points[:1]]), link, (link, link))


def _belt(part: Part) -> FloatArray:
    """Round both wheels (m, 2), in the frame of their carrier."""
    first, second = part.points @ [1.0, 1.0j]
    r, s, crossed = part.numbers
    towards = np.angle(second - first)
    part_of_turn = np.arccos(np.clip((r + s if crossed else r - s) / abs(second - first), -1.0, 1.0))
    round_first = first + r * np.exp(1j * np.linspace(towards + part_of_turn, towards + 2 * np.pi - part_of_turn, 31))
    side = np.pi - part_of_turn if crossed else -part_of_turn
    round_second = second + s * np.exp(1j * np.linspace(towards + side, towards - side, 31))
    way = np.concatenate([round_first, round_second, round_first[:1]])
    return np.column_stack([way.real, way.imag])


def _rack(part: Part, frames: Frames) -> Stroke:
    """A toothed bar on the side where it moves along its line as the pinion turns counter-clockwise."""
    radius, axis, sense = part.numbers
    _, bar, first = part.links
    centre, bars = placed(part.points[:1], _pose(frames.poses, part.links[0]))[:, 0], _pose(frames.poses, bar)
    seen = axis + _pose(frames.poses, first)[:, 2]
    touched = centre + sense * radius * np.column_stack([np.sin(seen), -np.cos(seen)])
    local = (touched - bars[:, :2]) @ [1.0, 1.0j] * np.exp(-1j * bars[:, 2])
    along = np.exp(1j * (seen[0] - bars[0, 2]))
    lengths, off = (local / along).real, float(np.median((local / along).imag))
    module = 2.0 * radius / TEETH
    low, high = float(lengths.min()) - 1.5 * radius, float(lengths.max()) + 1.5 * radius
    steps = np.arange(low, high, np.pi * module / 4.0)
    heights = off + 0.35 * module * np.resize([-1.0, 1.0, 1.0, -1.0], len(steps))
    teeth = (steps + 1j * heights) * along
    return _fixed(part, bar, np.column_stack([teeth.real, teeth.imag]), bar)


def _slider(part: Part, model: Drawable, frames: Frames, wide: float) -> Iterator[Stroke]:
    """Two rails on the first link as long as the way, and a block on the second one unless that is drawn as it is;
    nothing between links that are not drawn."""
    if any(link >= 0 and not len(model.outlines[link]) for link in part.links):
        return
    (first, second), (start, point), (axis,) = part.links, part.points, part.numbers
    carriers = _pose(frames.poses, first)
    reached = placed(point[None], _pose(frames.poses, second))[:, 0] - placed(start[None], carriers)[:, 0]
    along = (reached @ [1.0, -1.0j] * np.exp(1j * (carriers[:, 2] + axis))).real
    low, high = float(along.min()) - 2.0 * wide, float(along.max()) + 2.0 * wide
    for side in (-wide, wide):
        rail = complex(*start) + np.array([low + 1j * side, high + 1j * side]) * np.exp(1j * axis)
        yield _fixed(part, first, np.column_stack([rail.real, rail.imag]), "soft")
    if part.kind == "rails":
        return
    x, y = wide * np.array([(-1.8, -1.0), (1.8, -1.0), (1.8, 1.0), (-1.8, 1.0), (-1.8, -1.0)]).T
    block = np.column_stack([np.hypot(x, y), np.arctan2(y, x) + axis, np.zeros(len(x))])
    colour = second if second >= 0 else first
    yield Stroke(part.name, "turn", _ends(part)[1:], block, colour, (first, first), filled=True)
