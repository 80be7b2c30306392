"""The figure of a run: poses at the instants that matter, and energy, heights and closure over time.

`Drawing` is the mechanism on one pair of axes; the moving picture uses it too.
"""

from __future__ import annotations

import os
import textwrap
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..extras import needed
from ..files import read_path, write_whole
from ..model.disc import Disc
from ..record.drawable import Drawable
from ..record.outputs import Sample
from ..record.record import Record
from .contact_place import StruckPlaces
from .frames import Frames, frame_times, pivots, placed, sample
from .instants import instants
from .link_colours import COLOURS, link_colours
from .marks import EARTH, FLASH, SOFT, mark_instants, name_marks
from .strokes import Stroke, size_of_links, size_of_looks, straightened, strokes
from .title import title_of
from .view import View, view_of

INK, ACCENT = "#222222", "#33629b"

LEVEL = 0.2  # a ground whose normal rises less is a wall: what is off it is not above it
WIDE = 0.5  # poses that are flatter than this stand in two rows
NARROW = 0.6  # in frames narrower than this, of their height, there is room for one number below
STEADY = 1e-9  # curves that change by less than this part of their size are constant to rounding
ARROW = 0.35  # length of the longest arrow of a frame, part of the view's smaller half
CURVES = 600  # least number of instants on a curve
GROUPS = 4000
"""Groups of points of a curve that are drawn by their extremes: a picture is some 1300 dots wide."""
NAMED = 8  # curves that get a name and a colour each; more are shaded by their order


def draw(
    run: Record,
    path: str | os.PathLike[str] | None = None,
    *,
    forces: bool = False,
    settings: Mapping[str, object] | None = None,
) -> Any:
    """The figure of a run, saved as a PNG where a path is given; with ``forces`` its poses have arrows of what grounds
    push: forces, and at impacts impulses. The ``settings`` are named over it (:func:`title_of`)."""
    if not isinstance(forces, bool | np.bool_):
        raise TypeError(f"forces: found {forces!r}, expected True or False")
    target = None if path is None else read_path(path, "a .png file")
    if target is not None and target.suffix != ".png":
        raise ValueError(f"path: a plot is saved as .png, found {target.name!r}, expected a name that ends so")
    needed("matplotlib", "a plot of a run")
    figure_module = needed("matplotlib.figure", "a plot of a run")
    backend = needed("matplotlib.backends.backend_agg", "a plot of a run")

    duration = float(run.t[-1] - run.t[0])
    frames = sample(run, frame_times(run, CURVES / duration if duration > 0 else 1.0))
    curves = [_energy, _heights] + ([_closure] if run.model.closure(run.q[:1]).size else [])

    shown = instants(run)
    poses = sample(run, np.array([t for t, _ in shown]))
    view = view_of(poses)
    flat = float(view.half[1] / view.half[0])
    lines = 2 if flat < WIDE and len(shown) > 3 else 1
    column = 10.4 * lines / len(shown)  # inches from pose to pose
    tall = lines * (0.6 + 0.2 * any(view.follow) + float(np.clip(column * flat, 0.5, 2.6)))  # for the poses
    heights = [0.6 if curve is _closure else 1.0 for curve in curves]

    figure = figure_module.Figure(figsize=(11, 0.7 + tall + 2.0 * sum(heights)), dpi=120, layout="constrained")
    figure.get_layout_engine().set(w_pad=0.08)
    backend.FigureCanvasAgg(figure)
    strip, below = figure.subfigures(2, 1, height_ratios=(tall, 0.3 + 2.0 * sum(heights)))
    titles = [title for _, title in shown]
    _poses(strip.subplots(lines, -(-len(shown) // lines), squeeze=False), run, titles, poses, frames, view, forces)
    rows = below.subplots(len(curves), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    for axes, curve in zip(rows, curves, strict=True):
        curve(axes, run, frames)
        mark_instants(axes, run)
        axes.grid(True, color="#e6e6e6", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
    rows[-1].set_xlabel("time [s]")
    name_marks(below, run)
    below.align_ylabels(rows)
    if duration > 0:
        rows[-1].set_xlim(run.t[0], run.t[-1])
    title = title_of(run, settings)
    figure.suptitle(title if run.success else f"{title} — {_short(run.message)}", fontsize=13)

    if target is not None:
        write_whole(target, lambda part: figure.savefig(part, format="png", metadata={"Software": "ccgen"}))
    return figure


def _short(message: str) -> str:
    """The beginning of a message, as far as a title is read: why a run stopped, without the advice, in a line."""
    return textwrap.shorten(message.split(";", maxsplit=1)[0], 100, placeholder=" …")


def _poses(grid: Any, run: Record, titles: list[str], poses: Frames, motion: Frames, view: View, forces: bool) -> None:
    """The poses in axes of a grid, row by row; what is left of it stays empty."""
    for axes in grid.ravel()[len(titles) :]:
        axes.set_axis_off()
    room = 72.0 * 10.4 / grid.shape[1] / (2.0 * float(view.half[0]))  # points of the printer per metre
    arrows, places = _arrows(run, poses) if forces else [], StruckPlaces(run)
    for k, (axes, title) in enumerate(zip(grid.ravel(), titles, strict=False)):
        Drawing(axes, poses.model(k), view, motion, room).show(poses, k, view.centre[k])
        for number, impact in enumerate(run.impacts):
            if impact.t == poses.t[k]:
                struck = np.array([places.at(number + 1, contact, poses.q[k]) for contact in impact.contacts])
                circle = {"color": FLASH, "fillstyle": "none", "markersize": 13, "markeredgewidth": 1.8}
                axes.plot(*struck.T, "o", **circle, zorder=6, clip_on=False)
        if arrows:
            at_impact = any(impact.t == poses.t[k] for impact in run.impacts)
            _draw_arrows(axes, arrows[k], view, "N s" if at_impact else "N")
        axes.set_title(f"{title}\n$t$ = {poses.t[k]:.4g} s", fontsize=9, color=INK if title else SOFT)
        axes.set(xticks=[], yticks=[])
        if view.follow[0]:  # the frame of view moves: say where it is
            low, high = axes.get_xlim()
            ticks = [tick for tick in _ticks(low, high) if low <= tick <= high]
            narrow = view.half[0] < NARROW * view.half[1]
            axes.set_xticks(ticks[len(ticks) // 2 :][:1] if narrow else ticks)
            axes.tick_params(axis="x", labelsize=7, colors=SOFT, length=2)
            axes.set_xlabel("x [m]", fontsize=7, color=SOFT, labelpad=1)
        if view.follow[1]:
            low, high = axes.get_ylim()
            axes.set_yticks([tick for tick in _ticks(low, high) if low <= tick <= high])
            axes.tick_params(axis="y", labelsize=7, colors=SOFT, length=2)
        for spine in axes.spines.values():
            spine.set_color("#dddddd")


def _ticks(low: float, high: float) -> list[float]:
    ticker = needed("matplotlib.ticker", "a plot of a run")
    return list(ticker.MaxNLocator(3).tick_values(low, high))


Arrow = tuple[FloatArray, FloatArray]
"""The place (2,) in m at which a ground pushes, and the force (N) or impulse (N s), (2,)."""


def _arrows(run: Record, poses: Frames) -> list[list[Arrow]]:
    """For each pose what grounds push in it: at an impact impulses, else forces."""
    found: list[list[Arrow]] = []
    for k, (t, q) in enumerate(zip(poses.t, poses.q, strict=True)):
        number = next((number for number, one in enumerate(run.impacts) if one.t == t), None)
        model = poses.model(k) if number is None else run.in_force.at_impact(number)
        planes = model.ground_planes()
        if number is not None:
            impact = run.impacts[number]
            rubbing = impact.friction if len(impact.friction) else np.zeros(len(impact.contacts))
            pushes = dict(zip(impact.contacts, np.column_stack([impact.impulses, rubbing]), strict=True))
        elif run.motion is not None:
            pushes = dict(zip(run.model.contacts, run.contact_forces(t), strict=True))
        else:
            pushes = {}
        arrows = []
        for (point, ground), (normal, along) in pushes.items():
            if ground in planes and np.isfinite(normal) and (normal or along):
                place, up = planes[ground]
                at = np.asarray(model.point(point, q))
                at = at - ((at - place) @ up) * up
                arrows.append((at, normal * up + along * np.array([up[1], -up[0]])))
        found.append(arrows)
    return found


def round_below(value: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is at most a positive value."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(f"{power * max(step for step in (1, 2, 5) if step * power <= value * (1 + 1e-12)):.3g}")


def _draw_arrows(axes: Any, arrows: list[Arrow], view: View, unit: str) -> None:
    """The largest is as long as a part of the view; each pose has a scale of its own, as impulses are no forces, and an
    arrow in its corner that says how long a round number of ``unit`` is."""
    largest = max((float(np.hypot(*force)) for _, force in arrows), default=0.0)
    if not largest:
        return
    longest = ARROW * float(view.half.min())
    known = round_below(largest)
    (low, _), (bottom, _) = axes.get_xlim(), axes.get_ylim()
    corner = np.array([low, bottom]) + 0.08 * float(view.half.min())
    end = corner + np.array([longest * known / largest, 0.0])
    style = {"arrowstyle": "-|>", "color": FLASH, "linewidth": 1.6, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", end, corner, arrowprops=style, zorder=7)
    said = {"textcoords": "offset points", "fontsize": 7, "color": FLASH, "va": "center", "zorder": 7}
    axes.annotate(f"{known:g} {unit}", end, (4, 0), **said)
    for at, force in arrows:
        axes.annotate("", at + longest / largest * force, at, arrowprops=style, zorder=7)


def _energy(axes: Any, run: Record, frames: Frames) -> None:
    with_rows, (of_kinetic, of_potential) = _with_rows(run, frames), Sample(run, None).energies
    t, kinetic = with_rows(run.t, frames.t), with_rows(of_kinetic, frames.kinetic)
    potential = with_rows(of_potential, frames.potential)
    potential = potential - potential.min()  # else changes are lost beside a height that nothing comes to
    axes.plot(t, kinetic, color=COLOURS[3], label="kinetic")
    axes.plot(t, potential, color=COLOURS[4], label="potential,\nfrom its lowest")
    axes.plot(t, kinetic + potential, color=INK, linewidth=1.8, label="total")
    _dot_what_is_one_row(axes)
    axes.set_ylabel("energy [J]")
    _keep_sensible(axes, np.concatenate([kinetic, potential]), 1.0)
    _legend(axes)


def _with_rows(run: Record, frames: Frames) -> Callable[[FloatArray, FloatArray], FloatArray]:
    """What puts values at every recorded row and at the frames between rows in the order of time: jumps are drawn as
    jumps, and quick turns whole; of time stepping the rows alone: states between them are on a line, which keeps no
    energy."""
    between = ~np.isin(frames.t, run.t)
    for phase in run.phases:
        if phase.kind == "steps":
            between &= (frames.t <= phase.start) | (frames.t >= phase.end)
    order = np.argsort(np.concatenate([run.t, frames.t[between]]), kind="stable")
    return lambda of_rows, of_frames: np.concatenate([of_rows, of_frames[between]])[order]


def _heights(axes: Any, run: Record, frames: Frames) -> None:
    """The gap of every contact while that is on, called after its point, and after what that touches where there are
    several; without contacts how far joints are along their lines, or, where none slides, heights of the joints that
    move, or, where none does, angles."""
    model, rows, with_rows = run.model, Sample(run, None), _with_rows(run, frames)
    t, gaps = with_rows(run.t, frames.t), with_rows(rows.gaps, frames.states.gaps)
    among = [contact for contact in model.contacts if contact[1] not in model.stops | model.slide_ends]
    known = dict(zip(model.contacts, gaps.T, strict=True))
    points = [point for point, _ in among]
    heights = {
        point if points.count(point) == 1 else f"{point} on {ground}": known[point, ground]
        for point, ground in among
        if not np.isnan(known[point, ground]).all()
    }
    along = (
        {} if heights else {name: with_rows(curve, frames.states.slides[name]) for name, curve in rows.slides.items()}
    )
    planes = model.ground_planes()
    grounds = {ground for _, ground in model.contacts} <= {*planes, *model.stops, *model.slide_ends}
    level = all(normal[1] > LEVEL for _, normal in planes.values())
    above = "above ground [m]" if level else "off grounds [m]"
    axes.set_ylabel((above if grounds else "gap [m]") if heights else "along line [m]" if along else "height [m]")
    if not heights and not along:
        t = frames.t
        heights = _moving({joint: frames.joints[:, k, 1] for k, joint in enumerate(model.drawn_joints)})
        if heights and not any(np.ptp(curve) for curve in heights.values()):  # a pendulum about a fixed pin
            heights = dict(model.joint_angles(frames.q))
            axes.set_ylabel("angle [rad]")
    heights = heights or along
    named_curves(axes, t, heights)
    if heights:
        _keep_sensible(axes, np.concatenate(list(heights.values())), size_of_links(model, 1.0))


def _moving(curves: dict[str, FloatArray]) -> dict[str, FloatArray]:
    """Without those that do not change, where others do."""
    spread = {name: float(np.ptp(curve)) for name, curve in curves.items()}
    least = STEADY * max(spread.values(), default=0.0)
    return {name: curve for name, curve in curves.items() if spread[name] > least} or curves


def _keep_sensible(axes: Any, values: FloatArray, size: float) -> None:
    """No axis that is all rounding: what is constant is said to be, on an axis of a tenth of its size."""
    values = values[np.isfinite(values)]
    spread, size = float(np.ptp(values)) if len(values) else 0.0, max(size, float(np.max(np.abs(values), initial=0.0)))
    if spread > STEADY * size:
        return
    middle = float(values.mean()) if len(values) else 0.0
    axes.set_ylim(middle - 0.05 * size, middle + 0.05 * size)
    if all(len(line.get_xdata()) == 1 for line in axes.lines):
        return  # of one time nothing is said
    axes.text(0.5, 0.85, "constant, but for rounding", transform=axes.transAxes, color=SOFT, fontsize=9, ha="center")


def named_curves(axes: Any, t: FloatArray, curves: Mapping[str, FloatArray]) -> None:
    """Curves over time: a few in colours of their own, with a legend; many shaded by their order."""
    shades = needed("matplotlib", "a plot of a run").colormaps["cividis"](np.linspace(0.0, 0.9, max(len(curves), 1)))
    few = len(curves) <= NAMED
    for k, (name, curve) in enumerate(curves.items()):
        colour = (*COLOURS, INK, SOFT)[k] if few else shades[k]
        width = 2.6 - 1.6 * k / len(curves) if few else 0.9
        axes.plot(*thinned(t, curve), color=colour, linewidth=width, label=name)
    _dot_what_is_one_row(axes)
    if few and curves:
        _legend(axes, columns=2 if len(curves) > 4 else 1)
    elif curves:
        names = list(curves)
        words = f"{names[0]} (dark)\nto {names[-1]}\n(light)"
        axes.text(1.01, 0.95, words, transform=axes.transAxes, fontsize=8, va="top")


def _dot_what_is_one_row(axes: Any) -> None:
    """Mark curves of a single time by a dot, as a line through one point is not seen."""
    for line in axes.lines:
        if len(line.get_xdata()) == 1:
            line.set(marker="o", markersize=5)


def thinned(t: FloatArray, curve: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Of a curve with more points than can be seen the least and the largest of each group, and its ends: what a
    picture shows is the same, and a long run is drawn as quickly as a short one."""
    size = len(t) // GROUPS
    if size < 4 or np.isnan(curve).any():  # gaps stay where they are
        return t, curve
    groups = curve[: size * GROUPS].reshape(GROUPS, size)
    begins = size * np.arange(GROUPS)
    rest = [0, *range(size * GROUPS, len(t))]
    kept = np.unique(np.concatenate([begins + groups.argmin(axis=1), begins + groups.argmax(axis=1), rest]))
    return t[kept], curve[kept]


def _closure(axes: Any, run: Record, frames: Frames) -> None:
    gap = np.abs(Sample(run, None).closure).max(axis=-1)
    axes.semilogy(run.t, np.maximum(gap, 1e-17), ".-", color=COLOURS[0], linewidth=0.7, markersize=4)
    axes.set_ylabel("closure [m]")
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, 0.3e-17), max(high, 1e-13))


def _legend(axes: Any, columns: int = 1) -> None:
    beside = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.05)}
    axes.legend(**beside, frameon=False, fontsize=8, ncols=columns, handlelength=1.4)


class Drawing:
    """One mechanism on one pair of matplotlib axes; `show` moves it."""

    def __init__(self, axes: Any, model: Drawable, view: View, motion: Frames, room: float) -> None:
        """On ``axes``, with a ``view`` whose frames are shown, of a ``motion`` in which all of the way is that guides
        are drawn for; ``room`` is how many points of the printer a metre has, by which lines have their widths."""
        self.axes, self.model, self.view, self._given = axes, model, view, (motion, room)
        before = set(axes.get_children())
        axes.set_aspect("equal")
        self._draw_grounds()
        size = size_of_looks(motion, view.size)
        self._scale = float(np.clip(room * size / 60.0, 0.35, 1.0))  # lines of a small picture are thin
        self._colours = [COLOURS[number] for number in link_colours(motion.model(0), motion, view.size)]
        held = pivots(model, motion, view.size)
        axes.plot(*held.T, marker=6, linestyle="", color=SOFT, markersize=13 * self._scale, zorder=1)  # triangles
        self._outlines = [straightened(np.asarray(outline)) for outline in model.outlines]
        self._links = [self._link(k, len(outline)) for k, outline in enumerate(self._outlines)]
        self._discs = [self._disc(disc) for disc in model.discs]
        self._strokes = [(stroke, self._stroke(stroke)) for stroke in strokes(model, motion, size)]
        self._said = [(stroke, self._words(stroke)) for stroke, _ in self._strokes if stroke.said]
        (self._joints,) = axes.plot(
            [],
            [],
            "o",
            color="white",
            markeredgecolor=INK,
            markersize=5.0 * self._scale,
            markeredgewidth=1.1 * self._scale,
            zorder=5,
        )
        self._artists = [artist for artist in axes.get_children() if artist not in before]

    def of(self, model: Drawable) -> Drawing:
        """The same with another ``model``, in the place of this one."""
        for artist in self._artists:
            artist.remove()
        motion, room = self._given
        return Drawing(self.axes, model, self.view, motion, room)

    def _stroke(self, stroke: Stroke) -> Any:
        """The artist of a stroke, called after it."""
        named = {"ink": INK, "soft": SOFT, "accent": ACCENT}
        colour = self._colour(stroke.colour) if isinstance(stroke.colour, int) else named[stroke.colour]
        width = (0.8 if stroke.colour == "soft" else 1.2) * max(self._scale, 0.6)
        if stroke.filled:
            (area,) = self.axes.fill([], [], facecolor=colour, edgecolor=INK, linewidth=width, zorder=4)
            area.set_gid(stroke.name)
            return area
        (line,) = self.axes.plot([], [], color=colour, linewidth=width, zorder=4, gid=stroke.name)
        return line

    def _words(self, stroke: Stroke) -> Any:
        """What stands beyond the second corner of a stroke."""
        way = {"textcoords": "offset points", "color": ACCENT, "fontsize": 7, "annotation_clip": False}
        words = self.axes.annotate(stroke.said, (0, 0), (0, 0), ha="center", va="center", zorder=6, **way)
        words.set_in_layout(False)  # else poses would make room for it, each as much as it needs
        return words

    def _colour(self, link: int) -> str:
        return self._colours[link] if link >= 0 else SOFT

    def _link(self, k: int, points: int) -> Any:
        """The artist of a link: a bar, an area where the link has three points or more that are not in line, a dot
        where it has one and no disc."""
        colour = self._colours[k]
        if points >= 3:
            fill = needed("matplotlib.colors", "a plot").to_rgba(colour, 0.35)
            (area,) = self.axes.fill(
                [], [], facecolor=fill, edgecolor=colour, linewidth=2 * self._scale, joinstyle="round", zorder=2
            )
            return area
        if points == 1 and not any(disc.link == k for disc in self.model.discs):
            (dot,) = self.axes.plot([], [], "o", color=colour, markersize=8, zorder=3)
            return dot
        width = 4.5 * self._scale
        (bar,) = self.axes.plot([], [], color=colour, linewidth=width, solid_capstyle="round", zorder=3)
        return bar

    def _disc(self, disc: Disc) -> Any:
        """The artist of a disc or an edge: its rim and a spoke; what is fixed stays where it is."""
        colour = self._colour(disc.link)
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
        for link, (outline, artist) in enumerate(zip(self._outlines, self._links, strict=True)):
            points = placed(outline, frames.poses[k, link])
            if len(points) >= 3:
                artist.set_xy(points)
            else:
                artist.set_data(*points.T)
        for disc, rim in zip(self.model.discs, self._discs, strict=True):
            if disc.fixed:
                continue
            rim.set_data(*placed(disc.outline, frames.poses[k, disc.link]).T)
        for stroke, line in self._strokes:
            if stroke.filled:
                line.set_xy(stroke.corners(frames.poses[k]))
                continue
            line.set_data(*stroke.corners(frames.poses[k]).T)
            if stroke.length is not None:
                line.set_linestyle("--" if stroke.slack(frames.poses[k]) else "-")
        for stroke, words in self._said:
            first, second = stroke.corners(frames.poses[k])[:2]
            along = (second - first) / (float(np.hypot(*(second - first))) or 1.0)
            words.xy = second
            words.set_position(along * [16.0, 7.0])  # words are wider than high
        self._joints.set_data(*frames.joints[k].T)
        low, high = centre - self.view.half, centre + self.view.half
        self.axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
