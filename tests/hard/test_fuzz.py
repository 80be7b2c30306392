"""Random loops on random grounds keep the invariants; ``CCGEN_FUZZ`` says how many (``make hard``: 20, ``make fuzz``:
5,000; ``make test`` takes six of them), and ``CCGEN_FUZZ_SEED`` draws others than those of every time."""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Iterable

import numpy as np
import pytest

from ..support.workshop import Workshop
from .fuzz import SECONDS, Toss, faults, run, scene, tosses

EXAMPLES = int(os.environ.get("CCGEN_FUZZ", "20"))
SEED = int(os.environ.get("CCGEN_FUZZ_SEED", "0"))
LONGEST = 120.0
"""Seconds of the processor that no toss may take; most take hundredths."""

FEW = 6
"""Of those with six or nine rods, for every run of the tests."""


def test_a_few_random_tosses(workshop: Workshop) -> None:
    """Those of six and of nine rods, so that four models serve them."""
    _reach_their_end([toss for toss in tosses(200, 0) if toss.n in (6, 9)][:FEW], workshop)


@pytest.mark.hard
def test_random_tosses(workshop: Workshop) -> None:
    """Twenty models serve all tosses."""
    _reach_their_end(tosses(EXAMPLES, SEED), workshop)


def _reach_their_end(drawn: Iterable[Toss], workshop: Workshop) -> None:
    """Every one of them, and all keep the invariants. It is told how."""
    wrong: list[str] = []
    times: list[float] = []
    told: Counter[str] = Counter()
    stepped = 0.0
    for toss in drawn:
        model = workshop.model(scene(toss.n, toss.rough))
        began = time.process_time()  # what else runs on the machine does not count
        found = run(model, toss)
        times.append(time.process_time() - began)
        faulty = faults(found) + ([] if found.success else [found.message])
        if times[-1] > LONGEST:
            faulty.append(f"{times[-1]:.0f} s of time")
        if faulty:
            wrong.append(f"{toss}: {'; '.join(faulty)}")
            print(wrong[-1], flush=True)
        steps = [phase.end - phase.start for phase in found.phases if phase.kind == "steps"]
        stepped += sum(steps)
        told["of steps"] += bool(steps)
        told["of less restitution"] += any(impact.restitution_share < 1.0 for impact in found.impacts)
        told["of choices"] += found.choices > 0
        told["of a speed of rest"] += found.rest_speed > 0.0
    print(
        f"{len(times)} tosses, {len(wrong)} wrong; {dict(told)}; {stepped / (SECONDS * len(times)):.1e} of the time by "
        f"steps; seconds of the processor each: median {np.median(times):.2f}, "
        f"99 in 100 {np.quantile(times, 0.99):.1f}, most {max(times):.1f}"
    )
    assert not wrong, "\n".join(wrong)


@pytest.mark.hard
def test_an_arch_whose_foot_slides_at_the_limit(workshop: Workshop) -> None:
    """Found by random tosses (CCGEN_FUZZ_SEED=10): four joints rest, another bounces between two of them, one of which
    slides out and back at 1 mm/s; its friction keeps the direction that it had, and adds 4e-4 J."""
    toss = Toss(n=7, planes=1, rough=True, law="poisson", restitution=0.5, friction=1.2, seed=200)
    found = run(workshop.model(scene(toss.n, toss.rough)), toss)
    assert found.success and not faults(found), found.message


@pytest.mark.hard
@pytest.mark.parametrize("method", ["gauss", "dop853"])
@pytest.mark.parametrize(
    "toss",
    [
        Toss(n=7, planes=2, rough=True, law="poisson", restitution=0.9, friction=1.2, seed=461373845),
        Toss(n=10, planes=2, rough=True, law="stronge", restitution=0.7, friction=0.3, seed=733348246),
    ],
    ids=["seven", "ten"],
)
def test_friction_does_not_drive_what_slow_bounces_turn_around(toss: Toss, method: str, workshop: Workshop) -> None:
    """Found by random tosses. Where events crowd, what is slow is brought to rest. That turned the sliding of contacts
    around whose friction kept the direction against what they had slid: they gained 2e-9 to 1e-8 in a step."""
    found = run(workshop.model(scene(toss.n, toss.rough)), toss, method=method)
    assert found.success and not faults(found), found.message
    energy = np.sum(found.model.energy(found.q, found.u), axis=0)
    assert np.max(np.diff(energy)) < 1e-11 * energy[0]
