"""The picture of what derivatives cost: error over the step of differences, and error against wall time."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..extras import needed
from ..files import write_whole
from ..pictures.link_colours import COLOURS
from ..pictures.marks import SOFT
from ..pictures.plot import INK
from .gradient import DIFFERENCES, WAYS, Measured

MARKERS = dict(zip(WAYS, "osDv", strict=True))
LEAST = 1e-16
"""Errors smaller than this are drawn there."""


def draw_gradient(
    measured: Sequence[Measured], title: str, rtol: float, doubt: float, path: str | os.PathLike[str]
) -> Any:
    """The figure, saved as PNG at ``path``; ``rtol`` is the scene's, ``doubt`` how far the reference can be trusted."""
    figure_module = needed("matplotlib.figure", "a chart of gradients")
    backend = needed("matplotlib.backends.backend_agg", "a chart of gradients")
    figure = figure_module.Figure(figsize=(10.0, 5.0), dpi=120, layout="constrained")
    backend.FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2, sharey=True)
    tolerances = sorted({one.rtol for one in measured if one.way in DIFFERENCES}, reverse=True)
    for k, way in enumerate(WAYS):
        for tolerance in tolerances if way in DIFFERENCES else [None]:
            rows = [one for one in measured if one.way == way and tolerance in (None, one.rtol)]
            rows = [one for one in rows if np.isfinite(one.error)]
            tight = tolerance is not None and tolerance != rtol
            style: dict[str, Any] = {
                "color": COLOURS[k],
                "marker": MARKERS[way],
                "markersize": 4.0,
                "fillstyle": "none" if tight else "full",
                "label": way if tolerance is None else f"{way}, rtol {tolerance:.0e}",
            }
            errors = [max(one.error, LEAST) for one in rows]
            if way not in DIFFERENCES:
                at = [error for error, one in zip(errors, rows, strict=True) if one.rtol == rtol]
                for error in at:
                    left.axhline(
                        error,
                        color=COLOURS[k],
                        linestyle="--" if way == WAYS[-1] else "-",
                        label=f"{way}, rtol {rtol:.0e}",
                    )
                right.loglog([1e3 * one.seconds for one in rows], errors, linestyle="none", **style)
            else:
                left.loglog([one.step for one in rows], errors, ":" if tight else "-", **style)
                right.loglog([1e3 * one.seconds for one in rows], errors, linestyle="none", **style)
    left.set_xlabel("step, in parts of what is changed", color=INK)
    left.set_ylabel("largest error of an entry, relative", color=INK)
    right.set_xlabel("wall time of the gradient  [ms]", color=INK)
    taken = [1e3 * one.seconds for one in measured if np.isfinite(one.error)]
    if taken:  # whole decades, whose ends have numbers
        right.set_xlim(10.0 ** np.floor(np.log10(min(taken))), 10.0 ** np.ceil(np.log10(max(taken))))
    for axes in (left, right):
        axes.axhspan(LEAST / 10.0, max(doubt, LEAST), color="#eeeeee", zorder=0)
        axes.set_ylim(LEAST, 10.0)
        axes.grid(True, which="major", color="#e6e6e6", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(frameon=False, fontsize=8)
    right.text(0.99, 0.01, "grey: what the reference itself does not know", transform=right.transAxes, ha="right",
               va="bottom", fontsize=8, color=SOFT)  # fmt: skip
    figure.suptitle(title, fontsize=11, color=INK)
    write_whole(Path(path), lambda part: figure.savefig(part, format="png", metadata={"Software": "ccgen"}))
    return figure
