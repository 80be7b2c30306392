"""Random loops on random grounds keep the invariants; ``CCGEN_FUZZ`` says how many (``make fuzz``: 5,000)."""

from __future__ import annotations

import importlib
import os
import time

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ..conftest import Workshop
from .fuzz import Toss, faults, run, scene

EXAMPLES = int(os.environ.get("CCGEN_FUZZ", "200"))
LONGEST = 120.0
"""Seconds that no toss may take; most take hundredths."""

SECOND_BUDGET = 10_000
"""Steps and events of a simulated second, a twentieth of what a run may usually have."""

tosses = st.builds(
    Toss,
    n=st.integers(3, 12),
    planes=st.integers(1, 2),
    rough=st.booleans(),
    law=st.sampled_from(["newton", "poisson"]),
    restitution=st.sampled_from([0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0]),
    friction=st.sampled_from([0.05, 0.1, 0.3, 0.7, 1.2]),
    seed=st.integers(0, 2**31),
)


def test_random_tosses(workshop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    """Twenty models serve all tosses, and a toss that crowds its steps ends soon: else a few take most of the time."""
    monkeypatch.setattr(importlib.import_module("ccgen.runtime.simulate"), "SECOND_BUDGET", SECOND_BUDGET)
    ended = {"done": 0, "stopped": 0}

    @settings(
        max_examples=EXAMPLES,
        deadline=None,
        derandomize=True,
        database=None,
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
    )
    @given(tosses)
    def toss_one(toss: Toss) -> None:
        model = workshop.model(scene(toss.n, toss.rough))
        began = time.monotonic()
        found = run(model, toss)
        assert time.monotonic() - began <= LONGEST
        assert not faults(found), found.message
        ended["done" if found.success else "stopped"] += 1

    toss_one()
    print(f"{ended['done']} tosses reached their end, {ended['stopped']} stopped and said why")
