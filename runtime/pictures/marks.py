"""Marks beneath curves over time: impacts, events, contact, time stepping; and the key that says what they are."""

from __future__ import annotations

from typing import Any

from ..extras import needed
from ..record.record import Record
from .frames import shown_events, shown_impacts

EARTH, FLASH, SOFT = "#e9e4da", "#d55e00", "#888888"
EVENTS = ("#7b4ea3", "#008080", "#b0306a", "#6b6b1f")
"""Colours of names of events, in the order in which they come first. Where there are more names than colours, those
from the last of these on share one that is soft."""
LONGEST, IN_A_ROW = 32, 5
"""Letters of a name in the key, and marks in a row of it."""
SHORTEST = 1e-4
"""Part of the run that a contact must last to be seen."""
DASHES, DOTS = (0, (4, 2)), (0, (1, 1.5))
DASHED, DOTTED = 0.8, 1.3
"""Widths of lines, in points."""
SHADE = {"color": EARTH, "alpha": 0.6, "linewidth": 0}
HATCHES = {"facecolor": "none", "edgecolor": SOFT, "hatch": "////"}


def mark_instants(axes: Any, run: Record) -> None:
    """Impacts as dashed lines, events as dotted ones, contact as shade, time stepping as hatches, however short."""
    across = axes.get_xaxis_transform()  # times, and parts of the height
    contacts = [
        (phase.start, phase.end - phase.start) for phase in run.phases if phase.kind == "contact" and _seen(run, phase)
    ]
    axes.broken_barh(contacts, (0.0, 1.0), transform=across, zorder=0.2, **SHADE)  # one by one they take seconds
    for phase in run.phases:
        if phase.kind == "steps":
            axes.axvspan(phase.start, phase.end, **HATCHES, zorder=0.3)
    _lines(axes, run, {impact.t for _, impact in shown_impacts(run)}, FLASH, DASHES)
    for _, colour, times in _events(run):
        _lines(axes, run, times, colour, DOTS)


def _lines(axes: Any, run: Record, times: set[float], colour: str, dashes: Any) -> None:
    """Lines at times, fainter where there are many."""
    ends = times & {float(run.t[0]), float(run.t[-1])}  # the axes' own edge would cover those, and half be cut off
    wide, below = (DOTTED, 1.6) if dashes is DOTS else (DASHED, 0.5)  # dots would be lost beneath the grid
    look: dict[str, Any] = {"linewidth": wide, "alpha": 0.7 if len(times) <= 40 else 0.25, "color": colour}
    if inner := sorted(times - ends):
        axes.vlines(inner, 0.0, 1.0, transform=axes.get_xaxis_transform(), zorder=below, linestyles=dashes, **look)
    for t in sorted(ends):
        axes.axvline(t, zorder=3, clip_on=False, linestyle=dashes, **look)


def _events(run: Record) -> list[tuple[str, str, set[float]]]:
    """Names of events, in the order in which they came first, each with its colour and times (s); of many names those
    that have no colour of their own are one."""
    times: dict[str, set[float]] = {}
    for event in shown_events(run):
        times.setdefault(event.name, set()).add(float(event.t))
    names = list(times)
    own = names if len(names) <= len(EVENTS) else names[: len(EVENTS) - 1]
    found = [(name, EVENTS[k], times[name]) for k, name in enumerate(own)]
    if rest := names[len(own) :]:
        found.append((f"{len(rest)} other events", SOFT, set().union(*(times[name] for name in rest))))
    return found


def name_marks(figure: Any, run: Record) -> None:
    """Say in the corner of the ``figure``, beside "time", what the marks are that the run has; nothing without any."""
    lines, patches = needed("matplotlib.lines", "a plot of a run"), needed("matplotlib.patches", "a plot of a run")
    kinds = {phase.kind for phase in run.phases if phase.kind != "contact" or _seen(run, phase)}
    marks = []
    if run.impacts:
        marks.append(lines.Line2D([], [], color=FLASH, linewidth=DASHED, linestyle=DASHES, label="impact"))
    for name, colour, _ in _events(run):
        label = name if len(name) <= LONGEST else f"{name[: LONGEST - 1]}…"
        marks.append(lines.Line2D([], [], color=colour, linewidth=DOTTED, linestyle=DOTS, label=label))
    if "contact" in kinds:
        marks.append(patches.Patch(**SHADE, label="in contact"))
    if "steps" in kinds:
        marks.append(patches.Patch(**HATCHES, label="time stepping"))
    if marks:
        place = "lower right" if not run.events else "outside lower right"  # names may be long
        figure.legend(handles=marks, loc=place, ncols=min(len(marks), IN_A_ROW), frameon=False, fontsize=8)


def _seen(run: Record, phase: Any) -> bool:
    return bool(phase.end - phase.start > SHORTEST * (run.t[-1] - run.t[0]))
