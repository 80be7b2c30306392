"""Families of random mechanisms run to their ends and keep the invariants. ``CCGEN_FAMILIES`` says how many runs
there are (``make hard``: 24, two of each family; 144 with ``CCGEN_LARGE=1``), and ``CCGEN_FAMILIES_SEED`` draws
others than those of every time."""

from __future__ import annotations

import importlib
import os
from collections import Counter
from collections.abc import Iterable

import pytest

from ..support.endings import DONE
from ..support.tiers import many
from ..support.workshop import Workshop
from .families import Throw, throw, throws
from .family_runs import LONG, run

EXAMPLES = int(os.environ.get("CCGEN_FAMILIES", many(16, 144)))
SEED = int(os.environ.get("CCGEN_FAMILIES_SEED", "0"))
LONGEST = 60.0
"""Seconds of the wall clock, after which a run is ended and has not reached its end; most take hundredths."""

RATE_BUDGET = 10_000
"""Steps and events within a characteristic time, a twentieth of what a run may usually have, so that those that crowd
are brought to rest soon. Where sizes are far apart links turn quickly beside it, and runs have all."""

ENDED = 0.995
"""The part of the runs that reaches their end."""


@pytest.mark.hard
def test_families(workshop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    _all_but_few_end(throws(EXAMPLES, SEED), workshop, monkeypatch)


def _all_but_few_end(thrown: Iterable[Throw], workshop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    """All keep the invariants, and but a few in a thousand reach their end."""
    one_run = importlib.import_module("ccgen.runtime.simulation.one_run")
    usual = one_run.RATE_BUDGET
    ends: Counter[str] = Counter()
    wrong, stopped = [], []
    for each in thrown:
        monkeypatch.setattr(one_run, "RATE_BUDGET", usual if each.family in LONG else RATE_BUDGET)
        found = run(workshop.model(each.text), each, LONGEST)
        ends[found.end] += 1
        told = f"{each.family} {each.number} ({each.law}, {found.wall:.1f} s): {found.run.message}"
        if found.wrong:
            wrong.append(f"{told}: {'; '.join(found.wrong)}")
            print(f"{told}: {'; '.join(found.wrong)}", flush=True)
        if found.end != DONE:
            stopped.append(told)
            print(told, flush=True)
    print(f"{ends[DONE]} of {ends.total()} runs reached their end: {dict(ends)}")
    assert not wrong, "\n".join(wrong)
    assert ends[DONE] >= ENDED * ends.total(), "\n".join(stopped)


@pytest.mark.parametrize("number", [204, 278])
def test_stepping_is_short_against_the_motion(number: int, workshop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    """Discs in a box under a gravity of 1e-6 m/s2: half a swing takes an hour, in which they cross the box a thousand
    times. Bounces of two of them and a wall crowd; a span of a ten-thousandth of that hour was a tenth of the run."""
    monkeypatch.setattr(importlib.import_module("ccgen.runtime.simulation.one_run"), "RATE_BUDGET", RATE_BUDGET)
    each = throw("discs", number)
    found = run(workshop.model(each.text), each, LONGEST)
    assert found.end == DONE and not found.wrong, (found.run.message, found.wrong)
    assert found.stepped < 1e-3
