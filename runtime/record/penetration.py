"""How deep contacts are in what they touch: an audit of a run's rows."""

from __future__ import annotations

from typing import Any

import numpy as np

from .outputs import Sample
from .record import Record


def penetration_max(run: Record) -> float:
    """The largest depth (m) over all contacts that are on and all rows; 0 of a model without contacts.

    Stops of angles count with the mechanism's length as their lever. Of a run that was put together from pieces, as
    where a joint lets go, each piece knows which contacts are there."""
    pieces = getattr(run.advance, "pieces", ())
    if pieces:
        return max(penetration_max(piece.run) for piece in pieces)
    model: Any = run.model
    if not model.contacts:
        return 0.0
    levers = [model.length if ground in model.stops else 1.0 for _, ground in model.contacts]
    return max(0.0, float(-np.nanmin(Sample(run, None).gaps * np.array(levers, dtype=run.q.dtype), initial=0.0)))
