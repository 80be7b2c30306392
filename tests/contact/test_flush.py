"""Smooth boxes flush on each other, corner on corner.

A corner that bears on the round end of an edge, beside edges that bear as well, is pushed to the side by its least
offset. Its row and those of the edges are dependent but for that."""

from __future__ import annotations

import numpy as np
import pytest

from ccgen.runtime import simulate

from ..support.outline_scenes import flush_boxes
from ..support.tiers import all_hard_but
from ..support.workshop import Workshop

STACKS = {
    "two": ([0.2, 0.2], [1.0, 1.0]),
    "three": ([0.2, 0.2, 0.2], [1.0, 1.0, 1.0]),
    "heavy_in_the_middle": ([0.3, 0.3, 0.3], [1.0, 10.0, 0.1]),
    "four": ([0.5, 0.5, 0.5, 0.5], [5.0, 1.0, 1.0, 5.0]),
    "narrow_between_wide": ([0.4, 0.2, 0.4], [1.0, 1.0, 1.0]),
}


@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.6])
@pytest.mark.parametrize("stack", all_hard_but("two", "heavy_in_the_middle", of=STACKS))
def test_a_stack_stands(stack: str, restitution: float, workshop: Workshop) -> None:
    """For 3 s by every method: without impacts, time stepping or loss. A corner is closed as long as its gap, x^2 / 2 r
    where a box is x to the side of the next, is less than 1e-12 of a box: no box gets so far, no gap is more."""
    closed, aside = 1e-12 * 0.2, 6e-8
    model = workshop.model(flush_boxes(*STACKS[stack], restitution=restitution))
    for method in ("gauss", "dop853", "dopri5", "radau"):
        run = simulate(model, until=3.0, method=method)
        assert run.success, run.message
        assert run.impacts == () and {phase.kind for phase in run.phases} == {"contact"}
        assert 2.0 * np.abs(run.q - run.q[0]).max() <= aside
        assert np.abs(run.u).max() <= 1e-7
        assert model.gaps(run.q).min() >= -closed
        assert len(run.t) <= 1000


@pytest.mark.parametrize("aside", [1e-12, 1e-9, 1e-7])
def test_steps_put_boxes_back_to_rounding(aside: float, workshop: Workshop) -> None:
    """By time stepping, the upper box a little to the side: the corner beyond the other box is in front of its edge."""
    model = workshop.model(flush_boxes(*STACKS["two"]))
    q, u = model.start()
    q[model.q_names.index("slide_3")] = aside
    run = simulate(model, q, u, until=0.3, method="moreau", step=1e-3)
    assert run.success, run.message
    assert model.gaps(run.q).min() >= -1e-15
    assert np.max(np.diff(np.sum(model.energy(run.q, run.u), axis=0))) <= 1e-13
