"""Named points of links and mass centres, as the page traces them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..model.mass_centres import mass_centre
from ..record.drawable import Drawable
from ..record.record import Record


@dataclass(frozen=True)
class NamedPoint:
    """A point fixed in a link: its ``name``, the link's number, and its place (2,) in the link's frame, in m; of a mass
    centre also the ``mass``, in kg."""

    name: str
    link: int
    place: FloatArray
    mass: float = 0.0


def named_points(run: Record, then: Drawable | None = None) -> list[NamedPoint]:
    """The named points of the links that pictures show, welded ones too, as ``run.point`` calls them, by the model that
    is in force ``then``, at the start unless given.

    A run that ``simulate`` has not made knows its joints alone.
    """
    if run.motion is None:
        return []
    model: Any = then or run.model
    welded = model.data["welded_points"]
    shown = model.links[: len(model.outlines)]
    found = []
    for name in (*model.points, *welded):
        link = welded.get(name, name).partition(".")[0]
        if "." not in name or name in welded.values() or link not in shown:
            continue
        number = shown.index(link)
        x, y, angle = np.asarray(model.poses(run.q[:1])[0, number], dtype=float)
        away = complex(*(np.asarray(model.point(name, run.q[:1])[0], dtype=float) - [x, y])) * np.exp(-1j * angle)
        found.append(NamedPoint(name, number, np.array([away.real, away.imag])))
    return found


def mass_centres(run: Record, then: Drawable | None = None) -> list[NamedPoint]:
    """Mass centres of the links that pictures show and that have a mass, by the names of the links, likewise."""
    model = then or run.model
    return [
        NamedPoint(name, centre.link, np.array([centre.x, centre.y]), centre.mass)
        for name in model.links[: len(model.outlines)]
        if (centre := mass_centre(model, name))
    ]
