"""The motion of a run as one self-contained page that plays in a browser.

`player.html` is the page; its two slots are filled with the title and with the run as one JSON object.
"""

from __future__ import annotations

import html
import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..files import write_whole
from ..record.drawable import Drawable
from ..record.impact import Impact
from ..record.record import Record
from .frames import Frames, View, frame_times, pivots, sample, shown_impacts, view_of
from .link_colours import link_colours
from .strokes import Stroke, size_of_links, straightened, strokes

RATE = 60  # frames per second
MOST_NUMBERS = 3_000_000  # longer runs get fewer frames per second; the page blends between frames
PAGE = Path(__file__).with_name("player.html")


def write_player(run: Record, path: Path) -> Path:
    """Write the page to `path`; equal runs give equal bytes."""
    # "<" never appears inside the data, so that no name can end the script element it stands in
    data = json.dumps(content(run), separators=(",", ":"), ensure_ascii=True, allow_nan=False).replace("<", "\\u003c")
    head, title_end, script_end = PAGE.read_text(encoding="utf-8").split("@@")[::2]
    page = head + html.escape(run.model.name) + title_end + data + script_end
    write_whole(path, lambda part: part.write(page.encode()))
    return path


def content(run: Record) -> dict[str, Any]:
    """What the page shows, as plain data: per frame [x, y, angle] of each link and [x, y] of each joint in one row.

    Lengths are rounded to 1e-5 of the mechanism's size, angles to 1e-5, energies to 1e-6 of the largest.
    """
    model = run.model
    most = MOST_NUMBERS / (3 * len(model.outlines) + 2 * len(model.drawn_joints) + 4)
    frames = sample(run, frame_times(run, min(RATE, most / max(float(run.t[-1] - run.t[0]), 1e-9))))
    view = view_of(model, frames)
    length = _decimals(1e-5 * view.size)
    colours = link_colours(model, frames, view.size)
    return {
        "name": model.name,
        "message": "" if run.success else run.message,
        "t": _numbers(frames.t, 9),
        "poses": _poses(frames.poses, length),
        "joints": _numbers(frames.joints.reshape(len(frames.t), -1), length),
        "energy": _energies(frames),
        "links": [
            {
                "name": name,
                "outline": _numbers(straightened(np.asarray(outline)), length),
                "colour": colours[k],
                **_surfaces(model, k, length),
            }
            for k, (name, outline) in enumerate(zip(model.links[: len(model.outlines)], model.outlines, strict=True))
        ],
        "jointNames": list(model.drawn_joints),
        "groundPoints": _numbers(pivots(model, frames, view.size), length),
        "grounds": [
            {"name": name, "point": _numbers(point, length), "normal": _numbers(normal, 9)}
            for name, (point, normal) in model.ground_planes().items()
        ],
        "fixed": _surfaces(model, -1, length),
        "ropes": [
            [[link, *_numbers(point, length)] for link, point in zip(rope.links, rope.points, strict=True)]
            for rope in model.ropes
        ],
        "parts": [_part(one, length) for one in strokes(model, frames, size_of_links(model, view.size))],
        "impacts": [{"number": k, **_impact(run, impact, length)} for k, impact in shown_impacts(run)],
        "impactCount": len(run.impacts),
        "view": _view(view, length),
    }


def _part(stroke: Stroke, length: int) -> dict[str, Any]:
    """A stroke as the page evaluates it: see ``Stroke``; what it does not need is left out."""
    found: dict[str, Any] = {
        "name": stroke.name,
        "kind": stroke.kind,
        "at": [[link, *_numbers(np.array(place), length)] for link, *place in stroke.at],
        "colour": stroke.colour,
    }
    if stroke.kind != "way":
        found["points"] = _numbers(stroke.points, max(length, 5))
    if stroke.kind == "turn":
        found["links"] = list(stroke.links)
    if stroke.filled:
        found["filled"] = True
    if stroke.length is not None:
        found["length"] = stroke.length
    return found


def _surfaces(model: Drawable, link: int, length: int) -> dict[str, Any]:
    """[x, y, radius] of each disc of a link (-1: the ground), in its frame, and the outline of each edge."""
    own = [disc for disc in model.discs if disc.link == link]
    return {
        "discs": [_numbers(np.append(disc.centre, disc.radius), length) for disc in own if disc.round],
        "edges": [_numbers(disc.outline, length) for disc in own if not disc.round],
    }


def _impact(run: Record, impact: Impact, length: int) -> dict[str, Any]:
    q, _ = run.at(impact.t)
    contacts = [
        {
            "point": point,
            "ground": ground,
            "at": _numbers(run.model.point(point, q), length),
            "impulse": _digits(impulse),
        }
        for (point, ground), impulse in zip(impact.contacts, impact.impulses, strict=True)
    ]
    return {"t": _numbers(np.array(impact.t), 9), "contacts": contacts, "loss": _digits(impact.energy_loss)}


def _view(view: View, length: int) -> dict[str, Any]:
    """Centres for every frame where the view follows, otherwise only one."""
    moving = any(view.follow)
    centre = view.centre if moving else view.centre[:1]
    size = _numbers(np.array(view.size), length)
    return {"half": _numbers(view.half, length), "centre": _numbers(centre, length), "follow": moving, "size": size}


def _energies(frames: Frames) -> Any:
    energies = np.stack([frames.kinetic, frames.potential], axis=1)
    return _numbers(energies, _decimals(1e-6 * float(np.abs(energies).max())))


def _poses(poses: FloatArray, length: int) -> Any:
    places, angles = np.round(poses[..., :2], length), np.round(poses[..., 2:], 5)
    return _numbers(np.concatenate([places, angles], axis=-1).reshape(len(poses), -1), max(length, 5))


def _numbers(values: FloatArray, decimals: int) -> Any:
    """Nested lists of rounded numbers, without negative zeros."""
    return (np.round(np.asarray(values, dtype=float), decimals) + 0.0).tolist()


def _digits(value: float) -> float:
    return float(f"{value:.6g}")


def _decimals(step: float) -> int:
    """How many decimals keep differences of `step`."""
    return max(0, math.ceil(-math.log10(step))) if step > 0 else 0
