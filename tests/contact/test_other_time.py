"""A rough ring in another unit of time, a power of two: nothing is rounded otherwise, no threshold stays behind."""

from __future__ import annotations

import numpy as np
import pytest

from ccgen.runtime import simulate

from ..support.workshop import Workshop

RING = """
[loop]
links = 4
[start]
height = 0.3
tilt = 0.3
velocity = [{speed!r}, 0.0]
[gravity]
g = {gravity!r}
[[ground]]
restitution = 0.5
friction = 0.4
[run]
until = {until!r}
law = "poisson"
"""


@pytest.mark.parametrize("rtol", [1e-9, 1e-11])
def test_another_unit_of_time_changes_no_bit(rtol: float, workshop: Workshop) -> None:
    """Times are 2^20 as long: through its impacts, until it all but lies flat."""
    runs = []
    for unit in (1.0, 2.0**20):
        text = RING.format(speed=0.3 / unit, gravity=9.81 / unit**2, until=1.2 * unit)
        run = simulate(workshop.model(text), rtol=rtol)
        assert run.success, run.message
        runs.append((run.t / unit, run.q, run.u * unit, len(run.impacts)))
    one, other = runs
    assert one[3] == other[3] > 50
    for a, b in zip(one[:3], other[:3], strict=True):
        np.testing.assert_array_equal(a, b)
