"""Random loops on random grounds keep the invariants; ``CCGEN_FUZZ`` says how many (``make fuzz``: 5,000), and
``CCGEN_FUZZ_SEED`` draws others than those of every time."""

from __future__ import annotations

import importlib
import math
import os
import time
from collections import Counter

import pytest
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

from ..support.endings import DONE, ending
from ..support.workshop import Workshop
from .fuzz import Toss, faults, run, scene

EXAMPLES = int(os.environ.get("CCGEN_FUZZ", "200"))
SEED = int(os.environ.get("CCGEN_FUZZ_SEED", "0"))
LONGEST = 120.0
"""Seconds that no toss may take; most take hundredths."""

SECOND_BUDGET = 10_000
"""Steps and events of a simulated second, a twentieth of what a run may usually have."""

SHARE = 0.245
"""Of 10,000 tosses (seeds 1 to 20) this share stopped before its end. A survey may stop as often, and three standard
deviations more: which tosses a seed gives depends on the version of hypothesis and on numbers in the code around it."""

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
    monkeypatch.setattr(importlib.import_module("ccgen.runtime.simulation.one_run"), "SECOND_BUDGET", SECOND_BUDGET)
    ended: Counter[str] = Counter()
    wrong: list[str] = []

    @seed(SEED)
    @settings(
        max_examples=EXAMPLES,
        deadline=None,
        database=None,
        phases=[Phase.generate],  # one number more or less in a toss is another toss: nothing can be made simpler
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
    )
    @given(tosses)
    def toss_one(toss: Toss) -> None:
        model = workshop.model(scene(toss.n, toss.rough))
        began = time.monotonic()
        found = run(model, toss)
        seconds = time.monotonic() - began
        faulty = faults(found) + ([f"{seconds:.0f} s of time"] if seconds > LONGEST else [])
        if faulty:
            wrong.append(f"{toss}: {'; '.join(faulty)} ({found.message})")
            print(wrong[-1], flush=True)
        else:
            ended[ending(found)] += 1

    toss_one()
    stopped = ended.total() - ended[DONE]
    print(f"{ended[DONE]} tosses reached their end, {stopped} stopped and said why: {dict(ended)}")
    assert not wrong, "\n".join(wrong)
    assert stopped <= SHARE * EXAMPLES + 3.0 * math.sqrt(SHARE * (1.0 - SHARE) * EXAMPLES), ended


def test_an_arch_whose_foot_slides_at_the_limit(workshop: Workshop) -> None:
    """Found by random tosses (CCGEN_FUZZ_SEED=10): four joints rest, another bounces between two of them, one of which
    slides out and back at 1 mm/s; its friction keeps the direction that it had, and adds 4e-4 J."""
    toss = Toss(n=7, planes=1, rough=True, law="poisson", restitution=0.5, friction=1.2, seed=200)
    found = run(workshop.model(scene(toss.n, toss.rough)), toss)
    assert found.success and not faults(found), found.message
