"""The figure of a run's forces: what contacts push, how they rub, and what joints carry, over time."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..extras import needed
from ..files import read_path, write_whole
from ..record.force_history import History, history
from ..record.record import Record
from .marks import mark_instants, name_marks
from .plot import named_curves
from .title import title_of

Panel = tuple[str, dict[str, FloatArray]]
"""Label of the axis, and its curves by name."""


JOINTS = "joint force [N]"
ROOM = 1.2
"""Times the largest force away from lines of links: where the axis ends of forces that have no bound there."""
ROUNDING = 1e-13
"""Times the largest force of a run: some hundred roundings, as many as sums over links and contacts have at most."""


def draw_forces(
    run: Record,
    path: str | os.PathLike[str] | None = None,
    found: History | None = None,
    settings: Mapping[str, object] | None = None,
) -> Any:
    """The figure of a run's forces between impacts, saved as a PNG where a path is given.

    ``found`` are the forces where they are known already. The ``settings`` are named over it (:func:`title_of`)."""
    target = None if path is None else read_path(path, "a .png file")
    if target is not None and target.suffix != ".png":
        raise ValueError(f"path: a plot is saved as .png, found {target.name!r}, expected a name that ends so")
    figure_module = needed("matplotlib.figure", "a plot of forces")
    backend = needed("matplotlib.backends.backend_agg", "a plot of forces")
    found = history(run) if found is None else found
    shown = panels(run, found)
    figure = figure_module.Figure(figsize=(11, 0.8 + 2.2 * len(shown)), dpi=120, layout="constrained")
    backend.FigureCanvasAgg(figure)
    rows = figure.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (label, curves) in zip(rows, shown, strict=True):
        named_curves(axes, *_with_gaps(run, found.t, curves))
        mark_instants(axes, run)
        if found.beside.any() and label == JOINTS:
            away = zip(curves.values(), found.far_of_joints().T, strict=True)
            largest = max(float(np.max(curve, where=far, initial=0.0)) for curve, far in away)
            if not largest > 0.0:  # all rise to where they have no bound: half of the instants are seen
                sizes = np.max(list(curves.values()), axis=0)
                largest = float(np.median(sizes[np.isfinite(sizes)])) if np.isfinite(sizes).any() else 0.0
            if largest > 0.0:
                axes.set_ylim(0.0, ROOM * largest)
        axes.set_ylabel(label)
        axes.grid(True, color="#e6e6e6", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
    rows[-1].set_xlabel("time [s]")
    name_marks(figure, run)
    if run.t[-1] > run.t[0]:
        rows[-1].set_xlim(run.t[0], run.t[-1])
    figure.suptitle(f"{title_of(run, settings)}: forces", fontsize=13)
    if target is not None:
        write_whole(target, lambda part: figure.savefig(part, format="png", metadata={"Software": "ccgen"}))
    return figure


def _with_gaps(run: Record, t: FloatArray, curves: dict[str, FloatArray]) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Times and curves with a point that is no number in each stretch of time stepping, where no force is known."""
    gaps = [0.5 * (phase.start + phase.end) for phase in run.phases if phase.kind == "steps"]
    if not gaps:
        return t, curves
    places = np.searchsorted(t, gaps)
    return np.insert(t, places, gaps), {name: np.insert(curve, places, np.nan) for name, curve in curves.items()}


def _largest(curve: FloatArray) -> float:
    """The largest of sizes that have a bound."""
    return float(np.max(np.abs(curve), where=np.isfinite(curve), initial=0.0))


def panels(run: Record, found: History) -> list[Panel]:
    """Normal forces, friction, moments of stops, and the sizes of the joints' forces, of these what there is.

    Contacts that never push are left out, and a panel whose curves are all rounding of the largest force.
    """
    contacts, stops = run.model.contacts, run.model.stops
    single = len({ground for _, ground in contacts if ground not in stops}) == 1
    normal, friction, turning = {}, {}, {}
    for k, (point, ground) in enumerate(contacts):
        if not np.any(found.pushes[:, k]):
            continue
        if ground in stops:
            turning[ground] = found.pushes[:, k, 0]
            continue
        name = point if single else f"{point} on {ground}"
        normal[name] = found.pushes[:, k, 0]
        if ground not in run.model.slide_ends:
            friction[name] = found.pushes[:, k, 1]
    joints = {name: np.hypot(*found.reactions[:, k, :2].T) for k, name in enumerate(run.model.joints)}
    every: list[Panel] = [
        ("normal force [N]", normal),
        ("friction [N]", friction),
        ("moment of stops [N m]", turning),
        (JOINTS, joints),
    ]
    least = ROUNDING * max((_largest(curve) for _, curves in every for curve in curves.values()), default=0.0)
    shown = [panel for panel in every if any(np.any(np.abs(curve) > least) for curve in panel[1].values())]
    return shown or [("normal force [N]", {run.model.contacts[0][0]: np.zeros(len(found.t))})]
