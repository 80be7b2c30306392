"""The picture of a sweep: a map over two numbers that vary, a curve over one, histograms over more and over what is
drawn at random."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..ensemble.table import DONE
from ..extras import needed
from ..files import read_path, write_whole
from .results import Results

CHART = "sweep.png"
"""Its name in the folder of a sweep."""
MOST = 6
"""Panels: of more columns that are observed, the first are drawn."""
BINS = 40
MISSING = "#c44"
"""Colour of runs that did not come to their end."""
TOLD = ("run", "status", "reason", "t", "steps")
"""Columns that are not drawn."""


def draw_sweep(results: Results, path: str | os.PathLike[str]) -> Any:
    """The figure of what was observed, a panel for each column of one number, saved as PNG at ``path``; of a sample
    over one or two numbers a map or a curve, and how often each value is, beside each other.

    Of columns at several times the last is drawn. Runs that did not come to their end are marked and counted. Raises
    ``ValueError`` where no run is done, or where nothing was observed.
    """
    target = read_path(path, "a .png file")
    if target.suffix != ".png":
        raise ValueError(f"path: a chart is saved as .png, found {target.name!r}, expected a name that ends so")
    vary = list(results.manifest["vary"])
    table = {name: results.column(name) for name in results.to_arrow().column_names}
    done = np.asarray(table["status"] == DONE)
    columns = {name: _one(values) for name, values in table.items() if name not in (*TOLD, *vary)}
    if len(columns) > 1 and "impacts" not in results.manifest["observe"]:
        columns.pop("impacts")
    several = [name for name in vary if np.unique(table[name]).size > 1]
    spread = len(several) in (1, 2) and bool(results.manifest["samples"])
    shown = dict(list(columns.items())[: MOST // 2 if spread else MOST])
    labels = _labels([*several, *shown], results.manifest["units"])
    labels |= {
        name: f"{labels[name]} at t = {results.manifest['at'][-1]:g} s" for name in shown if _is_late(table[name])
    }
    figure, panels, beside = _panels(len(shown), spread)
    for axes, (name, values) in zip(panels, shown.items(), strict=True):
        if len(several) == 2:
            xy, of = [table[one] for one in several], [labels[one] for one in several]
            _map(figure, axes, xy, of, labels[name], values, done)
        elif len(several) == 1:
            _curve(axes, table[several[0]], labels[several[0]], labels[name], values, done)
        else:
            _histogram(axes, labels[name], values, done)
    for axes, (name, values) in zip(beside, shown.items(), strict=False):
        _histogram(axes, labels[name], values, done)
    for axes in (*panels, *beside):
        axes.spines[["top", "right"]].set_visible(False)
    statuses, counts = np.unique(table["status"], return_counts=True)
    ends = ", ".join(f"{n} {status}" for status, n in zip(statuses, counts.tolist(), strict=True))
    figure.suptitle(f"{results.manifest['model']}: {len(done)} runs, {ends}", fontsize=12)
    write_whole(target, lambda file: figure.savefig(file, format="png", metadata={"Software": "ccgen"}))
    return figure


def _panels(count: int, beside: bool) -> tuple[Any, list[Any], list[Any]]:
    """A figure with ``count`` panels, and as many ``beside`` them where these are wanted, else none."""
    figure_module = needed("matplotlib.figure", "a chart of a sweep")
    backend = needed("matplotlib.backends.backend_agg", "a chart of a sweep")
    across = 2 if beside else min(3, count)
    down = count if beside else -(-count // across)
    figure = figure_module.Figure(figsize=(1.2 + 4.4 * across, 1.0 + 3.6 * down), dpi=120, layout="constrained")
    backend.FigureCanvasAgg(figure)
    every = figure.subplots(down, across, squeeze=False).ravel().tolist()
    if beside:
        return figure, every[::2], every[1::2]
    for axes in every[count:]:
        axes.set_visible(False)
    return figure, every[:count], []


def _labels(names: Iterable[str], units: Mapping[str, str]) -> dict[str, str]:
    """Names with their units, as headings of tables have them; without one where it is no more than a number, or SI."""
    plain = ("", "1", "SI")
    return {name: name if (unit := units.get(name, "")) in plain else f"{name} [{unit}]" for name in names}


def _is_late(values: Any) -> bool:
    """Whether a column is at several times, of which the last is drawn."""
    return bool(np.ndim(values) == 2)


def _one(values: Any) -> FloatArray:
    """Of columns at several times the last."""
    values = np.asarray(values, dtype=float)
    return np.asarray(values[:, -1]) if _is_late(values) else values


def _map(
    figure: Any, axes: Any, xy: list[FloatArray], names: list[str], name: str, values: FloatArray, done: Any
) -> None:
    """Cells where two numbers lie on a grid, else points."""
    grids = [np.unique(x) for x in xy]
    known = done & np.isfinite(values)
    if grids[0].size * grids[1].size == values.size == np.unique(np.stack(xy), axis=1).shape[1]:
        places = [np.searchsorted(grid, x) for grid, x in zip(grids, xy, strict=True)]
        cells = np.full((grids[1].size, grids[0].size), np.nan)
        cells[places[1][known], places[0][known]] = values[known]
        drawn = axes.pcolormesh(*grids, np.ma.masked_invalid(cells), shading="nearest", cmap="viridis")
        axes.set_facecolor("#f3e3e3")
    else:
        drawn = axes.scatter(xy[0][known], xy[1][known], c=values[known], s=12, cmap="viridis", linewidths=0)
    if not known.all():
        label = f"not to the end: {int((~known).sum())}"
        axes.scatter(xy[0][~known], xy[1][~known], marker="x", s=14, color=MISSING, linewidths=0.8, label=label)
        axes.legend(loc="upper right", fontsize=8)
    figure.colorbar(drawn, ax=axes)
    axes.set_title(name, fontsize=10)
    axes.set_xlabel(names[0])
    axes.set_ylabel(names[1])


def _curve(axes: Any, x: FloatArray, of: str, name: str, values: FloatArray, done: Any) -> None:
    known = done & np.isfinite(values)
    order = np.argsort(x[known], kind="stable")
    axes.plot(x[known][order], values[known][order], "-o", markersize=3, linewidth=1)
    if not known.all():
        low = np.nanmin(values[known]) if known.any() else 0.0
        missing = np.full(int((~known).sum()), low)
        axes.plot(x[~known], missing, "x", color=MISSING, label=f"not to the end: {missing.size}")
        axes.legend(fontsize=8)
    axes.set_xlabel(of)
    axes.set_title(name, fontsize=10)


def _histogram(axes: Any, name: str, values: FloatArray, done: Any) -> None:
    known = done & np.isfinite(values)
    if known.any():
        axes.hist(values[known], bins=min(BINS, max(1, np.unique(values[known]).size)), color="#4a7ab5")
    if not known.all():
        axes.text(
            0.98,
            0.95,
            f"not to the end: {int((~known).sum())}",
            color=MISSING,
            ha="right",
            va="top",
            transform=axes.transAxes,
            fontsize=8,
        )
    axes.set_xlabel(name)
    axes.set_ylabel("runs")
