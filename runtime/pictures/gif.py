"""The moving picture of a run as a GIF."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..extras import needed
from ..files import write_whole
from ..record.impact import Impact
from ..record.record import Record
from .contact_place import StruckPlaces
from .frames import frame_times, sample, shown_impacts
from .marks import FLASH, SOFT
from .plot import Drawing
from .view import view_of

RATE = 25  # frames per second; a GIF counts in hundredths, so this plays in real time
PIXELS = 480  # the longer side
GLOW = 0.12  # seconds for which an impact is seen
PURPOSE = "an animation as a GIF"


def write_gif(run: Record, path: Path) -> Path:
    """Write the motion to `path`, in real time, with each impact glowing at its contact points."""
    needed("PIL", PURPOSE)
    pictures = _pictures(run)
    first = next(pictures)
    colours = first.quantize(128)  # of a picture that shows every colour there is
    indexed = (picture.quantize(palette=colours, dither=0) for picture in pictures)
    opening = next(indexed)
    write_whole(
        path,
        lambda part: opening.save(
            part, format="GIF", save_all=True, append_images=indexed, duration=1000 // RATE, loop=0, disposal=1
        ),
    )
    return path


def _pictures(run: Record) -> Iterator[Any]:
    """One picture with a glow for the palette, then the frames."""
    image = needed("PIL.Image", PURPOSE)
    for figure in drawn_frames(run, RATE, PIXELS, PURPOSE):
        figure.canvas.draw()
        yield image.fromarray(np.asarray(figure.canvas.buffer_rgba())[..., :3].copy())


def drawn_frames(run: Record, rate: int, pixels: int, purpose: str) -> Iterator[Any]:
    """One figure, drawn anew for every frame, of ``rate`` a second, and ``pixels`` on its longer side. A picture of the
    start with a glow comes first: it has every colour there is."""
    figures, backend = needed("matplotlib.figure", purpose), needed("matplotlib.backends.backend_agg", purpose)
    frames = sample(run, frame_times(run, rate, with_impacts=False))
    impacts, places = shown_impacts(run), StruckPlaces(run)
    view = view_of(frames)
    sides = np.clip(view.half / view.half.max(), 0.4, 1.0)
    view = replace(view, half=sides * view.half.max())

    figure = figures.Figure(figsize=tuple(sides * PIXELS / 100), dpi=100 * pixels / PIXELS)
    backend.FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    drawing = Drawing(axes, frames.model(0), view, frames, 72.0 * sides[0] * PIXELS / 100 / (2.0 * float(view.half[0])))
    (glow,) = axes.plot([], [], "o", color=FLASH, fillstyle="none", markersize=18, markeredgewidth=3, zorder=6)
    clock = axes.text(0.02, 0.98, "", transform=axes.transAxes, va="top", family="monospace", fontsize=10, color=SOFT)

    def draw(k: int, struck: FloatArray) -> Any:
        nonlocal drawing
        if frames.model(k) is not drawing.model:
            drawing = drawing.of(frames.model(k))
        drawing.show(frames, k, view.centre[k])
        glow.set_data(*struck.T)
        clock.set_text(f"{run.model.name}   t = {frames.t[k]:.2f} s")
        return figure

    yield draw(0, view.centre[:1])
    for k in range(len(frames.t)):
        yield draw(k, _struck(run, impacts, places, float(frames.t[k])))


def _struck(run: Record, impacts: list[tuple[int, Impact]], places: StruckPlaces, t: float) -> FloatArray:
    """Where the contacts of the impacts just before t were when they struck, (k, 2)."""
    recent = [(k, impact) for k, impact in impacts if 0 <= t - impact.t < GLOW]
    points = [places.at(k, contact, run.at(impact.t)[0]) for k, impact in recent for contact in impact.contacts]
    return np.reshape(points, (-1, 2))
