"""Runs in which the ends of a spring meet: its force jumps there, at an instant that is not differentiated."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..model.model import Model
from ..record.motion_at_rows import motion_at_rows
from ..record.record import Record

MET = 1e-9
"""Ends that are nearer, against the longest that the spring has been, meet: only short steps end there."""


def meetings(run: Record, model: Model) -> Iterator[tuple[str, float]]:
    """Per spring with a length at rest whose ends meet in the run, its name and the first time (s) at which they do."""
    lengths = [k for k, (name, _) in enumerate(model.told) if name.endswith(".length") and name in model.parameters]
    if not lengths:  # the forces of all rows are found for them
        return
    told = motion_at_rows(run).told
    for k in lengths:
        met = np.flatnonzero(told[:, k] <= MET * told[:, k].max())
        if len(met):
            yield model.told[k][0].removesuffix(".length"), float(run.t[met[0]])
