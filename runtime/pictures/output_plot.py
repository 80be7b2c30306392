"""The figure of outputs by name over time, those of one unit in one panel, and of the paths of points."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..extras import needed
from ..files import read_path, write_whole
from ..record.outputs import outputs_of, points_among, units_of, values_of, with_places
from ..record.record import Record
from .link_colours import COLOURS
from .marks import mark_instants, name_marks
from .plot import CURVES, named_curves
from .title import title_of

QUANTITIES = {
    "rad": "angle",
    "rad/s": "angular velocity",
    "rad/s^2": "angular acceleration",
    "m": "length",
    "m/s": "speed",
    "m/s^2": "acceleration",
    "N": "force",
    "N m": "moment",
    "J": "energy",
    "s": "time",
}
"""What is measured in a unit, where outputs of several kinds share a panel."""

PATH = 5.0
"""Height of the panel of paths (inches)."""


def draw_outputs(
    run: Record,
    names: Sequence[str],
    path: str | os.PathLike[str] | None = None,
    settings: Mapping[str, object] | None = None,
) -> Any:
    """The figure of these outputs, in the order of their names, saved as a PNG where a path is given.

    Of a point, ``coupler.tip``, the path is drawn, y over x, below what is drawn over time. Drawn at every row of the
    run and at some hundred even times. The ``settings`` are named over it (:func:`title_of`). Raises ``ValueError`` as
    :func:`values_of` does.
    """
    target = None if path is None else read_path(path, "a .png file")
    if target is not None and target.suffix != ".png":
        raise ValueError(f"path: a plot is saved as .png, found {target.name!r}, expected a name that ends so")
    figure_module = needed("matplotlib.figure", "a plot of outputs")
    backend = needed("matplotlib.backends.backend_agg", "a plot of outputs")
    points = points_among(run.model, names)
    t, values = _curves(run, with_places(run.model, names))
    units, over_time = units_of(run.model), [name for name in dict.fromkeys(names) if name not in points]
    panels = {unit: [name for name in over_time if units[name] == unit] for unit in map(units.get, over_time)}
    high = 2.2 * len(panels)
    figure = figure_module.Figure(figsize=(11, 0.8 + high + (PATH if points else 0.0)), dpi=120, layout="constrained")
    backend.FigureCanvasAgg(figure)
    parts = figure.subfigures(1 + bool(panels and points), 1, height_ratios=[high, PATH] if panels and points else None)
    above, below = (parts[0], parts[-1]) if panels and points else (parts, parts)
    if panels:
        _over_time(above, run, t, values, panels)
    if points:
        _paths(below, values, points)
    figure.suptitle(title_of(run, settings), fontsize=13)
    if target is not None:
        write_whole(target, lambda part: figure.savefig(part, format="png", metadata={"Software": "ccgen"}))
    return figure


def _over_time(
    figure: Any, run: Record, t: FloatArray, values: Mapping[str, FloatArray], panels: Mapping[Any, Sequence[str]]
) -> None:
    rows = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    labels = {name: f"{name} on {one.link}" if one.link else name for name, one in outputs_of(run.model).items()}
    for axes, (unit, shown) in zip(rows, panels.items(), strict=True):
        named_curves(axes, t, {labels[name]: values[name] for name in shown})
        mark_instants(axes, run)
        asked = {name.rpartition(".")[2] for name in shown}
        what = asked.pop().replace("_", " ") if len(asked) == 1 else QUANTITIES[str(unit)]
        axes.set_ylabel(f"{what} [{unit}]".replace("^2", "²"))
        axes.grid(True, color="#e6e6e6", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
    rows[-1].set_xlabel("time [s]")
    name_marks(figure, run)
    if run.t[-1] > run.t[0]:
        rows[-1].set_xlim(run.t[0], run.t[-1])


def _paths(figure: Any, values: Mapping[str, FloatArray], points: Sequence[str]) -> None:
    """Paths of points, alike in both directions; a dot is where each begins."""
    axes = figure.subplots(1, 1)
    for k, name in enumerate(points):
        colour = COLOURS[k % len(COLOURS)]
        x, y = values[f"{name}.x"], values[f"{name}.y"]
        axes.plot(x, y, color=colour, linewidth=1.6, label=name)
        axes.plot(x[:1], y[:1], "o", color=colour, markersize=5)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), fontsize=8, frameon=False)
    axes.grid(True, color="#e6e6e6", linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)


def _curves(run: Record, names: Sequence[str]) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Times and outputs there: at rows, which have both sides of impacts, and between them."""
    even = np.setdiff1d(np.linspace(run.t[0], run.t[-1], CURVES + 1, dtype=run.t.dtype), run.t)
    at_rows, between = values_of(run, names), values_of(run, names, even)
    t = np.concatenate([run.t, even])
    order = np.argsort(t, kind="stable")
    return t[order], {name: np.concatenate([at_rows[name], between[name]])[order] for name in at_rows}
