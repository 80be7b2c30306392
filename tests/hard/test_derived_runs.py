"""Derivatives of runs of many thrown loops: beside differences of runs in wide numbers."""

from __future__ import annotations

import pytest

from ..support.reach import Reach
from ..support.thrown_loops import BOUND, misses
from ..support.tiers import many
from ..support.workshop import Workshop

COUNT = many(5, 20)
"""Loops of each number of rods and kind: 200 in all in ``make figures``, the first of them in ``make hard``."""

FEW = many(2, 5)
"""Of those that stay, whose runs take longer."""

STAYING = 1e-8
"""Bound for loops that stay on the ground: the time of an impact that closes slowly, just behind another, is known to
fewer digits."""


@pytest.mark.hard
@pytest.mark.parametrize("rough", [False, True])
@pytest.mark.parametrize("n", [3, 4, 5, 6, 7])
def test_they_are_those_of_differences(n: int, rough: bool, workshop: Workshop, reach: Reach) -> None:
    found = list(misses(workshop, n, rough, seed=2, count=COUNT))
    refused = [why for _, why in found if why]
    reach(f"derivatives of thrown loops of {n}{', rough' * rough}: miss", max(miss for miss, _ in found), BOUND)
    reach(f"derivatives of thrown loops of {n}{', rough' * rough}: refused", len(refused), COUNT / 20)


@pytest.mark.hard
@pytest.mark.parametrize("rough", [False, True])
@pytest.mark.parametrize("n", [4, 6])
def test_so_are_those_of_what_stays_on_the_ground(n: int, rough: bool, workshop: Workshop, reach: Reach) -> None:
    found = list(misses(workshop, n, rough, seed=5, count=FEW, stays=True))
    refused = [why for _, why in found if why]
    reach(f"derivatives of loops of {n} that stay{', rough' * rough}: miss", max(miss for miss, _ in found), STAYING)
    reach(f"derivatives of loops of {n} that stay{', rough' * rough}: refused", len(refused), FEW / 2)
