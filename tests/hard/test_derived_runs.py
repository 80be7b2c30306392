"""Derivatives of runs of many thrown loops: beside differences of runs in wide numbers."""

from __future__ import annotations

import pytest

from ..support.reach import Reach
from ..support.thrown_loops import BOUND, misses
from ..support.workshop import Workshop

COUNT = 20


@pytest.mark.hard
@pytest.mark.parametrize("rough", [False, True])
@pytest.mark.parametrize("n", [3, 4, 5, 6, 7])
def test_they_are_those_of_differences(n: int, rough: bool, workshop: Workshop, reach: Reach) -> None:
    found = list(misses(workshop, n, rough, seed=2, count=COUNT))
    refused = [why for _, why in found if why]
    reach(f"derivatives of thrown loops of {n}{', rough' * rough}: miss", max(miss for miss, _ in found), BOUND)
    reach(f"derivatives of thrown loops of {n}{', rough' * rough}: refused", len(refused), 1)
