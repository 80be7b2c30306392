"""The figure of outputs by name over time: those of one unit in one panel."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..extras import needed
from ..files import read_path, write_whole
from ..record.outputs import units_of, values_of
from ..record.record import Record
from .plot import CURVES, mark_impacts, named_curves

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


def draw_outputs(run: Record, names: Sequence[str], path: str | os.PathLike[str] | None = None) -> Any:
    """The figure of these outputs, in the order of their names, saved as a PNG where a path is given.

    Drawn at every row of the run and at some hundred even times. Raises ``ValueError`` as :func:`values_of` does.
    """
    target = None if path is None else read_path(path, "a .png file")
    if target is not None and target.suffix != ".png":
        raise ValueError(f"a plot is saved as .png, found {target.name!r}; use another name")
    figure_module = needed("matplotlib.figure", "a plot of outputs")
    backend = needed("matplotlib.backends.backend_agg", "a plot of outputs")
    t, values = _curves(run, names)
    units = units_of(run.model)
    panels = {unit: [name for name in values if units[name] == unit] for unit in dict.fromkeys(map(units.get, values))}
    figure = figure_module.Figure(figsize=(11, 0.8 + 2.2 * len(panels)), dpi=120, layout="constrained")
    backend.FigureCanvasAgg(figure)
    rows = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (unit, shown) in zip(rows, panels.items(), strict=True):
        named_curves(axes, t, {name: values[name] for name in shown})
        mark_impacts(axes, run)
        asked = {name.rpartition(".")[2] for name in shown}
        what = asked.pop().replace("_", " ") if len(asked) == 1 else QUANTITIES[str(unit)]
        axes.set_ylabel(f"{what} [{unit}]".replace("^2", "²"))
        axes.grid(True, color="#e6e6e6", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
    rows[-1].set_xlabel("time [s]")
    if run.t[-1] > run.t[0]:
        rows[-1].set_xlim(run.t[0], run.t[-1])
    figure.suptitle(run.model.name, fontsize=13)
    if target is not None:
        write_whole(target, lambda part: figure.savefig(part, format="png", metadata={"Software": "ccgen"}))
    return figure


def _curves(run: Record, names: Sequence[str]) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Times and outputs there: at rows, which have both sides of impacts, and between them."""
    even = np.setdiff1d(np.linspace(run.t[0], run.t[-1], CURVES + 1, dtype=run.t.dtype), run.t)
    at_rows, between = values_of(run, names), values_of(run, names, even)
    t = np.concatenate([run.t, even])
    order = np.argsort(t, kind="stable")
    return t[order], {name: np.concatenate([at_rows[name], between[name]])[order] for name in at_rows}
