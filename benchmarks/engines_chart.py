"""The chart of engines.py: error against time, a panel for every motion."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Protocol

COLOURS = ("#1b6ca8", "#5fa8d3", "#c2571a", "#e39a5b", "#4d8b31", "#93c47d", "#7b4ea3", "#b79ad1", "#444444")
MARKS = "osD^vP<>X"
LEAST = 1e-16
"""Errors smaller than this are drawn there."""


class Measured(Protocol):
    """What is drawn of a run."""

    case: str
    tool: str
    milliseconds: float
    error: float


def draw(rows: Sequence[Measured], titles: Mapping[str, str], path: Path) -> None:
    """Error over time, both logarithmic; lower and further to the left is better. The last panel has the names."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    names = list(dict.fromkeys(row.tool for row in rows))
    cases = [case for case in titles if any(row.case == case for row in rows)]
    figure = Figure(figsize=(12.0, 7.6), dpi=110, facecolor="white", layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(2, 3).ravel()
    for axes, case in zip(panels, cases, strict=False):
        for k, name in enumerate(names):
            own = [row for row in rows if (row.case, row.tool) == (case, name)]
            axes.loglog(
                [row.milliseconds for row in own],
                [max(row.error, LEAST) for row in own],
                marker=MARKS[k % len(MARKS)],
                color=COLOURS[k % len(COLOURS)],
                markersize=5,
                linewidth=1.8 if name.startswith("ccgen") else 1.2,
                label=name,
            )
        axes.set_title(titles[case], fontsize=10)
        axes.set_xlabel("wall time  [ms]")
        rests = "rest" in titles[case]
        axes.set_ylabel("height of a corner at the end  [m]" if rests else "error at the end  [m, rad]")
        axes.grid(True, which="major", color="#e2e2e2", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
    for axes in panels[len(cases) :]:
        axes.axis("off")
    handles = {h.get_label(): h for axes in panels for h in axes.get_lines()}
    panels[-1].legend([handles[name] for name in names], names, loc="center", frameon=False, fontsize=10)
    figure.savefig(path, metadata={"Software": None})
