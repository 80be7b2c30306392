"""The bifurcation diagram: branches of periodic motions over a parameter, what is stable drawn through."""

from __future__ import annotations

import os
from collections.abc import Sequence
from itertools import groupby, pairwise
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..extras import needed
from ..files import read_path, write_whole
from .branch import Branch
from .values import names_of, shown, unit_of, varied_most

LINE, DOTS, MARK = "#33629b", "#9a9a9a", "#d55e00"
LARGEST, LEAST, CROWD = 4.0, 1.5, 40.0
"""Diameter of dots, in points: the largest, seen beside the lines; the least; and that times the root of how many
columns of them there are, so that many do not run together."""
MARKS = {"fold": "s", "flip": "^", "Neimark-Sacker": "D", "branch point": "o", "grazing": "X"}
"""How each kind of bifurcation is marked."""


def draw_branches(
    branches: Sequence[Branch],
    path: str | os.PathLike[str] | None = None,
    *,
    name: str | None = None,
    settled: tuple[FloatArray, FloatArray] | None = None,
    unit: str | None = None,
) -> Any:
    """The figure of branches of one model along one parameter, saved as PNG where a path is given.

    Drawn is a coordinate or rate by ``name`` each time that the section is crossed, that which changes most unless
    given: stable motions by a line, unstable ones by a dashed one, bifurcations by marks. ``settled`` are values of the
    parameter and what runs settle to there, as :func:`~.orbits.settled.settled` gives them, drawn as dots below.
    ``unit`` is that of the parameter, empty of a plain number: a model does not know it, its scene does.
    Raises ``ValueError`` for names that are none.
    """
    target = None if path is None else read_path(path, "a .png file")
    if target is not None and target.suffix != ".png":
        raise ValueError(f"path: a diagram is saved as .png, found {target.name!r}, expected a name that ends so")
    figure_module = needed("matplotlib.figure", "a bifurcation diagram")
    backend = needed("matplotlib.backends.backend_agg", "a bifurcation diagram")
    model = branches[0].orbits[0].return_map.model
    name = varied_most(branches[0].orbits) if name is None else name
    if name not in names_of(model):
        raise ValueError(f"name: found {name!r}, expected one of {', '.join(names_of(model))}")
    figure = figure_module.Figure(figsize=(8, 5), dpi=120, layout="constrained")
    backend.FigureCanvasAgg(figure)
    axes = figure.subplots()
    if settled is not None:
        axes.plot(*settled, "o", color=DOTS, markersize=_dot(settled[0]), markeredgewidth=0, zorder=1)
        axes.plot([], [], "o", color=DOTS, markersize=LARGEST, markeredgewidth=0, label="runs settle")
    for branch in branches:
        _lines(axes, branch, name)
    _marks(axes, branches, name)
    named = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    axes.legend(named.values(), named.keys(), fontsize=8, frameon=False)
    axes.set_xlabel(branches[0].parameter + {None: " [SI units]", "": ""}.get(unit, f" [{unit}]"))
    axes.set_ylabel(f"{name} [{unit_of(name)}] on the section")
    axes.grid(True, color="#e6e6e6", linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    figure.suptitle(f"{model.name}: periodic motions", fontsize=13)
    if target is not None:
        write_whole(target, lambda part: figure.savefig(part, format="png", metadata={"Software": "ccgen"}))
    return figure


def _dot(values: FloatArray) -> float:
    """The diameter of dots over these values of the parameter, in points."""
    return float(np.clip(CROWD / np.sqrt(max(np.unique(values).size, 1)), LEAST, LARGEST))


def _lines(axes: Any, branch: Branch, name: str) -> None:
    """A branch, bifurcations being points of it, in pieces of one stability."""
    nodes = [
        (float(k), x, shown(one, name), one.stable)
        for k, (x, one) in enumerate(zip(branch.values, branch.orbits, strict=True))
    ]
    kinds = [one for one in branch.bifurcations if one.kind != "grazing"]
    nodes += [(one.place, one.value, shown(one.orbit, name), None) for one in kinds]  # type: ignore[misc]
    nodes.sort(key=lambda node: node[0])
    parts = [(one, other, all(stable is not False for stable in (one[3], other[3]))) for one, other in pairwise(nodes)]
    for stable, group in groupby(parts, key=lambda part: part[2]):
        pieces = list(group)
        chain = [pieces[0][0], *(other for _, other, _ in pieces)]
        x, y = [node[1] for node in chain], np.array([node[2] for node in chain])
        style = {"linestyle": "-" if stable else "--", "linewidth": 1.6 if stable else 1.1, "color": LINE, "zorder": 3}
        for column in y.T:
            axes.plot(x, column, label="stable" if stable else "unstable", **style)


def _marks(axes: Any, branches: Sequence[Branch], name: str) -> None:
    for branch in branches:
        for one in branch.bifurcations:
            y = shown(one.orbit, name)
            style = {"color": MARK, "markersize": 6, "linestyle": "", "zorder": 4, "label": one.kind}
            axes.plot(np.full(len(y), one.value), y, MARKS[one.kind], **style)
