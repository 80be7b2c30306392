"""Random loops on random grounds keep the invariants; ``CCGEN_FUZZ`` says how many (``make hard``: 200, ``make fuzz``:
5,000; ``make test`` takes 20 of them), and ``CCGEN_FUZZ_SEED`` draws others than those of every time."""

from __future__ import annotations

import importlib
import os
import time
from collections import Counter
from collections.abc import Iterable

import pytest

from ..support.endings import DONE, ending
from ..support.workshop import Workshop
from .fuzz import Toss, faults, run, scene, tosses

EXAMPLES = int(os.environ.get("CCGEN_FUZZ", "200"))
SEED = int(os.environ.get("CCGEN_FUZZ_SEED", "0"))
LONGEST = 120.0
"""Seconds that no toss may take; most take hundredths."""

RATE_BUDGET = 10_000
"""Steps and events within a tenth of the duration, a second here, a twentieth of what a run may usually have."""

MOST_STOPPED = 72
"""Of the first 200 tosses of seed 0 no more stop before their end, and all say why: 70 do, or 69 where products and
sums are one operation. Crowds of events are decided by rounding, so another processor may stop one or two more."""

FEW, MOST_OF_FEW_STOPPED = 20, 9
"""Of the first 20 with six or nine rods 7 stop."""


def test_a_few_random_tosses(workshop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of six and of nine rods, so that four models serve them."""
    few = [toss for toss in tosses(200, 0) if toss.n in (6, 9)][:FEW]
    assert _stopped(few, workshop, monkeypatch) <= MOST_OF_FEW_STOPPED


@pytest.mark.hard
def test_random_tosses(workshop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    """Twenty models serve all tosses."""
    stopped = _stopped(tosses(EXAMPLES, SEED), workshop, monkeypatch)
    assert SEED or stopped <= MOST_STOPPED


def _stopped(drawn: Iterable[Toss], workshop: Workshop, monkeypatch: pytest.MonkeyPatch) -> int:
    """How many of the first 200 stop before their end; all keep the invariants, and say why they stop.

    A toss that crowds its steps ends soon: else a few take most of the time.
    """
    monkeypatch.setattr(importlib.import_module("ccgen.runtime.simulation.one_run"), "RATE_BUDGET", RATE_BUDGET)
    ended: Counter[str] = Counter()
    wrong: list[str] = []
    stopped = 0
    for number, toss in enumerate(drawn):
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
            stopped += number < 200 and ending(found) != DONE
    print(f"{ended[DONE]} tosses reached their end, {ended.total() - ended[DONE]} stopped and said why: {dict(ended)}")
    assert not wrong, "\n".join(wrong)
    return stopped


def test_an_arch_whose_foot_slides_at_the_limit(workshop: Workshop) -> None:
    """Found by random tosses (CCGEN_FUZZ_SEED=10): four joints rest, another bounces between two of them, one of which
    slides out and back at 1 mm/s; its friction keeps the direction that it had, and adds 4e-4 J."""
    toss = Toss(n=7, planes=1, rough=True, law="poisson", restitution=0.5, friction=1.2, seed=200)
    found = run(workshop.model(scene(toss.n, toss.rough)), toss)
    assert found.success and not faults(found), found.message
