"""The part of the plane that pictures of a run show."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray
from ..model.disc import Disc
from ..record.drawable import Drawable
from .frames import Frames, placed
from .strokes import size_of_looks, strokes

FOLLOW_BEYOND = 4.0  # the view follows along an axis when the motion is longer than this many sizes of the mechanism
PIVOT = 0.06  # height of the triangle of a pivot, part of the extent of the motion
FREE = 10.0  # as many times later where there is one link only
MARGIN = 1.12  # room around what is shown
LOOKS = 60  # frames in which what acts is looked at; it stands out little from links, which are in all of them

AXES = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])


@dataclass(frozen=True)
class View:
    """The rectangle to show: for each frame its centre (n, 2), for all frames half of its sides (2,).

    `follow` says for which axes the centre moves with the mechanism; `size` is the largest extent of the mechanism.
    """

    centre: FloatArray
    half: FloatArray
    follow: tuple[bool, bool]
    size: float


def view_of(frames: Frames) -> View:
    """The view that shows the whole motion, or follows the mechanism along the axes where the motion is long."""
    looks = frames.looks()
    seen = [_points(model, frames.poses[rows], frames.joints[rows]) for model, rows in looks]
    points = np.concatenate([part.reshape(-1, 2) for part in seen])
    fixed = np.concatenate([np.asarray(model.drawn_ground_points, dtype=float).reshape(-1, 2) for model, _ in looks])
    below = fixed - [0.0, PIVOT * float(np.max(np.ptp(points, axis=0)))]  # triangles stand there
    rims = [disc.outline for model, _ in looks for disc in model.discs if disc.fixed]
    corners = np.concatenate([points, fixed, below, *rims])
    low, high = corners.min(axis=0), corners.max(axis=0)
    extent = max(float(np.max(np.ptp(part, axis=1))) for part in seen)
    size = extent or float(np.max(high - low)) or 1.0  # all there is, of one point
    middle, reach = np.zeros((len(frames.t), 2)), np.zeros(2)
    for part, (_, rows) in zip(seen, looks, strict=True):
        middle[rows] = part.mean(axis=1)
        reach = np.maximum(reach, np.abs(part - part.mean(axis=1)[:, None]).max(axis=(0, 1)))

    # beside nothing that stands still a mechanism that is followed would seem to stand still itself
    scenery = len(fixed) > 0 or bool(rims) or any(model.ground_planes() for model, _ in looks)
    beyond = FOLLOW_BEYOND * (1.0 if len(looks[0][0].outlines) > 1 else FREE) if scenery else np.inf
    follow = (high - low) > beyond * size
    acting = np.concatenate([low[None], *_acting(frames, size)])  # arcs and arrows stand out beyond the links
    low, high = np.minimum(low, acting.min(axis=0)), np.maximum(high, acting.max(axis=0))
    centre = np.where(follow, middle, 0.5 * (low + high))
    half = MARGIN * np.maximum(np.where(follow, reach, 0.5 * (high - low)), 0.25 * size)
    return View(centre, half, (bool(follow[0]), bool(follow[1])), size)


def _points(model: Drawable, poses: FloatArray, joints: FloatArray) -> FloatArray:
    """The outermost places (frames, m, 2) of what is drawn of links, and of joints."""
    parts = [placed(np.asarray(outline), poses[:, k]) for k, outline in enumerate(model.outlines)]
    parts += [_reached(disc, poses[:, disc.link]) for disc in model.discs if not disc.fixed]
    points = np.concatenate([*parts, joints], axis=1)
    return points if points.shape[1] else np.asarray(poses[:, :, :2])  # nothing of it is drawn


def _reached(disc: Disc, poses: FloatArray) -> FloatArray:
    """The outermost places (frames, m, 2) along both axes of a disc, or all corners of an edge or a profile."""
    if not disc.round:
        return placed(disc.outline, poses)
    return np.asarray(placed(disc.centre[None], poses) + disc.radius * AXES)


def _acting(frames: Frames, size: float) -> list[FloatArray]:
    """Corners (m, 2) of what is drawn where effects act, in some of the frames."""
    some = np.unique(np.linspace(0, len(frames.t) - 1, LOOKS).astype(int))
    seen = replace(frames, poses=frames.poses[some])
    found = []
    for model, rows in frames.looks():
        shown = strokes(model, seen, size_of_looks(frames, size))
        own = some[rows[some]]
        poses = frames.poses[own if own.size else np.flatnonzero(rows)[:1]]
        found += [stroke.corners(pose) for stroke in shown for pose in poses]
    return found
