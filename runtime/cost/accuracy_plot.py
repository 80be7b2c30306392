"""The chart of what accuracy costs: error against wall time, a curve for every method."""

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
from .accuracy import Measured

MARKERS = "osD^vP"
STYLES = {"projected": "-", "left": ":", "damped": "--"}
FILLS = {"double": "full", "float": "none", "wide": "left"}
"""How markers are filled, by precision."""
LEAST = {"double": 1e-16, "float": 1e-16, "wide": 1e-19}
"""Errors smaller than this are drawn there."""


def draw_cost(
    measured: Sequence[Measured], title: str, seconds: float, doubt: float, path: str | os.PathLike[str]
) -> Any:
    """The figure, saved as PNG at ``path``.

    ``seconds`` are those simulated, ``doubt`` is how far the reference can be trusted.
    """
    figure_module = needed("matplotlib.figure", "a chart of accuracy")
    backend = needed("matplotlib.backends.backend_agg", "a chart of accuracy")
    figure = figure_module.Figure(figsize=(7.5, 5.0), dpi=120, layout="constrained")
    backend.FigureCanvasAgg(figure)
    axes = figure.subplots()
    names = list(dict.fromkeys(one.method for one in measured))
    least = min(LEAST[one.precision] for one in measured)
    for curve in dict.fromkeys((one.method, one.drift, one.precision) for one in measured):
        method, drift, precision = curve
        rows = [one for one in measured if (one.method, one.drift, one.precision) == curve and np.isfinite(one.worst)]
        k = names.index(method)
        axes.loglog(
            [max(one.worst, least) for one in rows],
            [1e6 * one.seconds / seconds for one in rows],
            STYLES[drift],
            marker=MARKERS[k % len(MARKERS)],
            color=COLOURS[k % len(COLOURS)],
            fillstyle=FILLS[precision],
            markersize=4.5,
            label=", ".join([method, *({drift} - {"projected"}), *({precision} - {"double"})]),
        )
    axes.axvspan(1e-20, max(doubt, least), color="#eeeeee", zorder=0)
    axes.set_xlim(left=least)
    axes.invert_xaxis()
    axes.set_xlabel("largest error of a pose at the end, or of an impact's time  [m, rad, s]", color=INK)
    axes.set_ylabel("wall time  [µs per simulated second]", color=INK)
    axes.grid(True, which="major", color="#e6e6e6", linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False)
    axes.set_title(title, fontsize=11, color=INK)
    axes.text(0.99, 0.01, "grey: what the reference itself does not know", transform=axes.transAxes, ha="right",
              va="bottom", fontsize=8, color=SOFT)  # fmt: skip
    write_whole(Path(path), lambda part: figure.savefig(part, format="png", metadata={"Software": "ccgen"}))
    return figure
