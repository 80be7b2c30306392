"""The part of the plane that pictures of a run show."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray
from ..model.disc import Disc
from ..record.drawable import Drawable
from .frames import Frames, placed
from .strokes import size_of_links, strokes

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


def view_of(model: Drawable, frames: Frames) -> View:
    """The view that shows the whole motion, or follows the mechanism along the axes where the motion is long."""
    parts = [placed(np.asarray(outline), frames.poses[:, k]) for k, outline in enumerate(model.outlines)]
    parts += [_reached(disc, frames.poses[:, disc.link]) for disc in model.discs if not disc.fixed]
    points = np.concatenate([*parts, frames.joints], axis=1)
    if not points.shape[1]:  # nothing of it is drawn
        points = frames.poses[:, :, :2]
    fixed = np.asarray(model.drawn_ground_points, dtype=float).reshape(-1, 2)
    below = fixed - [0.0, PIVOT * float(np.max(np.ptp(points.reshape(-1, 2), axis=0)))]  # triangles stand there
    corners = np.concatenate(
        [points.reshape(-1, 2), fixed, below, *(disc.outline for disc in model.discs if disc.fixed)]
    )
    low, high = corners.min(axis=0), corners.max(axis=0)
    size = float(np.max(np.ptp(points, axis=1))) or float(np.max(high - low)) or 1.0  # all there is, of one point
    middle = points.mean(axis=1)
    reach = np.abs(points - middle[:, None]).max(axis=(0, 1))

    # beside nothing that stands still a mechanism that is followed would seem to stand still itself
    scenery = bool(model.ground_planes()) or len(fixed) > 0 or any(disc.fixed for disc in model.discs)
    beyond = FOLLOW_BEYOND * (1.0 if len(model.outlines) > 1 else FREE) if scenery else np.inf
    follow = (high - low) > beyond * size
    acting = np.concatenate([low[None], *_acting(model, frames, size)])  # arcs and arrows stand out beyond the links
    low, high = np.minimum(low, acting.min(axis=0)), np.maximum(high, acting.max(axis=0))
    centre = np.where(follow, middle, 0.5 * (low + high))
    half = MARGIN * np.maximum(np.where(follow, reach, 0.5 * (high - low)), 0.25 * size)
    return View(centre, half, (bool(follow[0]), bool(follow[1])), size)


def _reached(disc: Disc, poses: FloatArray) -> FloatArray:
    """The outermost places (frames, m, 2) along both axes of a disc, or all corners of an edge or a profile."""
    if not disc.round:
        return placed(disc.outline, poses)
    return np.asarray(placed(disc.centre[None], poses) + disc.radius * AXES)


def _acting(model: Drawable, frames: Frames, size: float) -> list[FloatArray]:
    """Corners (m, 2) of what is drawn where effects act, in some of the frames."""
    some = np.unique(np.linspace(0, len(frames.t) - 1, LOOKS).astype(int))
    seen = replace(frames, poses=frames.poses[some])
    found = strokes(model, seen, size_of_links(model, size))
    return [stroke.corners(poses) for stroke in found for poses in seen.poses]
