"""Runs in which the ends of a spring meet: its force jumps there, at an instant that is not differentiated."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..model.model import Model
from ..record.outputs import units_of, values_of
from ..record.record import Record

MET = 1e-9
"""Ends that are nearer, against the mechanism's length or the longest that the spring has been, meet: only short steps
end there, of which one ends within the rounding of places, 1e-12 lengths, however little the spring moves."""


def meetings(run: Record, model: Model) -> Iterator[tuple[str, float]]:
    """Per spring with a length at rest whose ends meet in the run, its name and the first time (s) at which they do."""
    known = units_of(model)
    names = [name for name in model.parameters if name.endswith(".length") and name in known]
    for name, lengths in values_of(run, names).items():
        met = np.flatnonzero(lengths <= MET * max(lengths.max(), model.length))
        if len(met):
            yield name.removesuffix(".length"), float(run.t[met[0]])
