"""Loops that are thrown onto the ground: derivatives of their runs, and differences of runs in wide numbers."""

from __future__ import annotations

import pytest

from ..support.thrown_loops import BOUND, misses
from ..support.tiers import hard, many
from ..support.workshop import Workshop


@pytest.mark.parametrize("rough", [hard(False), True])
def test_derivatives_are_those_of_differences(rough: bool, workshop: Workshop) -> None:
    found = list(misses(workshop, 4, rough, seed=1, count=3))
    assert not [why for _, why in found if why]
    assert max(miss for miss, _ in found) < BOUND


@pytest.mark.hard
@pytest.mark.parametrize("rough", [False, True])
def test_so_are_those_of_what_stays_on_the_ground(rough: bool, workshop: Workshop) -> None:
    found = list(misses(workshop, 4, rough, seed=3, count=many(3, 6), stays=True))
    assert len([why for _, why in found if why]) <= many(1, 2)
    assert max(miss for miss, _ in found) < BOUND
