"""Marks beneath curves over time: impacts, contact, time stepping; and the key that says what they are."""

from __future__ import annotations

from typing import Any

from ..extras import needed
from ..record.record import Record
from .frames import shown_impacts

EARTH, FLASH, SOFT = "#e9e4da", "#d55e00", "#888888"
SHORTEST = 1e-4
"""Part of the run that a contact must last to be seen."""
DASHES = (0, (4, 2))
SHADE = {"color": EARTH, "alpha": 0.6, "linewidth": 0}
HATCHES = {"facecolor": "none", "edgecolor": SOFT, "hatch": "////"}


def mark_impacts(axes: Any, run: Record) -> None:
    """Impacts as lines, contact as shade, time stepping as hatches, however short."""
    across = axes.get_xaxis_transform()  # times, and parts of the height
    contacts = [
        (phase.start, phase.end - phase.start) for phase in run.phases if phase.kind == "contact" and _seen(run, phase)
    ]
    axes.broken_barh(contacts, (0.0, 1.0), transform=across, zorder=0.2, **SHADE)  # one by one they take seconds
    for phase in run.phases:
        if phase.kind == "steps":
            axes.axvspan(phase.start, phase.end, **HATCHES, zorder=0.3)
    times = sorted({impact.t for _, impact in shown_impacts(run)})
    ends = [t for t in times if t in (run.t[0], run.t[-1])]  # the axes' own edge would cover those, and half be cut off
    inner = [t for t in times if t not in ends]
    strength = 0.7 if len(times) <= 40 else 0.25
    look: dict[str, Any] = {"linewidth": 0.8, "alpha": strength, "color": FLASH}
    axes.vlines(inner, 0.0, 1.0, transform=across, zorder=0.5, linestyles=DASHES, **look)
    for t in ends:
        axes.axvline(t, zorder=3, clip_on=False, linestyle=DASHES, **look)


def name_marks(figure: Any, run: Record) -> None:
    """Say in the corner of the ``figure``, beside "time", what the marks are that the run has; nothing without any."""
    lines, patches = needed("matplotlib.lines", "a plot of a run"), needed("matplotlib.patches", "a plot of a run")
    kinds = {phase.kind for phase in run.phases if phase.kind != "contact" or _seen(run, phase)}
    marks = []
    if run.impacts:
        marks.append(lines.Line2D([], [], color=FLASH, linewidth=0.8, linestyle=DASHES, label="impact"))
    if "contact" in kinds:
        marks.append(patches.Patch(**SHADE, label="in contact"))
    if "steps" in kinds:
        marks.append(patches.Patch(**HATCHES, label="time stepping"))
    if marks:
        figure.legend(handles=marks, loc="lower right", ncols=len(marks), frameon=False, fontsize=8)


def _seen(run: Record, phase: Any) -> bool:
    return bool(phase.end - phase.start > SHORTEST * (run.t[-1] - run.t[0]))
