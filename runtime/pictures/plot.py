"""The figure of a run: poses at the instants that matter, and energy, heights and closure over time.

`Drawing` is the mechanism on one pair of axes; the moving picture uses it too.
"""

from __future__ import annotations

import os
import textwrap
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..extras import needed
from ..files import read_path, write_whole
from ..model.disc import Disc
from ..record.drawable import Drawable
from ..record.record import Record
from .frames import Frames, View, frame_times, placed, sample, shown_impacts, view_of

# Told apart with any colour vision (P. Tol's muted and bright schemes), in the order of the links.
COLOURS = ("#4477aa", "#cc6677", "#117733", "#ddaa33", "#88ccee", "#aa4499")
INK, SOFT, EARTH, FLASH = "#222222", "#888888", "#e9e4da", "#d55e00"

PANELS = 6  # poses drawn
CURVES = 600  # least number of instants on a curve
NAMED = 8  # curves that get a name and a colour each; more are shaded by their order


def draw(run: Record, path: str | os.PathLike[str] | None = None) -> Any:
    """The figure of a run, saved as a PNG where a path is given."""
    target = None if path is None else read_path(path, "a .png file")
    if target is not None and target.suffix != ".png":
        raise ValueError(f"a plot is saved as .png, found {target.name!r}; use another name")
    needed("matplotlib", "a plot of a run")
    figure_module = needed("matplotlib.figure", "a plot of a run")
    backend = needed("matplotlib.backends.backend_agg", "a plot of a run")

    duration = float(run.t[-1] - run.t[0])
    frames = sample(run, frame_times(run, CURVES / duration if duration > 0 else 1.0))
    curves = [_energy, _heights] + ([_closure] if run.model.closure(run.q[:1]).size else [])

    shown = instants(run)
    poses = sample(run, np.array([t for t, _ in shown]))
    view = view_of(run.model, poses)
    tall = 0.9 + float(np.clip(1.7 * view.half[1] / view.half[0], 1.0, 2.4))  # inches for the strip of poses

    figure = figure_module.Figure(figsize=(11, 0.4 + tall + 2.0 * len(curves)), dpi=120, layout="constrained")
    backend.FigureCanvasAgg(figure)
    strip, below = figure.subfigures(2, 1, height_ratios=(tall, 2.0 * len(curves)))
    _poses(strip, run, [title for _, title in shown], poses, view)
    rows = below.subplots(len(curves), 1, sharex=True, squeeze=False)[:, 0]
    for axes, curve in zip(rows, curves, strict=True):
        curve(axes, run, frames)
        mark_impacts(axes, run)
        axes.grid(True, color="#e6e6e6", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
    rows[-1].set_xlabel("time [s]")
    if duration > 0:
        rows[-1].set_xlim(run.t[0], run.t[-1])
    figure.suptitle(run.model.name if run.success else f"{run.model.name} — {_short(run.message)}", fontsize=13)

    if target is not None:
        write_whole(target, lambda part: figure.savefig(part, format="png", metadata={"Software": "ccgen"}))
    return figure


def _short(message: str) -> str:
    """The beginning of a message, as far as a title is read: why a run stopped, without the advice, in a line."""
    return textwrap.shorten(message.split(";", maxsplit=1)[0], 100, placeholder=" …")


def instants(run: Record, count: int = PANELS) -> list[tuple[float, str]]:
    """Up to `count` instants worth a picture, with their titles: start, joints that change, first impacts, end; gaps
    filled in between."""
    named = {float(run.t[0]): "start"}
    for change in run.changes[: count - 2]:
        named.setdefault(change.t, f"{change.joint} {'lets go' if change.kind == 'release' else 'takes hold'}")
    for number, impact in enumerate(run.impacts, start=1):
        if len(named) < count - 1 and float(impact.t) not in named:
            named[float(impact.t)] = f"impact {number}"
    named.setdefault(float(run.t[-1]), "end")
    times = np.array(sorted(named))
    if len(times) > 1:
        parts = np.ones(len(times) - 1)  # into how many equal parts each gap is cut
        while parts.sum() < count - 1:
            parts[np.argmax(np.diff(times) / parts)] += 1
        times = np.interp(np.arange(parts.sum() + 1), np.concatenate([[0], np.cumsum(parts)]), times)
    return [(float(t), named.get(float(t), "")) for t in times]


def _poses(figure: Any, run: Record, titles: list[str], frames: Frames, view: View) -> None:
    for k, (axes, title) in enumerate(zip(figure.subplots(1, len(titles), squeeze=False)[0], titles, strict=True)):
        Drawing(axes, run.model, view).show(frames, k, view.centre[k])
        for impact in run.impacts:
            if impact.t == frames.t[k]:
                struck = np.array([run.model.point(point, frames.q[k]) for point, _ in impact.contacts])
                axes.plot(*struck.T, "o", color=FLASH, fillstyle="none", markersize=13, markeredgewidth=1.8, zorder=6)
        axes.set_title(f"{title}\n$t$ = {frames.t[k]:.4g} s", fontsize=9, color=INK if title else SOFT)
        axes.set(xticks=[], yticks=[])
        for spine in axes.spines.values():
            spine.set_color("#dddddd")


def _energy(axes: Any, run: Record, frames: Frames) -> None:
    t, kinetic, potential = _with_both_sides(run, frames)
    axes.plot(t, kinetic, color=COLOURS[3], label="kinetic")
    axes.plot(t, potential, color=COLOURS[4], label="potential")
    axes.plot(t, kinetic + potential, color=INK, linewidth=1.8, label="total")
    axes.set_ylabel("energy [J]")
    _legend(axes)


def _with_both_sides(run: Record, frames: Frames) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Time and energies of the frames together with every recorded row, so that jumps are drawn as jumps."""
    kinetic, potential = run.model.energy(run.q, run.u)
    between = ~np.isin(frames.t, run.t)
    t = np.concatenate([run.t, frames.t[between]])
    order = np.argsort(t, kind="stable")
    kinetic = np.concatenate([kinetic, frames.kinetic[between]])
    potential = np.concatenate([potential, frames.potential[between]])
    return t[order], kinetic[order], potential[order]


def _heights(axes: Any, run: Record, frames: Frames) -> None:
    """Distance of each contact point from the nearest of what it can touch; without any, how far joints are along their
    lines, or, where none slides, heights of the joints."""
    model, gaps = run.model, run.model.gaps(frames.q)
    heights: dict[str, FloatArray] = {}
    nearest = False  # of several grounds that one point can touch
    for (point, ground), gap in zip(model.contacts, gaps.T, strict=True):
        if ground not in model.stops:
            nearest |= point in heights
            heights[point] = np.minimum(heights.get(point, gap), gap)
    along = {} if heights else dict(model.slides(frames.q))
    grounds = {ground for _, ground in model.contacts} <= {*model.ground_planes(), *model.stops}
    above = "above nearest ground [m]" if nearest else "above ground [m]"
    axes.set_ylabel((above if grounds else "gap [m]") if heights else "along line [m]" if along else "height [m]")
    heights = heights or along or {joint: frames.joints[:, k, 1] for k, joint in enumerate(model.drawn_joints)}
    named_curves(axes, frames.t, heights)


def named_curves(axes: Any, t: FloatArray, curves: Mapping[str, FloatArray]) -> None:
    """Curves over time: a few in colours of their own, with a legend; many shaded by their order."""
    shades = needed("matplotlib", "a plot of a run").colormaps["cividis"](np.linspace(0.0, 0.9, max(len(curves), 1)))
    few = len(curves) <= NAMED
    for k, (name, curve) in enumerate(curves.items()):
        colour = (*COLOURS, INK, SOFT)[k] if few else shades[k]
        axes.plot(t, curve, color=colour, linewidth=2.6 - 1.6 * k / len(curves) if few else 0.9, label=name)
    if few and curves:
        _legend(axes, columns=2 if len(curves) > 4 else 1)
    elif curves:
        names = list(curves)
        words = f"{names[0]} (dark)\nto {names[-1]}\n(light)"
        axes.text(1.01, 0.95, words, transform=axes.transAxes, fontsize=8, va="top")


def _closure(axes: Any, run: Record, frames: Frames) -> None:
    gap = np.abs(run.model.closure(run.q)).max(axis=-1)
    axes.semilogy(run.t, np.maximum(gap, 1e-17), ".-", color=COLOURS[0], linewidth=0.7, markersize=4)
    axes.set_ylabel("closure [m]")
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, 0.3e-17), max(high, 1e-13))


def mark_impacts(axes: Any, run: Record) -> None:
    """Impacts as lines, contact as shade, time stepping as hatches, however short."""
    for phase in run.phases:
        if phase.kind == "contact" and phase.end - phase.start > 1e-4 * (run.t[-1] - run.t[0]):
            axes.axvspan(phase.start, phase.end, color=EARTH, alpha=0.6, linewidth=0, zorder=0.2)
        elif phase.kind == "steps":
            axes.axvspan(phase.start, phase.end, facecolor="none", edgecolor=SOFT, hatch="////", zorder=0.3)
    times = sorted({impact.t for _, impact in shown_impacts(run)})
    strength = 0.7 if len(times) <= 40 else 0.25
    for t in times:
        axes.axvline(t, color=FLASH, linewidth=0.8, alpha=strength, linestyle=(0, (4, 2)), zorder=0.5)


def _legend(axes: Any, columns: int = 1) -> None:
    beside = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.05)}
    axes.legend(**beside, frameon=False, fontsize=8, ncols=columns, handlelength=1.4)


class Drawing:
    """One mechanism on one pair of matplotlib axes; `show` moves it."""

    def __init__(self, axes: Any, model: Drawable, view: View) -> None:
        self.axes, self.model, self.view = axes, model, view
        axes.set_aspect("equal")
        self._draw_grounds()
        pivots = np.asarray(model.drawn_ground_points, dtype=float).reshape(-1, 2)
        axes.plot(*pivots.T, marker=6, linestyle="", color=SOFT, markersize=13, zorder=1)  # triangles below
        self._links = [self._link(k, len(outline)) for k, outline in enumerate(model.outlines)]
        self._discs = [self._disc(disc) for disc in model.discs]
        self._ropes = [axes.plot([], [], color=INK, linewidth=1.0, zorder=4)[0] for _ in model.ropes]
        size = 5.0 if len(model.drawn_joints) <= 16 else 2.5
        (self._joints,) = axes.plot(
            [], [], "o", color="white", markeredgecolor=INK, markersize=size, markeredgewidth=1.1, zorder=5
        )

    def _link(self, k: int, points: int) -> Any:
        """The artist of a link: a bar, an area where the link has three points or more, a dot where it has one and no
        disc."""
        colour = COLOURS[k % len(COLOURS)]
        if points >= 3:
            fill = needed("matplotlib.colors", "a plot").to_rgba(colour, 0.35)
            (area,) = self.axes.fill([], [], facecolor=fill, edgecolor=colour, linewidth=2, joinstyle="round", zorder=2)
            return area
        if points == 1 and not any(disc.link == k for disc in self.model.discs):
            (dot,) = self.axes.plot([], [], "o", color=colour, markersize=8, zorder=3)
            return dot
        width = 4.5 if len(self.model.outlines) <= 16 else 2.5
        (bar,) = self.axes.plot([], [], color=colour, linewidth=width, solid_capstyle="round", zorder=3)
        return bar

    def _disc(self, disc: Disc) -> Any:
        """The artist of a disc or an edge: its rim and a spoke; what is fixed stays where it is."""
        colour = SOFT if disc.fixed else COLOURS[disc.link % len(COLOURS)]
        (rim,) = self.axes.plot([], [], color=colour, linewidth=1.6, zorder=1.5 if disc.fixed else 2.5)
        rim.set_data(*disc.outline.T)
        return rim

    def _draw_grounds(self) -> None:
        """Each half plane as an area with a hatched rim, large enough for every place the view goes to."""
        view = self.view
        middle = 0.5 * (view.centre.min(axis=0) + view.centre.max(axis=0))
        reach = float(np.hypot(*(view.half + np.ptp(view.centre, axis=0)))) * 2
        rim = 0.10 * float(view.half.max())
        for point, normal in self.model.ground_planes().values():
            tangent = np.array([normal[1], -normal[0]])
            foot = middle - ((middle - point) @ normal) * normal
            ends = np.array([foot - reach * tangent, foot + reach * tangent])
            deep = reach + float(np.abs((middle - point) @ normal))
            self.axes.fill(*np.concatenate([ends, ends[::-1] - deep * normal]).T, color=EARTH, linewidth=0, zorder=0)
            band = np.concatenate([ends, ends[::-1] - rim * normal])
            self.axes.fill(*band.T, facecolor="none", edgecolor="#b5aa95", hatch="/////", linewidth=0, zorder=0.1)
            self.axes.plot(*ends.T, color="#7a705e", linewidth=1.4, zorder=0.2)

    def show(self, frames: Frames, k: int, centre: FloatArray) -> None:
        """Move the mechanism to frame k and the view to its centre."""
        for link, (outline, artist) in enumerate(zip(self.model.outlines, self._links, strict=True)):
            points = placed(np.asarray(outline), frames.poses[k, link])
            if len(points) >= 3:
                artist.set_xy(points)
            else:
                artist.set_data(*points.T)
        for disc, rim in zip(self.model.discs, self._discs, strict=True):
            if disc.fixed:
                continue
            rim.set_data(*placed(disc.outline, frames.poses[k, disc.link]).T)
        for rope, line in zip(self.model.ropes, self._ropes, strict=True):
            line.set_data(*rope.way(frames.poses[k]).T)
        self._joints.set_data(*frames.joints[k].T)
        low, high = centre - self.view.half, centre + self.view.half
        self.axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
