"""The motion of a run as one self-contained page that plays in a browser.

`player.html` is the page; its two slots are filled with the title and with the run as one JSON object.
"""

from __future__ import annotations

import html
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..files import write_whole
from ..record.drawable import Drawable
from ..record.event import Event
from ..record.impact import Impact
from ..record.outputs import Sample, units_of
from ..record.record import Record
from .charted import ENERGIES, chart_times, check_outputs, chosen, curves
from .contact_place import StruckPlaces
from .frames import (
    MOST_EVENTS,
    MOST_IMPACTS,
    Frames,
    frame_times,
    pivots,
    sample,
    shown_changes,
    shown_events,
    shown_impacts,
)
from .link_colours import link_colours
from .named_points import mass_centres, named_points
from .strokes import Stroke, size_of_looks, straightened, strokes
from .title import title_of
from .view import View, view_of

RATE = 60  # frames per second
LEAST_FRAMES = 300  # of a short run: it is looked at slowly
TURN = 0.12  # rad by which the fastest link turns from frame to frame, up to FASTEST frames per second
FASTEST = 240
MOST_NUMBERS = 1_000_000  # longer runs get fewer frames per second; the page blends between frames
MOST_BYTES = 10_000_000
MOST_BYTES_IN_NOTEBOOK = 2_000_000
HEIGHT_IN_NOTEBOOK = 620  # pixels
PAGE = Path(__file__).with_name("player.html")


def write_player(
    run: Record, path: Path, outputs: Sequence[str] | None = None, settings: Mapping[str, object] | None = None
) -> Path:
    """Write the page to `path`, with these outputs plotted at first; equal runs give equal bytes. Its title names the
    ``settings`` (:func:`title_of`)."""
    page = page_of(run, MOST_BYTES, outputs, settings)
    write_whole(path, lambda part: part.write(page.encode()))
    return path


def frame_of(run: Record) -> str:
    """The page in a frame of its own, as notebooks show it: several of them do not know of each other."""
    page = html.escape(page_of(run, MOST_BYTES_IN_NOTEBOOK))
    style = f"width: 100%; height: {HEIGHT_IN_NOTEBOOK}px; border: 0"
    title = html.escape(f"{run.model.name} in motion")
    return f'<iframe title="{title}" sandbox="allow-scripts" style="{style}" srcdoc="{page}"></iframe>'


def page_of(
    run: Record, bytes_: int, outputs: Sequence[str] | None = None, settings: Mapping[str, object] | None = None
) -> str:
    """The page, of at most so many bytes: with fewer frames where the run is too long for that."""
    head, title_end, script_end = PAGE.read_text(encoding="utf-8").split("@@")[::2]
    most, title = min(MOST_NUMBERS, bytes_ // 8), title_of(run, settings)
    while True:
        # "<" never appears inside the data, so that no name can end the script element it stands in
        shown = content(run, outputs, most) | {"name": title}
        data = json.dumps(shown, separators=(",", ":"), ensure_ascii=True, allow_nan=False)
        page = head + html.escape(title) + title_end + data.replace("<", "\\u003c") + script_end
        size = len(html.escape(page).encode())  # as it is in a frame
        if size <= bytes_ or most < 1000:  # what remains then are shapes and names
            return page
        most = int(0.9 * most * bytes_ / size)


def content(run: Record, outputs: Sequence[str] | None = None, most: int | None = None) -> dict[str, Any]:
    """What the page shows, as plain data: per frame [x, y, angle] of each link and [x, y] of each joint in one row.

    Lengths are rounded to 1e-5 of the mechanism's size, angles to 1e-5, energies and outputs to 1e-6 of their largest.
    There are about ``most`` numbers in it. ``outputs`` are plotted at first, beside those that can be chosen.
    """
    check_outputs(run, [] if outputs is None else outputs)
    model = run.model
    plotted = list(dict.fromkeys(ENERGIES if outputs is None else outputs))
    charted = [name for name in dict.fromkeys([*plotted, *chosen(run)]) if name not in ENERGIES]
    in_a_row = 3 * len(model.outlines) + 2 * len(model.drawn_joints) + 4 + len(charted)
    rows = (most or MOST_NUMBERS) / in_a_row
    most_impacts = max(1, min(MOST_IMPACTS, int(rows / 4)))
    shown = shown_impacts(run, most_impacts)
    times = frame_times(run, _rate(run, rows), most=most_impacts)
    frames = sample(run, times)
    view = view_of(frames)
    length, places = _decimals(1e-5 * view.size), StruckPlaces(run)
    jumps = sorted({*(float(impact.t) for _, impact in shown), *shown_changes(run, most_impacts)})
    now, later = _looks(run, frames, view, length)
    return {
        "name": model.name,
        "message": "" if run.success else run.message,
        "t": _numbers(frames.t, 9),
        "poses": _poses(frames.poses, length),
        "joints": _numbers(frames.joints.reshape(len(frames.t), -1), length),
        **now,
        **({"later": later} if later else {}),
        "jointNames": list(model.drawn_joints),
        "impacts": [{"number": k, **_impact(run, k, impact, places, length)} for k, impact in shown],
        "impactCount": len(run.impacts),
        "events": [_event(event) for event in shown_events(run, min(most_impacts, MOST_EVENTS))],
        "view": _view(view, length),
        "chart": _chart(run, charted, plotted, frames, jumps),
        "plotted": plotted,
    }


def _looks(
    run: Record, frames: Frames, view: View, length: int
) -> tuple[dict[str, Any], list[tuple[int, dict[str, Any]]]]:
    """Shapes at the first frame, and for each frame from which on another model is in force, its number and the shapes
    that are others than at the first."""
    colours, first = link_colours(frames.model(0), frames, view.size), frames.model(0)
    looks = {id(model): _look(run, model, frames, view, length, colours) for model, _ in frames.looks()}
    now, later = looks[id(first)], list[tuple[int, dict[str, Any]]]()
    before = now
    for k in range(1, len(frames.t)):
        then = looks[id(frames.model(k))]
        if then != before:
            later.append((k, {key: shapes for key, shapes in then.items() if shapes != now[key]}))
            before = then
    return now, later


def _look(
    run: Record, model: Drawable, frames: Frames, view: View, length: int, colours: Sequence[int]
) -> dict[str, Any]:
    """The shapes of a model: what does not change from frame to frame while it is in force."""
    return {
        "links": [
            {
                "name": name,
                "outline": _numbers(straightened(np.asarray(outline)), length),
                "colour": colours[k],
                **_surfaces(model, k, length),
            }
            for k, (name, outline) in enumerate(zip(model.links[: len(model.outlines)], model.outlines, strict=True))
        ],
        "points": [
            {"name": one.name, "link": one.link, "at": _numbers(one.place, length)} for one in named_points(run, model)
        ],
        "massCentres": [
            {"name": one.name, "link": one.link, "at": _numbers(one.place, length), "mass": _digits(one.mass)}
            for one in mass_centres(run, model)
        ],
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
        "parts": [_part(one, length) for one in strokes(model, frames, size_of_looks(frames, view.size))],
    }


def _rate(run: Record, rows: float) -> float:
    """Frames per second: more where the run is short or a link turns fast, fewer where so many ``rows`` are too few."""
    duration = max(float(run.t[-1] - run.t[0]), 1e-9)
    turning = [k for k, name in enumerate(run.model.u_names) if name.startswith("w_")]
    fastest = float(np.max(np.abs(run.u[:, turning]), initial=0.0)) if turning else 0.0
    wanted = max(RATE, LEAST_FRAMES / duration, min(fastest / TURN, FASTEST))
    return min(wanted, 0.75 * rows / duration)


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
    if stroke.said:
        found["said"] = stroke.said
    return found


def _surfaces(model: Drawable, link: int, length: int) -> dict[str, Any]:
    """[x, y, radius] of each disc of a link (-1: the ground), in its frame, and the outline of each edge."""
    own = [disc for disc in model.discs if disc.link == link]
    return {
        "discs": [_numbers(np.append(disc.centre, disc.radius), length) for disc in own if disc.round],
        "edges": [_numbers(disc.outline, length) for disc in own if not disc.round],
    }


def _impact(run: Record, number: int, impact: Impact, places: StruckPlaces, length: int) -> dict[str, Any]:
    q, _ = run.at(impact.t)
    contacts = [
        {
            "point": point,
            "ground": ground,
            "at": _numbers(places.at(number, (point, ground), q), length),
            "impulse": _digits(impulse),
            "unit": "N m s" if ground in run.model.stops else "N s",
        }
        for (point, ground), impulse in zip(impact.contacts, impact.impulses, strict=True)
    ]
    return {"t": _numbers(np.array(impact.t), 9), "contacts": contacts, "loss": _digits(impact.energy_loss)}


def _event(event: Event) -> dict[str, Any]:
    """When it came, and what is said of it."""
    number = f" ({event.number})" if event.number > 1 else ""
    what = ": " + ", ".join(event.done) if event.done else ""
    said = f"event {event.name}{number}, {event.direction}, at t = {event.t:.6f} s{what}"
    return {"t": _numbers(np.array(event.t), 9), "name": event.name, "said": said}


def _chart(
    run: Record, names: Sequence[str], wanted: Sequence[str], frames: Frames, jumps: Sequence[float]
) -> dict[str, Any]:
    """Times, those of ``jumps`` twice, and the values of each output at them; null where it is not known. Outputs that
    nobody ``wanted`` and that are zero all the time, as friction where there is none, are left out."""
    t, asked = chart_times(run, frames.t, jumps)
    kinetic, potential = Sample(run, asked).energies
    values = dict(zip(ENERGIES, (kinetic + potential, kinetic, potential), strict=True))
    units = dict.fromkeys(ENERGIES, "J")
    if names:
        values, units = values | curves(run, names, asked), units_of(run.model)
    telling = [name for name in values if name in wanted or np.any(np.nan_to_num(values[name]))]
    return {
        "t": _numbers(t, 9),
        "columns": [{"name": name, "unit": units[name], "values": _known(values[name])} for name in telling],
    }


def _known(values: FloatArray) -> Any:
    """Numbers rounded to 1e-6 of the largest, and None for those that are none."""
    finite = np.isfinite(values)
    largest = float(np.max(np.abs(values[finite]), initial=0.0))
    decimals = _decimals(1e-6 * largest)
    rounded = _numbers(np.where(finite, values, 0.0), decimals)
    return [number if is_one else None for number, is_one in zip(rounded, finite, strict=True)]


def _view(view: View, length: int) -> dict[str, Any]:
    """Centres for every frame where the view follows, otherwise only one."""
    moving = any(view.follow)
    centre = view.centre if moving else view.centre[:1]
    size = _numbers(np.array(view.size), length)
    return {"half": _numbers(view.half, length), "centre": _numbers(centre, length), "follow": moving, "size": size}


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
