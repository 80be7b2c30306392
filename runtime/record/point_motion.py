"""How a point of the mechanism moves along a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..model.numbers import read_numbers, read_row_of_times
from .frozen import freeze, restore
from .outputs import Sample
from .record import Record


@dataclass(frozen=True, eq=False)
class PointMotion:
    """At times t (n,) the `position` (m), `velocity` (m/s) and `acceleration` (m/s²) of the point `name`, (n, 2) each.

    Of one time t () and (2,). Accelerations are not numbers where the run knows none.
    """

    name: str
    t: FloatArray
    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray

    def __post_init__(self) -> None:
        freeze(self, "t", "position", "velocity")
        self.acceleration.flags.writeable = False

    def __setstate__(self, state: dict[str, object]) -> None:
        restore(self, state)


def point_motion(run: Record, name: str, t: ArrayLike | None) -> PointMotion:
    """That of the point at the times t, or at all rows of the run, those before impacts as before them."""
    if t is None:
        sample = Sample(run, None)
        return PointMotion(name, run.t, sample.place(name), sample.velocity(name), sample.acceleration(name))
    times = np.array(read_numbers(t, "t", run.t.dtype))
    sample = Sample(run, read_row_of_times(times, run.t.dtype))
    found = sample.place(name), sample.velocity(name), sample.acceleration(name)
    return PointMotion(name, times, *(one if times.ndim else one[0] for one in found))
